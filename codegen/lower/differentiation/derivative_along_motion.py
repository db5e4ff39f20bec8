"""Derivatives along a direction: those of a value, first and second, in one walk forward.

Along the motion, with q̇ for the rates of q and 1 for that of t, the second derivative of Φ is
Φ_q q̈ - γ without the accelerations, so γ = -Φ'': by a Taylor series of length two through every
value of Φ, instead of by pairs of coordinates (Griewank and Walther, Evaluating Derivatives,
chapters 10 and 13).

The result is a sum of products of rates, ω_i² a + 2 ω_i b + ω_j² c. By hand one writes a, b and c
as sums over components and multiplies by the rates at the end; `Parts` keeps the three apart until
the sum is needed as one value. So Haug's formulas come out: ω² times the components of A s, that
are there. Equal values are one in the graph: a part that another equation has too is not computed
again.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import reduce
from types import MappingProxyType
from typing import NamedTuple

from codegen.lower.differentiation.program_tangents import (
    FractionalPower,
    fractional_power,
    slopes_of,
)
from codegen.lower.graph import SUMS, Graph
from codegen.lower.program import LOGICAL, Op, dependencies

Factors = tuple[float, tuple[int, ...]]  # a positive number, and rates in order of their numbers

PLAIN: Factors = (1.0, ())


class Parts:
    """Σ number · rates · value."""

    def __init__(self, graph: Graph, parts: Mapping[Factors, int]) -> None:
        self.graph = graph
        # factors → the value that they multiply, its sign included; no value is zero
        self.parts = {factors: value for factors, value in parts.items() if value != graph.zero}

    @classmethod
    def of(cls, graph: Graph, value: int) -> "Parts":
        """One value, the number in front of it set apart."""
        number, rest = _split(graph, value)
        return cls(graph, {(number, ()): rest})

    def __bool__(self) -> bool:
        """Whether there is anything but zero."""
        return bool(self.parts)

    def plus(self, other: "Parts") -> "Parts":
        """The sum; parts with the same factors are added."""
        if not (self.parts and other.parts):
            return self if self.parts else other
        terms = dict(self.parts)
        for factors, value in other.parts.items():
            terms[factors] = self.graph.add(terms.get(factors, self.graph.zero), value)
        return Parts(self.graph, terms)

    def scaled(self, number: float) -> "Parts":
        """The sum, times a number."""
        if number == 1.0:
            return self
        graph, terms = self.graph, dict[Factors, int]()
        for (factor_terms, rates), value in self.parts.items():
            terms[factor_terms * abs(number), rates] = value if number > 0 else graph.neg(value)
        return Parts(graph, terms if number else {})

    def times(self, value: int) -> "Parts":
        """The sum, times a value: one product.

        A number is multiplied in before, so that other products with the same factor share it;
        only where it stands alone it goes on, for a square may meet it.
        """
        graph = self.graph
        if value == graph.one or not self:
            return self
        (((terms, rates), front),) = self.single().parts.items()
        if graph.number(front) is not None:
            number, rest = _split(graph, value)
            return Parts(graph, {(terms * number, rates): graph.mul(front, rest)})
        if not graph.indicates(front):
            front, terms = graph.mul(graph.constant(terms), front), 1.0
        return Parts(graph, {(terms, rates): graph.mul(front, value)})

    def spread(self, value: int) -> "Parts":
        """The sum, times a value: a product a part."""
        graph = self.graph
        return Parts(graph, {of: graph.mul(part, value) for of, part in self.parts.items()})

    def outside(self, value: int) -> "Parts":
        """The sum, times a value that the rates multiply: what they multiplied stays outside."""
        graph, found = self.graph, Parts(self.graph, {})
        for (number, rates), part in self.parts.items():
            bare = graph.unsigned(part)
            inner = reduce(graph.mul, rates, value if bare == part else graph.neg(value))
            found = found.plus(Parts(graph, {(number, (bare,)): inner}))
        return found

    def product(self, other: "Parts") -> "Parts":
        """The sum, times another."""
        if not (self and other):
            return Parts(self.graph, {})
        (((a, one), x),) = self.single().parts.items()
        (((b, two), y),) = other.single().parts.items()
        return Parts(self.graph, {(a * b, tuple(sorted((*one, *two)))): self.graph.mul(x, y)})

    def along(self, rate: int) -> "Parts":
        """The sum, times a rate that stays outside."""
        if rate == self.graph.one:
            return self
        terms = {(c, tuple(sorted((*r, rate)))): value for (c, r), value in self.parts.items()}
        return Parts(self.graph, terms)

    def single(self) -> "Parts":
        """The same with one part at the most."""
        return self if len(self.parts) <= 1 else Parts(self.graph, {PLAIN: self.value()})

    def plain(self) -> "Parts":
        """The same with one part at the most, and no rates."""
        bare = all(not rates for _, rates in self.parts)
        return self.single() if bare else Parts(self.graph, {PLAIN: self.value()})

    def value(self) -> int:
        """The sum as one value.

        What several monomials of rates multiply is multiplied once, and a rate that several parts
        share is multiplied in once (Horner).
        """
        graph = self.graph
        alike: dict[int, dict[Factors, int]] = {}
        for factors, value in self.parts.items():
            bare = graph.unsigned(value)
            alike.setdefault(bare, {})[factors] = graph.one if bare == value else graph.minus_one
        if any(len(factors) > 1 for factors in alike.values()):
            terms = [graph.mul(_polynomial(graph, f), value) for value, f in alike.items()]
            return graph.total(terms)
        return self._summed()

    def _summed(self) -> int:
        graph = self.graph
        counts = Counter(rate for _, rates in self.parts for rate in set(rates))
        shared = max(counts, key=lambda rate: (counts[rate], -rate), default=None)
        if shared is not None and counts[shared] > 1:
            inner, rest = {}, {}
            for (number, rates), value in self.parts.items():
                if shared in rates:
                    k = rates.index(shared)
                    inner[number, rates[:k] + rates[k + 1 :]] = value
                else:
                    rest[number, rates] = value
            outside = Parts(graph, rest)._summed()
            return graph.add(outside, graph.mul(shared, Parts(graph, inner)._summed()))
        return graph.total([self._term(*factors, value) for factors, value in self.parts.items()])

    def _term(self, number: float, rates: tuple[int, ...], value: int) -> int:
        graph = self.graph
        front = reduce(graph.mul, rates, graph.one)
        return graph.mul(graph.constant(number), graph.mul(front, value))


def _split(graph: Graph, value: int) -> tuple[float, int]:
    """The number in front of a value, and the rest; a sign is the rest's, but that of a number."""
    node = graph.values[value]
    number = graph.number(value)
    if number is not None:
        return abs(number), graph.constant(1.0 if number >= 0.0 else -1.0)
    if node.op is Op.NEG:
        number, rest = _split(graph, node.args[0])
        return number, graph.neg(rest)
    if node.op is Op.MUL:
        for one, other in (node.args, node.args[::-1]):
            number = graph.number(one)
            if number is not None:
                return abs(number), other if number > 0.0 else graph.neg(other)
    return 1.0, value


