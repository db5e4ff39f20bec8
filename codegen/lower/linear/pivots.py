"""Entries of Φ_q that are numbers: each gives a coordinate by a constraint in every position."""

from codegen.lower.graph import Graph

LEAST_PIVOT = 0.1
"""accuracy: part of the largest number in its row of Φ_q that a pivot must have."""


def explicit_coordinate(graph: Graph, rows: dict[int, dict[int, int]]) -> tuple[int, int] | None:
    """Row and column of the number whose substitution fills in least; None where none is left.

    Parameters
    ----------
    rows
        Row → column → value, structural non-zeros only.
    """
    counts: dict[int, int] = {}
    for row in rows.values():
        for k in row:
            counts[k] = counts.get(k, 0) + 1
    candidates = []
    for i, row in rows.items():
        sizes = {k: abs(graph.number(entry) or 0.0) for k, entry in row.items()}
        least = LEAST_PIVOT * max(sizes.values(), default=0.0)
        candidates += [
            ((len(row) - 1) * (counts[k] - 1), -len(row), i, k)
            for k, size in sizes.items()
            if size > 0.0 and size >= least
        ]
    return min(candidates)[2:] if candidates else None
