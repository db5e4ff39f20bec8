"""Projects 5.1 and 8.1: the film follower driven, and on its own.

The book prints no results. The exact values are those of the closed form in
`models.studies.linkage`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi, radians

import numpy as np

from models.studies.linkage import FourBar, Rider
from models.studies.linkage_rows import summit, turns_row
from models.studies.paths import Path, extreme, path
from models.studies.rows import Row
from runtime import Result, load

SPEED = 2 * pi
INERTIAS = {"as printed": 9.2e-8, "of a 105 mm rod": 9.2e-6}
TORQUE, TURNS = 1e-6, 10
HOOK = 0.105 * np.exp(1j * radians(2.73))  # from B, with x' from B to C
RUN_OF_MOTOR = 20.0


def linkage(inertia: float = 9.2e-8) -> FourBar:
    """The machine in closed form with this J3, kg m²."""
    crank = Rider(0, 0.0075, 0.0012, 2.25e-8)
    coupler = Rider(1, 0.05, 0.01, inertia)
    rocker = Rider(2, 0.015, 0.0025, 4.5e-8)
    return FourBar(0, -0.03 + 0.045j, 0.015, 0.05, 0.03, -1, (crank, coupler, rocker))


def hook(run: Result) -> Path:
    """The path of P: the hook in the frame of the model, whose origin is C."""
    return path(run, "coupler", HOOK - 0.05)


@dataclass(frozen=True)
class Study:
    """All runs of the project.

    Attributes
    ----------
    turn
        One turn of the crank at 2π rad/s, kinematics.
    driven
        Name of J3 → the same turn with torques.
    even, motor
        From rest: ten turns under a constant torque; 20 s with the motor.
    """

    turn: Result
    driven: Mapping[str, Result]
    even: Result
    motor: Result


@cache
def study() -> Study:
    """Run everything once."""
    instants = np.linspace(0.0, 1.0, 721)
    turn = load("film_follower", "kinematics").kinematics(instants)
    machine = load("film_follower", "inverse_dynamics")
    driven = {
        name: machine.inverse_dynamics(instants, parameters={"J3": inertia})
        for name, inertia in INERTIAS.items()
    }
    end = linkage().time(2 * pi * TURNS, TORQUE, 0.0)
    even = load("film_follower", "constant_torque").simulate(
        end, np.linspace(0.0, end, 12001), rtol=1e-11
    )
    motor = load("film_follower", "motor").simulate(
        RUN_OF_MOTOR, np.linspace(0.0, RUN_OF_MOTOR, 12001), rtol=1e-11
    )
    return Study(turn, driven, even, motor)


def table() -> list[Row]:
    """Where the hook goes, and what it takes."""
    runs, exact = study(), linkage()
    ours = hook(runs.turn)
    start = complex(exact.point(1, HOOK, 0.0).at)
    place = "project 5.1"
    rows = [
        Row(place, "hook at φ1 = 0: x, mm", 1e3 * float(ours.at[0].real), 1e3 * start.real),
        Row(place, "hook at φ1 = 0: y, mm", 1e3 * float(ours.at[0].imag), 1e3 * start.imag),
    ]
    for word, sign, k in (
        ("highest", -1, int(np.argmax(ours.at.imag))),
        ("lowest", 1, int(np.argmin(ours.at.imag))),
    ):
        height = summit(exact, HOOK, SPEED * runs.turn.t[k], sign)
        rows.append(
            Row(place, f"hook, {word}: y, mm", 1e3 * extreme(runs.turn.t, ours, k), 1e3 * height)
        )
    place = "project 8.1"
    for name, run in runs.driven.items():
        k = 90
        torque = linkage(INERTIAS[name]).torque(SPEED * run.t[k], SPEED)
        found = run.reaction("crank_drive", "torque")[k]
        quantity = f"J3 {name}: torque at φ1 = 45°, µN m"
        rows.append(Row(place, quantity, 1e6 * float(found), 1e6 * float(torque)))
    return [*rows, turns_row(place, runs.even, linkage(), TORQUE, TURNS)]
