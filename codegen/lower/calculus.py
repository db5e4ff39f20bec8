"""Derivatives of what elements state, value by value in the graph.

Everything that follows from one statement Φ is taken from its values: Φ_q and ν by one walk back
from Φ (reverse accumulation), γ by one walk forward along the motion that carries the first and
second derivative of every value (a Taylor series of length two). Neither writes an expression out
coordinate by coordinate: a cost of a few times that of Φ itself, as by hand (Griewank and Walther,
Evaluating Derivatives, chapters 3, 10 and 13). Haug's formulas come out: where the walk back meets
what depends on one coordinate alone, such as A s, it takes its derivative B s, which is there.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from codegen.lower.graph import Graph
from codegen.lower.parts import PLAIN, Parts
from codegen.lower.program import LOGICAL, Op
from codegen.lower.rebuild import reached
from codegen.lower.tangent import slopes_of


PLANE = frozenset({Op.CONST, Op.INPUT, Op.ADD, Op.SUB, Op.NEG, Op.MUL, Op.SIN, Op.COS})
"""What vectors in a plane are made of."""


class Jet(NamedTuple):
    """First and second derivative along a direction."""

    first: Parts
    second: Parts


class Direction:
    """Derivatives along a straight line in the inputs.

    Parameters
    ----------
    graph
        Where the values are, and where the derivatives go.
    rates
        Input → its derivative along the line, constant on it; those of all others are zero.
    order
        Up to which derivative, 1 or 2.
    """

    def __init__(self, graph: Graph, rates: Mapping[int, int], order: int = 2) -> None:
        self.graph, self.rates, self.order = graph, rates, order
        self._nothing = Jet(Parts(graph, {}), Parts(graph, {}))
        self._known: dict[int, Jet] = {k: self._moving(rate) for k, rate in rates.items()}

    def _moving(self, rate: int) -> Jet:
        return Jet(Parts(self.graph, {PLAIN: rate}), self._nothing.second)

    def jet(self, number: int) -> Jet:
        """Both derivatives of a value."""
        if number not in self._known:
            for k in sorted(reached(self.graph, [number], self._known)):
                if k not in self._known:
                    with self.graph.serving(self.graph.values[k].serves):
                        self._known[k] = self._differentiated(k)
        return self._known[number]

    def _differentiated(self, number: int) -> Jet:
        graph, value = self.graph, self.graph.values[number]
        if not value.args or value.op in LOGICAL or graph.settled[number]:
            return self._nothing
        parts = [self._known[a] for a in value.args]
        if not any(part.first for part in parts):
            return self._nothing
        match value.op:
            case Op.ADD | Op.SUB | Op.NEG:
                signs = (1.0, -1.0) if value.op is Op.SUB else (1.0, 1.0)
                first, second = self._nothing
                for part, sign in zip(parts, signs if value.op is not Op.NEG else (-1.0,), strict=True):
                    first = first.plus(part.first.scaled(sign))
                    second = second.plus(part.second.scaled(sign))
                return Jet(first, second)
            case Op.MUL:
                return self._product(*value.args)
            case Op.DIV:
                return self._quotient(number, *value.args)
            case Op.SQRT:
                return self._root(number, *parts)
            case Op.SIN | Op.COS:
                return self._turned(value.op, value.args[0], parts[0])
            case Op.SELECT:
                return self._chosen(value.args[0], *parts[1:])
        return self._function(number, value.args, parts)

    def _product(self, a: int, b: int) -> Jet:
        one, two = self._known[a], self._known[b]
        if a == b:
            rate = one.first.single()
            first = rate.times(a).scaled(2.0)
            return self._jet(first, lambda: (rate.product(rate), one.second.times(a)), (2.0, 2.0))
        first = one.first.times(b).plus(two.first.times(a))
        return self._jet(
            first,
            lambda: (
                one.first.product(two.first),
                one.second.times(b),
                two.second.times(a),
            ),
            (2.0, 1.0, 1.0),
        )

    def _quotient(self, number: int, a: int, b: int) -> Jet:
        """n = a/b: n' = (a' - n b')/b, n'' = (a'' - n b'' - 2 n' b')/b."""
        graph, (one, two) = self.graph, (self._known[a], self._known[b])
        inverse = graph.div(graph.one, b)
        first = one.first.plus(two.first.times(number).scaled(-1.0)).times(inverse).single()
        return self._jet(
            first,
            lambda: (
                one.second.times(inverse),
                two.second.times(number).times(inverse),
                first.product(two.first).times(inverse),
            ),
            (1.0, -1.0, -2.0),
        )

    def _root(self, number: int, under: Jet) -> Jet:
        """n = √u: n' = u'/(2n), n'' = (u''/2 - n'²)/n."""
        inverse = self.graph.div(self.graph.one, number)
        first = under.first.scaled(0.5).times(inverse).single()

        def second() -> tuple[Parts, ...]:
            rest = under.second.scaled(0.5).plus(first.product(first).scaled(-1.0))
            return (rest.times(inverse),)

        return self._jet(first, second, (1.0,))

    def _turned(self, op: Op, angle: int, turning: Jet) -> Jet:
        """The angle's rate stays outside, so that it is multiplied in once for both components."""
        graph = self.graph
        itself = graph.function(op, angle)
        other = graph.function(Op.COS if op is Op.SIN else Op.SIN, angle)
        slope = Parts(graph, {PLAIN: other if op is Op.SIN else graph.neg(other)})
        rate = turning.first.value()
        first = slope.along(rate)
        bend = Parts(graph, {PLAIN: graph.neg(itself)})
        return self._jet(
            first, lambda: (bend.along(rate).along(rate), turning.second.times(slope.value())), (1.0, 1.0)
        )

    def _chosen(self, condition: int, yes: Jet, no: Jet) -> Jet:
        graph = self.graph

        def either(one: Parts, other: Parts) -> Parts:
            return Parts(graph, {PLAIN: graph.select(condition, one.value(), other.value())})

        return self._jet(either(yes.first, no.first), lambda: (either(yes.second, no.second),), (1.0,))

    def _function(self, number: int, args: tuple[int, ...], parts: list[Jet]) -> Jet:
        """f' = Σ f_k u_k', f'' = Σ f_k u_k'' + (f_k)' u_k'."""
        slopes = slopes_of(self.graph, number)
        first, second = self._nothing
        for slope, part in zip(slopes, parts, strict=True):
            if part.first:
                first = first.plus(part.first.times(slope))
        self._known[number] = Jet(first, second)  # a slope may be made of the value itself
        if self.order > 1:
            for slope, part in zip(slopes, parts, strict=True):
                if part.first:
                    second = second.plus(part.second.times(slope))
                    second = second.plus(self.jet(slope).first.product(part.first))
        return Jet(first, second)

    def _jet(self, first: Parts, second: object, numbers: tuple[float, ...]) -> Jet:
        if self.order < 2:
            return Jet(first, self._nothing.second)
        total = self._nothing.second
        for part, number in zip(second(), numbers, strict=True):  # type: ignore[operator]
            total = total.plus(part.scaled(number))
        return Jet(first, total)


