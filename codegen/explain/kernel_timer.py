"""Times of kernels, measured in turns inside one compiled loop.

Other work on the computer only adds to a time, so the minimum of many rounds is kept, and every
kernel has its turn in each round, so that all see the same conditions. The loop with an empty
kernel takes its turn too, and its time is subtracted; as numba takes about 0.1 ms to pass a
function, every turn has the same number of calls.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit, types

from codegen.numba_cache import checked_caches

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

F8, VECTOR, ROWS = types.float64, types.float64[::1], types.float64[:, ::1]
MODES, MODE_ROWS = types.int64[::1], types.int64[:, ::1]
SIGNATURE = types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR)
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}

TURN = 5e-4  # measured: s that the slowest kernel has in a round
ROUNDS = 500  # measured: rounds of turns, of which the least time of a kernel is kept


class States(NamedTuple):
    """Instants at which kernels are called: (k,), (k, n), (k, n), (k, s)."""

    t: Floats
    q: Floats
    v: Floats
    modes: Integers


class Timed(NamedTuple):
    """A kernel `accelerations`, its parameters with the constants, and how long λ must be."""

    kernel: Any
    p: Floats
    slots: int


def _loop(
    kernel: Any, t: Any, q: Any, v: Any, modes: Any, p: Any, a: Any, lam: Any, count: int
) -> float:
    total, row = 0.0, 0
    q_now, v_now, modes_now = q[0].copy(), v[0].copy(), modes[0].copy()
    for _ in range(count):
        for k in range(q_now.size):
            q_now[k], v_now[k] = q[row, k], v[row, k]
        for k in range(modes_now.size):
            modes_now[k] = modes[row, k]
        kernel(t[row], q_now, v_now, p, modes_now, a, lam)
        total += a[0]
        row = row + 1 if row + 1 < len(q) else 0
    return total


def _nothing(t: float, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
    a[0] = q[0]
    return 0


@cache
def _compiled() -> tuple[Any, Any]:
    function = types.FunctionType(SIGNATURE)
    loop = F8(function, VECTOR, ROWS, ROWS, MODE_ROWS, VECTOR, VECTOR, VECTOR, types.int64)
    with checked_caches():
        return njit(loop, **OPTIONS)(_loop), njit(SIGNATURE, **OPTIONS)(_nothing)


def times(kernels: Sequence[Timed], states: States, rounds: int = ROUNDS) -> list[float]:
    """Nanoseconds a call of each kernel, the loop's own taken off."""
    loop, nothing = _compiled()
    n = states.q.shape[1]
    runs = [
        partial(loop, kernel, *states, p, np.zeros(n), np.zeros(slots))
        for kernel, p, slots in (Timed(nothing, np.zeros(1), 1), *kernels)
    ]
    count = _calls(runs)
    best = [np.inf] * len(runs)
    for _ in range(rounds):
        for k, run in enumerate(runs):
            best[k] = min(best[k], _seconds(run, count))
    return [1e9 * (least - best[0]) / count for least in best[1:]]


def _calls(runs: Sequence[Callable[[int], float]]) -> int:
    """How many calls of the slowest kernel fill a turn."""
    slowest = 0.0
    for run in runs:
        few, many = (min(_seconds(run, count) for _ in range(5)) for count in (100, 1100))
        slowest = max(slowest, (many - few) / 1000)
    return min(max(int(TURN / max(slowest, 1e-9)), 100), 100_000)


def _seconds(run: Callable[[int], float], count: int) -> float:
    started = perf_counter()
    run(count)
    return perf_counter() - started
