"""Steps across a singular position: their beginnings, lengths and expected errors.

A method evaluates the equations at a few nodes of its step; the singular instant falls into the
middle of a gap between two of them. The length balances the error of the method against that of
rounding.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.core.array_types import f8, matrix, none, vector
from runtime.core.jit import compiled, inner
from runtime.core.rounding import EPS
from runtime.integrate.method import Method
from runtime.singularity.singular_position_near_motion import Singularity

FloatArray = npt.NDArray[np.float64]

_ROUNDING = 64.0  # accuracy: units of rounding within which a constraint counts as satisfied
_RESIDUE = 1e-15  # accuracy: of a position; rest of a constraint after Newton's iterations
_ROOM = 0.1  # measured: of a step; the distance from a node below which errors of stages show
_WEIGHT = 0.1  # measured: of one stage in the result of a step
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
def _weigh(
    known: FloatArray, h: float, lead: float, g: float, usual: float, out: FloatArray
) -> None:
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
def _balanced(known: FloatArray, g: float, usual: float) -> float:
    """Length of the step that errs least, not shorter than the usual one."""
    here = known[_NOISE] / (g**3 * usual**2)
    order = known[_ORDER]
    return float(usual * max(1.0, (2.0 * here / order) ** (1.0 / (order + 2.0))))


@compiled(none(matrix, vector, f8, vector))
def _best(gaps: FloatArray, known: FloatArray, usual: float, out: FloatArray) -> None:
    """The step across that errs least, wherever it begins; `gaps` has shape (k, 2)."""
    out[5] = np.inf
    for k in range(gaps.shape[0]):
        a, b = gaps[k, 0], gaps[k, 1]
        g = 0.5 * (b - a)
        h = _balanced(known, g, usual)
        _weigh(known, h, 0.5 * (a + b) * h, g, usual, out)


@compiled(none(matrix, vector, f8, f8, vector))
def _from_here(
    gaps: FloatArray, known: FloatArray, ahead: float, usual: float, out: FloatArray
) -> None:
    """The step across that errs least among those that begin the time `ahead` before."""
    out[5] = np.inf
    if ahead > 1e-9 * usual:
        for k in range(gaps.shape[0]):
            a, b = gaps[k, 0], gaps[k, 1]
            _weigh(known, ahead / (0.5 * (a + b)), ahead, 0.5 * (b - a), usual, out)
    # Just behind its beginning, or before it: then only the second node must be far away.
    second = gaps[0, 1]
    h = _balanced(known, second, usual)
    if ahead < 0.5 * second * h or not out[5] < np.inf:
        g = max(second - ahead / h, 0.5 * second)
        _weigh(known, h, ahead, g, usual, out)


@compiled(f8(vector, vector))
def _size(q: FloatArray, scale: FloatArray) -> float:
    """The largest coordinate, in units of its typical size, but not less than one."""
    largest = 1.0
    for j in range(q.size):
        largest = max(largest, abs(q[j] / scale[j]))
    return float(largest)


@cache
def _gaps(nodes: tuple[float, ...]) -> FloatArray:
    """The gaps between the nodes of a step, as fractions of it, (k, 2)."""
    return np.array([(a, b) for a, b in pairwise(sorted(nodes)) if b > a])


class CrossingSteps(NamedTuple):
    """The steps across that a method can take, at a tolerance; `scale` as in `Problem`."""

    scale: FloatArray
    rtol: float
    method: Method

    def rounding(self, q: FloatArray) -> float:
        """The residual of a constraint by rounding alone."""
        return _ROUNDING * EPS * float(_size(q, self.scale))

    def noise(self, position: Singularity) -> float:
        """Error over tolerance, times g³ h², of a step h that keeps the distance g h."""
        rounding = _RESIDUE * float(_size(position.q, self.scale))
        return 2.0 * _WEIGHT * rounding / (position.rate * position.speed * self.rtol)

    def reach(self, position: Singularity) -> float:
        """Time from a singular instant within which accelerations can be found by continuity."""
        return _TAYLOR / max(position.rate, position.speed)

    def best(self, position: Singularity, usual: float) -> CrossingStep:
        """The step across that errs least, wherever it begins; `usual` is a step's length, s."""
        out = np.empty(6)
        _best(_gaps(self.method.nodes), self._numbers(position), usual, out)
        return CrossingStep(*out.tolist())

    def from_here(self, position: Singularity, ahead: float, usual: float) -> CrossingStep:
        """The step across that errs least among those that begin the time `ahead` before, s."""
        out = np.empty(6)
        _from_here(_gaps(self.method.nodes), self._numbers(position), ahead, usual, out)
        return CrossingStep(*out.tolist())

    def _numbers(self, position: Singularity) -> FloatArray:
        order = float(self.method.error_order + 1)
        noise, reach = self.noise(position), self.reach(position)
        return np.array([noise, reach, position.speed, position.miss, order])
