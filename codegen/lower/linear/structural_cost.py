"""The cost of an elimination from the structure of its matrix, without a value built.

A large system is not eliminated by every order to find the cheapest one. A `Structure` does the
arithmetic of a graph on three kinds of values only: numbers, values of parameters alone, and those
that are known in a run. It counts the operations, and equal ones each time that they are asked for.
"""

from collections.abc import Sequence

from codegen.lower.graph import Graph
from codegen.lower.operation_count import WEIGHTS
from codegen.lower.program import Op

LARGE = 200  # measured: unknowns from which on ways take longer to build than to foresee


class CostExceededError(Exception):
    """An elimination costs more than the `limit` of its structure."""


class Structure(Graph):
    """A graph of two values beside numbers: one that parameters determine, and one that moves."""

    def __init__(self, limit: float = float("inf")) -> None:
        super().__init__()
        self.cost, self.limit = 0, limit
        self.parameter = self.input("p", 0, "")
        self.moving = self.input("q", 0, "")

    def kind(self, graph: Graph, value: int) -> int:
        """The value of this structure for one of a graph."""
        number = graph.floats[value]
        if number is not None:
            return self.constant(number)
        return self.parameter if graph.settled[value] else self.moving

    def kinds(self, graph: Graph, values: Sequence[int]) -> list[int]:
        """The values of this structure for those of a graph."""
        return [self.kind(graph, value) for value in values]

    def neg(self, a: int) -> int:
        """-a, which costs nothing."""
        number = self.floats[a]
        return a if number is None else self.constant(-number)

    def add(self, a: int, b: int) -> int:
        """The kind of a + b."""
        return self._moved(1) if a == b == self.moving else self._sum(a, b, 1)

    def sub(self, a: int, b: int) -> int:
        """The kind of a - b."""
        return self._moved(1) if a == b == self.moving else self._sum(a, b, -1)

    def _sum(self, a: int, b: int, sign: int) -> int:
        x, y = self.floats[a], self.floats[b]
        if x is not None and y is not None:
            return self.constant(x + sign * y)
        if y == 0.0:
            return a
        return b if x == 0.0 else self._operation(Op.ADD, a, b)

    def mul(self, a: int, b: int) -> int:
        """The kind of a b."""
        if a == b == self.moving:
            return self._moved(1)
        x, y = self.floats[a], self.floats[b]
        if x is not None and y is not None:
            return self.constant(x * y)
        if 0.0 in (x, y):
            return self.zero
        if x is not None and abs(x) == 1.0:
            return b
        if y is not None and abs(y) == 1.0:
            return a
        return self._operation(Op.MUL, a, b)

    def div(self, a: int, b: int) -> int:
        """The kind of a / b."""
        x, y = self.floats[a], self.floats[b]
        if x == 0.0:
            return self.zero
        if y is not None and y != 0.0:
            return self.mul(self.constant(1.0 / y), a)
        return self._operation(Op.DIV, a, b)

    def _operation(self, op: Op, a: int, b: int) -> int:
        """The kind of an operation's result, which adds to the cost unless parameters do."""
        if self.settled[a] and self.settled[b]:
            return self.parameter
        return self._moved(WEIGHTS.get(op, 1))

    def _moved(self, cost: int) -> int:
        """The kind of what is computed in a run, which adds to the cost."""
        self.cost += cost
        if self.cost > self.limit:
            raise CostExceededError
        return self.moving
