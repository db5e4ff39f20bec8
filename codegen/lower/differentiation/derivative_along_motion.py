"""Derivatives along a direction: those of a value, first and second, in one walk forward.

Along the motion, with q̇ for the rates of q and 1 for that of t, the second derivative of Φ is
Φ_q q̈ - γ without the accelerations, so γ = -Φ'': by a Taylor series of length two through every
value of Φ, instead of by pairs of coordinates (Griewank and Walther, Evaluating Derivatives,
chapters 10 and 13). Rates of angles stay outside sums (`codegen.lower.factored_sums`), so that
Haug's formulas come out: ω² times the components of A s, that are there.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from codegen.lower.differentiation.program_tangents import (
    FractionalPower,
    fractional_power,
    slopes_of,
)
from codegen.lower.factored_sums import PLAIN, Parts
from codegen.lower.graph import SUMS, Graph
from codegen.lower.program import LOGICAL, Op, dependencies

Terms = Callable[[], Iterable[tuple[float, Parts]]]


class Jet(NamedTuple):
    """First and second derivative along a direction."""

    first: Parts
    second: Parts


class Direction:
    """Derivatives of values of a graph along a straight line in the inputs, up to `order` 1 or 2.

    `rates` maps inputs to their derivatives along the line, constant on it; others have none.
    """

    def __init__(self, graph: Graph, rates: Mapping[int, int], order: int = 2) -> None:
        self.graph, self.order = graph, order
        # Slopes need no second derivative: that of aᵇ has a slope of its own without end. A cycle
        # with itself would keep the graph in memory.
        self._inner = Direction(graph, rates, order=1) if order > 1 else None
        self._nothing = Jet(Parts(graph, {}), Parts(graph, {}))
        self._known = {k: Jet(self._plain(rate), self._nothing.second) for k, rate in rates.items()}

    @property
    def _slopes(self) -> "Direction":
        """The direction in which the slopes of functions are differentiated."""
        return self._inner or self

    def jet(self, number: int) -> Jet:
        """Both derivatives of a value."""
        if number not in self._known:
            values = self.graph.values
            for k in sorted(dependencies(values, [number], self._known)):
                if k in self._known:
                    continue
                with self.graph.serving(values[k].serves):
                    self._known[k] = self._differentiate(k)
        return self._known[number]

    def _plain(self, value: int) -> Parts:
        return Parts(self.graph, {PLAIN: value})

    def _differentiate(self, number: int) -> Jet:
        graph, value = self.graph, self.graph.values[number]
        if not value.args or value.op in LOGICAL or graph.settled[number]:
            return self._nothing
        parts = [self._known[a] for a in value.args]
        if not any(part.first for part in parts):
            return self._nothing
        if (power := fractional_power(graph, number)) is not None:
            return self._power(power)
        match value.op:
            case Op.ADD | Op.SUB | Op.NEG:
                return self._sum(parts, SUMS[value.op])
            case Op.MUL:
                return self._product(*value.args)
            case Op.DIV:
                return self._quotient(number, *value.args)
            case Op.SQRT:
                return self._root(number, parts[0])
            case Op.SIN | Op.COS:
                return self._sine(value.op, value.args[0], parts[0])
            case Op.SELECT:
                return self._choice(value.args[0], parts[1], parts[2])
        return self._function(number, parts)

    def _sum(self, jets: list[Jet], signs: tuple[int, ...]) -> Jet:
        first, second = self._nothing
        for jet, sign in zip(jets, signs, strict=True):
            first = first.plus(jet.first.scaled(sign))
            second = second.plus(jet.second.scaled(sign))
        return Jet(first, second)

    def _jet(self, first: Parts, terms: Terms) -> Jet:
        """A jet whose second derivative is a sum, formed on demand."""
        second = self._nothing.second
        if self.order > 1:
            for number, part in terms():
                second = second.plus(part.scaled(number))
        return Jet(first, second)

    def _product(self, a: int, b: int) -> Jet:
        """n = a b: n' = a' b + a b', n'' = a'' b + 2 a' b' + a b''."""
        one, two = self._known[a], self._known[b]
        if a == b:
            rate = one.first.single()
            return self._jet(
                rate.times(a).scaled(2.0),
                lambda: ((2.0, rate.product(rate)), (2.0, one.second.times(a))),
            )
        return self._jet(
            one.first.times(b).plus(two.first.times(a)),
            lambda: (
                (2.0, one.first.product(two.first)),
                (1.0, one.second.times(b)),
                (1.0, two.second.times(a)),
            ),
        )

    def _quotient(self, number: int, a: int, b: int) -> Jet:
        """n = a/b: n' = (a' - n b')/b, n'' = (a'' - n b'' - 2 n' b')/b."""
        one, two = self._known[a], self._known[b]
        inverse = self.graph.div(self.graph.one, b)
        first = one.first.plus(two.first.times(number).scaled(-1.0)).times(inverse).single()
        return self._jet(
            first,
            lambda: (
                (1.0, one.second.times(inverse)),
                (-1.0, two.second.times(number).times(inverse)),
                (-2.0, first.product(two.first).times(inverse)),
            ),
        )

    def _power(self, power: FractionalPower) -> Jet:
        """n = bᵉ: n' = e bᵉ⁻¹ b', n'' = e bᵉ⁻¹ b'' + e (e - 1) bᵉ⁻² b'²."""
        under, slope = self._known[power.base], power.slope(self.graph)

        def second() -> Iterable[tuple[float, Parts]]:
            yield 1.0, under.second.times(slope)
            yield 1.0, self._plain(power.bend(self.graph, under.first.value()))

        return self._jet(under.first.times(slope), second)

    def _root(self, number: int, under: Jet) -> Jet:
        """n = √u: n' = u'/(2n), n'' = (u''/2 - n'²)/n."""
        inverse = self.graph.div(self.graph.one, number)
        first = under.first.scaled(0.5).times(inverse).single()

        def second() -> Iterable[tuple[float, Parts]]:
            rest = under.second.scaled(0.5).plus(first.product(first).scaled(-1.0))
            yield 1.0, rest.times(inverse)

        return self._jet(first, second)

    def _sine(self, op: Op, angle: int, turning: Jet) -> Jet:
        """The angle's rate stays outside, so that it is multiplied in once for both components."""
        graph = self.graph
        slope = graph.function(Op.COS if op is Op.SIN else Op.SIN, angle)
        slope = slope if op is Op.SIN else graph.neg(slope)
        rate = turning.first.value()
        bend = self._plain(graph.neg(graph.function(op, angle)))
        return self._jet(
            self._plain(slope).along(rate),
            lambda: ((1.0, bend.along(rate).along(rate)), (1.0, turning.second.times(slope))),
        )

    def _choice(self, condition: int, yes: Jet, no: Jet) -> Jet:
        def either(one: Parts, other: Parts) -> Parts:
            return self._plain(self.graph.select(condition, one.value(), other.value()))

        first = either(yes.first, no.first)
        return self._jet(first, lambda: ((1.0, either(yes.second, no.second)),))

    def _function(self, number: int, parts: list[Jet]) -> Jet:
        """n' = Σ f_k u_k', n'' = Σ f_k u_k'' + (f_k)' u_k' with the slopes f_k of a function."""
        pairs = list(zip(slopes_of(self.graph, number), parts, strict=True))
        moving = [(slope, part) for slope, part in pairs if part.first]
        first = self._nothing.first
        for slope, part in moving:
            first = first.plus(part.first.times(slope))

        def second() -> Iterable[tuple[float, Parts]]:
            for slope, part in moving:
                yield 1.0, part.second.times(slope)
                yield 1.0, self._slopes.jet(slope).first.product(part.first)

        return self._jet(first, second)
