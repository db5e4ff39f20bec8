"""Orders of pivots of Jacobians, and how many of their rows are weak: near to being lost."""

from typing import NamedTuple

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.linalg.full_pivoting import factor_fully
from runtime.singularity.scaled_constraints import ScaledConstraints

_WEAK = 0.3  # measured: singular values above this, in unit rows of scaled columns, are not weak
_APART = 3.0  # measured: factor by which the weak singular values lie below the others
_NONE = 1e-9  # accuracy: singular values below this are all zero
_KNOWN = 0.02  # measured: difference of two Jacobians up to which they share an order of pivots
_KEPT = 4  # measured: orders of pivots that are remembered
STRONG = 0.5  # measured: a pivot above this belongs to no weak row


class PivotOrder(NamedTuple):
    """A Jacobian's non-zeros, its order of pivots, and how many of its singular values are weak."""

    entries: Vector
    row_order: Integers
    column_order: Integers
    weak: int


class PivotOrders:
    """Orders of pivots of the last few Jacobians of a machine's constraints."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        self.constraints = constraints
        self.known: tuple[PivotOrder, ...] = ()

    def near(self, entries: Vector) -> PivotOrder:
        """Order of pivots of the Jacobian with these entries, or of one that hardly differs."""
        for known in self.known:
            if np.abs(known.entries - entries).max() < _KNOWN:
                return known
        order = self._choose(entries)
        self.known = (order, *self.known[: _KEPT - 1])
        return order

    def _choose(self, entries: Vector) -> PivotOrder:
        """Full pivoting as far as pivots are large; singular values of the complement of these."""
        constraints = self.constraints
        table, arrays = constraints.layout
        orders = arrays["row_order"], arrays["column_order"]
        a = constraints.dense(entries)
        strong, rows = factor_fully(a, *orders, STRONG), len(a)
        values = np.ones(rows)
        if strong < rows:
            # Loaded where something is singular.
            from runtime.singularity.schur_complement import reduce_to_weak_part

            if reduce_to_weak_part(table, a, strong):
                values[strong:] = 0.0
                smallest = np.linalg.svd(a[strong:, strong:], compute_uv=False)
                values[strong : strong + smallest.size] = smallest
            factor_fully(constraints.dense(entries), *orders, 0.0)
        return PivotOrder(
            entries, orders[0].copy(), orders[1].copy(), count_weak(np.minimum(values, 1))
        )


def count_weak(values: Vector) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0
