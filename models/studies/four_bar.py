"""Section 5.3: Hoeken's four-bar linkage, its straight line, its lock-up, and a run.

The exact values are those of the closed form in `models.studies.linkage`.
"""

from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np

from models.studies.linkage import FourBar, Rider
from models.studies.linkage_rows import summit, turns_row
from models.studies.paths import Path, extreme, path
from models.studies.rows import Row
from runtime import Result, load

SPEED = 2 * pi
TORQUE, TURNS = 5.0, 10
SHORT = 1.4  # BC = CD in m, with which the crank does not turn all around


def linkage(bar: float = 2.5) -> FourBar:
    """The machine in closed form with this length of BC and CD, m; rods of 1 kg/m."""
    crank, coupler, rocker = (
        Rider(k, length / 2, length, length**3 / 12) for k, length in enumerate((1.0, 2 * bar, bar))
    )
    return FourBar(0, 2, 1.0, bar, bar, 1, (crank, coupler, rocker), 9.81)


def tracer(run: Result) -> Path:
    """The path of P, the end of the coupler."""
    return path(run, "coupler", run.parameters["BC"])


@dataclass(frozen=True)
class Study:
    """All runs of the section.

    Attributes
    ----------
    turn, locked
        One turn of the crank, kinematics: with Hoeken's proportions, and with short bars.
    driven
        The turn with torques.
    even
        Ten turns under gravity and a constant torque, from 2π rad/s.
    """

    turn: Result
    locked: Result
    driven: Result
    even: Result


@cache
def study() -> Study:
    """Run everything once."""
    instants = np.linspace(0.0, 1.0, 721)
    kinematics = load("four_bar", "kinematics")
    short = {"BC": SHORT, "CD": SHORT}
    end = linkage().time(2 * pi * TURNS, TORQUE, SPEED)
    return Study(
        kinematics.kinematics(instants),
        kinematics.kinematics(instants, parameters=short),
        load("four_bar", "inverse_dynamics").inverse_dynamics(instants),
        load("four_bar", "constant_torque").simulate(
            end, np.linspace(0.0, end, 2001), rtol=1e-11, parameters={"crank_torque": TORQUE}
        ),
    )


def table() -> list[Row]:
    """The straight line, the angles, the torque, the lock-up."""
    runs, exact = study(), linkage()
    place = "5.3"
    ours = tracer(runs.turn)
    rows = [
        Row(place, f"φ1 = {degrees}°: y of P, m", float(ours.at[2 * degrees].imag), 4.0)
        for degrees in (90, 180, 270)
    ]
    near = slice(180, 360)
    k = near.start + int(np.argmax(ours.at.imag[near]))
    above = 1e3 * (extreme(runs.turn.t, ours, k) - 4)
    height = summit(exact, 5.0, SPEED * runs.turn.t[k], -1)
    rows.append(Row(place, "P leaves the line by, mm", above, 1e3 * (height - 4)))
    k, eighth = 90, pi / 4
    angles = {"3": ("coupler", 1), "4": ("rocker", 2)}
    for number, (body, bar) in angles.items():
        found = float(runs.turn.q(f"{body}.phi")[k])
        value = float(exact.angle(bar, eighth).at)
        rows.append(Row(place, f"φ1 = 45°: φ{number}, rad", found, value))
    torque = float(runs.driven.reaction("crank_drive", "torque")[k])
    rows += [
        Row(place, "φ1 = 45°: driving torque, N m", torque, float(exact.torque(eighth, SPEED))),
        Row(
            place,
            f"BC = CD = {SHORT:g} m lock at φ1, degrees",
            float(np.degrees(runs.locked.q("crank.phi")[-1])),
            float(np.degrees(linkage(SHORT).locks())),
        ),
    ]
    return [*rows, turns_row(place, runs.even, exact, TORQUE, TURNS)]
