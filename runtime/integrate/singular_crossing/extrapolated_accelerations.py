"""The accelerations close to a singular position, where the equations cannot be asked for them."""

import numpy as np

from runtime.core.array_types import Vector
from runtime.integrate.run_state import RunState
from runtime.singularity.motion_polynomial import Motion, interpolate, taylor


def extrapolate_accelerations(
    state: RunState, scale: Vector, motion: Motion, instant: float, delta: float
) -> Vector | None:
    """The accelerations at the start of `motion` by continuity, (n,); None where there are none.

    They are computed at four instants within 2 `delta` of the singular `instant`, before and
    behind it, at states on the constraints that the motion passes; a cubic through them gives
    its own, and better states. `scale`, (n,), are typical sizes of changes of the coordinates.
    """
    system, n = state.system, scale.size
    times = instant - motion.t + delta * np.array([-2.0, -1.0, 1.0, 2.0])
    nodes, orders = (0.0, 0.0, *(times / delta)), (0, 1, 2, 2, 2, 2)
    values = np.vstack([motion.q, motion.v, np.zeros((4, n))])
    lam = np.zeros(system.constraint_count)
    better = taylor(motion.t, motion.q, motion.v, np.zeros(n))
    for _ in range(4):
        for s, a in zip(times, values[2:], strict=True):
            q, v = better.at(s)
            if not _project(state, scale, motion.t + s, q, v):
                return None
            system.accelerations(motion.t + s, q, v, state.p, state.modes, a, lam)
        if not np.isfinite(values).all():
            return None
        better = interpolate(motion.t, delta, nodes, orders, values)
    first: Vector = 2.0 * better.series[2]
    return first


def _project(state: RunState, scale: Vector, t: float, q: Vector, v: Vector) -> bool:
    """Bring q and v onto the constraints, least in the metric of the masses."""
    dq, dv, moved = np.zeros_like(q), np.zeros_like(v), np.inf
    for _ in range(8):
        state.system.correction(t, q, v, state.p, scale**2, dq, dv)
        q += dq
        v += dv
        if not np.isfinite(dq + dv).all():
            return False
        moved = float(np.abs(dq / scale).max())
        if moved < 1e-13:
            break
    return moved < 1e-10  # near a singular position rounding keeps it from less
