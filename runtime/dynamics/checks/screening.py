"""One compiled look at a run that has ended: which of the checks at its end may find something.

Almost no check does. A run of some milliseconds would notice what each of them costs in Python, and
so would one of many samples; so bounds that are no stricter than the checks come first.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import types

from runtime.core.arrays import (
    Integers,
    Vector,
    f8,
    i8,
    integer_matrix,
    integers,
    matrix,
    none,
    vector,
)
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import jacobian_of, switching_of
from runtime.core.kinds import KNOTS, SLIDING, Direction
from runtime.integrate.problem import Options, Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.samples import Samples

CLOSED = 1e-9  # accuracy: of a coordinate's size; joints close to this, however small rtol is
# measured: tolerances; Baumgarte's method with dopri5 leaves 0.4 of one, other returns 1e-5
RESIDUAL = 10.0
SIDE = 1e-6  # safety: of a switching function's typical value; values nearer to zero are not judged
# safety: bounds of values in the mean of logarithms; contacts touch for a time
TINY, HUGE = 1e-9, 1e300
APART = 1e-12  # accuracy: of the time; events and sides of kinks are nearer to their instants

_BITS = _ORDER, _MODES, REVERSALS = 1, 2, 4  # formula: bits of the answer
_KNOTS = int(KNOTS)
_BEGAN = int(Direction.BEGAN)
_COLUMN, _COLUMNS = types.Array(i8, 1, "A"), types.Array(f8, 2, "A")  # of a log of events


class Suspicions(NamedTuple):
    """What the checks at the end of a run may find, and the reversals that were measured."""

    residuals: bool = False
    order_of_events: bool = False
    modes: bool = False
    reversals: bool = False
    reversed_event: Integers = np.zeros(0, np.int64)  # (e,): the number of the event before, or -1
    reached: Vector = np.zeros(0)  # (e,): |g| midway
    permitted: Vector = np.zeros(0)  # (s,): by so much each g may err


def screen_run(
    equations: Equations, samples: Samples, sizes: FloatArray, options: Options, run: Trajectory
) -> Suspicions:
    """Which of the checks at the end may find something; nothing that is not named here."""
    description, log = equations.description, run.events
    s, e = len(description.switches), len(log.t)
    residuals = equations.m > 0 and exceed_bound(
        equations.table, samples.t, samples.q, samples.residual, equations.p, sizes,
        RESIDUAL * max(options.rtol, CLOSED), np.zeros(len(description.jacobian_rows)),
    )  # fmt: skip
    if not (s or e):
        return Suspicions(residuals)
    reversed_event, reached, permitted = np.zeros(e, np.int64), np.zeros(e), np.zeros(s)
    bits = screen(
        equations.table, equations.p, samples.t, samples.q, samples.v, samples.modes,
        APART * max(abs(run.first_t), abs(run.final_t)), bool(description.time_functions),
        run.first_t, run.final_t, log.t, log.q, log.v, log.index, log.direction, options.rtol,
        options.absolute(sizes, options.rtol), np.zeros((5 + s, max(s, 2 * equations.n))),
        np.zeros((2, s), np.int64), reversed_event, reached, permitted,
    )  # fmt: skip
    order, modes, reversals = (bool(bits & bit) for bit in _BITS)
    return Suspicions(residuals, order, modes, reversals, reversed_event, reached, permitted)


@compiled(f8(ADDRESSES, i8, f8, vector, vector, vector, vector))
def change_of_switch(
    kernels: Any, k: Any, t: Any, state: Any, change: Any, p: Any, g: Any
) -> float:
    """By how much g of the switch number k changes with all of (q, v) in turn.

    The state, which is put back, and what each of its numbers changes by are (2n,); `g`, (s,), is
    written over. At the edge of its domain g changes as on the side where it has a number.
    """
    evaluate = switching_of(kernels)
    n, total = state.size // 2, 0.0
    q, v = state[:n], state[n:]
    evaluate(t, q, v, p, g)
    here = g[k]
    for j in range(state.size):
        before = state[j]
        state[j] = before + change[j]
        evaluate(t, q, v, p, g)
        if np.isnan(g[k]):
            state[j] = before - change[j]
            evaluate(t, q, v, p, g)
        total += 0.0 if np.isnan(g[k]) else abs(g[k] - here)
        state[j] = before
    return float(total)


@compiled(types.boolean(ADDRESSES, vector, matrix, matrix, vector, vector, f8, vector))
def exceed_bound(
    kernels: Any, t: Any, q: Any, residual: Any, p: Any, sizes: Any, part: Any, slopes: Any
) -> bool:
    """Whether any residual exceeds a part of the steepest slope at first times the least size.

    That is less than what the tolerances permit. What is no number is larger, too.
    """
    if t.size == 0:
        return False
    jacobian_of(kernels)(t[0], q[0], p, slopes)
    steepest, least = 0.0, sizes[0]
    for slope in slopes:
        if np.isnan(slope):
            return True
        steepest = max(steepest, abs(slope))
    for size in sizes:
        least = min(least, size)
    bound = part * steepest * least
    for k in range(residual.shape[0]):
        if not (residual[k, 0] <= bound and residual[k, 1] <= bound):
            return True
    return False


@inner
def _contradict_modes(
    kernels: Any, t: Any, q: Any, v: Any, modes: Any, p: Any, way: Any, moves: Any, scratch: Any
) -> bool:
    """Whether any g has a sign that its mode does not permit, beyond a part of its typical value.

    That is the geometric mean over the time off its surface. The largest value, as all that stand
    before a pole, would let any other pass.

    States are (t, q, v), `modes`, (k, s), say which sign is right. Where functions of time move
    what they depend on, each state counts a second time, moved along v by the time `way`, s, with
    the modes of the next. `scratch` has five rows, as long as g and q at least.
    """
    evaluate = switching_of(kernels)
    n, count, wrong = q.shape[1], modes.shape[1], False
    values, moved = scratch[0, :count], scratch[1, :n]
    logarithms, opposed, judged = scratch[2, :count], scratch[3, :count], scratch[4, :count]
    logarithms[:] = 0.0
    opposed[:] = 0.0
    judged[:] = 1e-300
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, values)
        lasts = abs(t[min(i + 1, t.size - 1)] - t[max(i - 1, 0)])
        for k in range(count):
            side = 0 if modes[i, k] == SLIDING else 2 * modes[i, k] - 1
            if side != 0 and not np.isnan(values[k]):
                logarithms[k] += lasts * np.log(max(TINY, min(HUGE, abs(values[k]))))
                judged[k] += lasts
                opposed[k] = max(opposed[k], -side * values[k])
    for i in range(1, t.size if moves else 0):
        for j in range(n):
            moved[j] = q[i - 1, j] + way * v[i - 1, j]
        evaluate(t[i - 1] + way, moved, v[i - 1], p, values)
        for k in range(count):
            side = 0 if modes[i, k] == SLIDING else 2 * modes[i, k] - 1
            opposed[k] = max(opposed[k], -side * values[k])
    for k in range(count):
        wrong = wrong or opposed[k] > SIDE * np.exp(logarithms[k] / judged[k])
    return wrong


@inner
def _measure_reversals(
    kernels: Any, t: Any, q: Any, v: Any, index: Any, direction: Any, p: Any, rtol: Any,
    absolute: Any, scratch: Any, largest: Any, events: Any, reversed_event: Any, reached: Any,
    permitted: Any,
) -> bool:  # fmt: skip
    """Whether any event (t, q, v) lies within the tolerance of the one before, which it reverses.

    `reversed_event`, (e,), gets that one's number, or -1, and `reached`, (e,), |g| midway. By so
    much as `permitted`, (s,), g may err as each y of q and v does by `absolute + rtol |y|`, at the
    first event of its switch, and with the largest |y| of all of these. Room is in `scratch`, three
    rows as long as g and (q, v) at least, and in `largest`, (s, 2n), and `events`, (2, s).
    """
    evaluate = switching_of(kernels)
    n, count = q.shape[1], permitted.size
    first, last, any_pair, within = events[0], events[1], False, False
    g, state, change = scratch[0, :count], scratch[1, : 2 * n], scratch[2, : 2 * n]
    last[:] = -1
    for i in range(t.size):
        k, reversed_event[i] = index[i], -1
        if k >= count:  # a function of time
            continue
        before = last[k]
        if before < 0:
            first[k] = i
        elif (
            direction[i] == -direction[before] and abs(direction[i]) == _BEGAN and t[before] < t[i]
        ):
            reversed_event[i], permitted[k], any_pair = before, 1.0, True
        last[k] = i
    if not any_pair:
        return False
    for i in range(t.size):
        k = index[i]
        if k < count and permitted[k] > 0.0:
            for j in range(n):
                largest[k, j] = max(largest[k, j], abs(q[i, j]))
                largest[k, n + j] = max(largest[k, n + j], abs(v[i, j]))
    for k in range(count):
        if permitted[k] > 0.0:
            for j in range(n):
                state[j], state[n + j] = q[first[k], j], v[first[k], j]
            for j in range(2 * n):
                change[j] = absolute[j] + rtol * largest[k, j]
            permitted[k] = change_of_switch(kernels, k, t[first[k]], state, change, p, g)
    for i in range(t.size):
        b = reversed_event[i]
        if b < 0:
            continue
        span, k = t[i] - t[b], index[i]
        for j in range(n):
            q0, q1, v0, v1 = q[b, j], q[i, j], v[b, j], v[i, j]
            state[j] = 0.5 * (q0 + q1) + 0.125 * span * (v0 - v1)
            state[n + j] = 1.5 * (q1 - q0) / span - 0.25 * (v0 + v1)
        evaluate(0.5 * (t[b] + t[i]), state[:n], state[n:], p, g)
        reached[i] = abs(g[k])
        within = within or reached[i] <= permitted[k]
    return within


@compiled(
    i8(
        ADDRESSES, vector, vector, matrix, matrix, integer_matrix, f8, types.boolean, f8, f8,
        vector, _COLUMNS, _COLUMNS, _COLUMN, _COLUMN, f8, vector, matrix, integer_matrix, integers,
        vector, vector,
    )
)  # fmt: skip
def screen(
    kernels: Any, p: Any, t: Any, q: Any, v: Any, modes: Any, way: Any, moves: Any, first_t: Any,
    final_t: Any, event_t: Any, event_q: Any, event_v: Any, index: Any, direction: Any, rtol: Any,
    absolute: Any, scratch: Any, events: Any, reversed_event: Any, reached: Any, permitted: Any,
) -> int:  # fmt: skip
    """Bits of what the samples (t, q, v, modes) and the log of events may show.

    `scratch` has five rows and one for each switch, as long as g and (q, v) at least, all 0.
    """
    found, last = 0, first_t
    for i in range(event_t.size):
        if not last <= event_t[i]:
            found |= _ORDER
        last = event_t[i]
    if event_t.size > 0 and not last <= final_t:
        found |= _ORDER
    if permitted.size == 0:
        return found
    if t.size > 1 and _contradict_modes(kernels, t, q, v, modes, p, way, moves, scratch):
        found |= _MODES
    if _measure_reversals(
        kernels, event_t, event_q, event_v, index, direction, p, rtol, absolute, scratch,
        scratch[5:], events, reversed_event, reached, permitted,
    ):  # fmt: skip
        found |= REVERSALS
    return found


@compiled(none(vector, _COLUMN, integers, vector, vector, integers, matrix))
def count_unresolved(
    t: Any, index: Any, reversed_event: Any, reached: Any, permitted: Any, parts: Any, out: Any
) -> None:
    """Write of each switch its events within the tolerance, (s, 4), from what `screen` measured.

    These are their number, the instant of the first, s, the largest |g| that was reached, and what
    the tolerances permit.
    """
    out[:, :] = 0.0
    for i in range(t.size):
        k, before = index[i], reversed_event[i]
        if before < 0 or not reached[i] <= permitted[k] or parts[k] == _KNOTS:
            continue
        of_pair = reversed_event[before] >= 0 and reached[before] <= permitted[k]
        if out[k, 0] == 0.0:
            out[k, 1] = t[before]
        out[k, 0] += 1.0 if of_pair else 2.0
        out[k, 2], out[k, 3] = max(out[k, 2], reached[i]), permitted[k]


@compiled(none(ADDRESSES, vector, matrix, matrix, vector, matrix))
def write_switching_values(kernels: Any, t: Any, q: Any, v: Any, p: Any, out: Any) -> None:
    """Write g at the states (t, q, v), (k,) and (k, n), into `out`, (k, s)."""
    evaluate = switching_of(kernels)
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, out[i])