def _polynomial(graph: Graph, monomials: dict[Factors, int]) -> int:
    """A sum of monomials of rates, each with ±1: a square where it is one, as (ω_i - ω_j)²."""
    ones = [rates for number, rates in monomials if number == 1.0]
    squares = [rates[0] for rates in ones if len(rates) == 2 and rates[0] == rates[1]]
    if len(monomials) == 3 and len(squares) == 2:
        a, b = sorted(squares)
        signs = [monomials[1.0, (k, k)] for k in (a, b)]
        mixed = monomials.get((2.0, (a, b)))
        if mixed is not None and signs[0] == signs[1]:
            rate = graph.add(a, b) if mixed == signs[0] else graph.sub(a, b)
            return graph.mul(signs[0], graph.mul(rate, rate))
    return Parts(graph, monomials)._summed()


Terms = Callable[[], Iterable[tuple[float, Parts]]]


class Jet(NamedTuple):
    """First and second derivative along a direction."""

    first: Parts
    second: Parts


class Direction:
    """Derivatives of values of a graph along a straight line in the inputs, up to `order` 1 or 2.

    `rates` maps inputs to their derivatives along the line, constant on it; others have none.
    `jets` has values whose derivatives are known, such as the entries of a rotation matrix. With
    `first`, min or max, they are those by global axes: numbers multiply the parts of a sum, as of a
    turned vector f, which are there, and fᵀb is kept as fᵀ(…), where what f is multiplied by serves
    other vectors of the body too; of two turned vectors f is that of the first or last body.
    """

    def __init__(
        self, graph: Graph, rates: Mapping[int, int], order: int = 2,
        jets: Mapping[int, Jet] = MappingProxyType({}), *, first: Callable[..., int] | None = None,
    ) -> None:  # fmt: skip
        self.graph, self.order, self.first = graph, order, first
        # Slopes need no second derivative: that of aᵇ has a slope of its own without end. A cycle
        # with itself would keep the graph in memory.
        self._inner = Direction(graph, rates, 1, jets, first=first) if order > 1 else None
        self._nothing = Jet(Parts(graph, {}), Parts(graph, {}))
        self._known = {k: Jet(self._plain(rate), self._nothing.second) for k, rate in rates.items()}
        self._known |= jets

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
        if self.first is not None and a != b:
            for jet, number in ((one, b), (two, a)):
                if self.graph.settled[number]:
                    return Jet(jet.first.spread(number), jet.second.spread(number))
            if turned := [k for k in (a, b) if self._is_turned(k)]:
                f = self.first(turned, key=self.graph.movers)
                return self._of_vector(f, b if f == a else a)
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

    def _is_turned(self, number: int) -> bool:
        """Whether a value is a component of a turned vector: each part of its slope has a rate."""
        parts = self._known[number].first.parts
        return len(parts) > 1 and all(rates for _, rates in parts)

    def _of_vector(self, f: int, b: int) -> Jet:
        """(f b)'' = f'' b + 2 f' b' + f b'', in components of f."""
        graph, one, two = self.graph, self._known[f], self._known[b]
        rate = two.first.value()
        first = one.first.outside(b).plus(Parts(graph, {(1.0, (f,)): rate}))
        return self._jet(
            first,
            lambda: (
                (1.0, one.second.outside(b)),
                (2.0, one.first.outside(rate)),
                (1.0, Parts(graph, {(1.0, (f,)): two.second.value()})),
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
