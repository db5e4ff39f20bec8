"""A kernel as loops: straight parts and loops over turns, on a workspace behind the parameters.

A *part* is a small program that is run `count` times. What it takes from outside is an operand:
entries of arrays, one a turn, numbers, one a turn, or what the turn before it left in a scalar.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from codegen.lower.program import Label, Value

Slots = npt.NDArray[np.int64]
Numbers = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Entries:
    """An entry of `array` a turn, at `slots`, shape (count,); `logical`: 0.0 means false."""

    array: str
    slots: Slots
    logical: bool = False


@dataclass(frozen=True, eq=False)
class Carried:
    """What `value` of the body was in the turn before; in the first turn an entry."""

    value: int
    first: "Entries | float"


Operand = Entries | Numbers | Carried


@dataclass(frozen=True, eq=False)
class Store:
    """Store `value` of the body in `array`, at `slots`, shape (count,), one a turn."""

    array: str
    slots: Slots
    value: int


@dataclass(frozen=True, eq=False)
class Part:
    """A body that runs `count` times, turn after turn.

    The first values of the body are its operands, in their order: inputs of the array "".
    """

    count: int
    body: tuple[Value, ...]
    operands: tuple[Operand, ...]
    stores: tuple[Store, ...]
    labels: tuple[Label, ...] = ()
    span: tuple[str, str] = ("", "")  # elements that the first and the last turn serve

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return len(self.body) + len(self.stores)


@dataclass(frozen=True, eq=False)
class Batches:
    """Parts that take turns: each run does the next rows of one of them.

    Attributes
    ----------
    kinds
        What a run may be. Nothing is carried from row to row.
    runs
        Kind, first row and the row behind the last, shape (runs, 3).
    """

    kinds: tuple[Part, ...]
    runs: Slots

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return sum(kind.statements for kind in self.kinds)


@dataclass(frozen=True, eq=False)
class Watch:
    """Checks on pivots in the workspace; shapes (count,)."""

    pivots: Slots
    references: Slots
    parts: Numbers
    constraints: Slots


@dataclass(frozen=True, eq=False)
class RolledKernel:
    """A kernel whose values are computed in parts."""

    parts: tuple[Part | Batches, ...]
    watch: Watch | None
    result: Entries | float | None  # what the kernel returns, where it returns a number
    workspace: int  # slots of ``p`` behind the constants that it writes

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return sum(part.statements for part in self.parts)
