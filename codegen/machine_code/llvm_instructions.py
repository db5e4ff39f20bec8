"""LLVM's instructions, and the values that they take and make."""

import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import count

FLOAT, INTEGER, TRUTH = "double", "i64", "i1"  # code: LLVM's names of the kinds of numbers
UNSIGNED = "i32"  # code: of the entries of a table, which are read as whole numbers
COMPARISONS = {"==": "eq", "!=": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}


class UntranslatableError(Exception):
    """A construct that generated kernels do not have."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number, or the truth of a condition: its text as an operand, and its kind.

    Attributes
    ----------
    unsigned
        Whether it is an entry of a table of whole numbers without sign, with which numba calculates
        in another way where no number with a sign takes part.
    """

    text: str
    kind: str
    unsigned: bool = False

    def __str__(self) -> str:
        return f"{self.kind} {self.text}"


@dataclass(frozen=True, slots=True)
class Array:
    """A contiguous array: the address of its first number, its kind, and its lengths."""

    address: str
    kind: str
    shape: tuple[Number, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """Several numbers, of a function that returns them or of an assignment."""

    numbers: tuple[Number, ...]


Value = Number | Array | Group


def structure_of(kinds: Iterable[str]) -> str:
    """The kind of a structure of several numbers."""
    return f"{{{', '.join(kinds)}}}"


def float_literal(value: float) -> Number:
    """A number as its 64 bits."""
    (bits,) = struct.unpack("<Q", struct.pack("<d", value))
    return Number(f"0x{bits:016X}", FLOAT)


def integer_literal(value: int) -> Number:
    """A whole number of 64 bits."""
    if not -(1 << 63) <= value < 1 << 63:
        raise UntranslatableError(str(value))
    return Number(str(value), INTEGER)


def is_literal(number: Number) -> bool:
    """Whether a number is known by its text."""
    return not number.text.startswith("%")


@dataclass(slots=True)
class Instructions:
    """The instructions of one function, in blocks.

    Attributes
    ----------
    flags
        What the optimizer may do with floating-point numbers, as in "contract".
    variables
        The instructions that make room for variables: the first block.
    block
        The label of the block that is being written; None behind its end.
    """

    flags: str
    lines: list[str] = field(default_factory=list)
    variables: list[str] = field(default_factory=list)
    block: str | None = "B.begin"
    _numbers: Callable[[], int] = field(default_factory=lambda: count().__next__)

    def label(self) -> str:
        """A new label."""
        return f"B.{self._numbers()}"

    def begin(self, label: str) -> None:
        """Begin the block with a label, to which the block before goes on if it has no end."""
        if self.block is not None:
            self.lines.append(f"  br label %{label}")
        self.lines.append(f"{label}:")
        self.block = label

    def end(self, instruction: str) -> None:
        """End the block with a jump or return; behind another one, nothing gets there."""
        if self.block is not None:
            self.lines.append(f"  {instruction}")
            self.block = None

    def jump(self, label: str) -> None:
        """Go on at a label."""
        self.end(f"br label %{label}")

    def branch(self, condition: Number, yes: str, no: str) -> None:
        """Go on at one of two labels."""
        self.end(f"br i1 {condition.text}, label %{yes}, label %{no}")

    def result(self, instruction: str, kind: str) -> Number:
        """The number that an instruction makes."""
        name = f"%.{self._numbers()}"
        self.lines.append(f"  {name} = {instruction}")
        return Number(name, kind)

    def store(self, number: Number, address: str) -> None:
        """Write a number to an address."""
        self.lines.append(f"  store {number}, ptr {address}")

    def load(self, address: str, kind: str) -> Number:
        """Read a number from an address."""
        return self.result(f"load {kind}, ptr {address}", kind)

    def read(self, array: Array, place: Number) -> Number:
        """An element of an array."""
        number = self.load(self.element(array, place), array.kind)
        if array.kind != UNSIGNED:
            return number
        return replace(self.result(f"zext {number} to i64", INTEGER), unsigned=True)

    def variable(self, kind: str) -> str:
        """The address of a new variable."""
        name = f"%.{self._numbers()}"
        self.variables.append(f"  {name} = alloca {kind}")
        return name

    def element(self, array: Array, place: Number) -> str:
        """The address of an element, whose place counts from the first."""
        pointer = f"getelementptr {array.kind}, ptr {array.address}, {place}"
        return self.result(pointer, "ptr").text

    def calculation(self, operation: str, a: Number, b: Number) -> Number:
        """The result of an operation on two numbers of one kind."""
        flags = f" {self.flags}" if a.kind == FLOAT and self.flags else ""
        return self.result(f"{operation}{flags} {a}, {b.text}", a.kind)

    def comparison(self, sign: str, a: Number, b: Number) -> Number:
        """Whether a relation holds; nothing but != holds for what is no number."""
        name = COMPARISONS[sign]
        if a.kind == FLOAT:
            order = "u" if sign == "!=" else "o"
            flags = f"{self.flags} " if self.flags else ""
            return self.result(f"fcmp {flags}{order}{name} {a}, {b.text}", TRUTH)
        signed = name if sign in ("==", "!=") else f"s{name}"
        return self.result(f"icmp {signed} {a}, {b.text}", TRUTH)

    def call(self, function: str, kind: str, *arguments: Number) -> Number:
        """What a function returns."""
        flags = f"{self.flags} " if kind == FLOAT and self.flags else ""
        operands = ", ".join(map(str, arguments))
        return self.result(f"call {flags}{kind} @{function}({operands})", kind)

    def packed(self, group: Group) -> Number:
        """Several numbers as one structure."""
        structure = Number("undef", structure_of(number.kind for number in group.numbers))
        for place, number in enumerate(group.numbers):
            structure = self.result(f"insertvalue {structure}, {number}, {place}", structure.kind)
        return structure

    def unpacked(self, structure: Number, kinds: Sequence[str]) -> Group:
        """The numbers of a structure."""
        return Group(
            tuple(
                self.result(f"extractvalue {structure}, {place}", kind)
                for place, kind in enumerate(kinds)
            )
        )

    def choice(self, kind: str, *sides: tuple[Number, str]) -> Number:
        """The number that comes from the block by which one got here."""
        texts = ", ".join(f"[{number.text}, %{label}]" for number, label in sides)
        return self.result(f"phi {kind} {texts}", kind)

    def selection(self, condition: Number, yes: Number, no: Number) -> Number:
        """One of two numbers that both are there."""
        return self.result(f"select i1 {condition.text}, {yes}, {no}", yes.kind)

    def as_float(self, number: Number) -> Number:
        """A number as a floating-point one."""
        if number.kind == INTEGER:
            return self.result(f"sitofp {number} to {FLOAT}", FLOAT)
        if number.kind == TRUTH:
            return self.result(f"uitofp {number} to {FLOAT}", FLOAT)
        return number

    def as_integer(self, number: Number) -> Number:
        """A number without what stands behind the point."""
        if number.kind == FLOAT:
            return self.result(f"fptosi {number} to {INTEGER}", INTEGER)
        if number.kind == TRUTH:
            return self.result(f"zext {number} to {INTEGER}", INTEGER)
        return number

    def truth(self, number: Number) -> Number:
        """Whether a number is not zero."""
        if number.kind == TRUTH:
            return number
        zero = float_literal(0.0) if number.kind == FLOAT else integer_literal(0)
        return self.comparison("!=", number, zero)
