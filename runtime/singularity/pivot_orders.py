"""Orders of pivots of Jacobians, and how many of their constraints are about to be lost."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.linalg.full_pivoting import ordered
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.search_table import COLUMN_ORDER, ROW_ORDER

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# measured: singular values above this, columns scaled and rows of unit length, are not weak
_WEAK = 0.3
_APART = 3.0  # measured: factor by which the weak singular values lie below the others
_NONE = 1e-9  # accuracy: singular values below this are all zero
_KNOWN = 0.02  # measured: difference of two Jacobians up to which they share an order of pivots
_KEPT = 4  # measured: orders of pivots that are remembered
_STRONG = 0.5  # measured: a pivot above this belongs to no weak row


class Frame(NamedTuple):
    """A Jacobian's non-zeros, its order of pivots, and how many of its singular values are weak."""

    entries: FloatArray
    row_order: IntArray
    column_order: IntArray
    weak: int


class Frames:
    """The frames of the last Jacobians of some constraints that were looked at."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        self.constraints = constraints
        self._known: list[Frame] = []

    def of(self, entries: FloatArray) -> Frame:
        """Order of pivots of the Jacobian with these entries, or of one that hardly differs."""
        for known in self._known:
            if np.abs(known.entries - entries).max() < _KNOWN:
                return known
        made = self._made(entries)
        self._known = [made, *self._known[: _KEPT - 1]]
        return made

    def _made(self, entries: FloatArray) -> Frame:
        constraints = self.constraints
        table, arrays = constraints.layout
        rows, wide = constraints.independent.size, constraints.scale.size + 1
        a, places = np.zeros((rows, wide)), constraints.places
        orders = arrays[ROW_ORDER], arrays[COLUMN_ORDER]
        strong = ordered(entries, *places, _STRONG, a, *orders)
        values = np.ones(rows)
        if strong < rows:
            from runtime.singularity.gauss_newton import (
                weak_part,  # loaded where something is singular
            )

            weak, free = rows - strong, wide - strong
            left, null = np.empty((rows, weak)), np.empty((wide, free))
            if weak_part(table, a, left, null, np.empty((weak, weak)), np.empty((free, free))):
                values[strong:] = 0.0
                smallest = np.linalg.svd(a[strong:, strong:], compute_uv=False)
                values[strong : strong + smallest.size] = smallest
            ordered(entries, *places, 0.0, a, *orders)
        return Frame(
            entries, orders[0].copy(), orders[1].copy(), weak_values(np.minimum(values, 1))
        )


def weak_values(values: FloatArray) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0
