"""What the hard cases must show: the bars, and one cell of every case."""

import numpy as np
import pytest

from models.hard.cases import CASES, find
from models.hard.suite.case import Case
from models.hard.suite.cell import COMPARED, Setting, Verdict, run
from models.hard.suite.worker import Worker
from runtime import Outcome, Result, load
from runtime.integrate.method import METHODS
from tests.runtime.integrate.systems import ACCURATE, ACCURATE_IMPLICIT

SETTING = Setting(COMPARED, "step")


def simulated(case: Case, rtol: float, method: str = COMPARED) -> Result:
    """The run of a case, which must reach its end."""
    result = case.machine().simulate(
        case.t_end,
        case.instants(),
        method=method,
        rtol=rtol,
        parameters=dict(case.parameters),
        start=dict(case.start),
    )
    assert result.outcome is Outcome.OK, result.message
    assert result.samples.residual[:, 0].max() < 1e-10
    return result


@pytest.mark.parametrize("method", [*ACCURATE, *ACCURATE_IMPLICIT])
def test_andrews_to_nine_digits(method: str) -> None:
    case = find("andrews")
    angles = case.measure(simulated(case, 1e-11, method))
    exact = case.reference().values
    assert case.reference().times[-1] == 0.05
    np.testing.assert_allclose(angles[-1], exact[-1], rtol=1e-9, atol=0)


def test_pendulum_after_2000_seconds() -> None:
    case = find("pendulum_point")
    place = case.measure(simulated(case, 1e-12))
    assert np.abs(place[-1] - case.reference().values[-1]).max() < 1e-6


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_no_step_is_far_worse_than_its_tolerance(rtol: float) -> None:
    """Where the bars come into line, coordinates that were independent two steps ago are not."""
    run = load("hard/double_pendulum", "thrown").simulate(8.0, rtol=rtol, progress=False)
    total = run.series("total")[0]
    assert np.abs(np.diff(total)).max() < 100.0 * rtol * np.abs(total).max()


@pytest.mark.parametrize("scene", ["point", "bar"])
def test_energy_of_a_long_run_drifts_as_the_time_and_not_as_its_square(scene: str) -> None:
    """An eighth of the drift after an eighth of the time; a quadratic one would leave 1/64."""
    result = simulated(find(f"pendulum_{scene}"), 1e-10)
    off = np.abs(result.energy() - result.energy()[0])
    early, late = off[result.t <= 250.0].max(), off.max()
    assert late < 1e-5
    assert 5.0 < late / early < 12.0


def test_high_precision_of_the_benchmark_is_met_with_steps_to_spare() -> None:
    """0.1 s of processor time are 200 000 steps of half a microsecond."""
    case = find("pendulum_point")
    result = simulated(case, 1e-10)
    assert np.abs(case.measure(result) - case.reference().values).max() < 1e-3
    assert result.stats["steps"] + result.stats["rejected"] < 100_000


@pytest.mark.parametrize("name", ["coil_spring_impact", "coil_spring_damped"])
def test_every_contact_of_the_coil_spring_is_in_time(name: str) -> None:
    case = find(name)
    off = np.abs(case.measure(simulated(case, 1e-12)) - case.reference().values)
    assert off[:10].max() < 1e-10
    assert off.max() < 1e-6


def test_the_compressor_stalls_in_time_and_stays_there() -> None:
    case = find("compressor_stall")
    result = simulated(case, 1e-10)
    time, place = case.reference().values
    found = case.measure(result)
    assert abs(found[0] - time) < 1e-9
    assert abs(found[1] - place) < 1e-9
    assert result.t[-1] == 10.0
    assert result.stats["steps"] < 2000


@pytest.mark.parametrize("method", ["bdf", "radau5", "auto"])
def test_a_stiff_train_costs_implicit_methods_a_tenth_of_the_steps(method: str) -> None:
    case = find("stiff_train")
    explicit, implicit = simulated(case, 1e-6), simulated(case, 1e-6, method)
    off = np.abs(case.measure(implicit) - case.measure(explicit)).max()
    assert off < 1e-6 * np.ptp(case.measure(explicit))
    assert 10 * implicit.stats["steps"] <= explicit.stats["steps"]


@pytest.mark.parametrize("method", METHODS)
def test_the_ball_rests_at_the_end_of_infinitely_many_flights(method: str) -> None:
    case = find("ball_dropped")
    off = np.abs(case.measure(simulated(case, 1e-8, method)) - case.reference().values)
    assert off.max() < 1e-9


