"""The kernels of a text → a module in LLVM's language, with the functions and tables that they use.

The operations, their order and the licence to contract a product and a sum are those that numba
would take from the text.
"""

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.machine_code.function_translation import FunctionTranslation
from codegen.machine_code.llvm_instructions import (
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

_WORDS = ("ptr", "ptr", "i64", "i64", "ptr", "i64", "i64")  # code: of an array, by numba
_ARRAY = "{ptr, ptr, i64, i64, ptr, [1 x i64], [1 x i64]}"
_ITEMS = {"float64": FLOAT, "int64": INTEGER, "uint32": UNSIGNED}  # numpy's names of kinds


Source = Callable[[Any], "Declaration"]
"""Returns what a function of the text declares; UntranslatableError if it is none."""


@dataclass(frozen=True)
class Kernel:
    """What callers know of a kernel.

    Attributes
    ----------
    symbol
        The linker's name.
    head
        The parameters of the machine code, of which numba's callers know several for an array.
    parameters
        The kernel's own, in their order.
    results
        Kinds of the numbers that it stores where the first parameter points.
    """

    symbol: str
    head: str
    parameters: tuple[Number | Array, ...]
    results: tuple[str, ...]


@dataclass(frozen=True)
class Declaration:
    """A function of the text, as others call it: kinds of arguments and results, if declared."""

    tree: ast.FunctionDef
    flags: str
    kinds: tuple[tuple[str, ...], tuple[str, ...]] | None


@dataclass(slots=True)
class LlvmModule:
    """The module of a text's kernels; other parts enter when something first uses them.

    Attributes
    ----------
    names
        Those that the text knows.
    source
        Returns what a function of the text declares.
    prefix
        What symbols begin with.
    flags
        What the optimizer may do with floating-point numbers, as in "contract".
    """

    names: Mapping[str, Any]
    source: Source
    prefix: str
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

    def add(self, tree: ast.FunctionDef, kernel: Kernel) -> None:
        """Add a kernel with a syntax tree; UntranslatableError at what no kernel has."""
        if not kernel.head.isascii():
            raise UntranslatableError(f"the parameters {kernel.head}")
        if len(tree.args.args) != len(kernel.parameters):
            raise UntranslatableError("parameters of another kind")
        parameters = dict(zip((p.arg for p in tree.args.args), kernel.parameters, strict=True))
        function = FunctionTranslation(self, parameters, kernel.results, is_kernel=True)
        function.run(tree)
        self.define(f'i32 @"{kernel.symbol}"({kernel.head})', function.code)
        if len(kernel.results) < 2:
            self.definitions.append(_entry_from_c(kernel))

    def declaration(self, name: str) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
        """Kinds of the arguments and results that a function of the text declares, if it does."""
        declared = self.source(self.names[name])
        if declared.flags != self.flags:
            raise UntranslatableError(f"{name} is compiled with other options")
        return declared.kinds

    def callee(
        self, name: str, kinds: tuple[str, ...], declared: tuple[str, ...]
    ) -> tuple[str, tuple[str, ...]]:
        """(symbol, kinds of its results) of a function of the text for arguments of some kinds."""
        if (name, kinds) not in self.callees:
            tree = self.source(self.names[name]).tree
            words = [name, *(p.arg for p in tree.args.args)]
            if len(words) != 1 + len(kinds) or not "".join(words).isascii():
                raise UntranslatableError(f"{name} of {len(kinds)} arguments")
            parameters = {
                p.arg: Number(f"%{p.arg}", k) for p, k in zip(tree.args.args, kinds, strict=True)
            }
            function = FunctionTranslation(self, parameters, declared)
            function.run(tree)
            results = function.results
            symbol = f'"{self.prefix}{name}.{len(self.callees)}"'
            kind = results[0] if len(results) == 1 else structure_of(results)
            head = ", ".join(map(str, parameters.values()))
            self.define(f"internal {kind} @{symbol}({head}) alwaysinline", function.code)
            self.callees[name, kinds] = symbol, results
        return self.callees[name, kinds]

    def define(self, head: str, code: Instructions) -> None:
        """Add a function."""
        lines = [*code.variables, "  br label %B.begin", "B.begin:", *code.lines]
        self.definitions.append("\n".join([f"define {head} {{", *lines, "}"]))


def _entry_from_c(kernel: Kernel) -> str:
    """A function that calls a kernel and returns what it stores; an array is a structure."""
    (result,) = kernel.results or ("ptr",)
    heads, lines, words = [], [], ["ptr %.result", "ptr %.exception"]
    for k, parameter in enumerate(kernel.parameters):
        if isinstance(parameter, Number):
            heads.append(f"{parameter.kind} %a{k}")
            words.append(f"{parameter.kind} %a{k}")
            continue
        heads.append(f"{_ARRAY} %a{k}")
        for place, kind in enumerate(_WORDS):
            path = f"{place}, 0" if place > 4 else f"{place}"  # the last are arrays of one
            lines.append(f"  %a{k}.{place} = extractvalue {_ARRAY} %a{k}, {path}")
            words.append(f"{kind} %a{k}.{place}")
    return "\n".join(
        [
            f'define {result} @"{kernel.symbol}.c"({", ".join(heads)}) {{',
            f"  %.result = alloca {result}",
            "  %.exception = alloca ptr",
            *lines,
            f'  %.status = call i32 @"{kernel.symbol}"({", ".join(words)})',
            f"  %.value = load {result}, ptr %.result",
            f"  ret {result} %.value",
            "}",
        ]
    )
