"""Projects 5.3 and 8.3: the rack and pinion against its closed form, in both models."""

from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from models.studies.drawing import draw
from models.studies.linkage import Track
from models.studies.one_freedom import inertia, potential
from models.studies.paths import path
from models.studies.rack_and_pinion import (
    DEAD,
    HALF,
    MODELS,
    SPEED,
    SWING,
    TORQUE,
    D,
    Driven,
    G,
    L,
    R,
    driven,
    left_over,
    motion,
    movers,
    period_of_run,
    study,
    table,
    turning_points,
)
from models.studies.rack_and_pinion_figures import figures
from runtime import Outcome, Result, load
from tests.models.linkages import residuals

LIMIT = 1e-10
both = pytest.mark.parametrize("ending", MODELS)


def near(found: np.ndarray, exact: np.ndarray, limit: float = LIMIT) -> bool:
    """Whether two functions of time are equal, relative to the largest value."""
    return bool(np.abs(found - exact).max() <= limit * np.abs(exact).max())


# -- the closed form -----------------------------------------------------------------------------


def slopes(track: Track, theta: np.ndarray) -> float:
    """How far the derivatives of a track are from differences of its values."""
    step = theta[1] - theta[0]
    worst = 0.0
    for value, rate in pairwise(track):
        difference = np.diff(value) - step * 0.5 * (rate[1:] + rate[:-1])
        worst = max(worst, float(np.abs(difference).max()))
    return worst


def test_the_closed_form_is_its_own_derivative() -> None:
    theta = np.linspace(-pi, pi, 100_001)
    step = theta[1] - theta[0]
    tracks = [*motion(theta).values()]
    for mover in movers(theta):
        tracks += [mover.centre, mover.angle]
    for track in tracks:
        assert slopes(track, theta) < 20 * step**3
    for value, rate in (inertia(movers(theta)), potential(movers(theta), G)):
        difference = np.diff(value) - step * 0.5 * (rate[1:] + rate[:-1])
        assert np.abs(difference).max() < 20 * step**3 * np.abs(value).max()


def test_the_closed_form_closes_and_rolls() -> None:
    """The pitch line touches the circle; as it rolls, both have the same velocity there."""
    theta = np.linspace(0.0, 2 * pi, 1001)
    moves, (_, rack, _) = motion(theta), movers(theta)
    along = np.exp(1j * moves["rack"].at)
    assert np.abs(rack.centre.at + HALF * along - D - L * np.exp(1j * theta)).max() < 1e-16
    contact = -1j * R * along
    assert np.abs(((contact - rack.centre.at) / along).imag).max() < 1e-16
    of_rack = rack.centre.first + 1j * moves["rack"].first * (contact - rack.centre.at)
    of_pinion = 1j * moves["pinion"].first * contact
    assert np.abs(of_rack - of_pinion).max() < 1e-15


def test_the_pinion_stops_where_the_rack_is_level() -> None:
    """D lies on the level of the pitch line: x of C is 0.11 ± 0.07 m, and φ = (x - 0.1)/0.02."""
    for theta, phi in zip((0.0, pi), DEAD, strict=True):
        moves = motion(theta)
        assert abs(moves["rack"].at) < 1e-15
        assert abs(moves["pinion"].at - phi) < 1e-14
        assert abs(moves["pinion"].first) < 1e-14


# -- kinematics ----------------------------------------------------------------------------------


@both
def test_both_models_move_as_the_closed_form(ending: str) -> None:
    run = study().swung[ending]
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < LIMIT
    check_motion(run, SWING * np.sin(SPEED * run.t))


def check_motion(run: Result, phi: np.ndarray) -> None:
    """Positions, velocities and accelerations of all bodies in the driven run."""
    exact = driven(run.t)
    assert np.abs(run.q("pinion.phi") - phi).max() < 1e-12
    # The second model lacks the last of them, the coupler.
    for name, mover in zip(run.description.bodies, movers(exact.theta), strict=False):
        ours = path(run, name)
        for place, found in ((mover.centre, ours), (mover.angle, angle(run, name))):
            for value, wanted in zip(found, over_time(place, exact), strict=True):
                # The pinion's centre stays where it is.
                assert np.abs(value - wanted).max() <= LIMIT * max(1e-2, np.abs(wanted).max())


def angle(run: Result, name: str) -> tuple[np.ndarray, ...]:
    """φ, φ̇ and φ̈ of a body."""
    return tuple(read(f"{name}.phi") for read in (run.q, run.v, run.a))


def over_time(place: Track, exact: Driven) -> tuple[np.ndarray, ...]:
    """A track over θ as a function of time, by the chain rule."""
    rate, second = exact.rate, exact.second
    return place.at, place.first * rate, place.second * rate**2 + place.first * second


def test_the_models_have_their_joints() -> None:
    first, second = (load("rack_and_pinion", f"kinematics{ending}") for ending in MODELS)
    assert (len(first.coordinates), len(second.coordinates)) == (9, 6)
    assert "link" in first.description.left_out.names
    assert {"C", "D"} <= set(second.description.left_out.names)
    rows = [row.name for row in first.description.constraints if row.element == "mesh"]
    assert len(rows) == 2


def test_a_swing_too_far_locks_at_the_dead_centre() -> None:
    """The run ends in the dead centre itself: where φ has its extreme, and at that instant."""
    run = study().locked
    assert run.outcome is Outcome.LOCKED
    assert abs(run.q("pinion.phi")[-1] - DEAD[1]) < 1e-12
    assert np.arcsin(-DEAD[1] / 3.5) + pi == pytest.approx(SPEED * run.t[-1], abs=1e-9)
    assert {"pinion_drive", "mesh"} <= set(run.message.replace(",", "").split())


