"""A mass above a base that moves by a law: flights, impacts, rest and release, in 50 digits.

The mass moves by ÿ = pull - squared · y while it flies, the base by h(t). An impact returns the
share e of the speed of approach; flights that shrink end where their sum does. From there the mass
lies on the base, as long as the base does not fall away faster than the mass would by itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array
from models.hard.suite.closed import Number

_DIGITS = 50
_SHORT = mp.mpf("1e-18")  # of a flight, s: the rest of the sum is as short


@dataclass(frozen=True)
class Base:
    """Place, velocity and acceleration of the base at t."""

    place: Callable[[Number], Number]
    velocity: Callable[[Number], Number]
    acceleration: Callable[[Number], Number]


@dataclass(frozen=True)
class Story:
    """What happens: flights as (t, y, v) at their begin, and times of rest and of release, s."""

    flights: list[tuple[Number, Number, Number]] = field(default_factory=list)
    rests: list[Number] = field(default_factory=list)
    releases: list[Number] = field(default_factory=list)


@dataclass(frozen=True)
class Bouncing:
    """A mass with ÿ = pull - squared · y in flight, an impact number e, and a base."""

    pull: Number
    squared: Number
    restitution: Number
    base: Base

    def flight(self, at: tuple[Number, Number, Number], t: Number) -> tuple[Number, Number]:
        """(y, v) at t of the flight that begins at `at`."""
        begin, y, v = at
        s = t - begin
        if self.squared == 0:
            return y + v * s + self.pull * s**2 / 2, v + self.pull * s
        w, middle = mp.sqrt(self.squared), self.pull / self.squared
        c, z = mp.cos(w * s), mp.sin(w * s)
        return middle + (y - middle) * c + v / w * z, v * c - (y - middle) * w * z

    def story(self, y: float, t_end: float, pace: float) -> Story:
        """From rest at y ≥ h(0) on; `pace` in s is short against every change of the base."""
        story = Story()
        with mp.workdps(_DIGITS):
            t, v = mp.mpf(0), mp.mpf(0)
            height = mp.mpf(y)
            if height <= self.base.place(t):
                height = self.base.place(t)
                story.rests.append(t)
                t = self._release(t, t_end, pace)
                story.releases.append(t)
                height, v = self.base.place(t), self.base.velocity(t)
            while t < t_end:
                story.flights.append((t, height, v))
                landed = self._landing(story.flights[-1], t_end, pace)
                if landed >= t_end:
                    break
                _, v = self.flight(story.flights[-1], landed)
                moving = self.base.velocity(landed)
                v = moving - self.restitution * (v - moving)
                over = landed - t < _SHORT or self.restitution == 0
                t, height = landed, self.base.place(landed)
                if over and self._held(t) > 0:
                    story.rests.append(t)
                    t = self._release(t, t_end, pace)
                    story.releases.append(t)
                    height, v = self.base.place(t), self.base.velocity(t)
        return story

    def _held(self, t: Number) -> Number:
        """By how much the base's acceleration exceeds the flight's: positive while it carries."""
        return self.base.acceleration(t) - self.pull + self.squared * self.base.place(t)

    def _gap(self, at: tuple[Number, Number, Number], t: Number) -> Number:
        return self.flight(at, t)[0] - self.base.place(t)

    def _landing(self, at: tuple[Number, Number, Number], t_end: float, pace: float) -> Number:
        """The first zero of the gap after the flight's begin."""
        begin, _, v = at
        relative, braking = v - self.base.velocity(begin), self._held(begin)
        short = 2 * relative / braking if relative > 0 and braking > 0 else mp.mpf(1)
        step = min(mp.mpf(pace), short / 8)
        low = begin + step
        while low < t_end and self._gap(at, low + step) > 0:
            low += step
        if low >= t_end:
            return mp.mpf(t_end)
        return _zero(lambda t: self._gap(at, t), low, low + step)

    def _release(self, t: Number, t_end: float, pace: float) -> Number:
        """Where the base begins to fall away faster than the mass would."""
        step = mp.mpf(pace)
        while t < t_end and self._held(t + step) > 0:
            t += step
        return mp.mpf(t_end) if t >= t_end else _zero(self._held, t, t + step)

    def place(self, story: Story, times: Array) -> Array:
        """y at the instants, m."""
        found = []
        for t in map(float, times):
            rest = max((at for at in story.rests if at <= t), default=None)
            flown = max((at for at in story.flights if at[0] <= t), default=None)
            if flown is None or (rest is not None and rest > flown[0]):
                found.append(float(self.base.place(mp.mpf(t))))
            else:
                found.append(float(self.flight(flown, mp.mpf(t))[0]))
        return np.array(found)


def _zero(f: Callable[[Number], Number], low: Number, high: Number) -> Number:
    """The zero between two places of opposite sign."""
    tol = mp.mpf(10) ** (6 - _DIGITS)
    return mp.findroot(f, (low, high), solver="anderson", tol=tol, maxsteps=100)
