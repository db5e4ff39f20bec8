"""Values of the switching functions at many states: compiled, and loaded where there are any."""

from typing import Any

from numba import types

from runtime.core.array_types import f8, i8, integer_matrix, integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import switching_of
from runtime.core.modes_and_event_kinds import SLIDING, Direction

_COLUMN, _COLUMNS = types.Array(i8, 1, "A"), types.Array(f8, 2, "A")  # of a log of events
_BEGAN = int(Direction.BEGAN)


@compiled(none(ADDRESSES, vector, matrix, matrix, vector, matrix))
def write_switching_values(kernels: Any, t: Any, q: Any, v: Any, p: Any, out: Any) -> None:
    """Write g at the states (t, q, v), (k,) and (k, n), into `out`, (k, s)."""
    evaluate = switching_of(kernels)
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, out[i])


@compiled(
    types.boolean(
        ADDRESSES, vector, matrix, matrix, integer_matrix, vector, f8, types.boolean, f8, matrix
    )
)
def contradicts_modes(
    kernels: Any, t: Any, q: Any, v: Any, modes: Any, p: Any, way: Any, moves: Any, part: Any,
    scratch: Any,
) -> bool:  # fmt: skip
    """Whether any g has a sign that its mode does not permit, beyond a part of its largest value.

    States are (t, q, v), `modes`, (k, s), say which sign is right. Where functions of time move
    what they depend on, each state counts a second time, moved along v by the time `way`, s, with
    the modes of the next. `scratch` has four rows, as long as g and q at least.
    """
    evaluate = switching_of(kernels)
    n, count, wrong = q.shape[1], modes.shape[1], False
    values, moved = scratch[0, :count], scratch[1, :n]
    largest, opposed = scratch[2, :count], scratch[3, :count]
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, values)
        for k in range(count):
            side = 0 if modes[i, k] == SLIDING else 2 * modes[i, k] - 1
            largest[k] = max(largest[k], abs(values[k]))
            opposed[k] = max(opposed[k], -side * values[k])
    for i in range(1, t.size if moves else 0):
        for j in range(n):
            moved[j] = q[i - 1, j] + way * v[i - 1, j]
        evaluate(t[i - 1] + way, moved, v[i - 1], p, values)
        for k in range(count):
            side = 0 if modes[i, k] == SLIDING else 2 * modes[i, k] - 1
            opposed[k] = max(opposed[k], -side * values[k])
    for k in range(count):
        wrong = wrong or opposed[k] > part * largest[k]
    return wrong


@compiled(f8(ADDRESSES, i8, f8, vector, vector, vector, vector))
def change_of_switch(
    kernels: Any, k: Any, t: Any, state: Any, change: Any, p: Any, g: Any
) -> float:
    """By how much g of the switch number k changes with all of (q, v) in turn.

    The state and what each of its numbers changes by are (2n,); `g`, (s,), is written over.
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
        total += abs(g[k] - here)
        state[j] = before
    return float(total)


@compiled(
    types.boolean(
        ADDRESSES, vector, _COLUMNS, _COLUMNS, _COLUMN, _COLUMN, vector, f8, vector, matrix, matrix,
        integer_matrix, integers, vector, vector,
    )
)  # fmt: skip
def measure_reversals(
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
