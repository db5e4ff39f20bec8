"""Singular vectors of Jacobians, and how many of their constraints are about to be lost."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_WEAK = 0.3  # a singular value above this, columns scaled and rows made unit length, is not weak
_APART = 3.0  # factor by which the weak singular values lie below the others
_NONE = 1e-9  # singular values below this are not told apart
_KNOWN = 0.02  # Jacobians that differ by no more than this share their singular vectors
_KEPT = 4


class Frame(NamedTuple):
    """Singular vectors of a Jacobian; of its singular values the last `weak` are."""

    matrix: FloatArray
    left: FloatArray
    values: FloatArray
    right: FloatArray
    weak: int


class Frames:
    """The frames of the last Jacobians that were looked at."""

    def __init__(self) -> None:
        self._known: list[Frame] = []

    def of(self, matrix: FloatArray) -> Frame:
        """Singular vectors of this Jacobian, or of a known one that hardly differs."""
        for known in self._known:
            if np.abs(known.matrix - matrix).max() < _KNOWN:
                return known
        left, values, right = np.linalg.svd(matrix)
        made = Frame(matrix, left, values, right, weak_values(values))
        self._known = [made, *self._known[: _KEPT - 1]]
        return made


def weak_values(values: FloatArray) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0
