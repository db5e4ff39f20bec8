"""Springs: stiff beside soft, long chains, surge and impact of section 8.4."""

from functools import cache
from math import pi, sqrt

import mpmath as mp
import numpy as np

from models.hard.spring_chain import BLOW, COUNT, MASS, PITCH, STIFFNESS
from models.hard.stiff_soft import AMPLITUDE, REST, SOFT, STIFF
from models.hard.suite.case import Array, Case, Reference, conservative, coordinates, table
from models.hard.suite.closed import chain
from runtime import Result

TEN = np.linspace(0.0, 10.0, 101)
CHAIN = np.linspace(0.0, 5.0, 201)
IMPACT = "coil_spring_impact_k50_events.csv"
DAMPED = "coil_spring_impact_k50_damped_events.csv"


@cache
def _soft_mode() -> Reference:
    with mp.workdps(30):
        both = mp.mpf(STIFF) + 2 * mp.mpf(SOFT)
        slow = mp.sqrt(2 * STIFF * SOFT / (both + mp.sqrt(both**2 - 4 * STIFF * SOFT)))
        moved = [float(AMPLITUDE * mp.cos(slow * mp.mpf(float(t)))) for t in TEN]
    values = 2 * REST + np.array(moved)[:, None]
    # The motion itself is one of 1 rad/s, whatever the step: fifty steps for two swings.
    return Reference(values, TEN, 1.0 + TEN[:, None], 50, 1e-12)


@cache
def _struck() -> Reference:
    rest = PITCH * np.arange(1, COUNT + 1)
    return Reference(rest + chain(CHAIN, COUNT, STIFFNESS, MASS, BLOW), CHAIN, 2.0, 110, 1e-13)


@cache
def _surge() -> Reference:
    rows = table("coil_spring_surge.csv")
    return Reference(rows[:, 1:7], rows[:, 0], 2.0, 200, 1e-13)


def _events(name: str, count: int | None, growth: tuple[float, float]) -> Reference:
    """The times of the contacts after the first; errors grow from one to the next."""
    path = name
    times = _times(path)[:count]
    grown = np.geomspace(*growth, len(times))
    return Reference(times, times, grown, 5, 1e-15)


def _times(name: str) -> Array:
    from models.hard.suite.case import ROOT

    path = ROOT / "tests" / "data" / name
    return np.loadtxt(path, delimiter=",", skiprows=2, usecols=2)


@cache
def _first_ten() -> Reference:
    return _events(IMPACT, 10, (1.0, 10.0))


@cache
def _all() -> Reference:
    return _events(IMPACT, None, (1.0, 1e5))


@cache
def _damped() -> Reference:
    return _events(DAMPED, None, (1.0, 1e5))


def _event_times(run: Result) -> Array:
    return np.array([event.time for event in run.events])


GIVEN = (
    "given solution in extended precision, 20 digits; from the first contact to the last, errors "
    "grow about 1e5-fold"
)

CASES = (
    Case(
        "stiff_soft", "1e9 N/m beside 1 N/m: the step of an explicit method is bound by an "
        "oscillation of 5000 Hz that is not there.",
        "Explicit methods take a hundred thousand steps, implicit ones a hundred.",
        "hard/stiff_soft", "soft_mode", 10.0, "x of the second mass, m", coordinates("second.x"),
        _soft_mode, "closed form, the soft mode alone, in 30 digits",
        tolerances=(1e-3, 1e-6, 1e-9, 1e-12), work=conservative,
    ),
    Case(
        "spring_chain", f"{COUNT} masses on springs: {3 * COUNT} coordinates, a wide spectrum.",
        "Errors as for one mass; the time grows with the number of masses and not faster.",
        "hard/spring_chain", "struck", 5.0, "x of all masses, m",
        coordinates(*(f"mass_{i}.x" for i in range(1, COUNT + 1))), _struck,
        "closed form, the sum over the modes; linear, nothing grows",
        work=conservative,
    ),
    Case(
        "coil_spring_surge", "Section 8.4.1, surge waves in six masses.",
        "As the chain.", "coil_spring", "surge", 10.0, "x of all masses, m",
        coordinates(*(f"mass_{i}.x" for i in range(1, 7))), _surge,
        "closed form; linear, nothing grows", work=conservative,
    ),
    Case(
        "coil_spring_first_ten", "Section 8.4.2, k = 50 N/m: a contact of 1e6 N/m beside springs "
        "of 50 N/m; the first ten contacts on and off.",
        "Within 1e-10 s at the tightest tolerance.",
        "coil_spring", "impact", 2.668, "times of the events, s", _event_times, _first_ten, GIVEN,
        sampled=False, work=conservative,
    ),
    Case(
        "coil_spring_impact", "The same to the end: 59 events.",
        "The last within 1e-6 s at the tightest tolerance; none is missed, none invented.",
        "coil_spring", "impact", 13.0, "times of the events, s", _event_times, _all, GIVEN,
        sampled=False, tolerances=(1e-8, 1e-10, 1e-12), work=conservative,
    ),
    Case(
        "coil_spring_damped", "The same with a damper in the contact.",
        "As without.", "coil_spring", "impact_damped", 13.0, "times of the events, s",
        _event_times, _damped, GIVEN, sampled=False, tolerances=(1e-8, 1e-10, 1e-12),
    ),
)  # fmt: skip
