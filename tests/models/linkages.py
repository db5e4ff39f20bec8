"""What a run of a four-bar linkage is held against: the closed form, and its balance of energy."""

from math import pi

import numpy as np

from models.studies.linkage import FourBar
from models.studies.paths import path
from runtime import Machine, Result

BODIES = ("crank", "coupler", "rocker")
LIMIT = 1e-10


def residuals(run: Result) -> tuple[float, float]:
    """Largest |Φ| and |Φ_q q̇ - ν| of a run."""
    data = run.data
    return float(data["constraint_residual"].max()), float(data["velocity_residual"].max())


def check_motion(run: Result, exact: FourBar, speed: float) -> None:
    """Positions, velocities and accelerations of a run at constant speed, from φ1 = 0."""
    phi = speed * run.t
    assert max(residuals(run)) < LIMIT
    for body, rider in zip(BODIES, exact.riders, strict=True):
        ours, place = path(run, body), exact.point(rider.bar, rider.centre, phi)
        turn, size = exact.angle(rider.bar, phi), np.abs(place.at).max()
        assert np.abs(ours.at - place.at).max() < LIMIT * size
        for found, value, power in (
            (ours.velocity, place.first, 1),
            (ours.acceleration, place.second, 2),
            (run.v(f"{body}.phi"), turn.first, 1),
            (run.a(f"{body}.phi"), turn.second, 2),
        ):
            wanted = speed**power * value
            assert np.abs(found - wanted).max() <= LIMIT * np.abs(wanted).max()
        # The x' axis of a body may run the other way along its bar.
        half_turns = (run.q(f"{body}.phi") - turn.at) / pi
        assert np.abs(half_turns - np.round(half_turns[0])).max() < LIMIT


def check_power(run: Result, exact: FourBar, speed: float) -> None:
    """The driver and the forces without potential pay for the change of energy, and no more."""
    phi = speed * run.t
    rate = exact.torque(phi, speed) * speed
    driver = run.power("crank_drive")
    forces = sum(run.power(row.name) for row in run.description.powers if "cut" in row.name)
    scale = np.abs(driver).max()
    assert np.abs(driver + forces - rate).max() < LIMIT * scale
    torque = run.reaction("crank_drive", "torque")
    assert np.abs(torque * speed - driver).max() < LIMIT * scale


def check_even(run: Result, exact: FourBar, torque: float) -> None:
    """Under a constant torque: energy, speed over angle, and constraints."""
    phi = run.q("crank.phi")
    assert max(residuals(run)) < LIMIT
    gained = run.energy() - run.energy()[0] - torque * (phi - phi[0])
    assert np.abs(gained).max() < 1e-8 * np.ptp(run.energy("kinetic"))
    speed = run.v("crank.phi")
    assert np.abs(speed - exact.speed(phi, torque, speed[0])).max() < 1e-8 * speed.max()


def check_slopes(exact: FourBar) -> None:
    """The closed form against itself: its derivatives are those of its values.

    The angles of two points a step apart differ by the mean of their rates, up to the step cubed.
    """
    phi = np.linspace(0.0, 2 * pi, 100_001)
    step = phi[1]
    for bar in (1, 2):
        for value, rate in zip(exact.angle(bar, phi), exact.angle(bar, phi)[1:], strict=False):
            difference = np.diff(value) - step * 0.5 * (rate[1:] + rate[:-1])
            assert np.abs(difference).max() < 1e3 * step**3
    for value, rate in (exact.inertia(phi), exact.potential(phi)):
        difference = np.diff(value) - step * 0.5 * (rate[1:] + rate[:-1])
        assert np.abs(difference).max() < 1e3 * step**3 * max(1e-9, np.abs(value).max())


def loop_gap(exact: FourBar, phi: np.ndarray) -> float:
    """Distance of C on the coupler from C on the rocker, m, over that of the longest bar."""
    on_coupler, on_rocker = exact.point(1, exact.b, phi).at, exact.point(2, exact.c, phi).at
    return float(np.abs(on_coupler - on_rocker).max() / max(exact.b, exact.c))


def gauss(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Instants and weights of Gauss's rule, twelve in every piece between the edges."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (nodes + 1)).ravel(), (half * weights).ravel()


def energy_gap(
    machine: Machine, edges: np.ndarray, parameters: dict[str, float]
) -> tuple[float, dict[str, float]]:
    """What the energy gained between the first and last edge exceeds the work by, J; the works."""
    instants, weights = gauss(edges)
    run = machine.simulate(
        edges[-1],
        np.concatenate([edges[:1], instants, edges[-1:]]),
        rtol=1e-12,
        parameters=parameters,
    )
    gained = float(run.energy()[-1] - run.energy()[0])
    names = [row.name for row in run.description.powers if row.name != "gravity"]
    works = {name: float(weights @ run.power(name)[1:-1]) for name in names}
    return gained - sum(works.values()), works
