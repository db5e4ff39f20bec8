"""Kernels of a generated text: declared as it is executed, compiled together, kept in one file.

A generated text is a module of numba. Executed here, its `numba.njit` makes `Kernel`s, which are
translated for LLVM. Numba compiles a text that the translation does not know.
"""

import ctypes
import inspect
import tempfile
import threading
import zlib
from collections.abc import Callable, Mapping, Sequence
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
from codegen.machine_code.code_folders import (
    code_folders,
    name_of_state,
    note_unkept,
    numba_keeps_in,
    processor,
    remove_older,
)
from codegen.machine_code.compiled_functions import own_folders
from codegen.machine_code.expression_translation import UntranslatableError
from codegen.machine_code.kernel_translation import KernelModule
from codegen.machine_code.undocumented_names import PLAIN, global_compiler_lock
from codegen.termination_signals import SignalDeferral

_numba: Any = numba  # numba and LLVM's bindings leave their names untyped
_types: Any = types
_llvm: Any = binding
_POINTER, _WHOLE = ctypes.c_void_p, ctypes.c_int64
_REALS = (float, int, np.floating, np.integer, np.bool_)
_WORDS = (_POINTER, _POINTER, _WHOLE, _WHOLE, _POINTER, _WHOLE, _WHOLE)  # code: of an array
_NUMBERS: dict[Any, Any] = {types.float64: ctypes.c_double, types.int64: _WHOLE}
_RESULTS: dict[Any, Any] = {types.none: _POINTER, **_NUMBERS}
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
        result = self._result_type()
        try:
            given = zip(self._readers, arguments, strict=True)
            words = [word for read, argument in given for word in read(argument)]
        except (TypeError, ValueError) as error:
            raise TypeError(self._mismatch(arguments)) from error
        self._entry(ctypes.byref(result), None, *words)
        return result.value

    @cached_property
    def _readers(self) -> tuple[Any, ...]:
        """Functions of an argument each, which return it as machine code takes it."""
        return tuple(_reader(kind) for kind in self.signature().args)

    @cached_property
    def _result_type(self) -> Any:
        """The type of what it returns."""
        kind = self.signature().return_type
        if kind not in _RESULTS:
            known = ", ".join(map(str, _RESULTS))
            raise TypeError(
                f"{self.__module__}.{self.py_func.__name__} returns {kind}; Python calls kernels "
                f"that return {known}."
            )
        return _RESULTS[kind]

    @cached_property
    def _entry(self) -> Any:
        """By numba's convention of calls, in which an array is seven arguments."""
        parts = [
            _WORDS if isinstance(x, _types.Array) else (_NUMBERS[x],) for x in self.declared.args
        ]
        words = (word for part in parts for word in part)
        return ctypes.PYFUNCTYPE(ctypes.c_int, _POINTER, _POINTER, *words)(self.address)

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

    def __wrapper_address__(self) -> int:
        return self.c_address

    def __reduce__(self) -> Any:
        """As the kernel of its text: addresses hold in one process."""
        return self.py_func.__globals__["__loader__"].pickled(self.py_func.__name__)


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
    folders = own_folders(path.parent, [text.encode()], f"{path.stem}.")
    if not folders:
        note_unkept()
    names["numba"] = NumbaOfTexts(partial(_compile_by_numba, keeps=bool(folders)))
    first = global_compiler_lock or nullcontext()  # which a thread has that decorates for numba
    with first, numba_keeps_in(folders[-1] if folders else None), SignalDeferral(in_commands=False):
        run()


def _compile(path: Path, text: str, names: Mapping[str, Any]) -> None:
    found = [x for x in names.values() if isinstance(x, Kernel) and x.declared is not None]
    if not found:
        return
    state = name_of_state([text.encode()])
    symbols = [f"lw.{state}.{kernel.py_func.__name__}" for kernel in found]
    if len({*symbols}) < len(symbols):
        raise UntranslatableError("two kernels have one name")
    with SignalDeferral(in_commands=False), _compiling:
        code = _kept_code(path, state, lambda: _translation(text, found, symbols, names))
        engine = _engine()
        engine.add_object_file(_llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
        for kernel, symbol in zip(found, symbols, strict=True):
            kernel.address = engine.get_function_address(symbol)
            kernel.c_address = engine.get_function_address(f"{symbol}.c")


def _kept_code(path: Path, state: str, made: Callable[[], bytes]) -> bytes:
    """Machine code from the disk, or made and kept there."""
    name = f"{path.stem}.{state}.lwo"
    folders = code_folders(path.parent, name)
    for folder in folders:
        with suppress(OSError, zlib.error):  # there is none, or it was cut short
            return zlib.decompress((folder / name).read_bytes())
    code = made()
    try:
        if not folders:
            raise OSError
        with tempfile.TemporaryDirectory(dir=folders[-1], prefix=".lw-") as place:
            whole = Path(place) / "code"
            whole.write_bytes(zlib.compress(code, 1))
            whole.replace(folders[-1] / name)
        remove_older(folders[-1], f"{path.stem}.*.lwo")
    except OSError:
        note_unkept()
    return code


def _translation(
    text: str, kernels: Sequence[Kernel], symbols: Sequence[str], names: Mapping[str, Any]
) -> bytes:
    """Machine code of kernels; UntranslatableError if one has more than kernels have."""
    with collection_paused():
        module = KernelModule(names, text, kernels[0].options, f"{symbols[0]}.")
        for kernel, symbol in zip(kernels, symbols, strict=True):
            module.add(kernel, symbol)
        return object_code(str(module))


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


def _reader(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    """A function: an argument → its words for machine code; TypeError if it is of another kind."""
    if not isinstance(kind, _types.Array):
        number = float if kind == types.float64 else int

        def read_number(argument: Any) -> tuple[Any, ...]:
            if not isinstance(argument, _REALS):
                raise TypeError
            return (number(argument),)

        return read_number
    dtype = np.dtype(str(kind.dtype))

    def read_array(argument: Any) -> tuple[Any, ...]:
        plain = isinstance(argument, np.ndarray) and not isinstance(argument, np.ma.MaskedArray)
        fits = plain and argument.dtype == dtype
        if not (fits and argument.ndim == 1 and argument.flags.carray):
            raise TypeError
        size, item, place = argument.size, argument.itemsize, argument.__array_interface__["data"]
        return (None, None, size, item, place[0], size, item)

    return read_array


def _kind_of_argument(argument: Any) -> str:
    """The kind of an argument, as numba writes it where it knows it."""
    try:
        return str(_numba.typeof(argument))
    except Exception:  # it says so in many ways
        return str(getattr(argument, "dtype", type(argument).__name__))
