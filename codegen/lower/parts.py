"""Sums whose numbers and rates stand outside, so that they are multiplied in once.

A derivative along a motion is a sum of products of rates, ω_i² a + 2 ω_i b + ω_j² c. By hand one
writes a, b and c as sums over components and multiplies by the rates at the end; `Parts` keeps the
three apart until the sum is asked for as one value. Equal values are one in the graph, so that a
part that another equation has too is not computed again.
"""

from collections import Counter
from collections.abc import Mapping

from codegen.lower.graph import Graph
from codegen.lower.program import Op

Factors = tuple[float, tuple[int, ...]]
"""A positive number, and rates in the order of their values' numbers."""

PLAIN: Factors = (1.0, ())


class Parts:
    """Σ number · rates · value.

    Attributes
    ----------
    parts
        Factors → the value that they multiply, its sign included; no value is zero.
    """

    def __init__(self, graph: Graph, parts: Mapping[Factors, int]) -> None:
        self.graph = graph
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
        found = dict(self.parts)
        for factors, value in other.parts.items():
            found[factors] = self.graph.add(found.get(factors, self.graph.zero), value)
        return Parts(self.graph, found)

    def scaled(self, number: float) -> "Parts":
        """The sum, times a number."""
        graph, found = self.graph, dict[Factors, int]()
        for (own, rates), value in self.parts.items():
            found[own * abs(number), rates] = value if number > 0 else graph.neg(value)
        return Parts(graph, found if number else {})

    def times(self, value: int) -> "Parts":
        """The sum, times a value: one product."""
        graph = self.graph
        if value in (graph.zero, graph.one):
            return self if value == graph.one else Parts(graph, {})
        number, rest = _split(graph, value)
        single = self.single()
        found = {factors: graph.mul(own, rest) for factors, own in single.parts.items()}
        return Parts(graph, found).scaled(number)

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
        number, rest = _split(self.graph, rate)
        found = {(c, tuple(sorted((*r, rest)))): value for (c, r), value in self.parts.items()}
        return Parts(self.graph, found).scaled(number)

    def single(self) -> "Parts":
        """The same with one part at the most."""
        return self if len(self.parts) <= 1 else Parts.of(self.graph, self.value())

    def value(self) -> int:
        """The sum as one value; a rate that several parts share is multiplied in once (Horner)."""
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
            outside = Parts(graph, rest).value()
            return graph.add(outside, graph.mul(shared, Parts(graph, inner).value()))
        terms = [self._term(*factors, value) for factors, value in self.parts.items()]
        return graph.total(terms)

    def _term(self, number: float, rates: tuple[int, ...], value: int) -> int:
        graph = self.graph
        front = graph.one
        for rate in rates:
            front = graph.mul(front, rate)
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