class Slopes:
    """Partial derivatives by walks back.

    Parameters
    ----------
    graph
        Where the values are, and where the derivatives go.
    inputs
        By which to differentiate.
    """

    def __init__(self, graph: Graph, inputs: Iterable[int]) -> None:
        self.graph = graph
        self.inputs = frozenset(inputs)
        self._bits = {1 << graph.place_of(k): k for k in self.inputs}
        self._all = sum(self._bits)
        self._alone: dict[int, Direction] = {}

    def gradient(self, weights: Mapping[int, int]) -> dict[int, int]:
        """Σ weight ∂value/∂input.

        Parameters
        ----------
        weights
            Value → what its derivatives are multiplied by.

        Returns
        -------
        dict
            Input → the sum, where it is not zero.
        """
        graph = self.graph
        found = dict.fromkeys(sorted(self.inputs), Parts(graph, {}))
        waiting: dict[int, Parts] = {}
        for number, weight in weights.items():
            self._hand(waiting, number, Parts.of(graph, weight))
        order = sorted(reached(graph, weights), reverse=True)
        for number in order:
            share = waiting.pop(number, None)
            if not share:
                continue
            with graph.serving(graph.values[number].serves):
                if self._ends(number):
                    for mover in self._movers(number):
                        found[mover] = found[mover].plus(self._leaf(share.single(), number, mover))
                else:
                    self._back(waiting, number, share.single())
        totals = {k: parts.value() for k, parts in found.items() if parts}
        return {k: total for k, total in totals.items() if total != graph.zero}

    def _movers(self, number: int) -> list[int]:
        """The inputs by which a value moves, in their order."""
        left, found = self.graph.movers[number] & self._all, []
        while left:
            bit = left & -left
            found.append(self._bits[bit])
            left -= bit
        return found

    def _ends(self, number: int) -> bool:
        """Whether the walk back ends here, for the slopes are there or as cheap.

        They are where one coordinate moves a value, and where two do and it is a sum of products
        of theirs and of sines, as the components of a vector that turns twice.
        """
        graph = self.graph
        movers = graph.movers[number] & self._all
        if movers & (movers - 1) == 0:
            return True
        two = movers.bit_count() == 2 and graph.values[number].op in (Op.ADD, Op.SUB)
        return two and all(graph.values[k].op in PLANE for k in reached(graph, [number]))

    def _hand(self, waiting: dict[int, Parts], number: int, share: Parts) -> None:
        if self.graph.movers[number] & self._all:
            before = waiting.get(number)
            waiting[number] = share if before is None else before.plus(share)

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
        value, sign = graph.values[weight], 1
        if value.op is Op.NEG:
            value, sign = graph.values[value.args[0]], -1
        bare = graph.values[slope].args[0] if graph.values[slope].op is Op.NEG else slope
        if value.op is Op.MUL:
            for one, other in (value.args, value.args[::-1]):
                if graph.has_product(one, bare):
                    product = graph.mul(graph.mul(one, slope), other)
                    return product if sign > 0 else graph.neg(product)
        return graph.mul(weight, slope)

    def _back(self, waiting: dict[int, Parts], number: int, share: Parts) -> None:
        graph, value = self.graph, self.graph.values[number]
        match value.op:
            case Op.ADD | Op.SUB if (turned := rotation(graph, number)) is not None:
                angle, slope, parts = turned
                self._hand(waiting, angle, share.times(slope))
                for part, factor in parts:
                    self._hand(waiting, part, share.times(factor))
            case Op.ADD | Op.SUB:
                one, two = value.args
                self._hand(waiting, one, share)
                self._hand(waiting, two, share if value.op is Op.ADD else share.scaled(-1.0))
            case Op.NEG:
                self._hand(waiting, value.args[0], share.scaled(-1.0))
            case Op.MUL:
                one, two = value.args
                if one == two:
                    self._hand(waiting, one, share.scaled(2.0).times(one))
                    return
                self._hand(waiting, one, share.times(two))
                self._hand(waiting, two, share.times(one))
            case Op.DIV:
                one, two = value.args
                share = share.times(graph.div(graph.one, two))
                self._hand(waiting, one, share)
                self._hand(waiting, two, share.times(number).scaled(-1.0))
            case Op.SQRT:
                inverse = graph.div(graph.one, number)
                self._hand(waiting, value.args[0], share.times(inverse).scaled(0.5))
            case Op.SELECT:
                condition, yes, no = value.args
                for side, kept in ((yes, (1, 0)), (no, (0, 1))):
                    chosen = {
                        factors: graph.select(
                            condition,
                            *(weight if keep else graph.zero for keep in kept),
                        )
                        for factors, weight in share.parts.items()
                    }
                    self._hand(waiting, side, Parts(graph, chosen))
            case _:
                for arg, slope in zip(value.args, slopes_of(graph, number), strict=True):
                    if graph.movers[arg] & self._all:
                        self._hand(waiting, arg, share.times(slope))


