"""A vibration that an explicit method lets grow, and the steps within which it does not.

Where a tolerance is relative, what vibrates may err in each step by so much of itself: if that is
more than the method's estimate is at the edge of its region of stability, the steps go beyond the
edge and the vibration grows by a little of itself in each, for ever. So its frequency is measured:
two states at one instant, the last stage and the result of a step, differ mostly by what is
fastest, and their accelerations by

    δa = -k δq - c δv,

k and c by least squares over some steps. With λ² + c λ + k = 0 it grows where |R(h λ)| > 1. That
two such states tell what is fastest is E. Hairer and G. Wanner's, Solving Ordinary Differential
Equations II, section IV.2, where stiffness is detected by them.
"""

import numpy as np

from runtime.core.function_table import COORDINATES
from runtime.core.jit import inner
from runtime.core.signatures import Integers, Vector
from runtime.core.workspace import SIZE, row_of

# Places in MEMORY: sums of the products of differences over the last steps; and the logarithm of
# what a vibration has grown by since steps were last short enough.
_QQ, _QV, _VV, _AQ, _AV, _AA, _GROWN = 0, 1, 2, 3, 4, 5, 6
FLOATS = 7
"""How much is remembered."""

_KEPT = 0.8  # of the sums, from one step to the next
_SEEN = 1e-12  # |δq| in sizes: what vibrates by less may grow
_ALIKE = 1e-6  # of |δq|² |δv|²: below it the two were parallel, and tell k alone
_MOST = 0.1  # by which a vibration may grow before steps are kept within the edge
_INSIDE = 0.9  # of the longest stable step, where the method damps a little
_SAFE = 0.25  # rad: no such step of a vibration is unstable
_HALVINGS = 12


@inner
def observe(
    context: Integers, memory: Vector, state: int, other: int, slope: int, other_slope: int
) -> int:
    """Take in the rows of two states at one instant, and those of their derivatives."""
    size_row = row_of(context, SIZE)
    n = context[COORDINATES]
    for i in range(_GROWN):
        memory[i] *= _KEPT
    for j in range(n):
        size = size_row[j]
        q = (row_of(context, state)[j] - row_of(context, other)[j]) / size
        v = (row_of(context, state)[n + j] - row_of(context, other)[n + j]) / size
        a = (row_of(context, slope)[n + j] - row_of(context, other_slope)[n + j]) / size
        memory[_QQ] += q * q
        memory[_QV] += q * v
        memory[_VV] += v * v
        memory[_AQ] += a * q
        memory[_AV] += a * v
        memory[_AA] += a * a
    return 0


@inner
def forget(memory: Vector) -> int:
    """Begin anew: the motion goes on under other equations."""
    for i in range(FLOATS):
        memory[i] = 0.0
    return 0


@inner
def growth(powers: Vector, h: float, k: float, c: float) -> float:
    """|R(h λ)| of the polynomial R with these coefficients, highest first; λ² + c λ + k = 0."""
    z = h * complex(-0.5 * c, np.sqrt(k - 0.25 * c * c))
    total = complex(0.0, 0.0)
    for i in range(powers.size):
        total = total * z + powers[i]
    return float(abs(total))


@inner
def bounded(memory: Vector, powers: Vector, h: float) -> float:
    """The length of a next step: `h`, or less where a vibration would grow, and has grown enough.

    Parameters
    ----------
    powers
        Coefficients of the method's stability function, highest first.
    """
    qq, qv, vv = memory[_QQ], memory[_QV], memory[_VV]
    aq, av, aa = memory[_AQ], memory[_AV], memory[_AA]
    if not (qq > _SEEN * _SEEN and np.isfinite(aa)):
        return h
    independent = qq * vv - qv * qv
    k, c = -aq / qq, 0.0
    if independent > _ALIKE * qq * vv:
        k = (qv * av - vv * aq) / independent
        c = (qv * aq - qq * av) / independent
        # Where several vibrate at once, c is known no better than by what they leave unexplained.
        rest = aa + k * (2.0 * aq + k * qq + 2.0 * c * qv) + c * (2.0 * av + c * vv)
        c = max(0.0, c - np.sqrt(max(0.0, rest) / vv))
    vibrates = k > 0.25 * c * c
    # Their mean lies below the fastest; the root of the mean square is nearer.
    k = max(k, np.sqrt(max(0.0, aa + c * (2.0 * av + c * vv)) / qq))
    # Once steps are kept within, what is looked at is the edge that they are kept from.
    kept = memory[_GROWN] > _MOST
    furthest = h / _INSIDE if kept else h
    larger = growth(powers, furthest, k, c) if vibrates else 0.0
    if not larger > 1.0:
        memory[_GROWN] = 0.0
        return h
    if not kept:
        memory[_GROWN] += np.log(larger)
        if not memory[_GROWN] > _MOST:
            return h
    low = min(furthest, _SAFE / np.sqrt(k))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + furthest)
        if growth(powers, middle, k, c) > 1.0:
            furthest = middle
        else:
            low = middle
    return float(min(h, _INSIDE * low))
