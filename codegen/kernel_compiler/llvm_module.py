"""A kernel → a module in LLVM's language: the kernel, and the functions and tables that it uses.

The operations, their order and the licence to contract a product and a sum are those that numba
would take from the text, so results agree but for the contractions that LLVM then chooses.
"""

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.kernel_compiler.function_translation import FunctionTranslation
from codegen.kernel_compiler.llvm_instructions import (
    FLOAT,
    INTEGER,
    UNSIGNED,
    Array,
    Instructions,
    Number,
    UntranslatableError,
    integer_literal,
    structure_of,
)

_OPTIONS = {"error_model": "numpy"}
_NUMBERS = {"float64": FLOAT, "int64": INTEGER}  # numba's names of kinds
_ITEMS = {"float64": FLOAT, "int64": INTEGER, "uint32": UNSIGNED}


Source = Callable[[Any], ast.FunctionDef]
"""Gives the syntax tree of a function."""


@dataclass(frozen=True)
class Kernel:
    """What callers know of a kernel.

    Attributes
    ----------
    symbol
        The linker's name.
    head
        The parameters of the machine code, of which numba makes several for an array.
    parameters
        The kernel's own, in their order.
    results
        Kinds of the numbers that it stores where the first parameter points.
    flags
        What the optimizer may do with floating-point numbers, as in "contract".
    """

    symbol: str
    head: str
    parameters: tuple[Number | Array, ...]
    results: tuple[str, ...]
    flags: str


def translate(
    tree: ast.FunctionDef, kernel: Kernel, names: Mapping[str, Any], source: Source
) -> str:
    """The module of a kernel with the syntax tree `tree`; `names` are those that its text knows.

    Raises UntranslatableError at what no kernel has.
    """
    module = LlvmModule(names, source, kernel.symbol, kernel.flags)
    if not kernel.head.isascii():
        raise UntranslatableError(f"the parameters {kernel.head}")
    if len(tree.args.args) != len(kernel.parameters):
        raise UntranslatableError("parameters of another kind")
    parameters = dict(zip((p.arg for p in tree.args.args), kernel.parameters, strict=True))
    function = FunctionTranslation(module, parameters, kernel.results, is_kernel=True)
    function.run(tree)
    module.define(f'i32 @"{kernel.symbol}"({kernel.head})', function.code)
    return module.text()


@dataclass(slots=True)
class LlvmModule:
    """The module of a kernel; its parts enter when something first uses them."""

    names: Mapping[str, Any]
    source: Source
    symbol: str
    flags: str
    tables: dict[str, str] = field(default_factory=dict)
    declarations: dict[str, str] = field(default_factory=dict)
    callees: dict[tuple[str, tuple[str, ...]], tuple[str, tuple[str, ...]]] = field(
        default_factory=dict
    )
    definitions: list[str] = field(default_factory=list)

    def text(self) -> str:
        """The whole in LLVM's language."""
        parts = (*self.tables.values(), *self.declarations.values(), *self.definitions)
        return "\n".join([*parts, ""])

    def table(self, name: str, values: Any) -> Array:
        """An array that the text knows, as a constant."""
        kind = _ITEMS.get(str(values.dtype))
        if kind is None or not (values.ndim and values.flags.c_contiguous and name.isascii()):
            raise UntranslatableError(f"the array {name}")
        address = f"@table.{name}"
        if name not in self.tables:
            flat = values.ravel()
            numbers = flat.view(np.uint64).tolist() if kind == FLOAT else flat.tolist()
            form = f"{kind} 0x%016X" if kind == FLOAT else f"{kind} %d"
            entries = ", ".join([form % number for number in numbers])
            self.tables[name] = (
                f"{address} = internal unnamed_addr constant [{flat.size} x {kind}] [{entries}]"
            )
        return Array(address, kind, tuple(map(integer_literal, values.shape)))

    def external(self, function: str, arguments: int, effects: str) -> str:
        """The name of a function elsewhere, from floating-point numbers to one."""
        kinds = ", ".join([FLOAT] * arguments)
        self.declarations[function] = f"declare {FLOAT} @{function}({kinds}){effects}"
        return function

    def declaration(self, name: str) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
        """Kinds of the arguments and results that a function of the text declares, if it does."""
        function = self.names[name]
        options = getattr(function, "targetoptions", _OPTIONS | {"fastmath": self.flags.split()})
        strict = options.get("error_model") == "numpy" and not options.get("boundscheck")
        allowed = options.get("fastmath") or ()
        if not strict or allowed is True or set(allowed) != set(self.flags.split()):
            raise UntranslatableError(f"{name} is compiled with other options")
        if getattr(function, "_can_compile", True):
            return None
        (result,) = function.overloads.values()
        returned = result.signature.return_type
        each = returned if hasattr(returned, "types") else (returned,)
        kinds = tuple(
            tuple(_NUMBERS.get(str(one), "") for one in some)
            for some in (result.signature.args, each)
        )
        if "" in (*kinds[0], *kinds[1]):
            raise UntranslatableError(f"{name} has other than numbers")
        return kinds[0], kinds[1]

    def callee(
        self, name: str, kinds: tuple[str, ...], declared: tuple[str, ...]
    ) -> tuple[str, tuple[str, ...]]:
        """(symbol, kinds of its results) of a function of the text for arguments of some kinds."""
        if (name, kinds) not in self.callees:
            tree = self.source(self.names[name])
            words = [name, *(p.arg for p in tree.args.args)]
            if len(words) != 1 + len(kinds) or not "".join(words).isascii():
                raise UntranslatableError(f"{name} of {len(kinds)} arguments")
            parameters = {
                p.arg: Number(f"%{p.arg}", k) for p, k in zip(tree.args.args, kinds, strict=True)
            }
            function = FunctionTranslation(self, parameters, declared)
            function.run(tree)
            results = function.results
            symbol = f'"{self.symbol}.{name}.{len(self.callees)}"'
            kind = results[0] if len(results) == 1 else structure_of(results)
            head = ", ".join(map(str, parameters.values()))
            self.define(f"internal {kind} @{symbol}({head}) alwaysinline", function.code)
            self.callees[name, kinds] = symbol, results
        return self.callees[name, kinds]

    def define(self, head: str, code: Instructions) -> None:
        """Add a function."""
        lines = [*code.variables, "  br label %B.begin", "B.begin:", *code.lines]
        self.definitions.append("\n".join([f"define {head} {{", *lines, "}"]))
