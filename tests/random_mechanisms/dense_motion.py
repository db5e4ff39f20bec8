"""Motions of a mechanism by the dense equations: integrated at 1e-12, or driven by Newton."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from tests.random_mechanisms.dense_dynamics import Dense

RTOL = 1e-12
MOST_STEPS = 4000  # safety: of the dense integration, before it is given up
WAYS = 40  # steps of a driven motion between two instants


class DenseError(ArithmeticError):
    """The dense formulation cannot go on either."""


def free_motion(dense: Dense, q: Any, v: Any, instants: Sequence[float]) -> tuple[Any, Any]:
    """Positions and velocities at instants, each (k, n), from the first of them on.

    In typical sizes, by DOP853 at 1e-12; after every step the state is put onto the constraints.

    Raises
    ------
    DenseError
        Where the steps become too many, or the joints do not close.
    """
    n, sizes = dense.n, np.concatenate([dense.sizes, dense.sizes])

    def rates(t: float, y: Any) -> Any:
        q, v = (y * sizes)[:n], (y * sizes)[n:]
        return np.concatenate([v, dense.solve(q, v, t).a]) / sizes

    found_q, found_v = [q], [v]
    y, steps = np.concatenate([q, v]) / sizes, 0
    speed = max(1.0, float(np.abs(y).max()))
    for begin, end in pairwise(instants):
        solver = DOP853(rates, begin, y, end, rtol=RTOL, atol=RTOL * 1e-1 * speed)
        while solver.status == "running":
            solver.step()
            steps += 1
            if solver.status == "failed" or steps > MOST_STEPS:
                raise DenseError(f"the dense integration stops at t = {solver.t:g} s")
            state = solver.y * sizes
            closed = dense.closed(state[:n], state[n:], solver.t)
            solver.y = np.concatenate(closed) / sizes
        y = solver.y
        found_q.append(y[:n] * dense.sizes)
        found_v.append(y[n:] * dense.sizes)
    return np.array(found_q), np.array(found_v)


def driven_motion(dense: Dense, q: Any, instants: Sequence[float]) -> tuple[Any, Any]:
    """Positions and velocities of a wholly driven mechanism at instants, each (k, n).

    Followed in small steps by Newton's method, from the velocity that the constraints give.

    Raises
    ------
    ArithmeticError
        Where Newton's method does not close the joints.
    """
    v = _driven_velocity(dense, q, instants[0])
    found = [(q, v)]
    for begin, end in pairwise(instants):
        times = np.linspace(begin, end, WAYS + 1)
        for before, t in pairwise(times):
            q = dense.closed(q + (t - before) * v, v, t)[0]
            v = _driven_velocity(dense, q, t)
        found.append((q, v))
    return np.array([q for q, _ in found]), np.array([v for _, v in found])


def _driven_velocity(dense: Dense, q: Any, t: float) -> Any:
    e = dense.equations(q, np.zeros(dense.n), t)
    scaled = e.jacobian * dense.sizes
    rows = np.linalg.norm(scaled, axis=1)
    return np.linalg.lstsq(scaled / rows[:, None], e.nu / rows, rcond=None)[0] * dense.sizes


def growth(
    motion: Callable[[Dense, Any, Any, Sequence[float]], Any], dense: Dense, q: Any, v: Any,
    instants: Sequence[float], size: float = 1e-8,
) -> float:  # fmt: skip
    """By what factor a small change of the start grows until the end, in typical sizes."""
    random = np.random.default_rng(0)
    shift = random.normal(size=(2, dense.n)) * dense.sizes * size
    scale = max(1.0, float(np.abs(v / dense.sizes).max()))
    begin = dense.closed(q + shift[0], v + scale * shift[1], instants[0])
    moved = motion(dense, *begin, instants)[-1]
    there = motion(dense, q, v, instants)[-1]
    return float(np.abs((moved - there) / dense.sizes).max()) / size
