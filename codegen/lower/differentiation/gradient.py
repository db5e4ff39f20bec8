"""Partial derivatives of a value by all its inputs, in one walk back from it.

Φ_q, ν and ∂V/∂q cost a few times what Φ and V do, as by hand, for an expression is never written
out coordinate by coordinate (reverse accumulation; Griewank and Walther, Evaluating Derivatives,
chapter 3). Where the walk meets what depends on one coordinate alone, such as A s, it takes its
slope B s, which is there: Haug's formulas come out.
"""

from collections.abc import Iterable, Mapping

from codegen.lower.differentiation.derivative_along_motion import PLAIN, Direction, Parts
from codegen.lower.differentiation.program_tangents import fractional_power, slopes_of
from codegen.lower.differentiation.turning import Turn
from codegen.lower.graph import SUMS, Graph
from codegen.lower.program import Op, dependencies

PLANE = frozenset({Op.CONST, Op.INPUT, Op.ADD, Op.SUB, Op.NEG, Op.MUL, Op.SIN, Op.COS})
"""Operations of which vectors in a plane consist."""

BREAKING = frozenset({Op.DIV, Op.SQRT, Op.POW, Op.LOG, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN2})
"""Operations that have no finite value or slope everywhere."""


class Slopes:
    """Partial derivatives by some inputs, and by turns about the bodies' axes or the ground's."""

    def __init__(
        self, graph: Graph, inputs: Iterable[int], turns: Iterable[Turn] = (), *,
        in_ground: bool = False,
    ) -> None:  # fmt: skip
        self.graph = graph
        self._by_place: dict[int, tuple[int, ...]] = {
            graph.place_of(k): (k,) for k in frozenset(inputs)
        }
        self._alone: dict[int, Direction] = {}  # input → the derivatives by it, where one is needed
        for turn in turns:
            self._by_place[graph.place_of(turn.axes[0])] = turn.axes
            for k, axis in enumerate(turn.axes):
                self._alone[axis] = turn.along_axis(k, in_ground=in_ground)
        self._all = sum(1 << place for place in self._by_place)

    def gradient(self, weights: Mapping[int, int]) -> dict[int, int]:
        """Input → Σ weight ∂value/∂input, where it is not zero; `weights` maps value → weight."""
        graph = self.graph
        slopes, nothing = dict[int, Parts](), Parts(graph, {})
        queue: dict[int, Parts] = {}
        for number, weight in weights.items():
            self._accumulate(queue, number, Parts.of(graph, weight))
        for number in sorted(dependencies(graph.values, weights), reverse=True):
            share = queue.pop(number, None)
            if not share:
                continue
            with graph.serving(graph.values[number].serves):
                if self._has_cheap_slopes(number):
                    for mover in self._movers(number):
                        leaf = self._leaf(share.single(), number, mover)
                        slopes[mover] = slopes.get(mover, nothing).plus(leaf)
                elif graph.values[number].op is Op.SELECT and self._may_lack_slope(number):
                    for mover, slope in self._choice_slopes(number).items():
                        slopes[mover] = slopes.get(mover, nothing).plus(share.times(slope))
                else:
                    self._back(queue, number, share.single())
        totals = {k: slopes[k].value() for k in sorted(slopes) if slopes[k]}
        return {k: total for k, total in totals.items() if total != graph.zero}

    def _movers(self, number: int) -> list[int]:
        """The inputs by which a value moves, in their order."""
        found, left = list[int](), self.graph.movers(number) & self._all
        while left:
            place = left.bit_length() - 1
            found += self._by_place[place][::-1]
            left ^= 1 << place
        return found[::-1]

    def _has_cheap_slopes(self, number: int) -> bool:
        """Whether the walk back ends here, for the slopes are there or as cheap.

        They are where one coordinate moves a value, and where two do and it is a sum of products
        of theirs and of sines, as the components of a vector that turns twice.
        """
        graph = self.graph
        movers = graph.movers(number) & self._all
        if movers & (movers - 1) == 0:
            return True
        two = movers.bit_count() == 2 and graph.values[number].op in (Op.ADD, Op.SUB)
        return two and all(
            graph.values[k].op in PLANE for k in dependencies(graph.values, [number])
        )

    def _may_lack_slope(self, number: int) -> bool:
        """Whether a side of a choice may have no slope where it does not hold."""
        graph = self.graph
        _, *sides = graph.values[number].args
        inside = dependencies(graph.values, sides)
        return any(graph.values[k].op in BREAKING and not graph.settled[k] for k in inside)

    def _choice_slopes(self, number: int) -> dict[int, int]:
        """Slopes of a choice, of the side that holds: zero times the other's nan would be nan."""
        graph = self.graph
        condition, *sides = graph.values[number].args
        yes, no = (self.gradient({side: graph.one}) for side in sides)
        return {
            mover: graph.select(condition, yes.get(mover, graph.zero), no.get(mover, graph.zero))
            for mover in sorted({*yes, *no})
        }

    def _accumulate(self, queue: dict[int, Parts], number: int, share: Parts) -> None:
        if self.graph.movers(number) & self._all:
            before = queue.get(number)
            queue[number] = share if before is None else before.plus(share)

    def _leaf(self, share: Parts, number: int, mover: int) -> Parts:
        """The share of a value that moves with one input alone, times its slope."""
        if number == mover:
            return share
        graph = self.graph
        if mover not in self._alone:
            self._alone[mover] = Direction(graph, {mover: graph.one}, order=1)
        slope = self._alone[mover].jet(number).first.plain()
        if not slope:
            return slope
        (((outer, _), weight),) = share.parts.items()
        (((inner, _), rest),) = slope.parts.items()
        # The number belongs to the weight, which every component is multiplied by.
        weight = graph.mul(graph.constant(outer * inner), weight)
        return Parts(graph, {PLAIN: self._product(weight, rest)})

    def _product(self, weight: int, slope: int) -> int:
        """Weight times slope, by a product of the slope that is there: a force's component."""
        graph = self.graph
        front = graph.unsigned(weight)
        factors = graph.values[front].args
        for one, other in (factors, factors[::-1]) if graph.values[front].op is Op.MUL else ():
            if graph.has_product(one, graph.unsigned(slope)):
                product = graph.mul(graph.mul(one, slope), other)
                return product if front == weight else graph.neg(product)
        return graph.mul(weight, slope)

    def _back(self, queue: dict[int, Parts], number: int, share: Parts) -> None:
        graph, value = self.graph, self.graph.values[number]
        if (power := fractional_power(graph, number)) is not None:
            self._accumulate(queue, power.base, share.times(power.slope(graph)))
            return
        match value.op:
            case Op.ADD | Op.SUB if (rotated := rotation(graph, number)) is not None:
                angle, slope, parts = rotated
                self._accumulate(queue, angle, share.times(slope))
                for part, factor in parts:
                    self._accumulate(queue, part, share.times(factor))
            case Op.ADD | Op.SUB | Op.NEG:
                for argument, sign in zip(value.args, SUMS[value.op], strict=True):
                    self._accumulate(queue, argument, share.scaled(sign))
            case Op.MUL if value.args[0] == value.args[1]:
                self._accumulate(queue, value.args[0], share.scaled(2.0).times(value.args[0]))
            case Op.DIV:
                one, two = value.args
                share = share.times(graph.div(graph.one, two))
                self._accumulate(queue, one, share)
                self._accumulate(queue, two, share.times(number).scaled(-1.0))
            case Op.SQRT:
                inverse = graph.div(graph.one, number)
                self._accumulate(queue, value.args[0], share.times(inverse).scaled(0.5))
            case Op.SELECT:
                condition, *sides = value.args
                for k, side in enumerate(sides):
                    chosen = {}
                    for factors, weight in share.parts.items():
                        weights = (weight, graph.zero) if k == 0 else (graph.zero, weight)
                        chosen[factors] = graph.select(condition, *weights)
                    self._accumulate(queue, side, Parts(graph, chosen))
            case _:
                for arg, slope in zip(value.args, slopes_of(graph, number), strict=True):
                    if graph.movers(arg) & self._all:
                        self._accumulate(queue, arg, share.times(slope))


