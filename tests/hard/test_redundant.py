"""A table on four parallel cranks, two more than it needs: borne, named, and told in the result.

What is right is known without the machine: it moves as a pendulum (closed form by elliptic
functions), and its multipliers of least norm are those of the pseudo-inverse of the whole system.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import sympy

from codegen import Model
from codegen.elements.forces.friction import JointFriction
from codegen.errors import AnalysisError, RedundancyError
from models.hard.parallel_linkage import parallel_linkage
from models.hard.suite.case import ROOT
from models.hard.suite.closed import pendulum
from runtime import Machine, Outcome, Result, load
from runtime.integrate.method import EXPLICIT
from runtime.mechanism.dense_equations import Equations
from tests.hard.start_values import start_and_guess

JOINTS = tuple(f"{pin}{k}" for k in range(4) for pin in "AB")
TIMES = np.linspace(0.0, 5.0, 101)
INERTIA = 4 * (1 / 12 + 1 / 4) + 5.0  # felt at the cranks' angle, kg m²
MOMENT = 9.81 * (4 * 0.5 + 5.0)  # of the weights about level cranks, N m


@pytest.fixture(scope="module")
def table() -> Machine:
    return load("hard/parallel_linkage", "fall", folder=ROOT)


@pytest.fixture(scope="module")
def plain(request: pytest.FixtureRequest) -> Machine:
    """The same bodies with the table on two of the cranks."""
    folder: Path = request.config.cache.mkdir("hard-machines")
    return load(parallel_linkage(4, carrying=2), "fall", folder=folder)


@pytest.fixture(scope="module")
def hung(request: pytest.FixtureRequest) -> Callable[[int], Machine]:
    """A bar hung below the table, which rests on so many of its cranks."""
    folder: Path = request.config.cache.mkdir("hard-machines")

    def made(carrying: int) -> Machine:
        model = parallel_linkage(4, carrying)
        with_bar(model)
        return load(model, "hung", folder=folder)

    return made


def with_bar(model: Model) -> None:
    """Hang a bar from the middle of the table."""
    bar = model.body("bar", mass=2.0, inertia=2 / 12)
    model.revolute("hook", model.bodies["table"].at(0, 0), bar.at(-0.5, 0))
    fall = model.scenes["fall"]
    at = dict(fall.guess)
    below = {bar.x: at["table.x"], bar.y: at["table.y"] - 0.5, bar.phi: -np.pi / 2}
    model.scene("hung", ["gravity"], start=dict(fall.start), guess={**at, **below})


def drawn(phi: float) -> dict[str, float]:
    """The table with its cranks at `phi`."""
    c, s = np.cos(phi), np.sin(phi)
    places = {"table.x": 1.5 + c, "table.y": s}
    for k in range(4):
        name = f"crank_{k}"
        places |= {f"{name}.x": k + c / 2, f"{name}.y": s / 2, f"{name}.phi": phi}
    return places


def turning(phi: float, omega: float) -> dict[str, float]:
    """Speeds of the table with its cranks at `phi`, turning at `omega`."""
    c, s = np.cos(phi), np.sin(phi)
    speeds = {"table.vx": -omega * s, "table.vy": omega * c}
    for k in range(4):
        name = f"crank_{k}"
        speeds |= {f"{name}.vx": -omega * s / 2, f"{name}.vy": omega * c / 2}
        speeds[f"{name}.omega"] = omega
    return speeds


def fallen(times: np.ndarray) -> np.ndarray:
    """The cranks' angle after a start from rest at 60 degrees, rad."""
    return pendulum(times, 5 * np.pi / 6, MOMENT / INERTIA) - np.pi / 2


