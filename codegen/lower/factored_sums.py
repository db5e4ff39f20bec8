"""Sums whose numbers and rates stand outside, so that they are multiplied in once.

A derivative along a motion is a sum of products of rates, ω_i² a + 2 ω_i b + ω_j² c. By hand one
writes a, b and c as sums over components and multiplies by the rates at the end; `Parts` keeps the
three apart until the sum is needed as one value. Equal values are one in the graph, so that a
part that another equation has too is not computed again.
"""

from collections import Counter
from collections.abc import Mapping
from functools import reduce

from codegen.lower.graph import Graph
from codegen.lower.program import Op

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
