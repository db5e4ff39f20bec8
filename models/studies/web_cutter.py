"""Projects 5.2 and 8.2: the web cutter driven, cutting, and on its motor.

The book prints no results. The exact values are those of the closed form in
`models.studies.linkage`; with the motor, of the equation of one degree of freedom that it gives.
The knives cut while the gap between the tips falls from the web's thickness to nothing, which at
any speed is between two fixed angles of the crank, and takes force times thickness as work.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from models.studies.linkage import FourBar, Rider, Track
from models.studies.paths import Path, path
from models.studies.rows import Row
from runtime import Machine, Result, load

SPEED = 2 * pi
FORCE, WEB, GAIN = 1000.0, 0.002, 20.0
TURNS = 4
NEAR = np.linspace(0.27, 0.30, 1201)  # instants around the first cut, s
UPPER = 0.04 - 0.24j  # in the frame of body 3, at C with x' from B to C
LOWER = 0.13j  # from the centroid of body 4
# In the frames at B, and at D with x' from D to C.
UPPER_FROM_B, LOWER_FROM_D = 0.28 + UPPER, 0.40 - (0.14 + 0.07j + LOWER)
CRANK = Rider(0, 0.02, 0.1, 1.5e-5)
COUPLER = Rider(1, 0.28, 1.0, 0.03)
ROCKER = Rider(2, 0.40 - (0.14 + 0.07j), 2.0, 0.04)
LINKAGE = FourBar(0, 0.26 - 0.04j, 0.04, 0.28, 0.40, 1, (CRANK, COUPLER, ROCKER), 9.81)


def tips(run: Result) -> tuple[Path, Path]:
    """The paths of the tips of the upper and the lower knife."""
    return path(run, "coupler", UPPER), path(run, "rocker", LOWER)


def gap(phi: npt.ArrayLike) -> Track:
    """Height of the upper tip over the lower one, m, in closed form."""
    upper = LINKAGE.point(1, UPPER_FROM_B, phi)
    lower = LINKAGE.point(2, LOWER_FROM_D, phi)
    return Track(*(above.imag - below.imag for above, below in zip(upper, lower, strict=True)))


@cache
def cut() -> tuple[float, float]:
    """Crank angles at which a cut begins and at which the tips meet, rad."""
    begins = brentq(lambda phi: gap(phi).at - WEB, 1.4, 2.0, xtol=1e-14)
    return begins, brentq(lambda phi: gap(phi).at, begins, 2.0, xtol=1e-14)


def cuts_of_motor() -> list[tuple[float, float]]:
    """When each cut begins and ends in the dynamic run, s.

    I ω dω/dφ + I' ω² / 2 + V' = gain (2π - ω) + F d(gap)/dφ, dt/dφ = 1/ω; the force jumps at known
    angles, so that every piece is smooth. What depends on φ alone is periodic, and its Fourier
    series, which ends below the last digit, spares the closed form in every step.
    """
    turn = np.linspace(0.0, 2 * pi, 256, endpoint=False)
    depends = np.array([*LINKAGE.inertia(turn), LINKAGE.potential(turn)[1], gap(turn).first])
    series = np.fft.rfft(depends)[:, :64] * np.where(np.arange(64) > 0, 2, 1) / len(turn)

    def rates(phi: float, state: np.ndarray, force: float) -> tuple[float, float]:
        omega = state[0]
        inertia, change, weight, closing = (series @ np.exp(1j * phi * np.arange(64))).real
        torque = GAIN * (SPEED - omega) - weight + force * closing
        return (torque - 0.5 * change * omega**2) / (inertia * omega), 1 / omega

    state, phi, found = np.array([SPEED, 0.0]), 0.0, []
    for lap in range(TURNS):
        times = []
        for edge, force in zip(cut(), (0.0, FORCE), strict=True):
            end = 2 * pi * lap + edge
            piece = solve_ivp(
                rates, (phi, end), state, "DOP853", args=(force,), rtol=3e-13, atol=1e-14
            )
            state, phi = piece.y[:, -1], end
            times.append(float(state[1]))
        found.append((times[0], times[1]))
    return found


@dataclass(frozen=True)
class Study:
    """All runs of the project.

    Attributes
    ----------
    turn
        One turn of the crank at 2π rad/s, kinematics.
    driven
        "cutting" or "idle" → the same turn with torques.
    running
        4 s with the motor, from 2π rad/s, closely sampled around the first cut.
    """

    turn: Result
    driven: Mapping[str, Result]
    running: Result


@cache
def study() -> Study:
    """Run everything once."""
    instants = np.linspace(0.0, 1.0, 3601)
    machine = load("web_cutter", "inverse_dynamics")
    running = load("web_cutter", "running")
    return Study(
        load("web_cutter", "kinematics").kinematics(instants),
        {
            name: machine.inverse_dynamics(instants, parameters={"cut_force": force})
            for name, force in (("cutting", FORCE), ("idle", 0.0))
        },
        running.simulate(4.0, np.union1d(np.linspace(0.0, 4.0, 8001), NEAR), rtol=1e-11),
    )


def cuts(run: Result) -> list[tuple[float, float]]:
    """When the gap falls below the web's thickness, and when the next time to nothing, s."""
    met = [e.time for e in run.events if e.name.endswith("< 0") and e.direction < 0]
    thin = [e.time for e in run.events if "web_thickness" in e.name and e.direction > 0]
    return [(begin, min(end for end in met if end > begin)) for begin in thin]


def work_of_cut(machine: Machine, begin: float, end: float) -> float:
    """What the web takes between two instants of the run with the motor, J; Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    half = 0.5 * (end - begin)
    instants = begin + half * (nodes + 1)
    run = machine.simulate(end, instants, rtol=1e-11)
    power = run.power("cut_above") + run.power("cut_below")
    return -half * float(weights @ power)


def table() -> list[Row]:
    """When it cuts, what a cut takes, and the torque."""
    runs = study()
    place = "project 8.2"
    rows = []
    for k in (750, 1000):
        angle = SPEED * runs.turn.t[k]
        for name, run in runs.driven.items():
            exact = float(LINKAGE.torque(angle, SPEED))
            if name == "cutting" and 0 < gap(angle).at < WEB and gap(angle).first < 0:
                exact -= FORCE * float(gap(angle).first)
            ours = float(run.reaction("crank_drive", "torque")[k])
            quantity = f"{name}: torque at φ1 = {np.degrees(angle):.0f}°, N m"
            rows.append(Row(place, quantity, ours, exact))
    return [*rows, *_with_the_motor(place, runs.running)]


def _with_the_motor(place: str, run: Result) -> list[Row]:
    found, exact = cuts(run), cuts_of_motor()
    starts = {"begins": 0, "ends": 1}
    rows = [
        Row(place, f"motor: cut {n + 1} {word}, s", found[n][k], exact[n][k])
        for n in (0, TURNS - 1)
        for word, k in starts.items()
    ]
    crank = run.description.coordinates.index("crank.phi")
    at = [float(np.degrees(e.q[crank])) for e in run.events if e.time in found[0]]
    rows += [
        Row(place, f"cut {word} at φ1, degrees", at[k], float(np.degrees(cut()[k])))
        for word, k in starts.items()
    ]
    work = work_of_cut(load("web_cutter", "running"), *found[-1])
    return [*rows, Row(place, "work of a cut, J", work, FORCE * WEB)]
