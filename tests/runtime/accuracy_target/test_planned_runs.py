"""Runs of a search that differ in more than their tolerance: in method, step or coordinates."""

from collections.abc import Callable
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from sympy import exp

from codegen import Model, t
from models.hard.suite.linkages import crank_angle
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks import energy_balance
from runtime.dynamics.formulations import formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.checkpoints import Checkpoints
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.machine_facade import Machine
from tests.random_mechanisms import Scales, accuracy_runs, random_mechanism

T = np.linspace(0.0, 3.0, 61)
COST = 8.0  # right-hand sides of all runs, over those of the cheapest single one


@pytest.fixture(scope="module")
def cart(workshop: Path) -> Machine:
    """A damped cart on a spring, with the companions of which the program may choose."""
    model = Model("damped_cart")
    damping = model.parameter("damping", 0.0, unit="N*s/m")
    body = model.body("cart", mass=1.0, inertia=1.0)
    model.translational("guide", model.ground, body, axis=(1, 0))
    model.spring("spring", model.ground.at(-2, 0), body, 1.0, free_length=1.0)
    model.force("drag", body.at(0, 0), -damping * body.vx)
    model.scene("pulled", ["spring", "drag"], start={body.x: 0.5, body.vx: 0.0})
    machine = load(model, folder=workshop)
    assert machine.mechanism.tangents
    return machine


@pytest.mark.parametrize(
    ("damping", "target", "expected"),
    [(0.5, 1e-3, "dop853"), (30.0, 1e-3, "radau5"), (30.0, 1e-9, "dop853")],
)
def test_an_implicit_method_follows_where_steps_are_long_beside_the_fastest_decay(
    cart: Machine, damping: float, target: float, expected: str
) -> None:
    run = cart.simulate(3.0, T, accuracy=target, parameters={"damping": damping}, progress=False)
    found = run.accuracy
    assert [trial.method for trial in found.runs][:2] == ["auto", expected]
    assert found.runs[0].steps < 100
    lower, upper = np.roots([1.0, damping, 1.0])  # z'' + d z' + z = 0 with z = x + 1
    a, b = np.linalg.solve([[1.0, 1.0], [lower, upper]], [1.5, 0.0])
    exact = np.real(a * np.exp(lower * T) + b * np.exp(upper * T)) - 1.0
    size = {row.name: row.scale for row in found.quantities}["cart.x"]
    errors = np.abs(run.series("cart.x")[0] - exact) / (size + np.abs(exact))
    assert max(errors.max(), found.estimated) <= target


@pytest.fixture(scope="module")
def pulse() -> Model:
    """A force that acts for an instant, alone and beside a slow motion."""
    model = Model("pulse")
    instant = model.parameter("instant", 50.0, unit="s")
    p = model.body("p", mass=2.0, inertia=1.0)
    slow = model.body("slow", mass=1.0, inertia=1.0)
    model.translational("guide", model.ground, p, axis=(1, 0))
    model.translational("other_guide", model.ground, slow, axis=(0, 1))
    model.force("pulse", p.at(0, 0), 10 * exp(-((10 * (t - instant)) ** 2)))
    model.spring("spring", model.ground.at(0, -1), slow, 0.01, free_length=1.5)
    start = {p.x: 0.0, p.vx: 0.0, slow.y: 0.0, slow.vy: 0.0}
    model.scene("alone", ["pulse"], start=start)
    model.scene("beside", ["pulse", "spring"], start=start)
    return model


@pytest.mark.parametrize("scene", ["alone", "beside"])
def test_a_pulse_between_the_steps_of_both_runs_is_found(
    pulse: Model, workshop: Path, scene: str
) -> None:
    found = load(pulse, scene, folder=workshop).simulate(100.0, accuracy=1e-6, progress=False)
    assert found.outcome is Outcome.OK
    gained = 10.0 * 0.1 * sqrt(pi) / 2.0
    assert found.series("p.vx")[0][-1] == pytest.approx(gained, rel=1e-6)
    assert found.series("p.x")[0][-1] == pytest.approx(50.0 * gained, rel=1e-6)
    assert 0.0 < found.accuracy.estimated < 1e-6