def assert_least(machine: Machine, run: Result) -> None:
    """Accelerations and reactions are those of the pseudo-inverse of [M Φ_qᵀ; Φ_q 0]."""
    p = machine.parameter_values(run.parameters)
    equations = Equations(machine.mechanism, p)
    n, m = equations.n, equations.m
    modes = np.zeros(0, dtype=np.int64)
    for k, (t, q, v) in enumerate(zip(run.t, run.samples.q, run.samples.v, strict=True)):
        slopes = equations.jacobian(t, q)
        whole = np.block([[equations.mass(q), slopes.T], [slopes, np.zeros((m, m))]])
        right = np.append(equations.forces(t, q, v, modes), equations.acceleration_rhs(t, q, v))
        x = np.linalg.pinv(whole, rcond=1e-10, hermitian=True) @ right
        told = np.zeros(run.samples.reaction.shape[1])
        machine.kernels.reactions(t, q, v, p, x[n:], told)
        np.testing.assert_allclose(run.samples.a[k], x[:n], rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(run.samples.reaction[k], told, rtol=1e-7, atol=1e-7)


def away_from_level(run: Result) -> np.ndarray:
    """Samples where the pseudo-inverse has digits: there the reactions are finite sums."""
    return np.abs(np.sin(run.q("crank_0.phi"))) > 0.05


def test_what_repeats_is_named_by_joint(table: Machine) -> None:
    start = table.assemble()
    assert [row.element for row in start.redundant] == ["B2", "B3"]
    assert set(start.redundant[0].follows_from) == {"A0", "A1", "A2", "B0", "B1", "B2"}
    assert set(start.not_unique) == set(JOINTS)
    assert start.degrees_of_freedom == 1
    assert len(start.independent) == 14
    assert "Constraint B3.y is redundant and consistent" in str(start)


@pytest.mark.parametrize("method", EXPLICIT)
def test_it_falls_as_if_they_were_not_there(table: Machine, plain: Machine, method: str) -> None:
    run = table.simulate(5.0, TIMES, method=method, rtol=1e-12, progress=False)
    other = plain.simulate(5.0, TIMES, method=method, rtol=1e-12, progress=False)
    assert run.outcome is Outcome.OK, run.message
    assert other.not_unique == ()
    exact = fallen(TIMES)
    for k in range(4):
        angle = run.q(f"crank_{k}.phi")
        np.testing.assert_allclose(angle, exact, rtol=0, atol=1e-9)
        np.testing.assert_allclose(angle, other.q(f"crank_{k}.phi"), rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.q("table.phi"), 0.0, atol=1e-10)
    energy = run.energy()
    assert np.ptp(energy) < 1e-9 * run.energy("kinetic").max()
    assert run.samples.residual[:, 0].max() < 1e-10


def test_the_result_says_what_is_not_unique_and_gives_the_least(table: Machine) -> None:
    run = table.simulate(2.0, np.linspace(0.0, 2.0, 41), rtol=1e-9, progress=False)
    assert "Redundant: B2.y, B3.y" in run.message
    assert "A0, B0, A1, B1, A2, B2, A3, B3 are not unique" in run.message
    assert set(run.not_unique) == set(JOINTS)
    assert run.about()["not_unique"] == ", ".join(run.not_unique)
    far = away_from_level(run)
    assert far.sum() > 30
    assert_least(table, sampled(table, run, far))


def sampled(machine: Machine, run: Result, chosen: np.ndarray) -> Result:
    """The run at some of its samples."""
    rows = {
        name: getattr(run.samples, name)[chosen]
        for name in ("t", "q", "v", "modes", "a", "reaction", "power", "energy", "residual")
    }
    kept = run.samples._replace(**rows)
    p = machine.parameter_values(run.parameters)
    return Result(
        machine.description,
        kept,
        p,
        analysis=run.analysis,
        outcome=run.outcome,
        message="",
        stats={},
    )


def test_reactions_that_are_unique_are_those_without_redundancy(
    hung: Callable[[int], Machine],
) -> None:
    times = np.linspace(0.0, 0.5, 11)
    both = [hung(n).simulate(0.5, times, rtol=1e-11, progress=False) for n in (4, 2)]
    assert "hook" not in both[0].not_unique
    assert set(both[0].not_unique) == set(JOINTS)
    for part in ("fx", "fy"):
        one, other = (run.reaction("hook", part) for run in both)
        assert np.abs(one).max() > 5.0
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("last", [1.01, 0.99, 1 + 1e-6, 2.5])
def test_a_crank_of_another_length_contradicts(table: Machine, last: float) -> None:
    with pytest.raises(RedundancyError) as caught:
        table.simulate(1.0, parameters={"last": last})
    text = str(caught.value)
    assert "constraint B3.y is redundant and contradictory" in text
    assert "Remove B3" in text
    gap = float(text.partition("(gap ")[2].partition(")")[0])
    assert 0.05 * abs(last - 1) < gap < abs(last - 1)


@pytest.mark.parametrize("method", ["energy", "settling"])
def test_it_hangs_in_equilibrium(table: Machine, method: str) -> None:
    rest = table.equilibrium(method, guess=drawn(-1.2))
    assert rest.outcome is Outcome.OK, rest.message
    for k in range(4):
        assert rest[f"crank_{k}.phi"] == pytest.approx(-np.pi / 2, abs=1e-12)
        assert rest.reaction(f"A{k}", "fy")[0] == pytest.approx(9 * 9.81 / 4, rel=1e-10)
    frequency = np.sqrt(MOMENT / INERTIA) / (2 * np.pi)
    np.testing.assert_allclose(rest.frequencies, [frequency], rtol=1e-7)
    assert set(rest.not_unique) == set(JOINTS)
    assert "not unique" in rest.message


def test_it_is_driven() -> None:
    driven = load("hard/parallel_linkage", "inverse_dynamics", folder=ROOT)
    run = driven.inverse_dynamics(np.linspace(0.0, 0.3, 31))
    assert run.outcome is Outcome.OK, run.message
    phi = np.pi / 3 + 2 * np.pi * run.t
    np.testing.assert_allclose(run.q("crank_3.phi"), phi, atol=1e-12)
    np.testing.assert_allclose(run.a("table.x"), -((2 * np.pi) ** 2) * np.cos(phi), atol=1e-9)
    assert "crank_drive" not in run.not_unique
    torque = MOMENT * np.cos(phi)  # against the weights: nothing gains speed
    np.testing.assert_allclose(run.reaction("crank_drive", "torque"), torque, atol=1e-8)
    assert_least(driven, run)
    motion = driven.kinematics(run.t)
    np.testing.assert_allclose(motion.q("table.y"), np.sin(phi), atol=1e-12)
    assert "Redundant: B2.y, B3.y" in motion.message


def test_it_starts_level_where_more_is_lost(table: Machine) -> None:
    start = table.assemble(**start_and_guess(table, drawn(0.0) | turning(0.0, -1.0)))
    assert [row.element for row in start.redundant] == ["B2", "B3"]
    assert start.singular == ("B1.x", "B2.x", "B3.x")
    assert start.degrees_of_freedom == 1
    run = table.simulate(1.0, start=start, rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK, run.message
    np.testing.assert_allclose(run.q("table.phi"), 0.0, atol=1e-9)
    assert np.ptp(run.energy()) < 1e-7 * run.energy("kinetic").max()


@pytest.mark.parametrize("method", ["bdf", "radau5", "auto"])
def test_implicit_methods_fall_alike(table: Machine, method: str) -> None:
    run = table.simulate(2.0, np.linspace(0.0, 2.0, 21), method=method, rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK, run.message
    np.testing.assert_allclose(run.q("crank_3.phi"), fallen(run.t), rtol=0, atol=2e-9)
    far = away_from_level(run)
    assert_least(table, sampled(table, run, far))


@pytest.mark.parametrize("correction", ["projection", "stage", "baumgarte", "hybrid"])
def test_every_way_back_leads_onto_all_constraints(table: Machine, correction: str) -> None:
    times = np.linspace(0.0, 0.5, 6)
    run = table.simulate(0.5, times, correction=correction, rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK, run.message
    np.testing.assert_allclose(run.q("crank_3.phi"), fallen(times), rtol=0, atol=1e-8)
    assert run.samples.residual[:, 0].max() < (1e-6 if correction == "baumgarte" else 1e-12)


def test_in_reduced_coordinates_no_constraint_is_left(table: Machine) -> None:
    times = np.linspace(0.0, 2.0, 21)
    run = table.simulate(2.0, times, formulation="reduced", rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK, run.message
    assert table.mechanism.reduced.closures == ()
    np.testing.assert_allclose(run.q("crank_3.phi"), fallen(times), rtol=0, atol=1e-9)
    assert set(run.not_unique) == set(JOINTS)
    assert_least(table, sampled(table, run, away_from_level(run)))


class Rust(JointFriction):
    """Friction in a pin, by a kind of its own."""

    kind = "rust"


def rub(model: Model) -> None:
    model.friction("rub", model.joints["A0"], 0.1, radius=0.02)


def rust(model: Model) -> None:
    coefficient, creep, radius = (sympy.Float(number) for number in (0.1, 1e-3, 0.02))
    model.add(Rust("rub", model.joints["A0"], coefficient, creep, radius))


@pytest.mark.parametrize("add", [rub, rust])
def test_friction_that_follows_from_reactions_is_refused(
    add: Callable[[Model], None], tmp_path: Path
) -> None:
    model = parallel_linkage(3)
    add(model)
    fall = model.scenes["fall"]
    model.scene("rubbed", ["gravity", "rub"], start=dict(fall.start), guess=dict(fall.guess))
    with pytest.raises(AnalysisError, match=r"friction in joints \(rub\) follows from their reac"):
        load(model, "rubbed", folder=tmp_path).simulate(1.0)


def test_samples_are_reproduced(table: Machine) -> None:
    """Which pivot is taken hangs on nothing but the state."""
    runs = [table.simulate(1.0, rtol=1e-6, progress=False) for _ in range(2)]
    for one, other in pairwise(runs):
        assert (one.samples.q == other.samples.q).all()
        assert (one.samples.reaction == other.samples.reaction).all()


def test_driven_table_passes_its_level_positions_as_a_parallelogram() -> None:
    """Two constraints follow from others everywhere, three where the bars lie level: one more.

    With the first crank at rest the table may turn about its pin, and every crank with it.
    """
    driven = load("hard/parallel_linkage", "inverse_dynamics", folder=ROOT)
    run = driven.kinematics(np.linspace(0.0, 2.0, 41))
    assert run.outcome is Outcome.OK
    assert np.abs(run.q("table.phi")).max() < 1e-12
    turned = np.pi / 3 + 2 * np.pi * run.t
    for k in range(4):
        np.testing.assert_allclose(run.q(f"crank_{k}.phi"), turned, atol=1e-11)
    np.testing.assert_allclose([row.time for row in run.singular], np.arange(4) / 2 + 1 / 3)
    for row in run.singular:
        assert row.lost == 1
        (free,) = row.null_directions
        rates = [free.get(f"crank_{k}.phi", 0.0) for k in range(4)]
        np.testing.assert_allclose(np.array(rates) / rates[3], np.arange(4) / 3.0, atol=1e-8)