# -- inverse dynamics ----------------------------------------------------------------------------


@both
def test_the_torque_pays_for_the_change_of_energy(ending: str) -> None:
    run = study().driven[ending]
    torque = run.reaction("pinion_drive", "torque")
    assert near(torque, driven(run.t, coupler=not ending).torque)
    assert near(torque * run.v("pinion.phi"), run.power("pinion_drive"))


@both
def test_the_mesh_bears_what_newton_asks_for(ending: str) -> None:
    """Tangential force from the pinion, R F = T - J φ̈; normal force from the rack about C."""
    run = study().driven[ending]
    exact = driven(run.t, coupler=not ending)
    pinion, rack, *_ = movers(exact.theta)
    spin = over_time(pinion.angle, exact)[2]
    tangential = (exact.torque - pinion.inertia * spin) / R
    assert near(run.reaction("mesh", "fx"), tangential)
    assert near(run.reaction("mesh", "torque"), R * tangential)
    # The tangential force runs through C, and the normal one passes it at the distance s.
    along = np.exp(1j * rack.angle.at)
    pull = rack.mass * (over_time(rack.centre, exact)[2] + 1j * G)
    moment = (np.conj(-HALF * along) * pull).imag
    moment = moment + rack.inertia * over_time(rack.angle, exact)[2]
    assert near(run.reaction("mesh", "fy"), -moment / motion(exact.theta)["slide"].at)


def test_the_link_bears_what_the_rack_pulls() -> None:
    """Model 2: what the mesh does not bear goes along the link, and across it nothing."""
    run = study().driven["_massless_coupler"]
    exact = driven(run.t, coupler=False)
    _, rack = movers(exact.theta, coupler=False)
    along = np.exp(1j * rack.angle.at)
    mesh = (run.reaction("mesh", "fx") + 1j * run.reaction("mesh", "fy")) * along
    at_end = rack.mass * (over_time(rack.centre, exact)[2] + 1j * G) - mesh
    in_link = at_end * np.exp(-1j * exact.theta)
    assert np.abs(in_link.imag).max() < LIMIT * np.abs(in_link).max()
    # The reaction is what the rack exerts on the ground, along the link from C to D.
    assert near(run.reaction("link", "fx"), in_link.real)


# -- dynamics ------------------------------------------------------------------------------------


@both
def test_it_returns_to_rest_after_a_period(ending: str) -> None:
    run = study().running[ending]
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < LIMIT
    end = {name: (run.q(name)[-1], run.v(name)[-1]) for name in run.description.coordinates.names}
    for name, (q, v) in end.items():
        assert abs(q - run.q(name)[0]) < 1e-9, name
        assert abs(v) < 1e-7, name
    assert run.v("pinion.phi").max() > 50


@both
def test_energy_and_work_balance(ending: str) -> None:
    run = study().running[ending]
    gained = run.energy() - run.energy()[0] - TORQUE * run.q("pinion.phi")
    assert np.abs(gained).max() < LIMIT * np.ptp(run.energy("kinetic"))
    end = path(run, "rack", HALF).at
    theta = np.angle(end - D)
    assert np.abs(np.abs(end - D) - L).max() < 1e-12
    wanted = left_over(theta, coupler=not ending)
    assert np.abs(run.energy("kinetic") - wanted).max() < LIMIT * wanted.max()


@both
def test_it_follows_the_equation_of_one_freedom(ending: str) -> None:
    """I θ̈ + I' θ̇² / 2 + V' = T φ', integrated by another program."""
    run, coupler = study().running[ending], not ending

    def rates(_: float, state: np.ndarray) -> tuple[float, float]:
        bodies = movers(state[0], coupler)
        (felt, slope), weight = inertia(bodies), potential(bodies, G)[1]
        given = TORQUE * motion(state[0])["pinion"].first
        return state[1], (given - weight - 0.5 * slope * state[1] ** 2) / felt

    start = (turning_points(coupler)[1], 0.0)
    exact = solve_ivp(rates, (0.0, run.t[-1]), start, "DOP853", run.t, rtol=1e-12, atol=1e-13)
    moves = motion(exact.y[0])
    assert np.abs(run.q("pinion.phi") - moves["pinion"].at).max() < 1e-9
    assert np.abs(run.q("rack.phi") - moves["rack"].at).max() < 1e-9
    assert near(run.v("pinion.phi"), moves["pinion"].first * exact.y[1], 1e-9)


def test_a_coupler_that_weighs_nothing_is_the_link() -> None:
    """The closed forms of the models differ by the coupler's mass and by nothing else."""
    assert period_of_run(coupler=False) < period_of_run()
    theta = np.linspace(0.0, 2 * pi, 9)
    with_it, without = movers(theta), movers(theta, coupler=False)
    arm = L**2 * (0.05 / 4 + 0.05 / 12)
    assert near(inertia(with_it)[0], inertia(without)[0] + arm, 1e-14)


# -- the study -----------------------------------------------------------------------------------


def test_ours_is_the_exact_value() -> None:
    rows = table()
    assert len(rows) == 17
    for row in rows:
        # Where it locks: see above.
        limit = 1e-6 if "locks" in row.quantity else 1e-9 * max(1e-2, abs(row.exact))
        assert abs(row.ours - row.exact) < limit, row


def test_the_figures_are_written(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path)
    assert [p.stem for p in written if p.suffix == ".png"] == [
        f"figure_p8_3_{k}" for k in (1, 2, 3)
    ]
    assert "coupler, 0.4762 s" in (tmp_path / "figure_p8_3_3.svg").read_text()
