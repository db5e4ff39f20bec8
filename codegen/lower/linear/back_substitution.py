"""Forward and back substitution through the pivots of an elimination."""

from dataclasses import dataclass

from codegen.lower.graph import Graph


@dataclass(frozen=True)
class Single:
    """An eliminated unknown: x = inverse · right - Σ scaled · x_j."""

    unknown: int
    inverse: int
    scaled: dict[int, int]
    right: tuple[int, ...]


@dataclass(frozen=True)
class Pair:
    """A coordinate k and a constraint c that gives it: b x_k + Σ b across · x_j = b right_c."""

    k: int
    c: int
    a: int
    over_b: int
    along: dict[int, int]
    across: dict[int, int]
    right_k: tuple[int, ...]
    right_c: tuple[int, ...]


@dataclass(frozen=True)
class Loop:
    """Two coordinates and the constraint that closes a loop: entries, minors, 1 / determinant."""

    i: int
    j: int
    c: int
    u: int
    v: int
    minor_i: int
    minor_j: int
    area: int
    inverse: int

    def solve(self, graph: Graph, right: list[int]) -> dict[int, int]:
        """The three unknowns."""
        mul, sub = graph.mul, graph.sub
        r_i, r_j, r_c = right[self.i], right[self.j], right[self.c]
        across = sub(mul(self.v, r_i), mul(self.u, r_j))
        x_i = graph.add(mul(self.minor_i, r_c), mul(self.v, across))
        x_j = sub(mul(self.minor_j, r_c), mul(self.u, across))
        force = graph.add(mul(self.minor_i, r_i), mul(self.minor_j, r_j))
        force = sub(force, mul(self.area, r_c))
        unknowns = {self.i: x_i, self.j: x_j, self.c: force}
        return {unknown: mul(self.inverse, value) for unknown, value in unknowns.items()}


@dataclass(frozen=True)
class Substitution:
    """A symmetric system before elimination, and the pivots that solve it."""

    graph: Graph
    entries: dict[tuple[int, int], int]  # (i, j) → value, both triangles
    right: list[list[int]]  # one list a column
    steps: list[Single | Pair]  # the pivots in order
    loop: Loop | None  # the loop that closed the system

    def back(self, column: int, x: dict[int, int]) -> list[int]:
        """All unknowns of a right side, from those of the loop in `x`."""
        rights: list[tuple[int, ...]] = [
            (step.right[column],) if isinstance(step, Single)
            else (step.right_k[column], step.right_c[column])
            for step in self.steps
        ]  # fmt: skip
        return self._back(rights, x)

    def refined(self, column: int, x: list[int]) -> list[int]:
        """The unknowns after one step of iterative refinement with the original equations.

        One step makes an elimination whose order ignores the sizes of masses as accurate as the
        equations themselves (R. D. Skeel, Mathematics of Computation 35, 1980).
        """
        graph, lack = self.graph, list(self.right[column])
        for (i, j), entry in self.entries.items():
            lack[i] = graph.sub(lack[i], graph.mul(entry, x[j]))
        change = self._solve(lack)
        return [graph.add(value, more) for value, more in zip(x, change, strict=True)]

    def _solve(self, right: list[int]) -> list[int]:
        """The unknowns of another right side, which is overwritten."""
        graph = self.graph
        mul, sub = graph.mul, graph.sub
        rights: list[tuple[int, ...]] = []
        for step in self.steps:
            if isinstance(step, Single):
                r = right[step.unknown]
                for j, factor in step.scaled.items():
                    right[j] = sub(right[j], mul(factor, r))
                rights.append((r,))
                continue
            r_k, r_c = right[step.k], mul(step.over_b, right[step.c])
            inner = sub(r_k, mul(step.a, r_c))
            for j, along in step.along.items():
                both = graph.add(mul(along, r_c), mul(step.across[j], inner))
                right[j] = sub(right[j], both)
            rights.append((r_k, r_c))
        return self._back(rights, {} if self.loop is None else self.loop.solve(graph, right))

    def _back(self, rights: list[tuple[int, ...]], x: dict[int, int]) -> list[int]:
        graph = self.graph
        for step, right in zip(reversed(self.steps), reversed(rights), strict=True):
            if isinstance(step, Single):
                first = graph.mul(step.inverse, right[0])
                x[step.unknown] = self._less(first, step.scaled, x)
            else:
                x[step.k] = self._less(right[1], step.across, x)
                force = graph.sub(right[0], graph.mul(step.a, x[step.k]))
                x[step.c] = graph.mul(step.over_b, self._less(force, step.along, x))
        return [x[i] for i in range(len(x))]

    def _less(self, start: int, row: dict[int, int], x: dict[int, int]) -> int:
        for j, factor in row.items():
            start = self.graph.sub(start, self.graph.mul(factor, x[j]))
        return start
