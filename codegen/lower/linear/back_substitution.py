"""The pivots of an elimination: forward through a right side, and back to its unknowns."""

from dataclasses import dataclass

from codegen.lower.graph import Graph


@dataclass(frozen=True)
class Single:
    """An eliminated unknown i: x_i = inverse · right_i - Σ across · x_j."""

    i: int
    inverse: int
    along: dict[int, int]  # the row
    across: dict[int, int]  # inverse · along

    def update(self, graph: Graph, j: int, k: int) -> int:
        """The number that the entry (j, k) loses with the unknown."""
        return graph.mul(self.across[j], self.along[k])

    def prepare(self, graph: Graph, right: list[int]) -> None:
        """Nothing: the right side of the row stays."""

    def forward(self, graph: Graph, right: list[int], j: int) -> None:
        """Take the unknown out of the right side of row j."""
        right[j] = graph.sub(right[j], graph.mul(self.across[j], right[self.i]))

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find the unknown from those eliminated later."""
        x[self.i] = graph.less(graph.mul(self.inverse, right[self.i]), self.across, x)


@dataclass(frozen=True)
class Pair:
    """A coordinate k and a constraint c that gives it: b x_k + Σ b across · x_j = b right_c."""

    k: int
    c: int
    a: int
    over_b: int
    along: dict[int, int]
    across: dict[int, int]
    rest: dict[int, int]  # along - a across

    def update(self, graph: Graph, i: int, j: int) -> int:
        """The number that the entry (i, j) loses with both unknowns."""
        first = graph.mul(self.along[i], self.across[j])
        return graph.add(first, graph.mul(self.across[i], self.rest[j]))

    def prepare(self, graph: Graph, right: list[int]) -> None:
        """Divide the right side of row c by b."""
        right[self.c] = graph.mul(self.over_b, right[self.c])

    def forward(self, graph: Graph, right: list[int], j: int) -> None:
        """Take both unknowns out of the right side of row j."""
        inner = graph.sub(right[self.k], graph.mul(self.a, right[self.c]))
        both = graph.mul(self.along[j], right[self.c]), graph.mul(self.across[j], inner)
        right[j] = graph.sub(right[j], graph.add(*both))

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find both unknowns from those eliminated later."""
        x[self.k] = graph.less(right[self.c], self.across, x)
        force = graph.sub(right[self.k], graph.mul(self.a, x[self.k]))
        x[self.c] = graph.mul(self.over_b, graph.less(force, self.along, x))


@dataclass(frozen=True)
class Loop:
    """Two coordinates and the constraint that closes a loop, the last that is left.

    [[a, b, u], [b, d, v], [u, v, 0]] is solved by its adjugate: one division instead of three. The
    determinant is minus the positive definite form a v² - 2 b u v + d u².
    """

    i: int
    j: int
    c: int
    u: int
    v: int
    minor_i: int
    minor_j: int
    area: int
    inverse: int  # of the form

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find the three unknowns."""
        mul, sub = graph.mul, graph.sub
        r_i, r_j, r_c = right[self.i], right[self.j], right[self.c]
        across = sub(mul(self.v, r_i), mul(self.u, r_j))
        x_i = graph.add(mul(self.minor_i, r_c), mul(self.v, across))
        x_j = sub(mul(self.minor_j, r_c), mul(self.u, across))
        force = graph.add(mul(self.minor_i, r_i), mul(self.minor_j, r_j))
        force = sub(force, mul(self.area, r_c))
        for unknown, value in ((self.i, x_i), (self.j, x_j), (self.c, force)):
            x[unknown] = mul(self.inverse, value)
