"""Long runs: what a small error of the clock becomes."""

from functools import cache
from math import pi

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array, Case, Reference, conservative, coordinates, table
from models.hard.suite.closed import pendulum, washboard
from runtime import Result

G = mp.mpf("9.81")
ALONG = np.linspace(0.0, 2000.0, 401)
ULP_WOUND = float(np.spacing(2e6 * pi))


@cache
def _point() -> Reference:
    theta = pendulum(ALONG, pi / 2, G)
    values = np.column_stack([-np.sin(theta), -np.cos(theta)])
    # A relative error of the energy shifts the frequency by 0.13 of itself; the bob then is off by
    # its speed, up to 4.4 m/s, times the delay.
    growth = 1.0 + 0.6 * ALONG[:, None]
    return Reference(values, ALONG, growth, 40_000, 1e-14)


@cache
def _bar() -> Reference:
    theta = pendulum(ALONG, pi / 2, 3 * G / 2)
    growth = 1.0 + 1.2 * ALONG[:, None]
    return Reference((1.5 * pi - theta)[:, None], ALONG, growth, 40_000, 1e-14)


@cache
def _double() -> Reference:
    rows = table("double_pendulum.csv")
    return Reference(rows[:, 1:3], rows[:, 0], rows[:, 5:6], 400, 1e-14)


@cache
def _turned() -> Reference:
    times = np.linspace(0.0, 1000.0, 201)
    # The angle's last digit is 9.3e-10 rad at the end, and each output rounds once or twice.
    trusted = 20 * np.spacing(2000 * pi * times[:, None])
    return Reference(2000 * pi * times[:, None], times, 1.0 + times[:, None], 20, trusted)


@cache
def _fast() -> Reference:
    times = np.linspace(0.0, 2 * pi, 201)
    angle = 100.0 * times
    values = np.column_stack([angle, np.cos(angle), np.sin(angle)])
    # The tolerance for a velocity of 100 rad/s is 100 rtol, and what is lost stays lost.
    return Reference(values, times, 1.0 + 100 * times[:, None], 1100, 1e-12)


def _washboard(begin: float, rounding: float) -> Reference:
    times = np.linspace(0.0, 20.0, 81)
    # An angle that is off by a little feels another torque, of up to 20 N m/rad: at 7.7 rad/s that
    # is a speed off by 2.6 a second, and 2.5 times that in angle.
    trusted = rounding * (1.0 + 6.5 * times[:, None])
    turned = washboard(times, begin, 10.0, 20.0)
    # An error of the speed, 10 rtol, turns into angle by up to 2.5 rad a second and rad/s.
    growth = 1.0 + 25 * times[:, None]
    return Reference(turned[:, None], times, growth, 330, trusted)


@cache
def _wound() -> Reference:
    # The angle is a multiple of 9.3e-10 rad: each of the 330 steps rounds it by up to half of that.
    return _washboard(2e6 * pi, 330 * ULP_WOUND / 2)


@cache
def _unwound() -> Reference:
    return _washboard(0.0, 1e-14)


def _turns(run: Result) -> Array:
    angle = run.q("crank.phi")
    return np.asarray(angle - angle[0])[:, None]


ELLIPTIC = "closed form by elliptic functions in 25 digits"
PENDULUM = (
    "; an error of the energy changes the frequency and so grows with the time, as does the "
    "number of errors"
)

CASES = (
    Case(
        name="pendulum_point",
        hard=(
            "A particle on a distance joint for 2000 s: neither of its coordinates is "
            "a good independent one for longer than a quarter of a swing."
        ),
        see=("The constraint stays at rounding and the energy drifts in proportion to the time."),
        model="hard/pendulum",
        scene="point",
        t_end=2000.0,
        quantity="x and y, m",
        measure=coordinates("bob.x", "bob.y"),
        reference=_point,
        origin=ELLIPTIC + PENDULUM,
        tolerances=(1e-8, 1e-10, 1e-12),
        work=conservative,
    ),
    Case(
        name="pendulum_bar",
        hard="The same with a body on a revolute joint.",
        see=(
            "The angle is the better coordinate; a partition that keeps it needs no change at all."
        ),
        model="hard/pendulum",
        scene="bar",
        t_end=2000.0,
        quantity="φ, rad",
        measure=coordinates("bar.phi"),
        reference=_bar,
        origin=ELLIPTIC + PENDULUM,
        tolerances=(1e-8, 1e-10, 1e-12),
        work=conservative,
    ),
    Case(
        name="double_pendulum",
        hard="Chaos: a perturbation grows 1e17-fold in 40 s.",
        see=(
            "Each tolerance is right up to its horizon, the column `until`; energy and "
            "constraints hold for the whole run."
        ),
        model="hard/double_pendulum",
        scene="thrown",
        t_end=40.0,
        quantity="φ of both bars, rad",
        measure=coordinates("upper.phi", "lower.phi"),
        reference=_double,
        origin=(
            "Taylor series of order 50 in 55 digits, a second run of order 40 in 45 "
            "digits agrees to 1e-28; growth by a third run from a start 1e-29 rad "
            "away"
        ),
        tolerances=(1e-3, 1e-6, 1e-9, 1e-12),
        work=conservative,
    ),
    Case(
        name="crank_turned",
        hard="A million turns: the angle is six million radians, its last digit 1e-9.",
        see="A handful of steps, and an error of a few last digits of the angle.",
        model="hard/crank",
        scene="turned",
        t_end=1000.0,
        quantity="φ, rad",
        measure=coordinates("crank.phi"),
        reference=_turned,
        origin="φ = ωt",
        work=conservative,
    ),
    Case(
        name="crank_wound",
        hard=(
            "The same angle with a torque that depends on it: a million turns lie "
            "behind the start, and only the part of a turn matters."
        ),
        see=("As `crank_unwound` down to the last digit of the angle, 1e-9 rad; no more steps."),
        model="hard/crank",
        scene="wound",
        t_end=20.0,
        quantity="φ - φ(0), rad",
        measure=_turns,
        reference=_wound,
        origin="closed form by the elliptic amplitude in 25 digits",
        work=lambda run: 20.0 * (np.cos(run.q("crank.phi")) - np.cos(run.q("crank.phi")[0])),
    ),
    Case(
        name="crank_unwound",
        hard="The same from φ = 0, for comparison.",
        see="The error at the same tolerance without the large angle.",
        model="hard/crank",
        scene="unwound",
        t_end=20.0,
        quantity="φ - φ(0), rad",
        measure=_turns,
        reference=_unwound,
        origin="closed form by the elliptic amplitude in 25 digits",
        work=lambda run: 20.0 * (np.cos(run.q("crank.phi")) - 1.0),
    ),
    Case(
        name="crank_fast",
        hard="A hundred turns of a crank whose independent coordinate is x and y by turns.",
        see="Up to 400 changes of partition cost neither accuracy nor steps.",
        model="hard/crank",
        scene="fast",
        t_end=2 * pi,
        quantity="φ in rad, x and y in m",
        measure=coordinates("crank.phi", "crank.x", "crank.y"),
        reference=_fast,
        origin="φ = ωt",
        work=conservative,
    ),
)
