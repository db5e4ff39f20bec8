"""Orders of pivots of Jacobians, and how many of their constraints are about to be lost."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.constraints.ordering import ordered
from runtime.constraints.roots import weak_part
from runtime.constraints.scaled import ScaledConstraints

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_WEAK = 0.3  # a singular value above this, columns scaled and rows made unit length, is not weak
_APART = 3.0  # factor by which the weak singular values lie below the others
_NONE = 1e-9  # singular values below this are not told apart
_KNOWN = 0.02  # Jacobians that differ by no more than this share their order of pivots
_KEPT = 4
_STRONG = 0.5  # a pivot above this belongs to no weak row


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
        rows, wide = constraints.independent.size, constraints.scale.size + 1
        a, places = np.zeros((rows, wide)), constraints.places
        row_order, column_order = np.zeros(rows, np.int64), np.zeros(wide, np.int64)
        strong = ordered(entries, *places, _STRONG, a, row_order, column_order)
        values = np.ones(rows)
        if strong < rows:
            part = np.zeros((rows - strong, wide - strong))
            left, square = np.zeros((rows, rows - strong)), np.zeros((rows - strong,) * 2)
            if weak_part(a, row_order, left, square, part):
                smallest = np.linalg.svd(part, compute_uv=False)
                values[strong : strong + smallest.size] = smallest
            ordered(entries, *places, 0.0, a, row_order, column_order)
        return Frame(entries, row_order, column_order, weak_values(values))


def weak_values(values: FloatArray) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0