def test_the_stalled_compressor_rests_exactly() -> None:
    case = find("compressor_stall")
    result = simulated(case, 1e-10)
    resting = result.t > case.reference().values[0]
    assert resting.sum() > 100
    assert np.ptp(result.q("crank.phi")[resting]) == 0.0
    assert np.ptp(result.samples.q[resting], axis=0).max() < 1e-14
    assert np.abs(result.samples.v[resting]).max() == 0.0
    assert np.abs(result.samples.a[resting]).max() == 0.0


@pytest.mark.parametrize("name", ["no_time", "one_step"])
def test_the_shortest_runs(name: str) -> None:
    case = find(name)
    result = simulated(case, 1e-6)
    assert result.stats["steps"] == len(case.instants()) - 1
    assert len(result.t) == len(case.instants())
    assert np.abs(case.measure(result) - case.reference().values).max() < 1e-14


def test_many_outputs_change_no_step_and_are_as_right_as_the_steps() -> None:
    case = find("dense_outputs")
    dense = simulated(case, 1e-9)
    steps = case.machine().simulate(case.t_end, rtol=1e-9)
    assert dense.stats["steps"] == steps.stats["steps"] < 100
    off = np.abs(case.measure(dense) - case.reference().values)[:, 0]
    at_ends = np.interp(steps.t, dense.t, off)
    assert off.max() < 10.0 * at_ends.max()


def test_the_error_falls_with_the_tolerance() -> None:
    case = find("every_tolerance")
    errors = []
    for rtol in case.tolerances:
        off = np.abs(case.measure(simulated(case, rtol)) - case.reference().values)
        errors.append(off.max() / rtol)
    assert len(errors) == 12
    assert max(errors) < 100.0
    assert min(errors) > 0.01


def test_a_million_turns_are_counted_to_the_last_digits() -> None:
    case = find("crank_turned")
    angle = case.measure(simulated(case, 1e-12))[:, 0]
    exact = case.reference().values[:, 0]
    assert exact[-1] / (2 * np.pi) == pytest.approx(1e6)
    assert (np.abs(angle - exact) <= 20 * np.spacing(exact)).all()


def test_a_fast_crank_changes_its_partition_more_than_a_hundred_times() -> None:
    assert simulated(find("crank_fast"), 1e-9).stats["repartitions"] > 100


@pytest.mark.parametrize(
    "case", [case for case in CASES if not case.long], ids=lambda case: case.name
)
def test_no_cell_is_wrong(case: Case) -> None:
    """The tightest tolerance but for the stiff case, whose explicit steps are many."""
    rtol = case.tolerances[2 if case.name == "stiff_soft" else -1]
    if case.t_end == 0.0:
        worker = Worker(find, limit=10.0)
        cell = worker.run(case, SETTING, rtol)
        worker.close()
    else:
        cell = run(case, SETTING, rtol)
    assert cell.verdict in (Verdict.CORRECT, Verdict.EXPECTED), f"{cell.verdict}: {cell.note}"
    assert cell.residual < 1e-10
    assert not cell.drift > 1e-4
    assert cell.steps > 0 or case.t_end == 0.0


def test_every_machine_is_one_that_loads_by_its_name() -> None:
    for case in CASES:
        assert case.scene == load(case.model, case.scene).scene
        if case.declare is not None:
            assert case.scene in case.declare().scenes


@pytest.mark.parametrize("method", ["bdf", "radau5"])
@pytest.mark.parametrize(
    "name",
    [
        "double_pendulum",
        "crank_wound",
        "crank_fast",
        "mass_ratio_light",
        "mass_ratio_heavy",
        "stiff_soft",
        "cam_thrown",
    ],
)
def test_implicit_methods_reach_the_tightest_tolerance(name: str, method: str) -> None:
    """Errors per step there are those of rounding a state, unless what it cuts off is kept."""
    case = find(name)
    cell = run(case, Setting(method, "step"), min(case.tolerances))
    assert cell.verdict == Verdict.CORRECT, f"{cell.verdict}: {cell.note}"
    assert cell.rejected < 0.1 * cell.steps


def test_a_very_short_run_is_not_pulled_about_by_rounding() -> None:
    """The time of Baumgarte's acceleration is a part of the run: 1e-12 s here."""
    result = find("crank_fast").machine().simulate(1e-9, correction="baumgarte", max_steps=1000)
    assert result.outcome is Outcome.OK, result.message
