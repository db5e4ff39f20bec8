"""Projects 5.3 and 8.3: the rack and pinion driven, and running under a torque, ours and exact.

The exact values are independent of this program. Points of the plane are complex numbers. The
coupler's angle θ says where everything is: its end is C = D + L e^{iθ}. The rack's pitch line runs
through C in the direction e^{iψ}, and touches the pinion's circle, on its left, at the distance s
from C:

    C = (s - iR) e^{iψ},   hence   s² = |C|² - R²;

and rolling ties the pinion to the rack, φ = ψ + (s - h)/R with h from the rack's middle to C.
Derivatives follow by hand; with C' e^{-iψ} = (s' + R ψ') + i s ψ' the pinion's rate φ' is the real
part over R, and vanishes where coupler and pitch line are in line.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from models.studies.linkage import Track
from models.studies.one_freedom import Mover, force, inertia, period, potential
from models.studies.rows import Row
from runtime import Result, load

FloatArray = npt.NDArray[np.float64]

PLACE = "project 8.3"
SPEED, SWING, TOO_FAR, TORQUE, G = 2 * pi, 2.5, 3.5, 0.05, 9.81
R, HALF, L, D = 0.02, 0.1, 0.07, 0.11 - 0.02j
MODELS = {"": "coupler", "_massless_coupler": "massless coupler"}
DEAD = (4.0, -3.0)  # φ where the rack is level: 0 + (0.18 - 0.1)/R and 0 + (0.04 - 0.1)/R


class Motion(dict[str, Track]):
    """Tracks over θ: the angles "rack", "pinion", "coupler" and the distance "slide" s."""


def motion(theta: npt.ArrayLike) -> Motion:
    """Where everything is for angles θ of the coupler, and two derivatives in θ."""
    theta = np.asarray(theta, dtype=np.float64)
    arm = L * np.exp(1j * theta)
    end = D + arm
    s = np.sqrt(np.abs(end) ** 2 - R**2)
    u = end / (s - 1j * R)
    first, second = 1j * arm / u, -arm / u
    psi1 = first.imag / s
    s1 = first.real - R * psi1
    psi2 = (second.imag - psi1 * first.real - s1 * psi1) / s
    s2 = second.real + psi1 * first.imag - R * psi2
    rack, slide = Track(np.angle(u), psi1, psi2), Track(s, s1, s2)
    return Motion(
        rack=rack,
        slide=slide,
        pinion=Track(rack.at + (s - HALF) / R, psi1 + s1 / R, psi2 + s2 / R),
        coupler=Track(theta, np.ones_like(theta), np.zeros_like(theta)),
    )


def bar(base: complex, place: complex, angle: Track) -> Track:
    """A point at `place` in a frame that turns about `base`, with two derivatives."""
    arm = place * np.exp(1j * angle.at)
    turned = (1j * angle.second - angle.first**2) * arm
    return Track(base + arm, 1j * angle.first * arm, turned)


def movers(theta: npt.ArrayLike, coupler: bool = True) -> list[Mover]:
    """The bodies; without the coupler those of the second model."""
    moves = motion(theta)
    end = bar(D, L, moves["coupler"])
    back = bar(0, -HALF, moves["rack"])
    middle = Track(*(a + b for a, b in zip(end, back, strict=True)))
    still = Track(*(np.zeros_like(moves["pinion"].at),) * 3)
    found = [
        Mover(0.05, 0.05 * R**2 / 2, still, moves["pinion"]),
        Mover(0.1, 0.1 * (2 * HALF) ** 2 / 12, middle, moves["rack"]),
    ]
    if coupler:
        half = bar(D, L / 2, moves["coupler"])
        found.append(Mover(0.05, 0.05 * L**2 / 12, half, moves["coupler"]))
    return found


def coupler_at(phi: npt.ArrayLike) -> FloatArray:
    """θ in (0, π) for angles of the pinion between its dead centres: Newton from a table."""
    table = np.linspace(0.0, pi, 2001)
    wanted = np.asarray(phi, dtype=np.float64)
    theta = np.interp(-wanted, -motion(table)["pinion"].at, table)
    for _ in range(6):
        pinion = motion(theta)["pinion"]
        theta = theta - (pinion.at - wanted) / pinion.first
    return theta


@dataclass(frozen=True)
class Driven:
    """The driven machine: θ and its rates at the instants, and what turns the pinion, N m."""

    theta: FloatArray
    rate: FloatArray
    second: FloatArray
    torque: FloatArray


def driven(t: npt.ArrayLike, coupler: bool = True) -> Driven:
    """The machine whose pinion follows 2.5 sin 2πt."""
    t = np.asarray(t, dtype=np.float64)
    theta = coupler_at(SWING * np.sin(SPEED * t))
    pinion = motion(theta)["pinion"]
    rate = SPEED * SWING * np.cos(SPEED * t) / pinion.first
    second = (-(SPEED**2) * SWING * np.sin(SPEED * t) - pinion.second * rate**2) / pinion.first
    along = force(movers(theta, coupler), G, rate, second)
    return Driven(theta, rate, second, along / pinion.first)


def left_over(theta: npt.ArrayLike, coupler: bool = True) -> FloatArray:
    """Kinetic energy, J, where θ is reached from rest at φ = 0 under the constant torque."""
    given = TORQUE * motion(theta)["pinion"].at - potential(movers(theta, coupler), G)[0]
    start = -potential(movers(coupler_at(0.0), coupler), G)[0]
    return given - start


def turning_points(coupler: bool = True) -> tuple[float, float]:
    """θ where the run comes to rest: beyond the dead centre at θ = 0, and where it began, rad."""
    start = float(coupler_at(0.0))
    other = brentq(lambda theta: float(left_over(theta, coupler)), 1e-3 - pi, -0.2, xtol=1e-15)
    return other, start


def period_of_run(coupler: bool = True) -> float:
    """Time from rest at φ = 0 through the dead centre to rest, and back, s."""

    def slowness(theta: FloatArray) -> FloatArray:
        felt = inertia(movers(theta, coupler))[0]
        return np.sqrt(felt / (2 * left_over(theta, coupler)))

    return period(slowness, *turning_points(coupler))


@dataclass(frozen=True)
class Study:
    """All runs of the projects; each by what the scenes' names end in, "" or "_massless_coupler".

    Attributes
    ----------
    swung
        One swing of the pinion, kinematics.
    locked
        A swing too far, kinematics of the first model.
    driven
        One swing with torques.
    running
        One period under a constant torque.
    """

    swung: Mapping[str, Result]
    locked: Result
    driven: Mapping[str, Result]
    running: Mapping[str, Result]


@cache
def study() -> Study:
    """Run everything once."""
    instants = np.linspace(0.0, 1.0, 1441)
    running = {}
    for ending in MODELS:
        end = period_of_run(coupler=not ending)
        running[ending] = load("rack_and_pinion", f"running{ending}").simulate(
            end, np.linspace(0.0, end, 2001), rtol=1e-12
        )
    return Study(
        {e: load("rack_and_pinion", f"kinematics{e}").kinematics(instants) for e in MODELS},
        load("rack_and_pinion", "kinematics").kinematics(instants, parameters={"swing": TOO_FAR}),
        {
            e: load("rack_and_pinion", f"inverse_dynamics{e}").inverse_dynamics(instants)
            for e in MODELS
        },
        running,
    )


def table() -> list[Row]:
    """Positions, torques and times of both models."""
    runs = study()
    return [*_positions(runs), *_torques(runs), *_times(runs)]


def _positions(runs: Study) -> list[Row]:
    rows = []
    for word, k in (("2.5", 360), ("-2.5", 1080)):
        theta = driven(runs.swung[""].t[k]).theta
        tilt = float(motion(theta)["rack"].at)
        place = float(movers(theta)[1].centre.at.real)
        for ending, name in MODELS.items():
            run = runs.swung[ending]
            what = f"{name}: φ = {word} rad"
            rows += [
                Row(PLACE, f"{what}: φ of the rack, rad", float(run.q("rack.phi")[k]), tilt),
                Row(PLACE, f"{what}: x of the rack, m", float(run.q("rack.x")[k]), place),
            ]
    # Kinematics stops at the last position that is regular to it, 3e-4 rad of the coupler ahead of
    # the dead centre: 5e-7 rad of the pinion.
    ours = float(runs.locked.q("pinion.phi")[-1])
    return [*rows, Row(PLACE, f"a swing of {TOO_FAR:g} rad locks at φ, rad", ours, DEAD[1])]


def _torques(runs: Study) -> list[Row]:
    rows = []
    for ending, name in MODELS.items():
        for k in (0, 360, 1080):
            run = runs.driven[ending]
            ours = float(run.reaction("pinion_drive", "torque")[k])
            exact = float(driven(run.t[k], coupler=not ending).torque)
            rows.append(Row(PLACE, f"{name}: torque at t = {run.t[k]:g} s, N m", ours, exact))
    return rows


def _times(runs: Study) -> list[Row]:
    """The period; the run ends there, and Newton mends what it missed."""
    rows = []
    for ending, name in MODELS.items():
        run = runs.running[ending]
        ours = float(run.t[-1] - run.v("pinion.phi")[-1] / run.a("pinion.phi")[-1])
        exact = period_of_run(coupler=not ending)
        rows.append(Row(PLACE, f"{name}: period under {TORQUE:g} N m, s", ours, exact))
    return rows
