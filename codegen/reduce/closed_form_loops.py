"""Loops with a solution in closed form.

With every coordinate but the angle θ known, a constraint of rigid bodies reads

    A sin θ + B cos θ + C = 0,   R² = A² + B²,   ρ = √(R² - C²),
    sin θ = (-A C - σ B ρ)/R²,   cos θ = (-B C + σ A ρ)/R²,   ∂Φ/∂θ = A cos θ - B sin θ = σ ρ,

with the branch σ = ±1 on which the loop was assembled. Two constraints that close a loop of two
bodies, a + R(θ) b + R(η) d = 0 with plane turns R, give one such equation by |a + R(θ) b|² = |d|²,
and η from the remaining equation. Where ρ vanishes the two branches meet: a dead centre.

C is the constraint with sin θ = cos θ = 0, A and B are its derivatives by these. The form is tested
numerically: an identity of analytic functions that holds at a few random points holds everywhere.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from random import Random
from typing import NamedTuple

from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.graph import Graph, substitute
from codegen.lower.interpreter import evaluate
from codegen.lower.program import Kernel, Op, Program, dependencies, store

POINTS = 4  # measured: random points at which an identity is tested
AGREED = 1e-9  # accuracy: numbers with a smaller difference, in parts of their sizes, are equal


class Angle(NamedTuple):
    """An angle in closed form."""

    column: int  # of the coordinate
    row: int  # of the constraint in whose name a dead centre is reported
    s: int  # sine
    c: int  # cosine
    discriminant: int | None = None  # ρ², which vanishes at a dead centre
    size: int | None = None  # the largest that ρ² may be
    slope: int | None = None  # σ ρ, whose sign is the branch; None where other equations decide
    branch: int | None = None  # the input σ


class Loop(NamedTuple):
    """Rows that are solved for as many angles."""

    rows: tuple[int, ...]
    angles: tuple[Angle, ...]

    @property
    def columns(self) -> tuple[int, ...]:
        """Columns of its angles."""
        return tuple(angle.column for angle in self.angles)


def find_loops(
    graph: Graph, q: Sequence[int], phi: Mapping[int, int], angles: Sequence[int],
    first_branch: int, own: Mapping[int, int],
    suits: Callable[[int, int], bool] = lambda square, size: True,
) -> list[Loop]:  # fmt: skip
    """The loops with a solution in closed form, in an order in which each needs only those before.

    `q`: the inputs that are the coordinates, by column; `phi`: row → value in the coordinates that
    are left; `angles`: columns that may be solved for; `first_branch`: slot of ``p``; `own`: row of
    each own coordinate of a joint. It alone determines the coordinate: another row of the joint may
    contain the place of a contact, but its derivative by it vanishes wherever the curves touch. Nor
    is it solved for anything else, which would leave the coordinate to such a row. `suits` says of
    ρ² and the largest that it may be whether a loop is to be solved so.
    """
    search, loops = _LoopSearch(graph, q, first_branch, own, suits), []
    phi, angles = dict(phi), list(angles)
    while loop := search.next_loop(phi, angles):
        loops.append(loop)
        for row in loop.rows:
            del phi[row]
        for column in loop.columns:
            angles.remove(column)
    return loops


class _LoopSearch:
    """The forms of a loop, and the branches that they have taken."""

    def __init__(
        self, graph: Graph, q: Sequence[int], first_branch: int, own: Mapping[int, int],
        suits: Callable[[int, int], bool],
    ) -> None:  # fmt: skip
        self.graph, self.q, self.branch, self.own, self.suits = graph, q, first_branch, own, suits

    def next_loop(self, phi: dict[int, int], angles: list[int]) -> Loop | None:
        """A loop of one row, else of two."""
        unknown = {self.q[k]: k for k in angles}
        support = {}
        for i, value in phi.items():
            reachable = dependencies(self.graph.values, [value])
            support[i] = tuple(sorted(unknown[number] for number in unknown if number in reachable))
        for i, columns in support.items():
            determined = self._is_determined(columns, (i,))
            if len(columns) == 1 and determined and (form := self._form(phi[i], columns)):
                start, ((a, b),) = form
                if angle := self._angle(i, *columns, a, b, start):
                    return Loop((i,), (angle,))
        for i, j in combinations(support, 2):
            columns = tuple(sorted({*support[i], *support[j]}))
            determined = self._is_determined(columns, (i, j))
            if len(columns) == 2 and len(support[i]) > 0 < len(support[j]) and determined:
                for pair in (columns, columns[::-1]):
                    if loop := self._pair((i, j), (phi[i], phi[j]), *pair):
                        return loop
        return None

    def _is_determined(self, columns: tuple[int, ...], rows: tuple[int, ...]) -> bool:
        """Whether own coordinates of joints stand with the rows that determine them alone."""
        return all((k in columns) == (i in rows) for k, i in self.own.items())

    # -- forms -------------------------------------------------------------------------------

    def _pair(
        self, rows: tuple[int, int], phi: tuple[int, int], column: int, last: int
    ) -> Loop | None:
        graph = self.graph
        forms = [self._form(value, (column, last)) for value in phi]
        if forms[0] is None or forms[1] is None:
            return None
        (u, ((a, b), (d, e))), (w, ((f, g), (h, k))) = forms[0], forms[1]
        for first, second, third, fourth in ((a, b, f, g), (d, e, h, k)):
            # [first second; third fourth] times its transposed is a number times one.
            across = graph.add(graph.mul(first, third), graph.mul(second, fourth))
            one, two = self._squares(first, second), self._squares(third, fourth)
            if not self._zero(across, one) or not self._zero(graph.sub(one, two), one):
                return None
        two = graph.constant(2.0)
        arm, reach = self._squares(a, b), self._squares(d, e)
        sine = graph.mul(two, graph.add(graph.mul(u, a), graph.mul(w, f)))
        cosine = graph.mul(two, graph.add(graph.mul(u, b), graph.mul(w, g)))
        rest = graph.add(self._squares(u, w), graph.sub(arm, reach))
        size = graph.mul(graph.constant(4.0), graph.mul(arm, reach))
        angle = self._angle(max(rows), column, sine, cosine, rest, size)
        if angle is None:
            return None
        x = graph.total([u, graph.mul(a, angle.s), graph.mul(b, angle.c)])
        y = graph.total([w, graph.mul(f, angle.s), graph.mul(g, angle.c)])
        # [d e; h k] (s, c) = -(x, y), by the transposed.
        inverse = graph.neg(graph.div(graph.one, reach))
        s = graph.mul(inverse, graph.add(graph.mul(d, x), graph.mul(h, y)))
        c = graph.mul(inverse, graph.add(graph.mul(e, x), graph.mul(k, y)))
        return Loop(rows, (angle, Angle(last, max(rows), s, c)))

    def _angle(
        self, row: int, column: int, a: int, b: int, start: int, size: int | None = None
    ) -> Angle | None:
        graph = self.graph
        square = self._squares(a, b)
        size = square if size is None else size
        discriminant = graph.sub(square, graph.mul(start, start))
        if not self.suits(discriminant, size):
            return None
        name = graph.values[self.q[column]].literal.name  # type: ignore[union-attr]
        branch = graph.input("p", self.branch, f"branch_{name}")
        self.branch += 1
        root = graph.mul(branch, graph.power(discriminant, 0.5))
        inverse = graph.div(graph.one, square)
        s = graph.neg(graph.add(graph.mul(a, start), graph.mul(b, root)))
        c = graph.sub(graph.mul(a, root), graph.mul(b, start))
        sine, cosine = self._sine_cosine(column)
        slope = graph.sub(graph.mul(a, cosine), graph.mul(b, sine))
        ends = graph.mul(inverse, s), graph.mul(inverse, c)
        return Angle(column, row, *ends, discriminant, size, slope, branch)

    def _squares(self, a: int, b: int) -> int:
        return self.graph.add(self.graph.mul(a, a), self.graph.mul(b, b))

    def _form(
        self, value: int, columns: tuple[int, ...]
    ) -> tuple[int, tuple[tuple[int, int], ...]] | None:
        """C and (A, B) of each angle, if the value is linear in their sines and cosines."""
        graph = self.graph
        ends = [self._sine_cosine(k) for k in columns]
        still = {number: graph.zero for pair in ends for number in pair}
        if dependencies(graph.values, [value], still) & {self.q[k] for k in columns}:
            return None
        (start,) = substitute(graph, [value], still)

        def slope(number: int) -> int:
            """Derivative by a sine or cosine, where all sines and cosines are zero."""
            return substitute(graph, differentiate(graph, [value], {number: graph.one}), still)[0]

        factors = [(slope(sine), slope(cosine)) for sine, cosine in ends]
        terms = [start]
        for (sine, cosine), (a, b) in zip(ends, factors, strict=True):
            terms += [graph.mul(a, sine), graph.mul(b, cosine)]
        if not self._zero(graph.sub(graph.total(terms), value), value):
            return None
        # Where the angle cancels, as in a link between two bodies of one pin, rounding is left.
        if any(self._holds(self._squares(*pair), start, _is_rounding) for pair in factors):
            return None
        return start, tuple(factors)

    def _sine_cosine(self, column: int) -> tuple[int, int]:
        angle = self.q[column]
        return self.graph.function(Op.SIN, angle), self.graph.function(Op.COS, angle)

    def _zero(self, value: int, size: int) -> bool:
        """Whether a value is zero at random points, compared with the size of another."""
        if value == self.graph.zero:
            return True
        return self._holds(value, size, lambda x, size: abs(x) <= AGREED * (1.0 + abs(size)))

    def _holds(self, value: int, size: int, test: Callable[[float, float], bool]) -> bool:
        """Whether two values pass a test at random points."""
        kernel = Kernel("test", "", (), store("out", [value, size], ["", ""]))
        program = Program(tuple(self.graph.values), (kernel,), (), 0.0)
        for point in range(POINTS):
            try:
                out = evaluate(program, "test", RandomPoint(point), math)["out"]
            except (ValueError, ZeroDivisionError, OverflowError):
                return False
            if not test(out[0], out[1]):
                return False
        return True


def _is_rounding(square: float, size: float) -> bool:
    """Whether a length, given by its square, is rounding beside another."""
    return square <= (AGREED * size) ** 2


class RandomPoint(dict[str, object]):
    """Arguments of kernels at a random point, the same in every build."""

    def __init__(self, point: int) -> None:
        super().__init__()
        self.point = point

    def __missing__(self, array: str) -> object:
        draw = Random(f"{array} {self.point}")
        if array == "t":
            return draw.uniform(0.1, 1.0)
        if array == "modes":
            return [draw.random() < 0.5 for _ in range(10_000)]
        span = (0.5, 1.5) if array == "p" else (-3.0, 3.0)
        return [draw.uniform(*span) for _ in range(10_000)]
