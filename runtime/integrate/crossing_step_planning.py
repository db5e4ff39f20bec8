"""Steps across a singular position: their beginnings, lengths, expected errors and method.

A method evaluates the equations at a few nodes of its step; the singular instant falls into the
middle of a gap between two of them. The length balances the error of the method against that of
rounding.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from runtime.core.arrays import EPS, Matrix, Vector, f8, matrix, none, vector
from runtime.core.jit import compiled, inner
from runtime.integrate.method import EXPLICIT, LEADING, Method
from runtime.integrate.run_state import RunState
from runtime.integrate.step_control import first_step
from runtime.linalg.unit_euler_parameters import normalise
from runtime.singularity.motion_polynomial import Motion, interpolate, taylor
from runtime.singularity.singular_position_near_motion import Singularity

_ROUNDING = 64.0  # accuracy: units of rounding within which a constraint counts as satisfied
_RESIDUE = 1e-15  # accuracy: of a position; rest of a constraint after Newton's iterations
_ROOM = 0.1  # measured: of a step; nearer to a node errors of stages show
_WEIGHT = 0.1  # measured: of one stage in the result of a step
_POOR = 10.0  # measured: error over tolerance from which on another method leads across
_LEARNING = 0.2  # measured: of the way there; first step of the method that takes over
_TAYLOR = 5e-3  # accuracy: eps ** (1/7) of the time scale, where rounding balances a cubic's error


class CrossingStep(NamedTuple):
    """A step across a singular configuration, and its errors."""

    h: float  # length, s
    lead: float  # of its beginning before the singular instant, s
    method: float  # expected error over the tolerance
    rounding: float  # the same
    start: float  # part of the latter that is due to the derivative at the beginning
    total: float  # the error to choose by


# Numbers of a singular position, as compiled formulas take them.
_NOISE, _REACH, _SPEED, _MISS, _ORDER = 0, 1, 2, 3, 4


@inner
def _weigh(known: Vector, h: float, lead: float, g: float, usual: float, out: Vector) -> None:
    """Keep a step that keeps the distance g h from the singular instant, if none errs less.

    Its error is that of the method, of rounding, and of stages: they lie off the constraints by
    their own errors, which the accelerations at that distance multiply by about 1/g; and the
    instant is known only so well. `out` is a `CrossingStep`.
    """
    noise = known[_NOISE]
    method = max(h / usual, 1.0) ** known[_ORDER]
    rounding = noise / (g**3 * h**2)
    start = noise * h / max(abs(lead), 1e-100) ** 3
    if abs(lead) < known[_REACH]:
        start = min(start, 1.0)  # it will be found by continuity
    uncertainty = known[_MISS] / (known[_SPEED] * g * h)
    total = method * (1.0 + (_ROOM / g) ** 2) + rounding + start + uncertainty**2
    if total < out[5]:
        out[0], out[1], out[2], out[3], out[4], out[5] = h, lead, method, rounding, start, total


@inner
def _balanced(known: Vector, g: float, usual: float) -> float:
    """Length of the step that errs least, not shorter than the usual one."""
    here = known[_NOISE] / (g**3 * usual**2)
    order = known[_ORDER]
    return float(usual * max(1.0, (2.0 * here / order) ** (1.0 / (order + 2.0))))


@compiled(none(matrix, vector, f8, f8, vector))
def _choose(gaps: Matrix, known: Vector, ahead: float, usual: float, out: Vector) -> None:
    """The step across that errs least, of those that begin `ahead` s before, inf: of all (k, 2)."""
    out[5] = np.inf
    for k in range(gaps.shape[0]):
        middle, g = 0.5 * (gaps[k, 0] + gaps[k, 1]), 0.5 * (gaps[k, 1] - gaps[k, 0])
        if ahead == np.inf:
            h = _balanced(known, g, usual)
            _weigh(known, h, middle * h, g, usual, out)
        elif ahead > 1e-9 * usual:
            _weigh(known, ahead / middle, ahead, g, usual, out)
    # Just behind its beginning, or before it: then only the second node must be far away.
    second = gaps[0, 1]
    h = _balanced(known, second, usual)
    if ahead < 0.5 * second * h or not out[5] < np.inf:
        g = max(second - ahead / h, 0.5 * second)
        _weigh(known, h, ahead, g, usual, out)


@compiled(f8(vector, vector))
def _size(q: Vector, scale: Vector) -> float:
    """The largest coordinate, in units of its typical size, but not less than one."""
    largest = 1.0
    for j in range(q.size):
        largest = max(largest, abs(q[j] / scale[j]))
    return float(largest)


@cache
def _gaps(nodes: tuple[float, ...]) -> Matrix:
    """The gaps between the nodes of a step, as fractions of it, (k, 2)."""
    return np.array([(a, b) for a, b in pairwise(sorted(nodes)) if b > a])


class CrossingSteps(NamedTuple):
    """The steps across that a method can take, at a tolerance; `scale` as in `Problem`."""

    scale: Vector
    rtol: float
    method: Method

    def rounding(self, q: Vector) -> float:
        """The residual of a constraint by rounding alone."""
        return _ROUNDING * EPS * float(_size(q, self.scale))

    def noise(self, position: Singularity) -> float:
        """Error over tolerance, times g³ h², of a step h that keeps the distance g h."""
        rounding = _RESIDUE * float(_size(position.q, self.scale))
        return 2.0 * _WEIGHT * rounding / (position.rate * position.speed * self.rtol)

    def reach(self, position: Singularity) -> float:
        """Time from a singular instant within which accelerations can be found by continuity."""
        return _TAYLOR / max(position.rate, position.speed)

    def best(self, position: Singularity, usual: float, ahead: float = np.inf) -> CrossingStep:
        """The step across that errs least, wherever it begins, or the time `ahead` before, s.

        `usual` is the length of a step elsewhere, s.
        """
        order, out = float(self.method.estimate_order), np.empty(6)
        noise, reach = self.noise(position), self.reach(position)
        known = np.array([noise, reach, position.speed, position.miss, order])
        _choose(_gaps(self.method.nodes), known, ahead, usual, out)
        return CrossingStep(*out.tolist())


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
    values = np.vstack([motion.position, motion.velocity, np.zeros((4, n))])
    lam = np.zeros(system.constraint_count)
    better = taylor(motion.t, motion.position, motion.velocity, np.zeros(n))
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
        normalise(q, state.system.turning)
        state.system.correction(t, q, v, state.p, scale**2, dq, dv)
        q += dq
        v += dv
        if not np.isfinite(dq + dv).all():
            return False
        moved = float(np.abs(dq / scale).max())
        if moved < 1e-13:
            break
    return moved < 1e-10  # near a singular position rounding keeps it from less


class MethodHandover:
    """The loan of the explicit method of highest order to a run whose own does not reach across.

    None that is implicit does: at the distance τ the derivative of the accelerations by the
    velocities is 2/τ, of opposite signs on both sides, and no Newton iteration goes through that.
    One of low order does not where its steps are so short that rounding rules.
    """

    def __init__(self, state: RunState) -> None:
        self.state, self.kept_length = state, 0.0

    def begin(
        self, steps: CrossingSteps, position: Singularity, ahead: float, usual: float
    ) -> bool:
        """Let that method step where it is needed to cross `position`, the time `ahead` from now.

        Returns whether there is way left on which to learn how long steps may be.
        """
        state, r = self.state, self.state.record
        name = state.methods[-1][1]
        if name in {LEADING, "auto"} or r["lent"]:
            return False
        if name in EXPLICIT and steps.best(position, usual).total < _POOR:
            return False
        self.kept_length = float(r["h"])
        r["lent"], r["automatic"] = 1, 0
        r["lent_until"] = position.t + max(ahead, self.kept_length)
        state.use_method(LEADING)
        first = first_step(state.table, r["t"], r["h_max"], r["rtol"], r["estimate_order"])
        way = _LEARNING * ahead
        r["usual"] = r["h"] = min(first, way) if way > 0.0 else max(first, self.kept_length)
        r["look_at"] = -np.inf
        return way > 0.0

    def end(self) -> None:
        """Go on with the method that was asked for."""
        state, r = self.state, self.state.record
        r["lent"], r["automatic"] = 0, int(state.options.method == "auto")
        r["h"] = self.kept_length
        state.use_method(state.methods[-1][1])
