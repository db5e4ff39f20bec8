"""Times of kernels inside compiled loops, interleaved, as the speed of the machine varies.

Each state is copied into the same arrays: handing out rows of a table counts references, which
takes longer than a kernel and overlaps with it differently each time. The loop itself, with
kernels that do nothing, takes its turn too, and is taken off. What others do on the machine only
ever adds to a time, so the least of many rounds is kept.
"""

from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any

import numba
import numpy as np
from numba import types

F8, VECTOR, ROWS = types.float64, types.float64[::1], types.float64[:, ::1]
MODES, MODE_ROWS = types.int64[::1], types.int64[:, ::1]
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}
TIME = 0.3
"""t of every call, s."""
POSITION = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR))
VELOCITY = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR, VECTOR))
FORCE = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR))
SOLUTION = types.FunctionType(types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR))
POWER = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR))


@numba.njit(F8(POSITION, types.int64, ROWS, VECTOR, VECTOR), **OPTIONS)
def many_positions(kernel, count, states, p, out):
    total, row = 0.0, 0
    q = states[0].copy()
    for _ in range(count):
        for k in range(q.size):
            q[k] = states[row, k]
        kernel(TIME, q, p, out)
        total += out[3]
        row = row + 1 if row + 1 < len(states) else 0
    return total


@numba.njit(F8(VELOCITY, types.int64, ROWS, ROWS, VECTOR, VECTOR), **OPTIONS)
def many_velocities(kernel, count, states, rates, p, out):
    total, row = 0.0, 0
    q, v = states[0].copy(), rates[0].copy()
    for _ in range(count):
        for k in range(q.size):
            q[k], v[k] = states[row, k], rates[row, k]
        kernel(TIME, q, v, p, out)
        total += out[3]
        row = row + 1 if row + 1 < len(states) else 0
    return total


@numba.njit(F8(FORCE, types.int64, ROWS, ROWS, VECTOR, MODE_ROWS, VECTOR), **OPTIONS)
def many_forces(kernel, count, states, rates, p, mode_rows, out):
    total, row = 0.0, 0
    q, v, modes = states[0].copy(), rates[0].copy(), mode_rows[0].copy()
    for _ in range(count):
        for k in range(q.size):
            q[k], v[k] = states[row, k], rates[row, k]
        for k in range(modes.size):
            modes[k] = mode_rows[row, k]
        kernel(TIME, q, v, p, modes, out)
        total += out[3]
        row = row + 1 if row + 1 < len(states) else 0
    return total


@numba.njit(F8(SOLUTION, types.int64, ROWS, ROWS, VECTOR, MODE_ROWS, VECTOR, VECTOR), **OPTIONS)
def many_solutions(kernel, count, states, rates, p, mode_rows, a, lam):
    total, row = 0.0, 0
    q, v, modes = states[0].copy(), rates[0].copy(), mode_rows[0].copy()
    for _ in range(count):
        for k in range(q.size):
            q[k], v[k] = states[row, k], rates[row, k]
        for k in range(modes.size):
            modes[k] = mode_rows[row, k]
        kernel(TIME, q, v, p, modes, a, lam)
        total += a[2]
        row = row + 1 if row + 1 < len(states) else 0
    return total


@numba.njit(F8(POWER, types.int64, ROWS, ROWS, VECTOR, MODE_ROWS, VECTOR, VECTOR), **OPTIONS)
def many_powers(kernel, count, states, rates, p, mode_rows, lam, out):
    total, row = 0.0, 0
    q, v, modes = states[0].copy(), rates[0].copy(), mode_rows[0].copy()
    for _ in range(count):
        for k in range(q.size):
            q[k], v[k] = states[row, k], rates[row, k]
        for k in range(modes.size):
            modes[k] = mode_rows[row, k]
        kernel(TIME, q, v, p, modes, lam, out)
        total += out[0]
        row = row + 1 if row + 1 < len(states) else 0
    return total


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR), **OPTIONS)
def no_position(t, q, p, out):
    out[3] = q[2]


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR, VECTOR), **OPTIONS)
def no_velocity(t, q, v, p, out):
    out[3] = q[2]


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR), **OPTIONS)
def no_force(t, q, v, p, modes, out):
    out[3] = q[2]


@numba.njit(types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR), **OPTIONS)
def no_solution(t, q, v, p, modes, a, lam):
    a[2] = q[2]
    return 0


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR), **OPTIONS)
def no_power(t, q, v, p, modes, lam, out):
    out[0] = q[2]


def interleaved(
    runs: Mapping[str, Callable[[int], Any]], count: int, repeats: int
) -> dict[str, float]:
    """Nanoseconds a call, the least of `repeats` rounds in which each takes its turn."""
    best = dict.fromkeys(runs, np.inf)
    for _ in range(repeats + 1):
        for name, run in runs.items():
            started = perf_counter()
            run(count)
            best[name] = min(best[name], (perf_counter() - started) / count * 1e9)
    return best
