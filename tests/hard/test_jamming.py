"""Friction that would jam in sliding to one side, and holds all the same: a ladder that is steep.

The foot of a ladder stands on a floor that rubs, its top runs along a smooth wall. Beyond some
coefficient of friction the foot cannot slide outwards at all (P. Painlevé, Comptes Rendus 121,
1895): friction raises the force that presses by more than it needs. At rest the forces are those of
statics.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from codegen import Model, t
from codegen.errors import AnalysisError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import METHODS
from runtime.machine_facade import Machine

G = 9.81
ROD, FOOT, TOP = 1.0, 0.1, 5.0  # kg, the rod of 1 m
WEIGHT = (ROD + FOOT + TOP) * G
BLOCKS = 12
STEEP = np.radians(100.0)


def ladder(folder: Path, blocks: int = 0, creep: float | None = None) -> Machine:
    """The ladder, the pull on its foot growing from F at W a second, and blocks of no concern."""
    m = Model(f"ladder_with_{blocks}", gravity=(0, -G))
    mu = m.parameter("mu", 0.5, sign="nonnegative")
    pull, growth = m.parameter("F", 0.0, unit="N"), m.parameter("W", 0.0, unit="N/s")
    rod = m.body("rod", mass=ROD, inertia=ROD / 12)
    foot, top = m.body("foot", mass=FOOT, inertia=0.01), m.body("top", mass=TOP, inertia=0.01)
    effects, start = ["gravity", "rub", "pull"], {rod.phi: STEEP, rod.omega: 0.0}
    for k in range(blocks):
        p = m.particle(f"p{k}", mass=1.0)
        m.dry_friction(f"r{k}", slip=p.vx, normal=10.0, coefficient=0.2)
        m.force(f"push{k}", p, t + 0.3 * k, 0)
        effects += [f"r{k}", f"push{k}"]
        start |= {p.x: 0, p.vx: 0, p.y: k, p.vy: 0}
    floor = m.translational("floor", m.ground, foot, axis=(1, 0))
    m.translational("wall", m.ground, top, axis=(0, 1))
    m.revolute("low", rod.at(-0.5, 0), foot)
    m.revolute("high", rod.at(0.5, 0), top)
    m.friction("rub", floor, mu, creep=creep)
    m.force("pull", foot, pull + growth * t, 0)
    m.scene("s", effects, start=start, guess=drawn(m, STEEP))
    return load(m, "s", folder=folder)


def drawn(m: Model, phi: float) -> dict[object, float]:
    rod, foot, top = (m.bodies[name] for name in ("rod", "foot", "top"))
    return {rod.x: -0.5 * np.cos(phi), rod.y: 0.5 * np.sin(phi), foot.x: -np.cos(phi),
            top.y: np.sin(phi)}  # fmt: skip


def leaning(degrees: float, omega: float = 0.0) -> dict[str, dict[str, float]]:
    """Where a run starts, and where the search for the rest of it begins."""
    phi = np.radians(degrees)
    near = {"rod.x": -0.5 * np.cos(phi), "rod.y": 0.5 * np.sin(phi), "foot.x": -np.cos(phi),
            "top.y": np.sin(phi)}  # fmt: skip
    return {"start": {"rod.phi": phi, "rod.omega": omega}, "guess": near}


def thrust(phi: float) -> float:
    """What keeps the foot at rest without a pull, by the moment about it."""
    return float((ROD / 2 + TOP) * G / np.tan(phi))


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return ladder(tmp_path_factory.mktemp("ladder"))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("correction", ["step", "baumgarte"])
def test_ladder_stands_by_every_method(machine: Machine, method: str, correction: str) -> None:
    run = machine.simulate(
        2.0, [0.0, 1.0, 2.0], **leaning(100.0), parameters={"mu": 1.0}, method=method,
        correction=correction, progress=False,
    )  # fmt: skip
    assert run.outcome is Outcome.OK
    assert np.ptp(run.samples.q, axis=0).max() == 0.0
    assert np.abs(run.samples.v).max() == 0.0
    np.testing.assert_allclose(run.reaction("rub", "force"), thrust(STEEP), rtol=1e-12)


@pytest.mark.parametrize("mu", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("degrees", [60.0, 91.0, 95.0, 100.0, 110.0, 120.0, 135.0])
def test_ladder_stands_wherever_statics_lets_it(
    machine: Machine, degrees: float, mu: float
) -> None:
    phi = np.radians(degrees)
    run = machine.simulate(
        2.0, [0.0, 2.0], **leaning(degrees), parameters={"mu": mu}, progress=False
    )
    if abs(thrust(phi)) > mu * WEIGHT:
        assert run.events or abs(run.v("rod.phi")).max() > 0.1
        return
    assert run.outcome is Outcome.OK
    assert np.ptp(run.samples.q, axis=0).max() == 0.0
    assert np.abs(run.samples.a).max() == 0.0
    for element, part, due in (
        ("rub", "force", thrust(phi)),
        ("rub", "normal", WEIGHT),
        ("rub", "limit", mu * WEIGHT),
        ("floor", "fy", WEIGHT),
        ("floor", "torque", 0.0),
        ("high", "fx", np.cos(phi) * thrust(phi) + np.sin(phi) * TOP * G),
        ("high", "fy", np.cos(phi) * TOP * G - np.sin(phi) * thrust(phi)),
    ):
        np.testing.assert_allclose(
            run.reaction(element, part), due, rtol=1e-12, atol=1e-12, err_msg=f"{element}.{part}"
        )
    share = 0.5 - 0.5 * thrust(phi) / (mu * WEIGHT)
    np.testing.assert_allclose(run.share("rub: foot_vx > 0"), share, rtol=1e-12)


def accelerations(phi: float, omega: float, friction: float) -> tuple[float, float]:
    """φ̈ and the force on the floor, for the force `friction` times it along the floor."""
    s, c = np.sin(phi), np.cos(phi)
    raised = ROD / 2 + TOP
    inertia = ROD / 3 + FOOT * s**2 + TOP * c**2
    bias = -raised * G * c - (FOOT - TOP) * s * c * omega**2
    fixed = WEIGHT - raised * s * omega**2
    phi_dd = (bias + friction * s * fixed) / (inertia - friction * s * raised * c)
    return phi_dd, fixed + raised * c * phi_dd


@pytest.mark.parametrize(("degrees", "omega"), [(110.0, 0.0), (120.0, 0.5), (100.0, -1.0)])
def test_ladder_slides_by_the_equation_of_its_angle(
    machine: Machine, degrees: float, omega: float
) -> None:
    mu, way, phi = 0.3, -1.0 if omega >= 0.0 else 1.0, np.radians(degrees)
    t_end = 0.35 if omega >= 0.0 else 0.02
    run = machine.simulate(
        t_end, [0.0, 0.4 * t_end, t_end], **leaning(degrees, omega), parameters={"mu": mu},
        rtol=1e-11, progress=False,
    )  # fmt: skip
    due = solve_ivp(
        lambda _, y: (y[1], accelerations(*y, way * mu)[0]), (0.0, t_end), (phi, omega),
        method="DOP853", rtol=1e-12, atol=1e-13, t_eval=run.t,
    )  # fmt: skip
    normal = np.array([accelerations(*y, way * mu)[1] for y in due.y.T])
    assert run.outcome is Outcome.OK
    moving = np.abs(due.y[1]) > 0.0
    assert (normal > 0.0).all()
    assert moving.any()
    np.testing.assert_allclose(run.q("rod.phi"), due.y[0], rtol=0, atol=1e-9)
    forces = run.reaction("rub", "force")
    np.testing.assert_allclose(forces[moving], (way * mu * normal)[moving], rtol=1e-7)


@pytest.mark.parametrize(("mu", "growth"), [(0.3, 10.0), (0.3, -10.0), (1.0, -10.0)])
def test_pulled_ladder_lets_go_at_the_limit(machine: Machine, mu: float, growth: float) -> None:
    due = (mu * WEIGHT * np.sign(growth) + thrust(STEEP)) / growth
    run = machine.simulate(
        due + 0.05, **leaning(100.0), parameters={"mu": mu, "W": growth}, progress=False
    )
    assert run.outcome is Outcome.OK
    assert run.events[0].time == pytest.approx(due, rel=1e-10)
    assert run.events[0].what == ("began" if growth > 0.0 else "ceased")
    assert np.sign(run.v("foot.x")[-1]) == np.sign(growth)


@pytest.mark.parametrize("pull", [-1.5, -0.9, -0.5, 0.5, 0.9, 0.99, 1.2, 3.0])
def test_pulled_ladder_stands_or_slides_at_once(machine: Machine, pull: float) -> None:
    """What jams in sliding to a side cannot be driven there from rest: friction always bears it."""
    rests = abs(thrust(STEEP) - pull * WEIGHT) <= WEIGHT
    run = machine.simulate(
        0.02, **leaning(100.0), parameters={"mu": 1.0, "F": pull * WEIGHT}, progress=False
    )
    assert run.outcome is Outcome.OK
    assert rests == (np.ptp(run.q("foot.x")) == 0.0)
    assert rests or np.sign(run.v("foot.x")[-1]) == np.sign(pull)
    if rests:
        due = thrust(STEEP) - pull * WEIGHT
        np.testing.assert_allclose(run.reaction("rub", "force"), due, rtol=1e-12)


@pytest.mark.parametrize(("degrees", "omega"), [(95.0, 0.5), (100.0, 0.5), (110.0, 3.0)])
def test_sliding_that_jams_is_named(machine: Machine, degrees: float, omega: float) -> None:
    """A foot that slides outwards neither sticks, since it moves, nor finds a force."""
    run = machine.simulate(1.0, **leaning(degrees, omega), parameters={"mu": 1.0}, progress=False)
    assert run.outcome is Outcome.INCONSISTENT
    assert "condition foot_vx > 0 of rub" in run.message
    assert "jams" in run.message
    assert run.t[-1] == 0.0


def test_foot_that_slides_in_comes_to_rest(machine: Machine) -> None:
    run = machine.simulate(
        1.0, **leaning(110.0, -0.5), parameters={"mu": 1.0}, rtol=1e-10, progress=False
    )
    assert run.outcome is Outcome.OK
    assert [e.what for e in run.events] == ["holds"]
    resting = run.t > run.events[0].time
    phi = run.q("rod.phi")[resting]
    assert np.ptp(phi) < 1e-15
    np.testing.assert_allclose(run.reaction("rub", "force")[resting], thrust(phi[0]), rtol=1e-12)


def test_a_jam_is_explained_with_its_numbers(machine: Machine) -> None:
    begin, values = leaning(100.0, -1.0), {"mu": 2.5, "F": 40.0}
    run = machine.simulate(1.0, **begin, parameters=values, progress=False)
    assert run.outcome is Outcome.INCONSISTENT
    s, c = np.sin(STEEP), np.cos(STEEP)
    inertia = ROD / 3 + FOOT * s**2 + TOP * c**2
    raised = -2.5 * (ROD / 2 + TOP) * c * s / inertia
    assert f"Friction rub in joint floor jams at a slip of {-s:.3g} m/s" in run.message
    assert f"(1 N of friction its limit by {raised:.3g} N)" in run.message
    assert "drive the motion back" not in run.message
    assert "give the friction creep=" not in run.message
    rest = machine.simulate(1.0, **leaning(100.0), parameters=values, progress=False)
    assert rest.outcome is Outcome.OK


def test_modes_of_a_state_from_which_no_run_starts_are_refused(machine: Machine) -> None:
    values = {"mu": 1.0}
    state = machine.assemble(**leaning(100.0, 0.5), parameters=values)
    with pytest.raises(AnalysisError, match="no run starts from this state"):
        machine.initial_modes(0.0, state.q, state.v, values)


def test_friction_with_a_creep_speed_jams_and_is_no_dependent_constraint(tmp_path: Path) -> None:
    run = ladder(tmp_path, creep=1e-3).simulate(
        1.0, **leaning(100.0, -1.0), parameters={"mu": 2.5, "F": 40.0}, progress=False
    )
    assert run.outcome is Outcome.NOT_FINITE
    assert "Friction rub in joint floor jams" in run.message
    assert run.t[-1] == 0.0


@pytest.fixture(scope="module")
def crowded(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return ladder(tmp_path_factory.mktemp("crowded"), BLOCKS)


def test_ladder_stands_among_many_blocks(crowded: Machine) -> None:
    run = crowded.simulate(
        1.0, [0.0, 1.0], **leaning(100.0), parameters={"mu": 1.0}, rtol=1e-10, progress=False
    )
    assert run.outcome is Outcome.OK
    assert np.ptp(run.q("rod.phi")) == 0.0
    np.testing.assert_allclose(run.reaction("rub", "force"), thrust(STEEP), rtol=1e-12)
    for k in range(BLOCKS):
        slid = 1.0 - min(1.0, max(0.0, 2.0 - 0.3 * k))
        start = max(0.3 * k - 2.0, 0.0)
        moved = 0.5 * start * slid**2 + slid**3 / 6.0
        assert run.q(f"p{k}.x")[-1] == pytest.approx(moved, rel=1e-8, abs=1e-14)


def test_jam_among_many_blocks_is_named(crowded: Machine) -> None:
    run = crowded.simulate(1.0, **leaning(100.0, 0.5), parameters={"mu": 1.0}, progress=False)
    assert run.outcome is Outcome.INCONSISTENT
    assert "of rub" in run.message
