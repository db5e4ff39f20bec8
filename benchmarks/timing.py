"""Times of kernels inside compiled loops, interleaved so that they share the machine's moods.

The loop itself, with kernels that do nothing, takes its turn too, and is taken off: it hands out
rows of arrays and calls through a pointer, which costs as much as a kernel.
"""

from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any

import numba
import numpy as np
from numba import types

F8, VECTOR, ROWS = types.float64, types.float64[::1], types.float64[:, ::1]
MODES, MODE_ROWS = types.int64[::1], types.int64[:, ::1]
OPTIONS = {"cache": True, "error_model": "numpy"}
POSITION = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR))
VELOCITY = types.FunctionType(types.none(F8, VECTOR, VECTOR, VECTOR, VECTOR))
SOLUTION = types.FunctionType(types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR))


@numba.njit(F8(POSITION, types.int64, ROWS, VECTOR, VECTOR), **OPTIONS)
def many_positions(kernel, count, q, p, out):
    total = 0.0
    for k in range(count):
        kernel(0.0, q[k % len(q)], p, out)
        total += out[3]
    return total


@numba.njit(F8(VELOCITY, types.int64, ROWS, ROWS, VECTOR, VECTOR), **OPTIONS)
def many_velocities(kernel, count, q, v, p, out):
    total = 0.0
    for k in range(count):
        kernel(0.0, q[k % len(q)], v[k % len(q)], p, out)
        total += out[3]
    return total


@numba.njit(F8(SOLUTION, types.int64, ROWS, ROWS, VECTOR, MODE_ROWS, VECTOR, VECTOR), **OPTIONS)
def many_solutions(kernel, count, q, v, p, modes, a, lam):
    total = 0.0
    for k in range(count):
        i = k % len(q)
        kernel(0.0, q[i], v[i], p, modes[i], a, lam)
        total += a[2]
    return total


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR), **OPTIONS)
def no_position(t, q, p, out):
    out[3] = q[2]


@numba.njit(types.none(F8, VECTOR, VECTOR, VECTOR, VECTOR), **OPTIONS)
def no_velocity(t, q, v, p, out):
    out[3] = q[2]


@numba.njit(types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR), **OPTIONS)
def no_solution(t, q, v, p, modes, a, lam):
    a[2] = q[2]
    return 0


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
