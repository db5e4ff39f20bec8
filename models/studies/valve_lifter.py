"""Section 8.5 of the book: does the follower stay on the cam?

The exact values come from the valve train's one freedom, written out by hand. With the pushrod's
lift s = e (1 - cos ωt), the pins run along the rocker's line, so that the valve moves by -s and the
rocker's angle is θ = -atan(s/a); then

    F = (m₃ + m₅) s̈ + J₄ θ' (θ' s̈ + θ'' ṡ²) + k (ℓ0 - ℓ + s).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from models.studies.rows import Row
from runtime import Result, load

RPM = 2 * pi / 60
STIFFNESSES = (10.0, 25.0, 40.0)
SPEEDS = (1500.0, 3000.0, 4500.0)
ECCENTRICITIES = (0.25, 0.35, 0.45)
NOMINAL = (25.0, 3000.0)
MASSES, ROCKER, ARM, LIFT, PRELOAD = 0.12 + 0.06, 1.8e-4, 0.06, 0.0025, 0.03
SEPARATES = {(10.0, 3000.0), (25.0, 4500.0)}
"""What the book finds unacceptable."""

LOWEST = "the force is lowest then; it vanishes earlier"
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Study:
    """All runs of the section.

    Attributes
    ----------
    driven
        (k in N/cm, rpm) → two turns of the cam with the follower held on it.
    free
        The same, with the follower free to leave.
    lifts
        Eccentricity in cm → a turn of the cam.
    """

    driven: Mapping[tuple[float, float], Result]
    free: Mapping[tuple[float, float], Result]
    lifts: Mapping[float, Result]


@cache
def study() -> Study:
    """Run everything once."""
    cases = dict.fromkeys([*((k, 3000.0) for k in STIFFNESSES), *((25.0, n) for n in SPEEDS)])
    held, loose = load("valve_lifter", "inverse_dynamics"), load("valve_lifter", "free_follower")
    driven, free = {}, {}
    for k, rpm in cases:
        parameters = {"k": 100.0 * k, "speed": rpm * RPM}
        instants = np.linspace(0.0, 120.0 / rpm, 1441)
        driven[k, rpm] = held.inverse_dynamics(instants, parameters=parameters)
        # The face begins pressed into the cam by what the force at rest asks of the contact.
        force = float(contact_force(k, rpm, np.zeros(1))[0])
        pressed = held.assemble(parameters=parameters).q[held.coordinates.index("pushrod.y")]
        pressed -= force / loose.parameter_values()[loose.parameters.index("K")]
        free[k, rpm] = loose.simulate(
            float(instants[-1]),
            instants,
            rtol=1e-9,
            parameters=parameters,
            start={"pushrod.y": pressed},
        )
    kinematics = load("valve_lifter", "kinematics")
    turn = np.linspace(0.0, 60.0 / NOMINAL[1], 361)
    lifts = {e: kinematics.kinematics(turn, parameters={"e": e / 100}) for e in ECCENTRICITIES}
    return Study(driven, free, lifts)


def contact_force(k: float, rpm: float, t: Array) -> Array:
    """F between cam and pushrod, N, by hand; k in N/cm."""
    omega = rpm * RPM
    s, rate = LIFT * (1 - np.cos(omega * t)), LIFT * omega * np.sin(omega * t)
    bend, u = LIFT * omega**2 * np.cos(omega * t), LIFT * (1 - np.cos(omega * t)) / ARM
    first, second = -1 / (ARM * (1 + u * u)), 2 * u / (ARM * (1 + u * u)) ** 2
    rocker = ROCKER * first * (first * bend + second * rate**2)
    return np.asarray(MASSES * bend + rocker + 100.0 * k * (PRELOAD + s))


def leaves_at(k: float, rpm: float) -> float:
    """The first instant at which the force by hand vanishes, s; infinite if it never does."""
    t = np.linspace(0.0, 60.0 / rpm, 20001)
    force = contact_force(k, rpm, t)
    below = np.flatnonzero(force < 0.0)
    if not len(below):
        return np.inf
    low, high = t[below[0] - 1], t[below[0]]
    return float(brentq(lambda at: contact_force(k, rpm, np.array([at]))[0], low, high))


def parts_at(run: Result) -> float:
    """The instant at which a free follower first leaves the cam, s; infinite if it never does."""
    return min((e.time for e in run.events if e.direction < 0), default=np.inf)


def table() -> list[Row]:
    """Every verdict of the section: the least force, and when a free follower leaves the cam.

    The free follower rests on a contact of stiffness K, so that it leaves a little before the
    rigid one would: the cam's surface springs back first.
    """
    runs = study()
    rows = []
    for (k, rpm), run in runs.driven.items():
        case = f"{k:g} N/cm, {rpm:g} rpm:"
        least = float(run.reaction("lift", "fy").min())
        exact = float(contact_force(k, rpm, run.t).min())
        verdict = "negative" if (k, rpm) in SEPARATES else "positive"
        rows.append(Row("8.5", f"{case} least force, N", least, exact, verdict))
        if exact < 0:
            parted, rigid = parts_at(runs.free[k, rpm]), leaves_at(k, rpm)
            book = (0.01, LOWEST) if k == 10.0 else (None, "")
            rows.append(Row("8.5", f"{case} leaves, s", parted, rigid, *book))
    for e, run in runs.lifts.items():
        lift = float(np.ptp(run.q("valve.y"))) * 100
        rows.append(Row("5.6", f"lift for e = {e:g} cm, cm", lift, 2 * e))
    return rows
