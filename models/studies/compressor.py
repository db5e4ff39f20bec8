"""Section 8.2 of the book: the compressor at rest, driven, and running.

The exact values are independent of this program: closed forms, or a one-degree-of-freedom
equation of the machine integrated in extended precision.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import asin, pi, sqrt

import numpy as np

from models.studies.rows import Row
from runtime import Result, load

FLYWHEELS = (225.0, 450.0, 900.0)
ROD_LENGTHS = (3.5, 2.5, 2.2, 2.1, 1.9)
DRIVE_SPEEDS = {"2π": 2 * pi, "4π": 4 * pi}
PLOT = "read from a plot"
LOOSE = "stopped early: 4.67 N m are left at the crank"
EARLY = "stopped early, as in table 8.2.3"
UNITS = "the gas force was 1000 times too small there"
ROUNDED = "rounded"


@dataclass(frozen=True)
class Study:
    """All runs of the section.

    Attributes
    ----------
    driven
        (scene, speed) → one turn at constant speed.
    running
        J1 → one second from φ1 = π, φ̇1 = 30 rad/s.
    kinematics
        Rod length → one turn of the crank.
    """

    driven: Mapping[tuple[str, str], Result]
    running: Mapping[float, Result]
    kinematics: Mapping[float, Result]


@cache
def study() -> Study:
    """Run everything once."""
    driven = {}
    for scene in ("inverse_dynamics", "inverse_dynamics_without_gas"):
        for name, speed in DRIVE_SPEEDS.items():
            instants = np.linspace(0.0, 2 * pi / speed, 721)
            driven[scene, name] = load("slider_crank", scene).inverse_dynamics(
                instants, parameters={"drive_speed": speed}
            )
    compressor = load("slider_crank", "compressor")
    running = {
        inertia: compressor.simulate(
            1.0, np.linspace(0.0, 1.0, 2001), rtol=1e-10, parameters={"J1": inertia}
        )
        for inertia in FLYWHEELS
    }
    linkage = load("slider_crank", "kinematics")
    kinematics = {
        length: linkage.kinematics(np.linspace(0.0, 1.0, 721), parameters={"rod_length": length})
        for length in ROD_LENGTHS
    }
    return Study(driven, running, kinematics)


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    return [*_equilibria(), *_driven(), *_running()]


def cycles_per_second(run: Result) -> float:
    """One over the time between the last two instants at which the slider begins to move right."""
    starts = [e.time for e in run.events if "slider_vx > 0" in e.name and e.direction > 0]
    return 1.0 / (starts[-1] - starts[-2])


def _equilibria() -> list[Row]:
    gravity = load("slider_crank", "gravity_equilibrium").equilibrium()
    printed = load("slider_crank", "gas_equilibrium_as_printed").equilibrium()
    gas = load("slider_crank", "gas_equilibrium").equilibrium(guess={"crank.phi": 4.0})
    place = "table 8.2.3"
    rows = [
        Row(place, "gravity: φ1, rad", gravity["crank.phi"], 3 * pi / 2, 4.726, LOOSE),
        Row(place, "gravity: x2, m", gravity["rod.x"], sqrt(3.5**2 - 4) / 2, 1.4635, LOOSE),
        Row(place, "gravity: y2, m", gravity["rod.y"], -1.0, -1.0),
        Row(place, "gravity: φ2, rad", gravity["rod.phi"], asin(4 / 7), 0.6082),
        Row(place, "gravity: x3, m", gravity["slider.x"], sqrt(3.5**2 - 4), 2.9, LOOSE),
    ]
    place = "table 8.2.4"
    rows += [
        Row(place, "gas / 1000: φ1, rad", printed["crank.phi"], 4.597068, 4.6004, EARLY),
        Row(place, "gas in N: φ1, rad", gas["crank.phi"], 3.527376, 4.6004, UNITS),
        Row(place, "gas in N: x3, m", gas["slider.x"], 1.565126, 2.6575, UNITS),
    ]
    machine = load("slider_crank", "gas_equilibrium")
    p = machine.parameter_values()
    q = machine.assemble().q.copy()
    slider = machine.coordinates.index("slider.x")
    stored, g = [], np.zeros(len(machine.description.switches))
    for x in (1.5, 5.5):
        q[slider] = x
        machine.kernels.switching(0.0, q, np.zeros_like(q), p, g)
        modes = (g > 0.0).astype(np.int64)
        stored.append(machine.kernels.potential(0.0, q, p, modes))
    work = stored[1] - stored[0]
    return [*rows, Row("8.2.4", "work in a cycle, N m", work, 260439.320, 260438.0, ROUNDED)]


def _driven() -> list[Row]:
    runs = study()
    start = {
        name: float(runs.kinematics[3.5].q(name)[0]) for name in ("rod.x", "rod.phi", "slider.x")
    }
    c = sqrt(0.5)
    angle = -asin(2 * c / 3.5)
    place = "table 5.2.6"
    x3 = 2 * c + sqrt(3.5**2 - 2.0)
    rows = [
        Row(place, "assembled: x2, m", start["rod.x"], (2 * c + x3) / 2, 3.015),
        Row(place, "assembled: φ2, rad", start["rod.phi"], angle, -0.41595),
        Row(place, "assembled: x3, m", start["slider.x"], x3, 4.6158),
    ]
    locked = float(runs.kinematics[1.9].t[-1])
    exact = (asin(1.9 / 2) - pi / 4) / (2 * pi)
    return [*rows, Row("5.2.4", "a rod of 1.9 m locks, s", locked, exact, 0.074, ROUNDED)]


def _running() -> list[Row]:
    runs = study().running
    stall = runs[225.0].events[-1]  # from then on the gas holds the machine
    names = runs[225.0].description.coordinates.names
    end = {name: float(stall.q[names.index(name)]) for name in ("crank.phi", "slider.x")}
    place = "8.2.4, J1 = 225"
    rows = [
        Row(place, "stalls at, s", stall.time, 0.114906810),
        Row(place, "stalls at φ1, rad", end["crank.phi"], 5.796224666),
        Row(place, "stalls at x3, m", end["slider.x"], 5.140072465),
    ]
    for inertia, exact, book in ((450.0, 3.8157, 3.7), (900.0, 4.3010, 4.2)):
        place = f"8.2.4, J1 = {inertia:g}"
        ours = cycles_per_second(runs[inertia])
        rows.append(Row(place, "cycles, 1/s", ours, exact, book, PLOT))
    return rows
