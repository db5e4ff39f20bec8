"""Instants of singular positions, starts beside them, and what analyses make of contacts."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from codegen import Model, t
from codegen.errors import AnalysisError
from linkwright.cli.application import app
from models.hard.parallel_linkage import parallel_linkage
from runtime import Machine, Outcome, load
from tests.hard.driven import STANDING
from tests.hard.start_values import start_and_guess


@pytest.fixture
def folder(request: pytest.FixtureRequest) -> Path:
    return request.config.cache.mkdir("beginnings")


# Singular positions.


@pytest.mark.parametrize("cranks", [2, 4])
def test_a_driven_simulation_passes_at_the_driver_s_instant(cranks: int, folder: Path) -> None:
    """The cranks start at 60 degrees and turn once a second: level after a third of it."""
    model = "hard/parallel_linkage" if cranks == 4 else parallel_linkage(cranks)
    machine = load(model, "inverse_dynamics", folder=folder)
    first = machine.simulate(0.5, progress=False).singular[0]
    assert abs(first.time - 1.0 / 3.0) < 1e-12
    assert first.lost == 1
    # With the first crank at rest the table turns about its pin: the others' rates grow evenly.
    (free,) = first.null_directions
    rates = [free.get(f"crank_{k}.phi", 0.0) for k in range(cranks)]
    if cranks == 4:
        np.testing.assert_allclose(np.diff(rates, 2), 0.0, atol=1e-8)


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12])
def test_every_singular_position_is_counted_whatever_the_steps(rtol: float, folder: Path) -> None:
    """Level every half turn; at 1e-5 that is four steps."""
    machine = load(parallel_linkage(2), "inverse_dynamics", folder=folder)
    run = machine.simulate(2.5, rtol=rtol, progress=False)
    np.testing.assert_allclose(
        [passed.time for passed in run.singular], 1.0 / 3.0 + 0.5 * np.arange(5), atol=1e-9
    )


def test_redundant_rows_hold_where_independent_ones_do_not() -> None:
    machine = load("hard/parallel_linkage", "inverse_dynamics")
    first = machine.kinematics(np.linspace(0.0, 0.5, 6), progress=False).singular[0]
    assert first.lost == 1
    (free,) = first.null_directions
    rates = [free.get(f"crank_{k}.phi", 0.0) for k in range(4)]
    np.testing.assert_allclose(np.array(rates) / rates[3], np.arange(4) / 3.0, atol=1e-8)


@pytest.mark.parametrize("beyond", [1e-5, 1e-4])
def test_what_lies_before_the_start_is_not_passed(beyond: float) -> None:
    turned = {"crank.phi": np.pi / 2 + beyond, "rod.phi": -np.pi / 2 - beyond}
    machine = load("hard/equal_rods", "spin")
    run = machine.simulate(1.0, **start_and_guess(machine, STANDING | turned), progress=False)
    assert run.outcome is Outcome.OK, run.message
    assert all(row.time > 0.0 for row in run.singular)
    assert run.stats["singular_crossings"] == len(run.singular)


@pytest.mark.parametrize("before", [1e-7, 1e-6, 1e-5, -1e-7, -1e-6])
def test_a_start_beside_a_singular_position_is_held_and_runs(before: float) -> None:
    """From the model's drawing, which is nowhere near; the branch is the one that it closes to."""
    machine = load("hard/equal_rods", "spin")
    run = machine.simulate(3.0, start={"crank.phi": np.pi / 2 - before}, progress=False)
    assert run.outcome is Outcome.OK, run.message
    assert abs(run.q("crank.phi")[0] - np.pi / 2 + before) < 1e-15
    assert abs(run.v("crank.phi")[0] - 2.0) < 1e-6
    turning = "slider.x" if abs(run.v("slider.x")[0]) < 1.0 else "crank.phi"
    exact = 0.0 if turning == "slider.x" else 2.0 * np.cos(run.q("crank.phi"))
    np.testing.assert_allclose(run.q("slider.x"), exact, atol=1e-6)


@pytest.mark.parametrize("before", [0.0, 1e-9])
def test_a_drawing_that_fits_two_motions_ends_by_name(before: float) -> None:
    """The slider may pass or stay, and neither position nor velocities say which is meant."""
    machine = load("hard/equal_rods", "spin")
    run = machine.simulate(1.0, start={"crank.phi": np.pi / 2 - before}, progress=False)
    assert run.outcome is Outcome.SINGULAR, run.message
    assert run.q("crank.phi")[0] == np.pi / 2 - before
    assert run.v("crank.phi")[0] == 2.0
    assert "driver" not in run.message
    assert "redundant" not in run.message