def rotation(graph: Graph, number: int) -> tuple[int, int, tuple[tuple[int, int], ...]] | None:
    """A sum a cos θ ± b sin θ: θ, its slope by θ and (a, cos θ), (b, ± sin θ); None for others.

    The slope of one component of a turned vector is the other one, and that is often there.
    """
    value = graph.values[number]
    entries: dict[Op, tuple[int, int]] = {}
    angles = set()
    for arg in value.args:
        if graph.values[arg].op is not Op.MUL:
            return None
        for one, other in (pair := graph.values[arg].args, pair[::-1]):
            if graph.values[one].op in (Op.SIN, Op.COS) and graph.values[one].op not in entries:
                entries[graph.values[one].op] = (one, other)
                angles.add(graph.values[one].args[0])
                break
    if len(entries) < 2 or len(angles) > 1:
        return None
    (c, a), (s, b) = entries[Op.COS], entries[Op.SIN]
    cosine, sine = graph.one, graph.one
    if value.op is Op.SUB:
        first_is_cosine = next(iter(entries)) is Op.COS  # the other may have a cosine as well
        cosine, sine = (cosine, graph.neg(sine)) if first_is_cosine else (graph.neg(cosine), sine)
    slope = graph.sub(graph.mul(sine, graph.mul(b, c)), graph.mul(cosine, graph.mul(a, s)))
    return angles.pop(), slope, ((a, graph.mul(cosine, c)), (b, graph.mul(sine, s)))
