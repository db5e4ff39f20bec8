"""Springs: stiff beside soft, long chains, surge and impact of section 8.4."""

from functools import cache

import mpmath as mp
import numpy as np

from models.hard.spring_chain import BLOW, COUNT, MASS, PITCH, STIFFNESS
from models.hard.stiff_soft import AMPLITUDE, REST, SOFT, STIFF
from models.hard.suite.case import ROOT, Array, Case, Reference, conservative, coordinates, table
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


def _events(name: str, count: int, growth: float | Array, steps: float) -> Reference:
    """The times of the first contacts on and off, but for the one that begins with the run."""
    path = ROOT / "tests" / "data" / name
    times = np.loadtxt(path, delimiter=",", skiprows=2, usecols=2)[:count]
    return Reference(times, times, growth, steps, 1e-14)


@cache
def _first_ten() -> Reference:
    return _events(IMPACT, 10, 22.0, 80)


@cache
def _all() -> Reference:
    grown = np.concatenate([np.full(40, 90.0), np.geomspace(100.0, 1700.0, 19)])
    return _events(IMPACT, 59, grown, 410)


@cache
def _damped() -> Reference:
    return _events(DAMPED, 41, 1500.0, 1200)


def _event_times(run: Result) -> Array:
    return np.array([event.time for event in run.events])


GIVEN = (
    "given solution in extended precision, 20 digits; growth by perturbing each start value of a "
    "solution by matrix exponentials"
)

CASES = (
    Case(
        name="stiff_soft",
        hard=(
            "1e9 N/m beside 1 N/m: the step of an explicit method is limited by an "
            "oscillation of 5000 Hz that the motion does not contain."
        ),
        see="Explicit methods take a hundred thousand steps, implicit ones a hundred.",
        model="hard/stiff_soft",
        scene="soft_mode",
        t_end=10.0,
        quantity="x of the second mass, m",
        measure=coordinates("second.x"),
        reference=_soft_mode,
        origin="closed form, the soft mode alone, in 30 digits",
        tolerances=(1e-3, 1e-6, 1e-9, 1e-12),
        work=conservative,
    ),
    Case(
        name="spring_chain",
        hard=f"{COUNT} masses on springs: {3 * COUNT} coordinates, a wide spectrum.",
        see=("Errors as for one mass; the time grows with the number of masses and not faster."),
        model="hard/spring_chain",
        scene="struck",
        t_end=5.0,
        quantity="x of all masses, m",
        measure=coordinates(*(f"mass_{i}.x" for i in range(1, COUNT + 1))),
        reference=_struck,
        origin="closed form, the sum over the modes; linear, nothing grows",
        work=conservative,
    ),
    Case(
        name="coil_spring_surge",
        hard="Section 8.4.1, surge waves in six masses.",
        see="As for the chain.",
        model="coil_spring",
        scene="surge",
        t_end=4.0,
        quantity="x of all masses, m",
        measure=coordinates(*(f"mass_{i}.x" for i in range(1, 7))),
        reference=_surge,
        origin="closed form; linear, nothing grows",
        work=conservative,
    ),
    Case(
        name="coil_spring_first_ten",
        hard=(
            "Section 8.4.2, k = 50 N/m: a contact of 1e6 N/m beside springs of 50 N/m;"
            " the first ten contacts on and off."
        ),
        see="The events are right to 1e-10 s at the tightest tolerance.",
        model="coil_spring",
        scene="impact",
        t_end=2.668,
        quantity="times of the events, s",
        measure=_event_times,
        reference=_first_ten,
        origin=GIVEN,
        sampled=False,
        work=conservative,
    ),
    Case(
        name="coil_spring_impact",
        hard="The same to the end: 59 events.",
        see=("The last within 1e-6 s at the tightest tolerance; none is missed, none is added."),
        model="coil_spring",
        scene="impact",
        t_end=13.0,
        quantity="times of the events, s",
        measure=_event_times,
        reference=_all,
        origin=GIVEN,
        sampled=False,
        tolerances=(1e-8, 1e-10, 1e-12),
        work=conservative,
    ),
    Case(
        name="coil_spring_damped",
        hard="The same with a damper in the contact.",
        see="As without the damper.",
        model="coil_spring",
        scene="impact_damped",
        t_end=13.0,
        quantity="times of the events, s",
        measure=_event_times,
        reference=_damped,
        origin=GIVEN,
        sampled=False,
        tolerances=(1e-8, 1e-10, 1e-12),
    ),
)
