"""Section 5.5: a slider driven by a gear train, and one by a planetary gear, ours and exact.

The exact values are independent of this program. Points of the plane are complex numbers.

Train: the wheel's angle θ says where everything is. The pinion turns by -2θ; the pin is at
P = r e^{iθ}, and the rod's tip on the line y = e at C = P + l e^{iψ} with sin ψ = (e - r sin θ)/l.
The slider turns back where crank and rod are in line: the stroke is
√((l + r)² - e²) - √((l - r)² - e²).

Planetary: the planet turns against the carrier, both by φ, and its point is at
R e^{iφ} + R e^{-iφ} = 2 R cos φ, on the x axis: a stroke of 4 R.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt

import numpy as np
import numpy.typing as npt

from models.studies.linkage import Track
from models.studies.one_freedom import Mover, duration, force, inertia, potential
from models.studies.quick_return import extremes
from models.studies.rows import Row
from runtime import Result, load

FloatArray = npt.NDArray[np.float64]

PLACE = "5.5"
SPEED, TORQUE, TURNS, G = 4 * pi, 0.2, 10, 9.81
RATIO, CRANK, ROD, OFFSET, PLANET = -2.0, 0.06, 0.25, 0.03, 0.06
OFFSETS = (0.0, 0.03, 0.06)
DRIVERS = {"train": "pinion_drive", "planetary": "carrier_drive"}
TURN = {"train": 1.0, "planetary": 0.5}
"""How long one stroke and return takes at 4π rad/s, s."""


def still(theta: FloatArray) -> Track:
    """What does not move."""
    return Track(*(np.zeros_like(theta),) * 3)


def turning(theta: FloatArray, ratio: float) -> Track:
    """An angle that grows with θ."""
    return Track(ratio * theta, np.full_like(theta, ratio), np.zeros_like(theta))


def arm(length: float, angle: Track) -> Track:
    """A vector of constant length and its derivatives."""
    at = length * np.exp(1j * angle.at)
    return Track(at, 1j * angle.first * at, (1j * angle.second - angle.first**2) * at)


def plus(one: Track, other: Track) -> Track:
    """The sum of two paths."""
    return Track(*(a + b for a, b in zip(one, other, strict=True)))


def rod_angle(theta: FloatArray, offset: float = OFFSET) -> Track:
    """ψ of the rod: l sin ψ = e - r sin θ, differentiated twice."""
    psi = np.arcsin((offset - CRANK * np.sin(theta)) / ROD)
    first = -CRANK * np.cos(theta) / (ROD * np.cos(psi))
    second = (CRANK * np.sin(theta) / ROD + np.sin(psi) * first**2) / np.cos(psi)
    return Track(psi, first, second)


def train(theta: npt.ArrayLike, offset: float = OFFSET) -> list[Mover]:
    """Pinion, wheel, rod and slider over the angle of the wheel."""
    theta = np.asarray(theta, dtype=np.float64)
    wheel, rod = turning(theta, 1.0), rod_angle(theta, offset)
    pin = arm(CRANK, wheel)
    above = Track(np.full_like(theta, 0.15) * 1j, *still(theta)[1:])
    return [
        Mover(0.6, 0.6 * 0.05**2 / 2, above, turning(theta, RATIO)),
        Mover(2.5, 2.5 * 0.1**2 / 2, still(theta), wheel),
        Mover(0.3, 0.3 * ROD**2 / 12, plus(pin, arm(ROD / 2, rod)), rod),
        Mover(1.0, 1e-3, plus(pin, arm(ROD, rod)), still(theta)),
    ]


def planetary(phi: npt.ArrayLike) -> list[Mover]:
    """Carrier, planet and slider over the angle of the carrier."""
    phi = np.asarray(phi, dtype=np.float64)
    carrier, planet = turning(phi, 1.0), turning(phi, -1.0)
    centre = arm(PLANET, carrier)
    return [
        Mover(0.2, 0.2 * PLANET**2 / 12, arm(PLANET / 2, carrier), carrier),
        Mover(0.9, 0.9 * PLANET**2 / 2, centre, planet),
        Mover(1.0, 1e-3, plus(centre, arm(PLANET, planet)), still(phi)),
    ]


def torque(name: str, t: npt.ArrayLike) -> FloatArray:
    """What turns the pinion, or the carrier, at 4π rad/s, N m."""
    turned = SPEED * np.asarray(t, dtype=np.float64)
    ratio = 1 / RATIO if name == "train" else 1.0
    movers = (train if name == "train" else planetary)(ratio * turned)
    rate = np.full_like(turned, ratio * SPEED)
    return force(movers, G, rate, np.zeros_like(turned)) * ratio


def speed(theta: npt.ArrayLike) -> FloatArray:
    """|θ̇| of the wheel from rest at θ = 0 under the constant torque on the pinion, rad/s.

    The pinion turns to the left and the wheel to the right, θ < 0.
    """
    theta = np.asarray(theta, dtype=np.float64)
    start = potential(train(0.0), G)[0]
    kinetic = TORQUE * RATIO * theta - (potential(train(theta), G)[0] - start)
    return np.sqrt(2 * kinetic / inertia(train(theta))[0])


def time_of_turns(turns: float) -> float:
    """When the pinion has made so many turns from rest under the constant torque, s."""
    return duration(lambda turned: 1 / speed(-turned), 0.0, 2 * pi * turns / abs(RATIO))


def stroke(offset: float) -> float:
    """The train's, m: from crank and rod in line to crank over rod."""
    return sqrt((ROD + CRANK) ** 2 - offset**2) - sqrt((ROD - CRANK) ** 2 - offset**2)


