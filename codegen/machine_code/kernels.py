"""Kernels of a generated text: declared as it is executed, compiled together, kept in one file.

A generated text is a module of numba. Executed here, its `numba.njit` makes `Kernel`s, which are
translated for LLVM. Numba compiles a text that the translation does not know.
"""

import ast
import inspect
import tempfile
import threading
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext, suppress
from functools import cache, cached_property, partial, update_wrapper
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import types
from numba.extending import typeof_impl

from codegen.garbage_collection import collection_paused
from codegen.machine_code import llvm_module
from codegen.machine_code.code_folders import (
    code_folder,
    name_of_state,
    note,
    numba_keeps_in,
    processor,
    remove_older,
)
from codegen.machine_code.kernel_callers import caller
from codegen.machine_code.llvm_instructions import (
    FLOAT,
    INTEGER,
    Array,
    Number,
    UntranslatableError,
)
from codegen.machine_code.llvm_module import Declaration, LlvmModule
from codegen.machine_code.undocumented_names import PLAIN, global_compiler_lock
from codegen.termination_signals import SignalDeferral

_numba: Any = numba  # numba and LLVM's bindings leave their names untyped
_types: Any = types
_llvm: Any = binding
_KINDS: dict[Any, str] = {types.float64: FLOAT, types.int64: INTEGER}
_compiling = threading.Lock()  # one thread at a time: all share a target machine and an engine


