"""Powers whose exponent is not whole, and their derivatives where the base is zero.

b^(n + 1/2) is computed as bⁿ √b, which the rule of products would differentiate into 0/0 at b = 0.
The rule of powers does not: its exponents fall by one with every derivative, and only those that
become negative divide by b.
"""

from typing import NamedTuple

from codegen.lower.graph import Graph
from codegen.lower.program import Op

# safety: the smallest number there is, added to a divisor: 0/0 is 0 there, and all else infinite
LEAST = 5e-324


class FractionalPower(NamedTuple):
    """sign · base ^ exponent."""

    base: int
    exponent: float
    sign: float

    def slope(self, graph: Graph) -> int:
        """d/d(base) = sign · exponent · base ^ (exponent - 1)."""
        front = graph.constant(self.sign * self.exponent)
        return graph.mul(front, graph.power(self.base, self.exponent - 1.0))

    def bend(self, graph: Graph, rate: int) -> int:
        """d²/d(base)² · rate².

        With an exponent below 2 it is a quotient, which is 0 where base and rate both are, as at
        the origin in (x² + y²)^(3/2).
        """
        front = graph.constant(self.sign * self.exponent * (self.exponent - 1.0))
        square, left = graph.mul(rate, rate), self.exponent - 2.0
        if left > 0.0:
            return graph.mul(front, graph.mul(graph.power(self.base, left), square))
        divisor = graph.add(graph.power(self.base, -left), graph.constant(LEAST))
        return graph.mul(front, graph.div(square, divisor))


def fractional_power(graph: Graph, number: int) -> FractionalPower | None:
    """The power with a broken exponent above 1 that a value is; None for other values."""
    value = graph.values[number]
    if value.op is Op.POW:
        exponent = graph.number(value.args[1])
        known = exponent is not None and exponent > 1.0 and exponent != int(exponent)
        return FractionalPower(value.args[0], exponent, 1.0) if known and exponent else None
    if value.op is not Op.MUL:
        return None
    for whole, root in (value.args, value.args[::-1]):
        if graph.values[root].op is Op.SQRT:
            base = graph.values[root].args[0]
            bare = graph.unsigned(base)
            if count := _factors(graph, whole, bare):
                return FractionalPower(base, count + 0.5, 1.0 if base == bare else (-1.0) ** count)
    return None


def _factors(graph: Graph, number: int, base: int) -> int:
    """n where a value is baseⁿ, formed of products alone; 0 for other values."""
    if number == base:
        return 1
    value = graph.values[number]
    counts = [_factors(graph, a, base) for a in value.args] if value.op is Op.MUL else [0]
    return sum(counts) if all(counts) else 0
