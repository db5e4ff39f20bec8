"""Euler parameters of length 1."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt


def normalise(q: npt.NDArray[np.float64], turning: Iterable[int], free: Any = slice(None)) -> None:
    """Give the Euler parameters of each body, from columns `turning` of q on, (..., n), length 1.

    Only those that are `free`, a mask or indices, change; where they cannot, none does. Φ_q of
    joints has no component along p: Newton's method converges by it at |p| = 1 alone.
    """
    moving = np.zeros(q.shape[-1], np.bool_)
    moving[free] = True
    for first in turning:
        p, moves = q[..., first : first + 4], moving[first : first + 4]
        left = 1.0 - np.sum(p[..., ~moves] ** 2, axis=-1, keepdims=True)
        square = np.sum(p[..., moves] ** 2, axis=-1, keepdims=True)
        if (left > 0.0).all() and (square > 0.0).all():
            p[..., moves] *= np.sqrt(left / square)
