"""Edges of what can be asked: no time at all, one step, many outputs, any tolerance."""

from functools import cache
from math import pi

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array, Case, Reference, conservative, coordinates
from models.hard.suite.closed import pendulum

SQUARED = 3 * mp.mpf("9.81") / 2
DENSE = np.linspace(0.0, 2.0, 20_001)
SWEEP = np.linspace(0.0, 2.0, 41)
INSTANT = 1e-3
EVERY = tuple(10.0**-digits for digits in range(2, 14))


def _bar(times: Array, steps: float) -> Reference:
    angle = 1.5 * pi - pendulum(times, pi / 2, SQUARED)
    return Reference(angle[:, None], times, 1.0 + 5 * times[:, None], steps, 5e-15)


@cache
def _at_once() -> Reference:
    return _bar(np.zeros(1), 1)


@cache
def _one_step() -> Reference:
    return _bar(np.array([0.0, INSTANT]), 1)


@cache
def _dense() -> Reference:
    return _bar(DENSE, 40)


@cache
def _sweep() -> Reference:
    return _bar(SWEEP, 40)


ELLIPTIC = "closed form by elliptic functions in 25 digits"
PHI = "φ, rad"
BAR = ("hard/pendulum", "bar")

CASES = (
    Case(
        "no_time", "A run that ends where it starts.",
        "One row of output, the assembled start, and no step.",
        *BAR, 0.0, PHI, coordinates("bar.phi"), _at_once, ELLIPTIC, work=conservative,
    ),
    Case(
        "one_step", "A run of a millisecond whose first step may be as long as it.",
        "A single step that is as right as the others.",
        *BAR, INSTANT, PHI, coordinates("bar.phi"), _one_step, ELLIPTIC,
        tolerances=(1e-3, 1e-6, 1e-9), options={"first_step": INSTANT}, work=conservative,
    ),
    Case(
        "dense_outputs", "20 001 outputs over some forty steps.",
        "Between the steps the error is that of the steps.",
        *BAR, 2.0, PHI, coordinates("bar.phi"), _dense, ELLIPTIC, work=conservative,
    ),
    Case(
        "every_tolerance", "One machine at rtol from 1e-2 to 1e-13.",
        "The error falls with the tolerance over eleven decades.",
        *BAR, 2.0, PHI, coordinates("bar.phi"), _sweep, ELLIPTIC, tolerances=EVERY,
        work=conservative,
    ),
)  # fmt: skip
