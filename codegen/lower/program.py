"""The intermediate representation: values, kernels, a program. Plain data, no mathematics.

A *value* is one scalar operation on earlier values; values are numbered, and equal values have
one number. A *kernel* is a named list of (output slot, value). There is no control flow but
``select``, whose condition depends on modes, or on time and parameters alone, and no memory but
inputs and outputs.

`Labels` name the values of a solution, by which a reader of the generated text finds his way. An
entry of the reduced matrix is called after its unknowns (``M_crank_phi``, ``Phi_B_x_rod_phi``), a
right side after its equation, a pivot and its inverse after the unknown that it eliminates. Names
change nothing in the operations; the first role of a value counts.
"""

from collections import Counter
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

from codegen.tables.piecewise_cubic import Table


class Op(Enum):
    """The operations."""

    __hash__ = object.__hash__  # measured: that of `Enum` took a tenth of the time of lowering

    CONST = "const"
    INPUT = "input"
    ADD = "+"
    SUB = "-"
    MUL = "*"
    DIV = "/"
    NEG = "neg"
    SIN = "sin"
    COS = "cos"
    TAN = "tan"
    ASIN = "asin"
    ACOS = "acos"
    ATAN = "atan"
    ATAN2 = "atan2"
    SINH = "sinh"
    COSH = "cosh"
    TANH = "tanh"
    EXP = "exp"
    LOG = "log"
    SQRT = "sqrt"
    FLOOR = "floor"
    POW = "pow"
    TABLE = "table"
    LESS = "<"
    MODE = "mode"
    SLIDING = "sliding"
    NOT = "not"
    AND = "and"
    OR = "or"
    SELECT = "select"


LEAVES = frozenset({Op.CONST, Op.INPUT, Op.MODE})
COMMUTATIVE = frozenset({Op.ADD, Op.MUL, Op.AND, Op.OR})
LOGICAL = frozenset({Op.MODE, Op.SLIDING, Op.NOT, Op.AND, Op.OR, Op.LESS})
ELEMENTARY = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2"),
    *("sinh", "cosh", "tanh", "exp", "log", "sqrt", "pow", "floor"),
)
"""Functions that `math` knows under the names of their operations."""
FUNCTIONS = frozenset(map(Op, (*ELEMENTARY, "table")))


class Input(NamedTuple):
    """Slot `slot` of the argument `array` (``t`` has one slot), called `name` in the text."""

    array: str
    slot: int
    name: str


class Lookup(NamedTuple):
    """A derivative of a table."""

    table: Table
    order: int


class Folded(NamedTuple):
    """How a constant came about: `sign` (``+``, ``*``, ``sin`` …) of `numbers`; `note` names it."""

    sign: str
    numbers: tuple[float, ...]
    note: str = ""


Literal = float | int | Input | Lookup | None


class Value(NamedTuple):
    """One operation."""

    op: Op
    args: tuple[int, ...] = ()  # numbers of the values that it takes
    # the float of a constant, the slot of an input, the number of a mode, a table's derivative
    literal: Literal = None
    serves: str = ""  # element for which the value was first needed; a comment in the text
    origin: Folded | None = None  # of a constant computed from others: which; for the text alone


class Output(NamedTuple):
    """Store `value` in slot `slot` of the argument `array`; `note` is its comment."""

    array: str
    slot: int
    value: int
    note: str = ""


class Check(NamedTuple):
    """`pivot` is weak when it is not above `part` of `reference` times the program's tolerance."""

    pivot: int
    reference: int
    constraint: int
    part: float = 1.0


class Label(NamedTuple):
    """A name for `value` in the text of a kernel, and the step of a solution that computes it."""

    value: int
    name: str
    step: int = 0


@dataclass(frozen=True, slots=True)
class Kernel:
    """One function of the generated module."""

    name: str
    summary: str  # what it answers
    arguments: tuple[str, ...]  # in order; `t` is a float, `modes` integers, the rest float arrays
    outputs: tuple[Output, ...]  # an output to the array "return" is returned
    checks: tuple[Check, ...] = ()  # pivots to watch
    watched: bool = False  # whether it returns 0 or 1 + the first weak constraint
    labels: tuple[Label, ...] = ()  # names of values, for the text alone
    steps: tuple[str, ...] = ()  # what each step of a solution does

    @property
    def roots(self) -> list[int]:
        """The values that are stored or checked."""
        checked = (v for check in self.checks for v in (check.pivot, check.reference))
        return [*(out.value for out in self.outputs), *checked]


