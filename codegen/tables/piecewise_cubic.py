"""Functions by cubic pieces: plain numbers, which every stage may hold."""

import hashlib
import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

MARGIN = 1e-9  # accuracy: rounding of a law's argument beyond its ends, in parts of its length

Row = tuple[float, float, float, float]
Beyond = Literal["stop", "hold", "extrapolate"]
Role = Literal["values", "end", "knots", "range"]


@dataclass(frozen=True)
class Table:
    """A function given by points, a cubic between two knots."""

    name: str  # an identifier
    knots: tuple[float, ...]  # ascending; the last of a periodic table is the first, a period later
    rows: tuple[Row, ...]  # (c0, c1, c2, c3): c0 + c1 s + c2 s² + c3 s³ with s from the left knot
    periodic: bool
    # Beyond the ends of one that does not repeat: undefined (nan), the value at the end, or the
    # cubic of the last piece.
    beyond: Beyond = "stop"
    smooth: int = 2  # how many derivatives are continuous at the knots
    kind: str = "spline"
    # "end": what another table is at its ends; "knots", "range": a switching function of another
    role: Role = "values"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the numbers."""
        numbers: tuple[Any, ...] = (self.knots, self.rows, self.periodic)
        if (more := (self.beyond, self.smooth, self.role)) != ("stop", 2, "values"):
            numbers += more
        return hashlib.sha256(repr(numbers).encode()).hexdigest()

    @property
    def first(self) -> float:
        """Where it begins."""
        return self.knots[0]

    @property
    def last(self) -> float:
        """Where it ends, or begins to repeat."""
        return self.knots[-1]

    @property
    def length(self) -> float:
        """From the first point to the last."""
        return self.last - self.first

    @property
    def stops(self) -> bool:
        """Whether it is undefined beyond its ends."""
        return not self.periodic and self.beyond == "stop"

    @property
    def held(self) -> tuple[float, float] | None:
        """The values before its first and behind its last point, where it holds them."""
        if self.periodic or self.beyond != "hold":
            return None
        c0, c1, c2, c3 = self.rows[-1]
        s = self.knots[-1] - self.knots[-2]
        return self.rows[0][0], c0 + s * (c1 + s * (c2 + s * c3))

    def __call__(self, x: Any, order: int = 0) -> Any:
        """The value or a derivative at a number of any kind; complex numbers by their real part."""
        at = float(getattr(x, "real", x))
        if math.isnan(at):
            return math.nan
        if self.periodic:
            turns = math.floor((at - self.first) / self.length)
            x, at = x - turns * self.length, at - turns * self.length
        elif self.stops and not -MARGIN <= (at - self.first) / self.length <= 1 + MARGIN:
            return math.nan
        elif (held := self.held) and not self.first <= at <= self.last:
            return (held[int(at > self.last)] if order == 0 else 0.0) + 0 * x
        inner = bisect_right(self.knots, at, 1, len(self.knots) - 1) - 1
        s, row = x - self.knots[inner], self.rows[inner]
        return derivative_at(row, s, order)


class Excess(NamedTuple):
    """The place furthest outside of the values at the knots."""

    at: float
    value: float
    share: float  # of their range


def excess(table: Table) -> Excess | None:
    """By how much a table leaves the range of its points; None where it stays inside."""
    ends = [row[0] for row in table.rows]
    ends.append(derivative_at(table.rows[-1], table.knots[-1] - table.knots[-2], 0))
    low, high = min(ends), max(ends)
    worst = None
    for (left, right), row in zip(pairwise(table.knots), table.rows, strict=True):
        for s in _turning_places(row, right - left):
            value = derivative_at(row, s, 0)
            beyond = max(value - high, low - value)
            if beyond > 0.0 and (worst is None or beyond > worst.share):
                worst = Excess(left + s, value, beyond)
    return worst and worst._replace(share=worst.share / (high - low) if high > low else math.inf)


def _turning_places(row: Row, length: float) -> Iterator[float]:
    """Where the slope of a piece vanishes inside of it: c1 + 2 c2 s + 3 c3 s² = 0."""
    _, c1, c2, c3 = row
    under = c2 * c2 - 3 * c1 * c3
    if under < 0.0:
        return
    half = -(c2 + math.copysign(math.sqrt(under), c2))
    for top, bottom in ((half, 3 * c3), (c1, half)):
        if bottom != 0.0 and 0.0 < top / bottom < length:
            yield top / bottom


def derivative_at(row: Row, s: Any, order: int) -> Any:
    """A derivative of a piece, `s` from its left knot."""
    c0, c1, c2, c3 = row
    if order == 0:
        return c0 + s * (c1 + s * (c2 + s * c3))
    if order == 1:
        return c1 + s * (2 * c2 + s * (3 * c3))
    return 2 * c2 + s * (6 * c3) if order == 2 else 6 * c3 + 0 * s
