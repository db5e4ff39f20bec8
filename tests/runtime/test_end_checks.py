"""No run is OK that a check at its end contradicts; angles without digits are refused."""

import re
from collections.abc import Callable
from copy import copy
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sympy import Mod

from codegen import Model, t
from codegen.errors import AssemblyError
from runtime import load
from runtime.core.kinds import Direction
from runtime.core.outcomes import Outcome
from runtime.dynamics import simulation
from runtime.dynamics.checks import end_checks, energy_balance
from runtime.dynamics.checks.screening import Suspicions, screen_run
from runtime.integrate.problem import Events, Trajectory
from runtime.integrate.recording_buffers import Recording, in_order
from runtime.machine_facade import Machine
from runtime.results.samples import Samples


@pytest.mark.parametrize("power", [8, 10, 12, 14, 16])
def test_angles_whose_sine_has_no_digits_are_refused(pendulum: Machine, power: int) -> None:
    angle = next(row for row in pendulum.description.coordinates if not row.is_length)
    with pytest.raises(AssemblyError, match=rf"{angle.name} is 1e\+{power:02d} rad"):
        pendulum.simulate(1.0, start={angle.name: 10.0**power})


@pytest.mark.parametrize("power", [3, 5, 7])
def test_angles_with_digits_keep_their_joints(pendulum: Machine, power: int) -> None:
    angle = next(row for row in pendulum.description.coordinates if not row.is_length)
    run = pendulum.simulate(1.0, start={angle.name: 10.0**power})
    assert run.outcome is Outcome.OK
    assert run.samples.residual[:, 0].max() < 1e-8


def test_run_with_broken_joints_is_not_ok(pendulum: Machine) -> None:
    """A state handed over, which assembly has not seen, may have an angle of any size."""
    begin = pendulum.assemble()
    turns = np.where(pendulum.description.is_length, 0.0, 1e12)
    start = replace(begin, q=begin.q + turns)
    assert pendulum.simulate(0.5, "steps", start=start).outcome is Outcome.CONTRADICTED
    # With Baumgarte's method no balance of energy is kept that would end it before.
    run = pendulum.simulate(0.5, start=start, correction="baumgarte")
    assert run.outcome is Outcome.CONTRADICTED
    assert "constraints are not satisfied" in run.message
    assert "too few digits" in run.message


