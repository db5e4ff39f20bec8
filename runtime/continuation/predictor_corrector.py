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
from numba import types

from runtime.continuation.pivot_monitor import (
    BARRIER,
    LEAST,
    MARGIN,
    MARK,
    NEWTON,
    REJECTED,
    STEP,
    STEPS,
    TRAVEL,
    T,
    look,
    restore_look,
    suspicious,
)
from runtime.core.array_types import f8, integer_matrix, integers, matrix, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import TYPES, accelerations_of, correction_of, jacobian_of

DONE, STUCK, SUSPECT, ARRIVED = 0, 1, 2, 3

# measured: scaled error of a prediction up to which it is trusted to name the branch
_PREDICTED = 0.05
_TRAVEL = 0.5  # measured: scaled motion of the longest step


@compiled(
    types.int64(
        TYPES["correction"], f8, vector, vector, vector, vector, vector, vector, vector, vector
    ),
)
def settle(
    correction: Any, t: Any, q: Any, v: Any, p: Any, w: Any, scale: Any, dq: Any, dv: Any, info: Any
) -> int:
    """Newton's method for q(t), then v, from a prediction.

    Returns 0, 1 + the constraint whose pivot is weak, or -1 where it does not contract. `info`
    receives the first scaled change of q, of v, and the number of iterations.
    """
    n = len(q)
    previous = 0.0
    converged = False
    info[2] = 0.0
    for iteration in range(30):
        weak = correction(t, q, v, p, w, dq, dv)
        info[2] += 1.0
        if weak != 0:
            return int(weak)
        size = 0.0
        largest = 1.0
        for i in range(n):
            if not np.isfinite(dq[i]):
                return -1
            size = max(size, abs(dq[i]) / scale[i])
            largest = max(largest, abs(q[i]) / scale[i])
        if not size < 1e6:
            return -1
        if iteration == 0:
            info[0] = size
        elif size > 0.5 * previous and size > 1e-9:
            return -1
        for i in range(n):
            q[i] += dq[i]
        if size <= 4e-16 * largest or (iteration > 0 and size <= 1e-9 and size > 0.25 * previous):
            converged = True
            break
        previous = size
    if not converged:
        return -1
    info[1] = 0.0
    for iteration in range(2):
        weak = correction(t, q, v, p, w, dq, dv)
        if weak != 0:
            return int(weak)
        for i in range(n):
            if iteration == 0:
                info[1] = max(info[1], abs(dv[i]) / scale[i])
            v[i] += dv[i]
    return 0


@inner
def attempt(
    correction: Any, accelerations: Any, new: Any, q: Any, v: Any, a: Any, p: Any, w: Any,
    scale: Any, modes: Any, lam: Any, record: Any, work: Any,
) -> bool:  # fmt: skip
    """Predict q and v at the instant `new` in two rows of `work`, and correct them there.

    Accelerations become those at `new`; where the prediction is too poor to tell the branch, they
    stay, and the answer is False.
    """
    t, n = record[T], len(q)
    h = new - t
    q_new, v_new, info = work[0], work[1], work[4]
    for i in range(n):
        q_new[i] = q[i] + h * (v[i] + 0.5 * h * a[i])
        v_new[i] = v[i] + h * a[i]
    reason = settle(correction, new, q_new, v_new, p, w, scale, work[2], work[3], info)
    record[NEWTON] += info[2]
    good = reason == 0 and info[0] <= _PREDICTED and abs(h) * info[1] <= 4.0 * _PREDICTED
    if good and accelerations(new, q_new, v_new, p, modes, a, lam) != 0:
        accelerations(t, q, v, p, modes, a, lam)
        good = False
    return good


@compiled(types.int64(
    ADDRESSES, vector, vector, vector, vector, vector, vector, vector, integers, vector, matrix,
    matrix, vector, matrix, integer_matrix, vector, matrix, matrix, integer_matrix,
))  # fmt: skip
def advance(
    kernels: Any, times: Any, p: Any, w: Any, scale: Any, q: Any, v: Any, a: Any, modes: Any,
    lam: Any, q_out: Any, v_out: Any, record: Any, work: Any, sparse: Any, values: Any,
    dense: Any, pivots: Any, orders: Any,
) -> int:  # fmt: skip
    """Advance the state (q, v, a, at record[T]) through `times` and store it at each.

    record[MARK] counts the instants done. `sparse` (2, nnz) contains rows and columns of Phi_q;
    `values` (nnz,), `dense` (m, n), `pivots` (3, m) and `orders` (2, m) are work arrays that, like
    the record, persist between calls.

    Returns DONE; STUCK with the state at the last position reached; SUSPECT, where the pivots at
    record[END] are suspicious, with the state of the last good ones; ARRIVED at the barrier.
    """
    correction = correction_of(kernels)
    accelerations = accelerations_of(kernels)
    jacobian = jacobian_of(kernels)
    n = len(q)
    q_new, v_new, info = work[0], work[1], work[4]
    order, spare = orders[0], orders[1]
    done = int(record[MARK])
    if record[LEAST] < 0.0:
        look(
            jacobian, record[T], q, v, p, scale, sparse, values, dense, pivots, order, record, work
        )
    while done < len(times):
        target = times[done]
        t = record[T]
        if t == target:
            for i in range(n):
                q_out[done, i] = q[i]
                v_out[done, i] = v[i]
            done += 1
            record[MARK] = done
            continue
        if t == record[BARRIER]:
            return ARRIVED
        speed = 0.0
        for i in range(n):
            speed = max(speed, abs(v[i]) / scale[i])
        sign = 1.0 if target > t else -1.0
        barred = (target - record[BARRIER]) * sign > 0.0 and (record[BARRIER] - t) * sign > 0.0
        if barred:
            target = record[BARRIER]
        step = min(record[STEP], _TRAVEL / max(speed, 1e-300))
        last = step >= abs(target - t)
        new = target if last else t + sign * step
        h = new - t
        if abs(h) <= 8e-16 * max(abs(t), 1e-3 * abs(target)) and not last:
            return STUCK
        if not attempt(
            correction, accelerations, new, q, v, a, p, w, scale, modes, lam, record, work
        ):
            record[REJECTED] += 1.0
            record[STEP] = 0.5 * abs(h)
            if abs(h) <= 1e-15 * max(abs(t), abs(target)):
                return STUCK
            continue
        travel = 0.0
        for i in range(n):
            travel = max(travel, abs(q_new[i] - q[i]) / scale[i])
            q[i] = q_new[i]
            v[i] = v_new[i]
        record[T] = new
        record[STEPS] += 1.0
        record[TRAVEL] += travel
        if info[0] < 0.2 * _PREDICTED:
            record[STEP] = max(record[STEP], 2.0 * abs(h))
        ends = last and (barred or done + 1 == len(times))
        if record[TRAVEL] < MARGIN * record[LEAST] and not ends:
            continue
        if suspicious(
            jacobian, new, q, p, scale, sparse, values, dense, pivots, order, spare, record, work
        ):
            restore_look(record, work, q, v)
            accelerations(record[T], q, v, p, modes, a, lam)
            return SUSPECT
        look(jacobian, new, q, v, p, scale, sparse, values, dense, pivots, order, record, work)
    return DONE
