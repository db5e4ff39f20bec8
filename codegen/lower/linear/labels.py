"""Names for the values of a solution, by which a reader of the generated text finds his way.

An entry of the reduced matrix is called after its unknowns (``M_crank_phi``, ``Phi_B_x_rod_phi``),
a right side after its equation, a pivot and its inverse after the unknown that it eliminates. Names
change nothing in the operations; the first role of a value counts.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from codegen.lower.program import Check, Kernel, Label, Output

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
