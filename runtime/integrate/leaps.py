"""Steps across a singular position: where they begin, how long they are, and what they err by.

A method evaluates the equations at a few nodes of its step; the singular instant falls into the
middle of a gap between two of them. The length balances the error of the method against that of
rounding.
"""

from itertools import pairwise
from types import ModuleType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.constraints.singular import Singularity

FloatArray = npt.NDArray[np.float64]

_EPS = 2.2e-16
_ROUNDING = 64.0  # units of rounding within which a constraint counts as satisfied
_RESIDUE = 1e-15  # of a position: what Newton's iterations leave of a constraint
_ROOM = 0.1  # of a step: the distance from a node below which errors of stages tell
_WEIGHT = 0.1  # of one stage in the result of a step
_TAYLOR = 5e-3  # eps ** (1/7): of the time scale, where rounding balances a cubic's error


class Leap(NamedTuple):
    """A step across: its length, its beginning before the singular instant, s, and errors.

    `method` and `rounding` are expected errors over the tolerance; `start` is the part of the
    latter that is due to the derivative at the beginning; `total` is what to choose by.
    """

    h: float
    lead: float
    method: float
    rounding: float
    start: float
    total: float


class Leaps:
    """The steps across that a method can take, at a tolerance."""

    def __init__(self, scale: FloatArray, rtol: float, parts: ModuleType) -> None:
        self.scale, self.rtol = scale, rtol
        self.follow(parts)

    def follow(self, parts: ModuleType) -> None:
        """Plan for the steps of the method that is a module `parts`."""
        self.order = parts.ERROR_ORDER + 1
        nodes = sorted(getattr(parts, "NODES", (0.0, 1.0)))
        self.gaps = [(a, b) for a, b in pairwise(nodes) if b > a]

    def rounding(self, q: FloatArray) -> float:
        """What a constraint misses by rounding alone."""
        return _ROUNDING * _EPS * self._size(q)

    def noise(self, found: Singularity) -> float:
        """Error over tolerance, times g³ h², of a step h that keeps the distance g h."""
        rounding = _RESIDUE * self._size(found.q)
        return 2.0 * _WEIGHT * rounding / (found.rate * found.speed * self.rtol)

    def reach(self, found: Singularity) -> float:
        """Time from a singular instant within which accelerations can be found by continuity."""
        return _TAYLOR / max(found.rate, found.speed)

    def best(self, found: Singularity, usual: float) -> Leap:
        """The step across that errs least, wherever it begins."""
        leaps = []
        for a, b in self.gaps:
            g = 0.5 * (b - a)
            h = self._balanced(found, g, usual)
            leaps.append(self._leap(found, h, 0.5 * (a + b) * h, g, usual))
        return min(leaps, key=lambda leap: leap.total)

    def from_here(self, found: Singularity, ahead: float, usual: float) -> Leap:
        """The step across that errs least among those that begin now."""
        leaps = []
        for a, b in self.gaps if ahead > 1e-9 * usual else ():
            h = ahead / (0.5 * (a + b))
            leaps.append(self._leap(found, h, ahead, 0.5 * (b - a), usual))
        # Just behind its beginning, or before it: then only the second node must be far away.
        second = self.gaps[0][1]
        h = self._balanced(found, second, usual)
        if ahead < 0.5 * second * h or not leaps:
            g = max(second - ahead / h, 0.5 * second)
            leaps.append(self._leap(found, h, ahead, g, usual))
        return min(leaps, key=lambda leap: leap.total)

    def _leap(self, found: Singularity, h: float, lead: float, g: float, usual: float) -> Leap:
        """A step that keeps the distance g h between its nodes and the singular instant.

        Its error is that of the method, of rounding, and of stages: they lie off the constraints
        by their own errors, which the accelerations at that distance multiply by about 1/g; and
        the instant is known only so well.
        """
        method = max(h / usual, 1.0) ** self.order
        rounding = self.noise(found) / (g**3 * h**2)
        start = self.noise(found) * h / max(abs(lead), 1e-100) ** 3
        if abs(lead) < self.reach(found):
            start = min(start, 1.0)  # it will be found by continuity
        unsure = found.miss / (found.speed * g * h)
        total = method * (1.0 + (_ROOM / g) ** 2) + rounding + start + unsure**2
        return Leap(h, lead, method, rounding, start, total)

    def _balanced(self, found: Singularity, g: float, usual: float) -> float:
        """Length of the step that errs least, not shorter than the usual one."""
        here = self.noise(found) / (g**3 * usual**2)
        return float(usual * max(1.0, (2.0 * here / self.order) ** (1.0 / (self.order + 2))))

    def _size(self, q: FloatArray) -> float:
        return float(np.abs(q / self.scale).max(initial=1.0))
