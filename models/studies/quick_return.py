"""Section 8.3 of the book: the shaper at rest, driven, and running.

The exact values are independent of this program. With the crank's angle given, everything else of
the machine follows from one closed-form triangle after the other; equilibrium and driving torque
are derivatives of that, and the time of a turn is the integral of 1/φ̇3 by the theorem of energy,
all taken with 20 digits and more.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import sqrt

import numpy as np

from models.studies.rows import Row
from runtime import Machine, Result, load

SLIDERS = (25.0, 50.0, 100.0)
FLYWHEELS = (1000.0, 2000.0, 4000.0)
LOOSE = "stopped early: 7.83 N m are left at the crank"
CUT_ENDS = "cut: slider_x >= -4.0"

# Table 8.3.2: quantity, unit, coordinate, exact, book.
RESTING = (
    ("x2, m", "rocker.x", 1.49965731182, 1.4998),
    ("y2, m", "rocker.y", 1.32326412597, 1.3232),
    ("φ2, rad", "rocker.phi", 0.722993257693, 0.72292),
    ("φ3, rad", "crank.phi", -0.869179106294, -0.86588),
    ("x4, m", "block.x", 0.968180644079, 0.97196),
    ("y4, m", "block.y", 0.854300981745, 0.85750),
    ("x5, m", "rod.x", 2.33258487570, 2.3329),
    ("y5, m", "rod.y", 3.32326412597, 3.3232),
    ("φ5, rad", "rod.phi", -0.792846021304, -0.79302),
    ("x6, m", "slider.x", 1.66585512774, 1.6663),
)
# m6 → smallest and largest torque that the inertia of the bodies asks for at 2π rad/s, N m.
TORQUES = {
    25.0: (-978540.891, 1156950.29),
    50.0: (-1254146.17, 1544243.94),
    100.0: (-1806478.71, 2319525.25),
}
# J3 → (exact, book) turns a second, over the first turn.
CYCLES = {1000.0: (2.21656644, 2.2), 2000.0: (1.83657380, 1.8), 4000.0: (1.51804718, 1.5)}


@dataclass(frozen=True)
class Study:
    """All runs of the section.

    Attributes
    ----------
    kinematics
        One turn at 2π rad/s from φ3 = 0.44.
    driven
        m6 → one turn at 2π rad/s from just after the cut, with all that acts.
    inertial
        The same, with the inertia of the bodies alone.
    running
        J3 → two seconds from the end of a cut at 5 rad/s.
    """

    kinematics: Result
    driven: Mapping[float, Result]
    inertial: Mapping[float, Result]
    running: Mapping[float, Result]


@cache
def study() -> Study:
    """Run everything once."""
    turn = np.linspace(0.0, 1.0, 3601)
    instants = np.linspace(0.0, 2.0, 4001)
    shaper = load("quick_return", "shaper")
    return Study(
        load("quick_return", "kinematics").kinematics(turn),
        _driven(load("quick_return", "inverse_dynamics"), turn),
        _driven(load("quick_return", "inverse_dynamics_of_inertia"), turn),
        {
            inertia: shaper.simulate(2.0, instants, rtol=1e-10, parameters={"J3": inertia})
            for inertia in FLYWHEELS
        },
    )


def _driven(machine: Machine, turn: np.ndarray) -> dict[float, Result]:
    return {mass: machine.inverse_dynamics(turn, parameters={"m6": mass}) for mass in SLIDERS}


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    return [*_equilibrium(), *_geometry(), *_torques(), *_running()]


def cycles_per_second(run: Result) -> float:
    """One over the time of the first turn, from the end of a cut to the end of the next."""
    return 1.0 / next(e.time for e in run.events if e.name == CUT_ENDS and e.direction < 0)


def extremes(values: np.ndarray) -> tuple[float, float]:
    """The smallest and the largest value of a smooth function of time.

    Each is an extreme of the quartic through five neighbouring samples: the largest sample alone
    misses a peak of the torque by tens of N m.

    Parameters
    ----------
    values
        Samples at equal distances of one period, its end included, shape (k,).
    """
    values, offsets = values[:-1], np.arange(-2, 3)
    found = []
    for k in (int(values.argmin()), int(values.argmax())):
        curve = np.polynomial.Polynomial.fit(offsets, values[(k + offsets) % len(values)], 4)
        places = curve.deriv().roots()
        found.append(float(curve(places[np.abs(places).argmin()].real)))
    return found[0], found[1]


def _equilibrium() -> list[Row]:
    rest = load("quick_return", "gravity_equilibrium").equilibrium()
    return [
        Row("table 8.3.2", what, rest[name], exact, book, LOOSE)
        for what, name, exact, book in RESTING
    ]


def _geometry() -> list[Row]:
    left, right = extremes(study().kinematics.q("slider.x"))
    place = "figure 8.3.3"
    return [
        Row(place, "stroke, left: x6, m", left, -sqrt(5.9**2 - 4**2)),
        Row(place, "stroke, right: x6, m", right, 3 - sqrt(1.9**2 - (4 - sqrt(7)) ** 2)),
    ]


def _torques() -> list[Row]:
    rows = []
    for mass, run in study().inertial.items():
        place = f"8.3.3, m6 = {mass:g}"
        ours = extremes(run.reaction("crank_drive", "torque"))
        for word, value, exact in zip(("min", "max"), ours, TORQUES[mass], strict=True):
            rows.append(Row(place, f"inertial T, {word}, N m", value, exact))
    return rows


def _running() -> list[Row]:
    runs = study().running
    rows = [Row("8.3.4", "work of a cut, N m", _work_of_a_cut(), 1.04e6, 10.4e5)]
    for inertia, (exact, book) in CYCLES.items():
        ours = cycles_per_second(runs[inertia])
        rows.append(Row(f"8.3.4, J3 = {inertia:g}", "cycles, 1/s", ours, exact, book))
    return rows


def _work_of_a_cut() -> float:
    """What the motor gives in a turn and the machine does not keep."""
    machine = load("quick_return", "shaper")
    period = 1.0 / cycles_per_second(study().running[2000.0])
    run = machine.simulate(period, [0.0, period], rtol=1e-12)
    turned = float(np.diff(run.q("crank.phi"))[0])
    return run.parameters["T3"] * turned - float(np.diff(run.energy())[0])