def rotation(graph: Graph, number: int) -> tuple[int, int, tuple[tuple[int, int], ...]] | None:
    """A sum a cos θ ± b sin θ: θ, its slope by θ and (a, cos θ), (b, ± sin θ); None for others.

    The slope of one component of a turned vector is the other one, and that is often there.
    """
    value = graph.values[number]
    found: dict[Op, tuple[int, int]] = {}
    angles = set()
    for arg in value.args:
        if graph.values[arg].op is not Op.MUL:
            return None
        for one, other in (pair := graph.values[arg].args, pair[::-1]):
            if graph.values[one].op in (Op.SIN, Op.COS) and graph.values[one].op not in found:
                found[graph.values[one].op] = (one, other)
                angles.add(graph.values[one].args[0])
                break
    if len(found) < 2 or len(angles) > 1:
        return None
    (c, a), (s, b) = found[Op.COS], found[Op.SIN]
    first_is_cosine = graph.values[value.args[0]] .args.count(c) > 0
    cosine, sine = graph.one, graph.one
    if value.op is Op.SUB:
        cosine, sine = (cosine, graph.neg(sine)) if first_is_cosine else (graph.neg(cosine), sine)
    slope = graph.sub(
        graph.mul(sine, graph.mul(b, c)), graph.mul(cosine, graph.mul(a, s))
    )
    return angles.pop(), slope, ((a, graph.mul(cosine, c)), (b, graph.mul(sine, s)))
