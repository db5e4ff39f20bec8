"""Interpolation of a branch of a driven motion across a branch point.

Close to it velocities and accelerations are quotients 0/0. So states are computed on the branch at
some distance before and behind, where little is lost to rounding, and the motion in between is the
polynomial through them. The branch point itself, which is less accurate, is not one of them.
"""

from typing import NamedTuple

import numpy as np

from runtime.continuation.bifurcation_branches import Branch
from runtime.continuation.predictor_corrector import return_to_motion
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.singularity.motion_polynomial import Motion, interpolate

# measured: of the time scale; states at this and twice this distance are interpolated
DISTANCE = 2e-2
# measured: multiples of `DISTANCE`, in the order in which they are tried
_FACTORS = (1.0, 0.5, 2.0, 0.25, 4.0, 0.125)
# accuracy: distance from its branch, over that of the next branch, at which a state is on it
_NEAR = 0.2
_NODES = (-1.0, 1.0, -2.0, 2.0)  # formula: nodes of the interpolation, in units of the distance


class Zone(NamedTuple):
    """A branch about a singular instant t; within `reach` of it, s, q is a polynomial."""

    t: float
    reach: float
    motion: Motion

    def holds(self, t: float) -> bool:
        """Whether an instant lies within the zone."""
        return bool(abs(t - self.t) <= self.reach)

    def at(self, t: float) -> tuple[FloatArray, FloatArray]:
        """q and dq/dt at an instant within, each (n,)."""
        return self.motion.at(t - self.t)


def distance_between(choices: list[Branch], scale: FloatArray) -> float:
    """Distance of the next branch's velocity from that of the first, scaled, 1/s."""
    first = choices[0].v
    distances = (float(np.linalg.norm((other.v - first) / scale)) for other in choices[1:])
    return min(distances, default=np.inf)


def interpolate_branch(
    equations: Equations, t: float, q: FloatArray, choices: list[Branch], scale: FloatArray,
    rate: float,
) -> Zone | None:  # fmt: skip
    """The first branch about (t, q); None where it does not go on smoothly on both sides.

    `rate` tells how fast its singular value moves, 1/s.
    """
    rate = max(rate, float(np.linalg.norm(choices[0].v / scale)), 1e-3)
    apart = _NEAR * distance_between(choices, scale)
    for factor in _FACTORS:
        unit = factor * DISTANCE / rate
        states = _compute_nodes(equations, t, q, choices[0], scale, apart, unit)
        if states is not None:
            orders = [0] * len(_NODES) + [1] * len(_NODES)
            return Zone(t, 2.0 * unit, interpolate(t, unit, 2 * _NODES, orders, states))
    return None


def _compute_nodes(
    equations: Equations, t: float, q: FloatArray, branch: Branch, scale: FloatArray,
    apart: float, unit: float,
) -> FloatArray | None:  # fmt: skip
    """q, then dq/dt, at the nodes, shape (2 nodes, n); None where one misses the branch."""
    nodes, n = len(_NODES), len(q)
    states = np.zeros((2 * nodes, n))
    a, p = branch.a, equations.p
    for i, x in enumerate(_NODES):
        h = x * unit
        there, v = q + h * (branch.v + 0.5 * h * a), branch.v + h * a
        guess, guessed_v = there.copy(), v.copy()
        correction, work = equations.kernels.correction, np.zeros((2, n))
        code, *_ = return_to_motion(correction, t + h, there, v, p, scale * scale, scale, *work)
        off = float(np.linalg.norm((there - guess) / scale))
        veered = float(np.linalg.norm((v - guessed_v) / scale))
        if code != 0 or off > apart * abs(h) or veered > apart:
            return None
        states[i], states[nodes + i] = there, v
        if i == 1:
            # What the equations leave open of the acceleration follows from the nearer two.
            a = (states[nodes + 1] - states[nodes]) / (2.0 * unit)
    return states
