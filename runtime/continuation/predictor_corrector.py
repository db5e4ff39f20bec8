"""Compiled predictor-corrector that follows a driven motion from instant to instant.

Each step predicts q from position, velocity and acceleration and corrects it by Newton's method.
A step is halved where the prediction is poor, so that the machine stays on its branch however far
apart the instants lie, and where Newton's method fails, so that a lock-up is approached to the
last position at which the machine still assembles.

A step can be so long that it lands on another assembly of the machine. So the pivots of Phi_q are
compared from time to time (`pivot_monitor`); at a suspicion the state goes back to the last good
comparison, and the code is SUSPECT.
"""

from typing import Any

import numpy as np
from numba import from_dtype

from runtime.continuation.pivot_monitor import (
    MARGIN,
    RECORD,
    WORKSPACE,
    is_suspicious,
    record_pivots,
    return_to_comparison,
)
from runtime.core.array_types import f8, i8, tuple_type, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import TYPES, accelerations_of, correction_of
from runtime.linalg.vectors import axpy, copy_vector, largest_ratio

DONE, STUCK, SUSPECT, ARRIVED = 0, 1, 2, 3

# measured: scaled error of a prediction up to which it is trusted to name the branch
_PREDICTED = 0.05
_TRAVEL = 0.5  # measured: scaled motion of the longest step
_ITERATIONS = 30  # safety: of Newton's method for a position


@compiled(tuple_type((i8, f8, f8, i8))(TYPES["correction"], f8, *[vector] * 7))
def return_to_motion(
    correction: Any, t: Any, q: Any, v: Any, p: Any, w: Any, scale: Any, dq: Any, dv: Any
) -> tuple[int, float, float, int]:
    """Newton's method for q(t), then v, from a prediction.

    Returns 0, 1 + the constraint whose pivot is weak, or -1 where it does not contract; the first
    scaled changes of q and of v; and the number of iterations.
    """
    previous, first, iterations = 0.0, np.inf, 0
    while True:
        weak = correction(t, q, v, p, w, dq, dv)
        iterations += 1
        if weak != 0:
            return int(weak), first, np.inf, iterations
        size = largest_ratio(dq, scale)
        if iterations == 1:
            first = size
        elif size > 0.5 * previous and size > 1e-9:
            return -1, first, np.inf, iterations
        if not size < 1e6:
            return -1, first, np.inf, iterations
        largest = max(1.0, largest_ratio(q, scale))
        axpy(1.0, dq, q)
        if size <= 4e-16 * largest or (iterations > 1 and size <= 1e-9 and size > 0.25 * previous):
            break
        if iterations == _ITERATIONS:
            return -1, first, np.inf, iterations
        previous = size
    first_v = 0.0
    for turn in range(2):
        weak = correction(t, q, v, p, w, dq, dv)
        if weak != 0:
            return int(weak), first, np.inf, iterations
        if turn == 0:
            first_v = largest_ratio(dv, scale)
        axpy(1.0, dv, v)
    return 0, first, first_v, iterations


@inner
def try_step(kernels: Any, new: Any, s: Any, r: Any) -> float:
    """Predict q and v at the instant `new` in two rows of `trial`, and correct them there.

    Returns the scaled error of the predicted q, and the accelerations become those at `new`; where
    the prediction is too poor to tell the branch, it is infinite, and they stay.
    """
    h = new - r.t
    q, v = s.trial[0], s.trial[1]
    for i in range(q.size):
        q[i] = s.q[i] + h * (s.v[i] + 0.5 * h * s.a[i])
        v[i] = s.v[i] + h * s.a[i]
    code, off, veered, iterations = return_to_motion(
        correction_of(kernels), new, q, v, s.p, s.weights, s.scale, s.trial[2], s.trial[3]
    )
    r.newton += iterations
    if code != 0 or off > _PREDICTED or abs(h) * veered > 4.0 * _PREDICTED:
        return np.inf
    accelerations = accelerations_of(kernels)
    if accelerations(new, q, v, s.p, s.modes, s.a, s.lam) == 0:
        return off
    accelerations(r.t, s.q, s.v, s.p, s.modes, s.a, s.lam)
    return np.inf


@compiled(i8(ADDRESSES, vector, WORKSPACE, from_dtype(RECORD)))
def advance(kernels: Any, times: Any, s: Any, r: Any) -> int:
    """Advance the state (q, v, a, at `r.t`) through `times` and store it at each.

    `r.mark` counts the instants done.

    Returns DONE; STUCK with the state at the last position reached; SUSPECT, where the pivots at
    `r.end` are suspicious, with the state of the last good ones; ARRIVED at the barrier.
    """
    q, v = s.trial[0], s.trial[1]
    if r.least < 0.0:
        record_pivots(kernels, s, r)
    while r.mark < len(times):
        target, t = times[r.mark], r.t
        if t == target:
            copy_vector(s.q, s.q_out[r.mark])
            copy_vector(s.v, s.v_out[r.mark])
            r.mark += 1
            continue
        if t == r.barrier:
            return ARRIVED
        sign = 1.0 if target > t else -1.0
        barred = (target - r.barrier) * sign > 0.0 and (r.barrier - t) * sign > 0.0
        if barred:
            target = r.barrier
        step = min(r.step, _TRAVEL / max(largest_ratio(s.v, s.scale), 1e-300))
        last = step >= abs(target - t)
        new = target if last else t + sign * step
        h = abs(new - t)
        if h <= 8e-16 * max(abs(t), 1e-3 * abs(target)) and not last:
            return STUCK
        off = try_step(kernels, new, s, r)
        if off > _PREDICTED:
            r.rejected += 1
            r.step = 0.5 * h
            if h <= 1e-15 * max(abs(t), abs(target)):
                return STUCK
            continue
        travel = 0.0
        for i in range(q.size):
            travel = max(travel, abs(q[i] - s.q[i]) / s.scale[i])
            s.q[i] = q[i]
            s.v[i] = v[i]
        r.t = new
        r.steps += 1
        r.travel += travel
        if off < 0.2 * _PREDICTED:
            r.step = max(r.step, 2.0 * h)
        ends = last and (barred or r.mark + 1 == len(times))
        if r.travel < MARGIN * r.least and not ends:
            continue
        if is_suspicious(kernels, s, r):
            return_to_comparison(s, r)
            accelerations_of(kernels)(r.t, s.q, s.v, s.p, s.modes, s.a, s.lam)
            return SUSPECT
        record_pivots(kernels, s, r)
    return DONE