class Kernel(_types.WrapperAddressProtocol):  # type: ignore[misc]
    """A function of a generated text: Python, numba's functions and function tables call it.

    Attributes
    ----------
    py_func
        The function of the text.
    declared
        The signature that the text declares, or None.
    options
        What the text asks of numba.
    address
        Where its machine code is, by numba's convention of calls.
    c_address
        Where its entry from C is; numba asks for it where a kernel is a value.
    """

    address = c_address = 0

    def __init__(self, function: Any, declared: str | None, options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.py_func, self.options = function, options
        self.declared: Any = None if declared is None else eval(declared, {}, dict(vars(_types)))

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python; TypeError where the arguments are not those of its signature."""
        for argument in arguments:  # numba sees no order of bytes in what is packed for a caller
            if isinstance(argument, np.ndarray) and not argument.dtype.isnative:
                raise TypeError(self._mismatch(arguments))
        call = self._caller
        try:
            return call(self.address, *arguments)
        except TypeError as error:
            raise TypeError(self._mismatch(arguments)) from error

    def _mismatch(self, arguments: tuple[Any, ...]) -> str:
        """A sentence: the parameters of the kernel, and what was given in their place."""
        names = inspect.signature(self.py_func).parameters
        kinds = zip(names, self.signature().args, strict=True)
        wanted = ", ".join(f"{name}: {kind}" for name, kind in kinds)
        given = ", ".join(map(_kind_of_argument, arguments)) or "nothing"
        return f"{self.py_func.__name__}({wanted}) is called with ({given})."

    def signature(self) -> Any:
        """Its signature; TypeError if the text declares none."""
        if self.declared is None:
            raise TypeError(f"{self.__module__}.{self.py_func.__name__} has no one signature.")
        return self.declared

    @cached_property
    def _caller(self) -> Any:
        return caller(self.signature(), f"{self.__module__}.{self.py_func.__name__}")

    def __wrapper_address__(self) -> int:
        return self.c_address

    @cached_property
    def declaration(self) -> Declaration:
        """What other functions of the text know of it."""
        fastmath = self.options.get("fastmath") or ()
        checks = self.options.get("boundscheck") or _numba.config.BOUNDSCHECK
        if self.options.get("error_model") != "numpy" or fastmath is True or checks:
            raise UntranslatableError(f"{self.py_func.__name__} is compiled with other options")
        kinds = None
        if (signature := self.declared) is not None and all(x in _KINDS for x in signature.args):
            kinds = (tuple(_KINDS[x] for x in signature.args), _results(signature))
        return Declaration(_syntax_tree(self.py_func), " ".join(sorted(fastmath)), kinds)

    def described(self, symbol: str) -> llvm_module.Kernel:
        """As numba's callers know it: an array is seven parameters of machine code."""
        head = ["ptr noalias %.results", "ptr noalias %.exception"]
        parameters: list[Number | Array] = []
        names = self.py_func.__code__.co_varnames[: self.py_func.__code__.co_argcount]
        if len(names) != len(self.declared.args):
            raise UntranslatableError("a signature of another length")
        for name, kind in zip(names, self.declared.args, strict=True):
            if isinstance(kind, _types.Array):
                if kind.ndim != 1 or kind.layout != "C" or kind.dtype not in _KINDS:
                    raise UntranslatableError(str(kind))
                owner = f"ptr %{name}.owner, ptr %{name}.parent, i64 %{name}.size, i64 %{name}.item"
                head.append(f"{owner}, ptr %{name}, i64 %{name}.length, i64 %{name}.stride")
                length = Number(f"%{name}.length", INTEGER)
                parameters.append(Array(f"%{name}", _KINDS[kind.dtype], (length,)))
            elif kind in _KINDS:
                parameters.append(number := Number(f"%{name}", _KINDS[kind]))
                head.append(str(number))
            else:
                raise UntranslatableError(str(kind))
        return llvm_module.Kernel(
            symbol, ", ".join(head), tuple(parameters), _results(self.declared)
        )


@typeof_impl.register(Kernel)
def type_of_kernel(kernel: Kernel, context: object) -> Any:
    """The type of a kernel that is handed to a compiled function as a value."""
    return _types.FunctionType(kernel.signature())


class NumbaOfTexts:
    """What a generated text finds as `numba`, with another `njit`."""

    def __init__(self, njit: Callable[..., Any]) -> None:
        self.njit = njit

    def __getattr__(self, name: str) -> Any:
        return getattr(_numba, name)


def declare(declared: Any = None, **options: Any) -> Any:
    """In the place of `numba.njit`: a kernel, or a function that kernels call."""
    if callable(declared):
        return Kernel(declared, None, options)
    return lambda function: Kernel(function, declared, options)


def _compile_by_numba(*declared: Any, keeps: bool, **options: Any) -> Any:
    """`numba.njit`, in the plain way with the options that its documentation has."""
    unknown = [name for name in options if PLAIN and name.startswith("_")]
    known = {k: x for k, x in options.items() if k not in unknown}
    return _numba.njit(*declared, **{**known, "cache": keeps and bool(options.get("cache"))})


def execute(path: Path, text: str, names: dict[str, Any], run: Callable[[], object]) -> None:
    """Execute a text, which finds `numba` among its names, and compile or load its kernels.

    `run` executes it. Numba compiles all of a text that has more than kernels have.
    """
    if not PLAIN:
        names["numba"] = NumbaOfTexts(declare)
        run()
        with suppress(UntranslatableError, RecursionError):
            _compile(path, text, names)
            return
    folder = code_folder(path.parent)
    names["numba"] = NumbaOfTexts(partial(_compile_by_numba, keeps=folder is not None))
    within = folder and folder / f"{path.stem}.{name_of_state([text.encode()])}"
    if folder and within and not within.exists():
        remove_older(folder, f"{path.stem}.{'[0-9a-f]' * len(within.suffix[1:])}")
    first = global_compiler_lock or nullcontext()  # which a thread has that decorates for numba
    with first, numba_keeps_in(within), SignalDeferral(in_commands=False):
        run()


def _compile(path: Path, text: str, names: Mapping[str, Any]) -> None:
    found = [x for x in names.values() if isinstance(x, Kernel) and x.declared is not None]
    if not found:
        return
    state = name_of_state([text.encode()])
    symbols = [f"lw.{state}.{kernel.py_func.__name__}" for kernel in found]
    with SignalDeferral(in_commands=False), _compiling:
        code = _kept_code(path, state, lambda: _translation(found, symbols, names))
        engine = _engine()
        engine.add_object_file(_llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
        for kernel, symbol in zip(found, symbols, strict=True):
            kernel.address = engine.get_function_address(symbol)
            kernel.c_address = engine.get_function_address(f"{symbol}.c")


def _kept_code(path: Path, state: str, made: Callable[[], bytes]) -> bytes:
    """Machine code from the disk, or made and kept there."""
    folder = code_folder(path.parent)
    if folder is None:
        return made()
    file = folder / f"{path.stem}.{state}.lwo"
    with suppress(OSError, zlib.error):  # there is none, or it was cut short
        return zlib.decompress(file.read_bytes())
    code = made()
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".lw-") as place:
            whole = Path(place) / "code"
            whole.write_bytes(zlib.compress(code, 1))
            whole.replace(file)
        remove_older(folder, f"{path.stem}.*.lwo")
    except OSError as error:
        note(folder, f"not kept ({error.strerror or error}); each process compiles it again")
    return code


def _translation(
    kernels: Sequence[Kernel], symbols: Sequence[str], names: Mapping[str, Any]
) -> bytes:
    """Machine code of kernels; UntranslatableError if one has more than kernels have."""
    with collection_paused():
        flags = kernels[0].declaration.flags
        module = LlvmModule(names, lambda one: one.declaration, f"{symbols[0]}.", flags)
        for kernel, symbol in zip(kernels, symbols, strict=True):
            if kernel.declaration.flags != flags:
                raise UntranslatableError("kernels of several options")
            module.add(kernel.declaration.tree, kernel.described(symbol))
        return object_code(module.text())


def object_code(text: str) -> bytes:
    """A module in LLVM's language → an object file, by the passes that numba has as well."""
    machine = _target_machine()
    try:
        module = _llvm.parse_assembly(text, _llvm.create_context())
        module.verify()
    except RuntimeError as error:
        raise UntranslatableError(str(error)) from error
    module.data_layout = str(machine.target_data)
    for function in module.functions:
        builder = _pass_builder(3, True)
        builder.getFunctionPassManager().run(function, builder)
    cheap = _pass_builder(0, False)
    passes = cheap.getModulePassManager()
    passes.add_loop_rotate_pass()
    passes.add_instruction_combine_pass()
    passes.add_jump_threading_pass()
    passes.run(module, cheap)
    full = _pass_builder(3, True)
    full.getModulePassManager().run(module, full)
    return bytes(machine.emit_object(module))


def _pass_builder(speed: int, vectorizes_loops: bool) -> Any:
    options = _llvm.create_pipeline_tuning_options(speed_level=speed)
    options.loop_vectorization, options.slp_vectorization = vectorizes_loops, False
    return _llvm.create_pass_builder(_target_machine(), options)


@cache
def _target_machine() -> Any:
    _llvm.initialize_native_target()
    _llvm.initialize_native_asmprinter()
    name, features = processor()
    is_x86 = _llvm.Target.from_default_triple().name.startswith("x86")
    return _llvm.Target.from_triple(_llvm.get_process_triple()).create_target_machine(
        cpu=name, features=features, opt=3, reloc="static" if is_x86 else "default",
        codemodel="jitdefault", jit=True,
    )  # fmt: skip


@cache
def _engine() -> Any:
    """What loads object files, for the whole process."""
    return _llvm.create_mcjit_compiler(_llvm.parse_assembly(""), _target_machine())


def _results(signature: Any) -> tuple[str, ...]:
    """Kinds of what a function returns."""
    result = signature.return_type
    each: Iterable[Any] = result if isinstance(result, _types.BaseTuple) else (result,)
    try:
        return tuple(_KINDS[one] for one in each if one != _types.none)
    except KeyError as error:
        raise UntranslatableError(str(result)) from error


def _syntax_tree(function: Any) -> ast.FunctionDef:
    """The syntax tree of a function of a text."""
    lines = function.__globals__["__loader__"].get_source("").split("\n")
    code = function.__code__
    first = code.co_firstlineno - 1  # of its decorator
    last = first + 1
    while last < len(lines) and lines[last][:1] in ("d", " ", ")", ""):
        last += 1
    try:
        body = ast.parse("\n".join(lines[first:last])).body
    except SyntaxError as error:
        raise UntranslatableError(f"the text of {code.co_name}") from error
    end = first + max(node.end_lineno or 0 for node in body)
    whole = end >= max(line for _, line, *_ in code.co_positions() if line)
    match body:
        case [ast.FunctionDef(name=code.co_name) as tree] if whole:
            return tree
    raise UntranslatableError(f"the text of {code.co_name}")


def _kind_of_argument(argument: Any) -> str:
    """The kind of an argument, much as numba writes it."""
    if not isinstance(argument, np.ndarray):
        return type(argument).__name__
    order = "C" if argument.flags.c_contiguous else "F" if argument.flags.f_contiguous else "A"
    more = "" if argument.flags.writeable else ", read-only"
    if not argument.dtype.isnative:
        more += ", not in the machine's order of bytes"
    return f"array({argument.dtype.name}, {argument.ndim}d, {order}{more})"
