"""Motions of a spatial mechanism by the dense equations, integrated at 1e-12."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.spatial.transform import Rotation

from tests.random_mechanisms.spatial_constraints import SpatialState, cross
from tests.random_mechanisms.spatial_dynamics import DenseError, SpatialDense

RTOL = 1e-12
MOST_STEPS = 20_000  # safety: of the dense integration, before it is given up
SINGULAR = 1e-4  # of the weakest pivot of independent rows, over the largest


def motion(
    dense: SpatialDense, state: SpatialState, instants: Sequence[float], rtol: float = RTOL
) -> list[SpatialState]:
    """The states at instants, from that of the first of them on.

    By DOP853 on rotation vectors from the matrices of the last step; after every step the state is
    put onto the constraints.

    Raises
    ------
    DenseError
        Where the steps become too many, the joints do not close, or a pose is singular.
    """
    found, rank, steps = [state], dense.system(state, instants[0]).rank, 0
    first: float | None = None
    for begin, end in pairwise(instants):
        t = begin
        while t < end:
            rows, pivot = dense.independent_rows(state, t, rank)
            if pivot < SINGULAR:
                raise DenseError(f"the pose at t = {t:g} s is singular")
            solver = _solver(dense, state, (t, end), rows, first, rtol)
            solver.step()
            steps += 1
            if solver.status == "failed" or steps > MOST_STEPS:
                raise DenseError(f"the dense integration stops at t = {t:g} s")
            first, t = solver.h_abs, solver.t
            state = dense.closed(_unpacked(state, solver.y), t, rank)
        found.append(state)
    return found


def _solver(
    dense: SpatialDense, base: SpatialState, span: tuple[float, float], rows: Any,
    first: float | None, rtol: float,
) -> DOP853:  # fmt: skip
    n, (t, end) = dense.n, span

    def rates(now: float, y: Any) -> Any:
        state = _unpacked(base, y)
        solved = dense.solve(state, now, rows)
        turn = y[3 * n : 6 * n].reshape(n, 3)
        turning = _rate_of_turn(turn, state.w)
        velocity = np.concatenate([state.v, state.w], axis=1)
        counted = np.einsum("kbx,bx->k", solved.system.turns.by[:, :-1], velocity)
        return np.concatenate([a.ravel() for a in (state.v, turning, solved.r, solved.w, counted)])

    parts = base.r, np.zeros(3 * n), base.v, base.w, base.turned
    start = np.concatenate([np.ravel(part) for part in parts])
    speed = max(1.0, float(np.abs(start).max()))
    bound = None if first is None else min(first, end - t)
    return DOP853(rates, t, start, end, rtol=rtol, atol=0.1 * rtol * speed, first_step=bound)


def _unpacked(base: SpatialState, y: Any) -> SpatialState:
    n = len(base.r)
    r, turn, v, w = (y[3 * n * k : 3 * n * (k + 1)].reshape(n, 3) for k in range(4))
    return SpatialState(r, Rotation.from_rotvec(turn).as_matrix() @ base.R, v, w, y[12 * n :])


def _rate_of_turn(turn: Any, w: Any) -> Any:
    """The rate of rotation vectors, whose matrix stands on the left, for ω in global axes."""
    square = np.sum(turn * turn, axis=1, keepdims=True)
    half = 0.5 * np.sqrt(square)
    small = square < 1e-4
    few = np.where(small, square, 0.0)
    safe = np.where(small, 1.0, half)
    factor = np.where(
        small,
        1 / 12 + few / 720 + few**2 / 30240,
        (1 - safe / np.tan(safe)) / np.where(small, 1.0, square),
    )
    across = cross(turn, w)
    return w - 0.5 * across + factor * cross(turn, across)
