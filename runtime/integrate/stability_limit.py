"""Step limit where an explicit method would let a vibration grow.

A relative tolerance permits a vibration an error of so much of its amplitude in each step. Where
that is more than the error estimate at the edge of the method's region of stability, the steps go
beyond the edge and the vibration grows a little in each, for ever. So its frequency is measured:
two states at one instant, the last stage and the result of a step, differ mostly by the fastest
motion, and their accelerations by

    δa = -k δq - c δv,

k and c by least squares over some steps. With λ² + c λ + k = 0 the vibration grows where
|R(h λ)| > 1. That two such states reveal the fastest motion is E. Hairer and G. Wanner's (Solving
Ordinary Differential Equations II, section IV.2), who detect stiffness by them.
"""

import numpy as np

from runtime.core.arrays import Context, Integers, Vector
from runtime.core.function_table_slots import COORDINATES, HOOK
from runtime.core.jit import compiled, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import SIZE, STAGE, Y1, row_of
from runtime.integrate.step_control import propose

# Places in METHOD_FLOATS: sums of products of differences over the last steps; and the logarithm
# of the vibration's growth since steps were last short enough.
_QQ, _QV, _VV, _AQ, _AV, _AA, _GROWN = 0, 1, 2, 3, 4, 5, 6
FLOATS = 7  # numbers in METHOD_FLOATS

_KEPT = 0.8  # measured: share of the sums that lasts from one step to the next
_SEEN = 1e-12  # accuracy: |δq| in sizes; a smaller vibration is ignored
_ALIKE = 1e-6  # accuracy: of |δq|² |δv|²; below it both are parallel and determine only k
_MOST = 0.1  # measured: growth of a vibration from which on steps are limited
_INSIDE = 0.9  # measured: share of the longest stable step, where the method damps a little
_SAFE = 0.25  # safety: rad; a vibration hardly grows in such a step, nor in a shorter one
_HALVINGS = 12  # accuracy: of the bisection for the longest stable step


def memory(n: int) -> tuple[int, int]:
    """Numbers that the method keeps for n coordinates: floats and integers."""
    return FLOATS, 0


@inner
def permits_growth(rtol: float, length: int, edge: float) -> bool:
    """Whether the error permits steps beyond the edge to one vibrating velocity among all."""
    return bool(rtol * np.sqrt(length) > edge)


@inner
def observe(context: Context, last: int) -> int:
    """Take in the last stage and the result of a step, two states at one instant.

    `last` is the row of the result's derivative; that of the last stage's is the one before.
    """
    n = context[COORDINATES]
    memory, sizes = context.method_floats, row_of(context, SIZE)
    y, z = row_of(context, Y1), row_of(context, STAGE)
    after, before = row_of(context, last), row_of(context, last - 1)
    for i in range(_GROWN):
        memory[i] *= _KEPT
    for j in range(n):
        q = (y[j] - z[j]) / sizes[j]
        v = (y[n + j] - z[n + j]) / sizes[j]
        a = (after[n + j] - before[n + j]) / sizes[j]
        memory[_QQ] += q * q
        memory[_QV] += q * v
        memory[_VV] += v * v
        memory[_AQ] += a * q
        memory[_AV] += a * v
        memory[_AA] += a * a
    return 0


@compiled(HOOK)
def idle(context: Integers, t: float, h: float) -> int:
    """Do nothing: the hook of a method that keeps no more than the state and its derivative."""
    return 0


@compiled(HOOK)
def restart(context: Context, t: float, h: float) -> int:
    """Forget the vibration: the motion goes on under other equations."""
    context.method_floats[:FLOATS] = 0.0
    return 0


@inner
def amplification(powers: Vector, h: float, k: float, c: float) -> float:
    """|R(h λ)| of the polynomial R with these coefficients, highest first; λ² + c λ + k = 0."""
    z = h * complex(-0.5 * c, np.sqrt(k - 0.25 * c * c))
    total = complex(0.0, 0.0)
    for i in range(powers.size):
        total = total * z + powers[i]
    return float(abs(total))


@inner
def stable_length(memory: Vector, powers: Vector, h: float) -> float:
    """Length of the next step: `h`, or less where a vibration would grow, and has grown enough.

    `powers` are the coefficients of the method's stability function R, highest first.
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
    # Once steps are kept within the edge, that edge is examined and no longer the step.
    kept = memory[_GROWN] > _MOST
    furthest = h / _INSIDE if kept else h
    larger = amplification(powers, furthest, k, c) if vibrates else 0.0
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
        if amplification(powers, middle, k, c) > 1.0:
            furthest = middle
        else:
            low = middle
    return float(min(h, _INSIDE * low))


@inner
def stable_ratio(context: Context, h: float, powers: Vector, edge: float) -> float:
    """Ratio of two steps' lengths by the error, or less where a vibration would grow too much."""
    ratio = propose(context, h)
    if not permits_growth(run_record(context).rtol, 2 * context[COORDINATES], edge):
        return float(ratio)
    return float(stable_length(context.method_floats, powers, ratio * h) / h)