def test_no_estimate_is_zero(pulse: Model, workshop: Path) -> None:
    """Nothing moves before the pulse, and both runs say so exactly."""
    machine = load(pulse, "alone", folder=workshop)
    found = machine.simulate(10.0, accuracy=1e-6, progress=False).accuracy
    assert all(row.error > 0.0 for row in found.quantities)
    assert 0.0 < found.estimated < np.inf
    assert "alike in both, to the last digit, also with steps of at most 0.00" in found.means
    assert found.runs[-1].steps >= 1000


def test_runs_whose_steps_samples_bound_are_compared_with_shorter_steps(tmp_path: Path) -> None:
    model = Model("paced")
    arm = model.body("arm", mass=1.0, inertia=0.05)
    model.revolute("pin", model.ground.at(0, 0), arm.at(0, 0))
    torque = model.sampled("torque", 0.002, -2.0 * arm.phi - 0.1 * arm.omega, unit="N m")
    model.torque("drive", on=arm, value=torque)
    model.scene("turn", ["drive"], start={arm.phi: 1.0, arm.omega: 0.0})
    machine = load(model, folder=tmp_path)
    result = machine.simulate(0.4, 41, accuracy=1e-6)
    accuracy = result.accuracy
    *_, other, delivered = accuracy.runs
    assert len(accuracy.runs) == 3
    assert delivered.rtol == other.rtol
    assert delivered.steps > 1.9 * other.steps
    assert "runs of two tolerances took the same steps" in accuracy.means
    exact = machine.simulate(0.4, 41, rtol=1e-13, max_step=2e-4)
    errors = np.abs(result.q("arm.phi") - exact.q("arm.phi"))
    assert errors.max() <= accuracy.estimated <= 1e-6


@pytest.mark.parametrize(("seed", "horizons"), [(1, 1.0), (2, 1.0), (9, 2.0)])
def test_targets_of_random_mechanisms_are_met_at_a_bounded_cost(
    seed: int, horizons: float, workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sample of `tests.random_mechanisms.accuracy_runs`."""
    monkeypatch.setattr(accuracy_runs, "METHODS", ("dop853", "dopri5"))
    mechanism = random_mechanism(seed, scales=Scales())
    machine = load(mechanism.model(), mechanism.scene, folder=workshop)
    targets = (1e-4, 1e-6)
    found = list(accuracy_runs.judge(machine, horizons * mechanism.horizon, targets, ["cartesian"]))
    assert [one.target for one in found] == list(targets)
    for one in found:
        assert one.met, str(one)
        assert one.cost <= COST, str(one)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_decays_in_a_run_decays_in_both_kinds_of_coordinates(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch, sign: float
) -> None:
    """Also where the last part of the run is in the other kind."""
    mechanism = library("hard/n_four_bar", "fall").mechanism
    kinds = len(mechanism.reduced.kept), len(mechanism.description.coordinates)
    decay = property(lambda state: sign * state.system.coordinates)
    monkeypatch.setattr(RunState, "mean_decay", decay)
    ready = PreparedSimulation(mechanism, 1.0, t_start=0.0, parameters=None, guess=None, start=None)
    taken = formulate(ready, "reduced", "dop853", "step")
    path = taken.run(Options(rtol=1e-6, t_eval=np.linspace(0.0, 1.0, 11)), Checkpoints())
    assert path.outcome.name == "OK"
    assert path.decay == min(sign * count for count in kinds)


def test_a_search_goes_on_in_all_coordinates_where_a_check_contradicts_reduced_ones(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine, times = library("hard/n_four_bar", "fall"), np.linspace(0.0, 1.0, 21)
    found = iter(["The energy changes."])  # of the first result alone
    monkeypatch.setattr(energy_balance, "describe_unexplained_energy", lambda *_: next(found, ""))
    run = machine.simulate(1.0, times, accuracy=1e-6, formulation="reduced", progress=False)
    assert run.outcome is Outcome.OK
    assert run.accuracy.formulation == "cartesian"
    assert [one.formulation for one in run.accuracy.runs][-2:] == ["cartesian"] * 2
    assert "The energy changes" in run.accuracy.means
    assert run.message.endswith("which is thrown away. The energy changes.")
    assert "rely" not in run.message + run.accuracy.means
    delivered = run.accuracy.runs[-1]
    again = machine.simulate(
        1.0, times, rtol=delivered.rtol, method=delivered.method, formulation="cartesian"
    )
    np.testing.assert_array_equal(again.samples.q, run.samples.q)
    exact = crank_angle(2, times)
    assert np.max(np.abs(run.q("crank_0.phi") - exact) / (1.0 + np.abs(exact))) <= 1e-6
