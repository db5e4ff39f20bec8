"""Interpolation of a branch of a driven motion across a branch point.

Close to it velocities and accelerations are quotients 0/0. So states are computed on the branch at
some distance before and behind, where little is lost to rounding, and the motion in between is the
polynomial through them. The branch point itself, which is less accurate, is not one of them.
"""

from typing import NamedTuple

import numpy as np

from runtime.continuation.bifurcation_branches import Branch
from runtime.continuation.predictor_corrector import settle
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.singularity.local_motion import Motion, interpolate

# measured: of the time scale; states at this and twice this distance are interpolated
DISTANCE = 2e-2
# measured: multiples of `DISTANCE`, in the order in which they are tried
_TRIED = (1.0, 0.5, 2.0, 0.25, 4.0, 0.125)
# accuracy: distance from its branch, over that of the next branch, at which a state is on it
_NEAR = 0.2
_ENDS = (-1.0, 1.0, -2.0, 2.0)  # formula: nodes of the interpolation, in units of the distance


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


def zone(
    equations: Equations,
    t: float,
    q: FloatArray,
    branch: Branch,
    apart: float,
    scale: FloatArray,
    rate: float,
) -> Zone | None:
    """The branch about (t, q); None where it does not go on smoothly on both sides.

    Parameters
    ----------
    apart
        Distance of the next branch's velocity, scaled, 1/s; infinite where there is none.
    rate
        How fast the machine and its singular value move, 1/s.
    """
    for factor in _TRIED:
        found = _zone(equations, t, q, branch, apart, scale, factor * DISTANCE / rate)
        if found is not None:
            return found
    return None


def _zone(
    equations: Equations,
    t: float,
    q: FloatArray,
    branch: Branch,
    apart: float,
    scale: FloatArray,
    unit: float,
) -> Zone | None:
    w = scale * scale
    values: list[FloatArray] = []
    rates: list[FloatArray] = []
    a = branch.a
    for x in _ENDS:
        h = x * unit
        there, v = q + h * (branch.v + 0.5 * h * a), branch.v + h * a
        guess, info = there.copy(), np.zeros(3)
        dq, dv = np.zeros_like(q), np.zeros_like(q)
        weak = settle(
            equations.kernels.correction, t + h, there, v, equations.p, w, scale, dq, dv, info
        )
        if weak != 0:
            return None
        off = float(np.linalg.norm((there - guess) / scale))
        veered = float(np.linalg.norm((v - branch.v - h * a) / scale))
        if off > _NEAR * apart * abs(h) or veered > _NEAR * apart:
            return None
        values.append(there)
        rates.append(v)
        if x == 1.0:
            # What the equations leave open of the acceleration follows from the nearer two.
            a = (rates[1] - rates[0]) / (2.0 * unit)
    orders = [0] * len(_ENDS) + [1] * len(_ENDS)
    motion = interpolate(t, unit, 2 * _ENDS, orders, np.vstack([*values, *rates]))
    return Zone(t, 2.0 * unit, motion)
