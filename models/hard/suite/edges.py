"""Extreme arguments: no time at all, one step, many outputs, any tolerance."""

from functools import cache
from math import pi

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array, Case, Reference, conservative, coordinates
from models.hard.suite.closed import pendulum

SQUARED = 3 * mp.mpf("9.81") / 2
DENSE = np.linspace(0.0, 2.0, 5001)
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
def _striker() -> Reference:
    return Reference(np.array([[1.2]]), np.zeros(1), 1.0, 1, 1e-15)


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

CASES = (
    Case(
        name="no_time",
        hard="A run that ends where it starts.",
        see="One row of output, the assembled start, and no step.",
        model="hard/pendulum",
        scene="bar",
        t_end=0.0,
        quantity=PHI,
        measure=coordinates("bar.phi"),
        reference=_at_once,
        origin=ELLIPTIC,
        work=conservative,
    ),
    Case(
        name="no_time_switching",
        hard="The same where a condition is on its boundary at the start.",
        see="The same, without an endless loop.",
        model="coil_spring",
        scene="impact",
        t_end=0.0,
        quantity="x of the striker, m",
        measure=coordinates("striker.x"),
        reference=_striker,
        origin="the start as declared",
        work=conservative,
    ),
    Case(
        name="one_step",
        hard="A run of a millisecond whose first step may be as long as the run.",
        see="A single step, as accurate as any other.",
        model="hard/pendulum",
        scene="bar",
        t_end=INSTANT,
        quantity=PHI,
        measure=coordinates("bar.phi"),
        reference=_one_step,
        origin=ELLIPTIC,
        tolerances=(1e-3, 1e-6, 1e-9),
        options={"first_step": INSTANT},
        work=conservative,
    ),
    Case(
        name="dense_outputs",
        hard="5001 outputs over some forty steps.",
        see="The error between the steps is that of the steps.",
        model="hard/pendulum",
        scene="bar",
        t_end=2.0,
        quantity=PHI,
        measure=coordinates("bar.phi"),
        reference=_dense,
        origin=ELLIPTIC,
        work=conservative,
    ),
    Case(
        name="every_tolerance",
        hard="One machine at rtol from 1e-2 to 1e-13.",
        see="The error falls with the tolerance over eleven decades.",
        model="hard/pendulum",
        scene="bar",
        t_end=2.0,
        quantity=PHI,
        measure=coordinates("bar.phi"),
        reference=_sweep,
        origin=ELLIPTIC,
        tolerances=EVERY,
        work=conservative,
    ),
)