def test_a_start_on_no_branch_is_not_blamed_on_drivers_or_redundancy() -> None:
    machine = load("hard/equal_rods", "spin")
    between = STANDING | {"crank.omega": 2.0, "rod.omega": 0.7}
    start = machine.assemble(**start_and_guess(machine, between))
    start.v[:] = 0.0
    start.v[[row.velocity for row in machine.coordinates].index("crank.omega")] = 2.0
    run = machine.simulate(1.0, start=start, progress=False)
    assert run.outcome is Outcome.SINGULAR
    assert "starts in a singular position or too near to one" in run.message
    assert "driver" not in run.message
    assert "redundant" not in run.message


# Contacts.


@pytest.fixture
def pushed(folder: Path) -> Machine:
    model = Model("pushed")
    body = model.body("block", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, body, axis=(1, 0))
    model.driver("push", body.x, t)
    model.contact("stop", gap=1 - body.x, restitution=0.5)
    model.scene("s", ["stop"], ["push"], guess={body.x: 0.0})
    return load(model, "s", folder=folder)


def test_drivers_are_not_followed_through_a_rigid_contact(pushed: Machine) -> None:
    with pytest.raises(AnalysisError, match=r"kinematics does not decide.*has stop"):
        pushed.kinematics([0.0, 0.5, 2.0])
    with pytest.raises(AnalysisError, match=r"inverse dynamics does not decide.*has stop"):
        pushed.inverse_dynamics([0.0, 0.5, 2.0])


@pytest.mark.parametrize("speed", [1.0, -1.0, 1e-3])
@pytest.mark.parametrize("width", [1e-9, 1e-6])
def test_a_narrow_clearance_keeps_the_energy(width: float, speed: float, folder: Path) -> None:
    """A ball between two walls, which return all of it: x is a triangle wave."""
    model = Model("narrow")
    apart = model.parameter("apart", 1.0, unit="m")
    ball = model.particle("ball", mass=2.0)
    model.contact("left", gap=ball.x, restitution=1.0)
    model.contact("right", gap=apart - ball.x, restitution=1.0)
    start = {ball.x: 0.5, ball.vx: 1.0, ball.y: 0.0, ball.vy: 0.0}
    model.scene("s", ["left", "right"], start=start)
    run = load(model, "s", folder=folder).simulate(
        10.0 * width / abs(speed),
        parameters={"apart": width},
        start={"ball.x": 0.5 * width, "ball.vx": speed},
        progress=False,
    )
    assert run.outcome is Outcome.OK, run.message
    assert len(run.events) == 10
    assert run.v("ball.x")[-1] == pytest.approx(speed, rel=1e-12)


def test_a_dry_friction_runs_on_redundant_constraints(folder: Path) -> None:
    """Its normal force is given: against the pendulum that the linkage is, with a brake."""
    model = parallel_linkage(4)
    crank = model.bodies["crank_0"]
    model.dry_friction("brake", slip=crank.omega, normal=20.0, coefficient=0.3)
    model.scene("braked", ["gravity", "brake"], start={crank.phi: np.pi / 3})
    times = np.linspace(0.0, 0.8, 9)
    run = load(model, "braked", folder=folder).simulate(0.8, times, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK, run.message

    def exact(_: float, y: np.ndarray) -> list[float]:
        torque = -7.0 * 9.81 * np.cos(y[0]) - 6.0 * np.sign(y[1] or -1.0)
        return [y[1], torque / (4.0 / 3.0 + 5.0)]

    known = solve_ivp(exact, (0.0, 0.8), [np.pi / 3, 0.0], t_eval=times, rtol=1e-11, atol=1e-12)
    assert known.y[1].max() <= 0.0  # it turns one way
    np.testing.assert_allclose(run.q("crank_0.phi"), known.y[0], atol=1e-7)


# The command line.


def test_a_run_of_no_length_is_a_run_for_the_command_too() -> None:
    asked = ["simulate", "hard/bouncing_ball", "--scene", "dropped", "--t-end", "0", "--json"]
    found = CliRunner().invoke(app, asked)
    assert found.exit_code == 0, found.output
    told = json.loads(found.stdout)
    assert told["ok"] is True
    backwards = CliRunner().invoke(app, [*asked[:-2], "-1"])
    assert backwards.exit_code == 2