@dataclass(frozen=True)
class Study:
    """All runs of the section.

    Attributes
    ----------
    moved
        "train" or "planetary" → one stroke and return at 4π rad/s, kinematics.
    offsets
        Height of the train's slider, m → the same.
    driven
        "train" or "planetary" → the same with torques.
    running
        Ten turns of the pinion from rest under a constant torque.
    """

    moved: Mapping[str, Result]
    offsets: Mapping[float, Result]
    driven: Mapping[str, Result]
    running: Result


@cache
def study() -> Study:
    """Run everything once."""
    instants = {name: np.linspace(0.0, end, 1441) for name, end in TURN.items()}
    machine = load("gear_slider", "train_kinematics")
    end = time_of_turns(TURNS)
    return Study(
        {n: load("gear_slider", f"{n}_kinematics").kinematics(t) for n, t in instants.items()},
        {e: machine.kinematics(instants["train"], parameters={"offset": e}) for e in OFFSETS},
        {
            n: load("gear_slider", f"{n}_inverse_dynamics").inverse_dynamics(t)
            for n, t in instants.items()
        },
        load("gear_slider", "train_running").simulate(end, np.linspace(0.0, end, 2001), rtol=1e-12),
    )


def table() -> list[Row]:
    """Strokes, the straight line, torques, and the time of ten turns."""
    runs = study()
    rows = []
    for offset, run in runs.offsets.items():
        left, right = extremes(run.q("slider.x"))
        what = f"train, {offset:g} m above the centre: stroke, m"
        rows.append(Row(PLACE, what, right - left, stroke(offset)))
    left, right = extremes(runs.moved["planetary"].q("slider.x"))
    off = float(np.abs(runs.moved["planetary"].q("slider.y")).max())
    rows += [
        Row(PLACE, "planetary: stroke, m", right - left, 4 * PLANET),
        Row(PLACE, "planetary: the slider leaves its line by, m", off, 0.0),
    ]
    for name, run in runs.driven.items():
        for k in (180, 900):
            ours = float(run.reaction(DRIVERS[name], "torque")[k])
            what = f"{name}: torque at t = {run.t[k]:g} s, N m"
            rows.append(Row(PLACE, what, ours, float(torque(name, run.t[k]))))
    running = runs.running
    missed = 2 * pi * TURNS - running.q("pinion.phi")[-1]
    ours = float(running.t[-1] + missed / running.v("pinion.phi")[-1])
    what = f"train: {TURNS} turns from rest under {TORQUE:g} N m, s"
    return [*rows, Row(PLACE, what, ours, time_of_turns(TURNS))]
