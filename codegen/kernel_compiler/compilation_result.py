"""One kernel → the result of a compilation, as numba keeps and calls it."""

import ast
import sys
from types import FunctionType
from typing import Any

from llvmlite import binding  # type: ignore[import-untyped]
from numba import types
from numba.core import bytecode, compiler, config, environment, funcdesc
from numba.core.typing import templates

from codegen.kernel_compiler.llvm_instructions import (
    FLOAT,
    INTEGER,
    Array,
    Number,
    UntranslatableError,
)
from codegen.kernel_compiler.llvm_module import Kernel, translate

_config: Any = config
_compiler: Any = compiler  # numba leaves these untyped
_Descriptor: Any = funcdesc.PythonFunctionDescriptor
_Identity: Any = bytecode.FunctionIdentity
_Environment: Any = environment.Environment
_templates: Any = templates
_llvm: Any = binding

_KINDS: dict[Any, str] = {types.float64: FLOAT, types.int64: INTEGER}
# The sizes of numbers, and where numba writes what an exception would need.
_HEAD = 'target datalayout = "{layout}"\n@"{environment}" = common global ptr null\n'


def compile_kernel(state: tuple[Any, ...], function: FunctionType) -> Any:
    """The result for what numba gives its compiler; UntranslatableError for what is no kernel."""
    typing_context, context, _, arguments, returned, flags, _ = state
    context = _compiler._make_subtarget(context, flags)
    descriptor = _descriptor(function, context, arguments, returned, flags)
    kernel = describe_kernel(descriptor, flags)
    text = translate(
        syntax_tree(function), kernel, function.__globals__, lambda f: syntax_tree(f.py_func)
    )
    library = _library(context.codegen(), descriptor, text)
    globals_of_it = _Environment.from_fndesc(descriptor)
    entry = context.get_executable(library, descriptor, globals_of_it)
    context.insert_user_function(entry, descriptor, [library])
    return _compiler.compile_result(
        typing_context=typing_context, target_context=context, entry_point=entry,
        typing_error=None, type_annotation="", library=library, call_helper=None,
        signature=_templates.signature(returned, *arguments), objectmode=False, lifted=(),
        fndesc=descriptor, environment=globals_of_it, metadata={}, reload_init=[],
    )  # fmt: skip


def _descriptor(function: Any, context: Any, arguments: Any, returned: Any, flags: Any) -> Any:
    """What numba knows of a function that it has compiled."""
    identity = _Identity.from_function(function)
    return _Descriptor(
        native=True, modname=function.__module__, qualname=identity.func_qualname,
        unique_name=identity.unique_name, doc=function.__doc__ or "", typemap=None,
        restype=returned, calltypes=None, args=tuple(identity.arg_names), kws=(),
        mangler=context.mangler, argtypes=tuple(arguments), inline=False, noalias=False,
        abi_tags=[flags.get_mangle_string()], uid=identity.unique_id,
    )  # fmt: skip


def describe_kernel(descriptor: Any, flags: Any) -> Kernel:
    """A kernel as numba's callers know it: an array is seven parameters of machine code."""
    checks = (
        flags.boundscheck or _config.BOUNDSCHECK or flags.debuginfo or flags.error_model != "numpy"
    )
    entries = not (flags.no_cpython_wrapper and flags.no_cfunc_wrapper)
    if descriptor.restype is None or checks or entries:
        raise UntranslatableError("a function that numba adds something to")
    head = ["ptr noalias %.results", "ptr noalias %.exception"]
    if len(descriptor.args) != len(descriptor.argtypes):
        raise UntranslatableError("a signature of another length")
    parameters: list[Number | Array] = []
    for name, kind in zip(descriptor.args, descriptor.argtypes, strict=True):
        if isinstance(kind, types.Array):
            if kind.ndim != 1 or kind.layout != "C":
                raise UntranslatableError(str(kind))
            owner = f"ptr %{name}.owner, ptr %{name}.parent, i64 %{name}.size, i64 %{name}.item"
            head.append(f"{owner}, ptr %{name}, i64 %{name}.length, i64 %{name}.stride")
            length = Number(f"%{name}.length", INTEGER)
            parameters.append(Array(f"%{name}", _kind(kind.dtype), (length,)))
        else:
            number = Number(f"%{name}", _kind(kind))
            head.append(str(number))
            parameters.append(number)
    result: Any = descriptor.restype
    results: Any = result if isinstance(result, types.BaseTuple) else (result,)
    return Kernel(
        symbol=descriptor.mangled_name,
        head=", ".join(head),
        parameters=tuple(parameters),
        results=tuple(_kind(one) for one in results if one != types.none),
        flags=" ".join(sorted(flags.fastmath.flags)),
    )


def _kind(numba_type: Any) -> str:
    if numba_type not in _KINDS:
        raise UntranslatableError(str(numba_type))
    return _KINDS[numba_type]


def syntax_tree(function: Any) -> ast.FunctionDef:
    """The syntax tree of a function of an imported text."""
    loader = getattr(sys.modules.get(function.__module__), "__loader__", None)
    lines = getattr(loader, "lines", None)
    if lines is None:
        raise UntranslatableError(f"{function.__module__} is no imported text")
    code = function.__code__
    first = code.co_firstlineno - 1  # of its decorator
    last = first + 1
    while last < len(lines) and lines[last][:1] in ("d", " ", ")", "\n"):
        last += 1
    try:
        body = ast.parse("".join(lines[first:last])).body
    except SyntaxError as error:
        raise UntranslatableError(f"the text of {code.co_name}") from error
    end = first + max(node.end_lineno or 0 for node in body)
    whole = end >= max(line for _, line, *_ in code.co_positions() if line)
    match body:
        case [ast.FunctionDef(name=code.co_name) as tree] if whole:
            return tree
    raise UntranslatableError(f"the text of {code.co_name}")


def _library(machine: Any, descriptor: Any, text: str) -> Any:
    """A text of LLVM's as a library of numba's, which will be kept on disk."""
    library = machine.create_library(descriptor.qualname)
    library.enable_object_caching()
    head = _HEAD.format(layout=machine._data_layout, environment=descriptor.env_name)
    try:
        module = _llvm.parse_assembly(f"{head}{text}")
    except RuntimeError as error:
        raise UntranslatableError(str(error)) from error
    library.add_llvm_module(module)
    return library