@dataclass(frozen=True)
class Program:
    """All kernels of a scene over one numbering of values."""

    values: tuple[Value, ...]  # in order: a value's arguments have smaller numbers
    kernels: tuple[Kernel, ...]  # in the order of the text
    # Values that stand in `p` behind the declared parameters, in the order of their slots: stiction
    # forces, which a run sets, then what depends on parameters alone.
    constants: tuple[int, ...]
    weak_pivot: float  # the tolerance of the checks
    # place of one of the kernels → the numbers that it computes, once they were asked for
    _reachable: dict[int, tuple[int, ...]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    _counts: dict[int, Counter[Op]] = field(  # how many values of each kind these are
        default_factory=dict, init=False, repr=False, compare=False
    )

    @cached_property
    def lookups(self) -> frozenset[Lookup]:
        """The derivatives of tables that its values take."""
        return frozenset(v.literal for v in self.values if isinstance(v.literal, Lookup))

    def reachable(self, kernel: Kernel) -> tuple[int, ...]:
        """Numbers of the values that `kernel` computes, in order; constants of p are leaves."""
        place = self._place(kernel)
        if place is not None and place in self._reachable:
            return self._reachable[place]
        found = dependencies(self.values, kernel.roots, self.hoisted(kernel))
        numbers = tuple(sorted(found))
        if place is not None:
            self._reachable[place] = numbers
        return numbers

    def note_reachable(self, kernel: Kernel, numbers: Iterable[int]) -> None:
        """Keep what one of the kernels computes, from one who knows it, in order."""
        place = self._place(kernel)
        assert place is not None
        self._reachable[place] = tuple(numbers)
        self._counts.pop(place, None)

    def counts(self, kernel: Kernel) -> Mapping[Op, int]:
        """How many values of each kind `kernel` reaches, leaves too, without constants of p."""
        place = self._place(kernel)
        if place is not None and place in self._counts:
            return MappingProxyType(self._counts[place])
        hoisted, values = self.hoisted(kernel), self.values
        found = Counter(values[k].op for k in self.reachable(kernel) if k not in hoisted)
        if place is not None:
            self._counts[place] = found
        return MappingProxyType(found)

    def _place(self, kernel: Kernel) -> int | None:
        return next((k for k, own in enumerate(self.kernels) if own is kernel), None)

    def hoisted(self, kernel: Kernel) -> frozenset[int]:
        """The values that `kernel` reads from ``p`` instead of computing them."""
        return frozenset(self.constants if kernel.name != "constants" else ())


def dependencies(
    values: Sequence[Value], roots: Iterable[int], stop: Container[int] = ()
) -> set[int]:
    """The roots and all values that they depend on, but not those below the ones in `stop`."""
    stack, numbers = list(roots), set[int]()
    while stack:
        number = stack.pop()
        if number not in numbers:
            numbers.add(number)
            if number not in stop:
                stack.extend(values[number].args)
    return numbers


STATE = ("t", "q", "v", "p")  # the arguments that most kernels begin with


def store(array: str, values: Sequence[int], notes: Sequence[str]) -> tuple[Output, ...]:
    """Outputs that fill `array` in order."""
    pairs = zip(values, notes, strict=True)
    return tuple(Output(array, k, value, note) for k, (value, note) in enumerate(pairs))


def storing(
    name: str, summary: str, arguments: str, values: Sequence[int], notes: Sequence[str]
) -> Kernel:
    """The kernel that stores `values` in the last of its arguments, which stand in one string."""
    names = tuple(arguments.split())
    return Kernel(name, summary, names, store(names[-1], values, notes))


_label = tuple.__new__  # measured: a named tuple's own takes four times as long


@dataclass
class Labels:
    """Collects the names of one solution, step by step."""

    names: Sequence[str] = ()  # of the unknowns; empty where nothing is to be named
    right: Sequence[Sequence[str]] = ()  # of the right sides, one list a column
    solution: Sequence[Sequence[str]] = ()  # of the unknowns' values, one list a column
    matrix: str = "M"  # stem of an entry between two unknowns that are no multipliers
    by_value: dict[int, Label] = field(default_factory=dict)  # value → its name and its step
    steps: list[str] = field(default_factory=list)  # the title of each step, for a comment

    def kernel(
        self, name: str, summary: str, arguments: str, outputs: tuple[Output, ...],
        checks: Iterable[Check],
    ) -> Kernel:  # fmt: skip
        """The kernel of the solution, which watches its pivots; its arguments in one string."""
        labels, steps = tuple(self.by_value.values()), tuple(self.steps)
        names = tuple(arguments.split())
        return Kernel(name, summary, names, outputs, tuple(checks), True, labels, steps)

    def step(self, title: str) -> None:
        """Begin a step with the comment `title`."""
        self.steps.append(title)

    def add(self, value: int, name: str) -> None:
        """Name a value, unless it has a name."""
        if self.names and value not in self.by_value:
            self.by_value[value] = _label(Label, (value, name, len(self.steps) - 1))

    def name(self, value: int, stem: str, *unknowns: int) -> None:
        """Name a value after a stem and unknowns, unless it has a name."""
        if self.names and value not in self.by_value:
            self.add(value, self.of(stem, *unknowns))

    def of(self, stem: str, *unknowns: int) -> str:
        """The name from a stem and unknowns."""
        return "_".join((stem, *(self.names[i] for i in unknowns))) if self.names else stem

    def pivot(self, value: int, inverse: int, unknown: int) -> None:
        """Name a pivot and its inverse."""
        if self.names:
            name, step = self.of("pivot", unknown), len(self.steps) - 1
            before = self.by_value.get(value)
            self.by_value[value] = Label(value, name, before.step if before else step)
            self.name(inverse, "inverse", unknown)

    def entry(self, value: int, i: int, j: int, duals: frozenset[int] = frozenset()) -> None:
        """Name an entry of the reduced matrix: Phi of a multiplier and a coordinate."""
        if not self.names or value in self.by_value:
            return
        if i in duals and j not in duals:
            i, j = j, i
        mixed = j in duals and i not in duals
        stem = "Phi" if mixed else "S" if i in duals else self.matrix
        pair = (j, i) if mixed else (i,) if i == j else (i, j) if i < j else (j, i)
        self.add(value, self.of(stem, *pair))

    def sides(self, values: Sequence[Sequence[int]], unknown: int) -> None:
        """Name the right sides of one equation."""
        if self.names:
            for names, column in zip(self.right, values, strict=True):
                self.add(column[unknown], names[unknown])

    def solved(self, columns: Sequence[Sequence[int]]) -> None:
        """Name the values of the unknowns."""
        for names, column in zip(self.solution, columns, strict=False):
            for name, value in zip(names, column, strict=True):
                self.add(value, name)

    def titles(self, *unknowns: int) -> str:
        """Names of unknowns, for a comment."""
        return ", ".join(self.names[i] for i in unknowns) if self.names else ""