@pytest.mark.parametrize("correction", ["step", "projection", "baumgarte", "hybrid"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
def test_right_runs_are_not_contradicted(free: Machine, correction: str, rtol: float) -> None:
    run = free.simulate(1.0, rtol=rtol, correction=correction, method="dopri5")
    assert run.outcome is Outcome.OK


def test_run_whose_log_goes_back_is_not_ok(gas: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the loop has logged is judged, and not what sorting makes of it."""
    logged = Recording.events

    def shuffled(recording: Recording) -> Events:
        events = logged(recording)
        assert len(events.t) > 1
        return replace(events, t=events.t[::-1].copy())

    monkeypatch.setattr(Recording, "events", shuffled)
    run = gas.simulate(1.0, start={"crank.omega": 30.0})
    assert run.outcome is Outcome.CONTRADICTED
    assert "not in order" in run.message


def test_ends_of_bouncing_alone_are_put_in_order() -> None:
    t, index = np.array([1.0, 9.0, 2.0, 3.0, 2.5, 4.0]), np.array([0, 1, 0, 2, 0, 2])
    direction = np.array([1, 0, -1, 0, 1, -1])
    assert direction[1] == Direction.HOLDS
    state = np.zeros((6, 1))
    events = in_order(Events(t, index, direction, state, state.copy()), 5.0, (1,))
    assert events.t.tolist() == [1.0, 2.0, 3.0, 2.5, 4.0, 5.0]
    assert events.index.tolist() == [0, 0, 2, 0, 2, 1]


def record_modes(patch: pytest.MonkeyPatch, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Let runs record other modes than they had."""
    recorded = Recording.samples

    def missed(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        t, y, modes = recorded(recording)
        return t, y, change(modes)

    patch.setattr(Recording, "samples", missed)


@pytest.mark.parametrize("t_eval", [None, np.linspace(0.0, 1.0, 50)])
def test_run_whose_modes_contradict_their_functions_is_not_ok(
    gas: Machine, monkeypatch: pytest.MonkeyPatch, t_eval: np.ndarray | None
) -> None:
    """A condition that the run takes for false while it holds: an event was missed."""
    turning = {"crank.omega": 30.0}
    assert gas.simulate(1.0, t_eval, start=turning).outcome is Outcome.OK
    record_modes(monkeypatch, lambda modes: 1 - modes)
    run = gas.simulate(1.0, t_eval, start=turning)
    assert run.outcome is Outcome.CONTRADICTED
    assert "contradicts its switching function" in run.message
    assert gas.description.switches[0].title.partition(":")[0] in run.message


def test_a_mode_is_judged_at_the_edge_of_its_functions_domain(
    workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """(-x)^2.5 has a number at x = 0 and none beyond."""
    model = Model("edge_of_a_domain")
    bead = model.particle("bead", mass=1.0)
    model.force("push", bead, fy=1.0, when=(-bead.x) ** 2.5 + 1 - bead.y > 0)
    machine = load(model, folder=workshop)
    moving = {"bead.vy": 0.1}
    assert machine.simulate(0.5, start=moving).outcome is Outcome.OK
    record_modes(monkeypatch, lambda modes: 1 - modes)
    run = machine.simulate(0.5, start=moving)
    assert run.outcome is Outcome.CONTRADICTED
    assert "contradicts its switching function" in run.message


def test_one_sample_that_contradicts_its_function_is_an_event_missed(
    gas: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A condition that turns twice between two samples that are right leaves no two wrong ones."""
    turning, at = {"crank.omega": 30.0}, np.linspace(0.0, 1.0, 50)
    record_modes(
        monkeypatch, lambda modes: np.where(np.arange(50)[:, None] == 20, 1 - modes, modes)
    )
    run = gas.simulate(1.0, at, start=turning)
    assert run.outcome is Outcome.CONTRADICTED
    assert f"From t = {at[20]:.6g} s on the mode of " in run.message


def test_a_run_that_nothing_contradicts_pays_for_one_look(
    gas: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each check would be dear for a run of two milliseconds."""
    for check in ("_residuals", "_order_of_events", "_sides_of_modes"):
        monkeypatch.setattr(end_checks, check, None)
    assert gas.simulate(1.0, start={"crank.omega": 30.0}).outcome is Outcome.OK


def test_what_is_not_suspected_is_not_contradicted(
    gas: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Samples and events made wrong by anything from rounding to 1 are judged as by all checks."""
    given: list[tuple[Any, ...]] = []
    check = simulation.check_result
    monkeypatch.setattr(simulation, "check_result", lambda *args, **_: given.append(args))
    gas.simulate(1.0, "steps", start={"crank.omega": 30.0})
    result, equations, sizes, options, run, *_ = given[0]
    rng, verdicts = np.random.default_rng(1), []

    def contradiction(samples: Samples, run: Trajectory, suspicions: Suspicions) -> str:
        judged = copy(result)
        judged.samples, judged.outcome, judged.contradiction = samples, Outcome.OK, ""
        check(judged, equations, sizes, options, run, suspicions)
        return str(judged.contradiction)

    for k in range(120):
        samples, trajectory = result.samples, run
        at, size = rng.integers(len(samples.t) - 1), 10.0 ** rng.uniform(-16.0, 0.0)
        if k % 4 == 0:
            residual = samples.residual.copy()
            residual[at, k % 2] = np.nan if k % 20 == 0 else size
            samples = samples._replace(residual=residual)
        elif k % 4 == 1:
            modes = samples.modes.copy()
            modes[at : at + k % 3] ^= 1
            samples = samples._replace(modes=modes)
        elif k % 4 == 2:
            samples = samples._replace(q=samples.q + size * rng.normal(size=samples.q.shape))
        else:
            t = run.events.t.copy()
            t[at % len(t)] += size * rng.choice([-1.0, 1.0])
            trajectory = run._replace(events=replace(run.events, t=t))
        screened = screen_run(equations, samples, sizes, options, trajectory)
        verdicts.append(contradiction(samples, trajectory, screened))
        assert verdicts[-1] == contradiction(samples, trajectory, Suspicions(True, True, True))
    assert 20 < sum(map(bool, verdicts)) < 100


@pytest.mark.parametrize("t_eval", ["steps", [0.501, 1.0], [0.5, 1.0]])
@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_modes_that_stay_past_a_jump_are_events_missed(
    workshop: Path, monkeypatch: pytest.MonkeyPatch, t_eval: list[float] | str, method: str
) -> None:
    """A sawtooth jumps at ends of steps, beside which either mode may be right."""
    model = Model("pushed_by_a_sawtooth")
    p = model.particle("p", mass=1.0)
    model.force("push", p, 1.0, 0, when=Mod(t, 0.02) < 0.005)
    model.scene("s", ["push"], start={p.x: 0.0, p.y: 0.0, p.vx: 0.0, p.vy: 0.0})
    machine = load(model, folder=workshop)
    run = machine.simulate(1.0, t_eval, method=method, progress=False)
    assert run.outcome is Outcome.OK
    logged = Recording.events

    def none(recording: Recording) -> Events:
        events = logged(recording)
        return Events(*(getattr(events, field.name)[:0] for field in fields(events)))

    record_modes(monkeypatch, lambda modes: 0 * modes)
    monkeypatch.setattr(Recording, "events", none)
    run = machine.simulate(1.0, t_eval, method=method, progress=False)
    assert run.outcome is Outcome.CONTRADICTED
    assert "on the mode of push: " in run.message


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
def test_a_run_records_no_more_than_it_may(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch, formulation: str
) -> None:
    """Its end says what takes how much; samples at given instants take what was asked for."""
    machine = library("slider_crank", "compressor")
    run = machine.simulate(1e3, formulation=formulation, max_bytes=20_000, progress=False)
    assert run.outcome is Outcome.MEMORY
    assert re.search(r"recorded in \d+ steps and \d+ events take \S+e\+04 bytes\.", run.message)
    assert "t_eval" in run.message
    assert "max_bytes" in run.message
    assert "max_steps" not in run.message
    assert sum(array.nbytes for array in (run.t, run.samples.q, run.samples.v)) < 200_000
    at = np.linspace(0.0, 1.0, 2000)
    run = machine.simulate(1.0, at, formulation=formulation, max_bytes=20_000, progress=False)
    assert run.outcome is Outcome.OK


def test_reduced_run_that_a_check_contradicts_is_repeated_in_all_coordinates(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine, t = library("slider_crank", "compressor"), np.linspace(0.0, 0.2, 5)
    whole = machine.simulate(0.2, t)
    wrong = "The energy changes by 3 J."
    found = iter([wrong])  # of the first run alone
    monkeypatch.setattr(energy_balance, "describe_unexplained_energy", lambda *_: next(found, ""))
    less = machine.simulate(0.2, t, formulation="reduced")
    assert less.outcome is Outcome.OK
    np.testing.assert_array_equal(less.samples.q, whole.samples.q)
    assert less.message.startswith(whole.message)
    assert less.message.endswith(
        "This run is in all coordinates: a check contradicted one in reduced coordinates, which is "
        f"thrown away. {wrong}"
    )
    assert "rely" not in less.message
    assert less.contradiction == ""
