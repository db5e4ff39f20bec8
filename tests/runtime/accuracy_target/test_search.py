"""Simulations with an accuracy target: errors, messages, records, refusals."""

import csv
import dataclasses
import json
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from codegen.errors import InputError
from linkwright.cli.analyses import summary
from linkwright.cli.application import app
from models.hard.suite.linkages import crank_angle
from runtime.accuracy_target.run_comparison import difference, is_resolved
from runtime.accuracy_target.runs import Quantities
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from runtime.results.run_records import ReachedAccuracy
from runtime.show.html_report import page

TARGETS = (1e-3, 1e-5, 1e-7, 1e-9)


@pytest.fixture(scope="module")
def compressor(library: Callable[[str, str], Machine]) -> Machine:
    machine = library("slider_crank", "compressor")
    assert machine.mechanism.reduced.kept.size  # built, so that the program may choose it
    return machine


@pytest.fixture(scope="module")
def accurate(compressor: Machine) -> Result:
    """A second of the compressor, J = 450 kg m²."""
    return compressor.simulate(
        1.0, np.linspace(0.0, 1.0, 101), accuracy=1e-7, parameters={"J1": 450.0}, progress=False
    )


def reached(machine: Machine, t_end: float, accuracy: float, **words: Any) -> ReachedAccuracy:
    return machine.simulate(t_end, accuracy=accuracy, progress=False, **words).accuracy


def reference(root: Path, name: str) -> dict[str, np.ndarray]:
    with (root / "tests" / "data" / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


# Accuracy that is reached


@pytest.mark.parametrize("target", TARGETS)
def test_the_true_error_is_below_the_target(root: Path, compressor: Machine, target: float) -> None:
    exact = reference(root, "compressor_J450")
    run = compressor.simulate(
        exact["t"][-1], exact["t"], accuracy=target, parameters={"J1": 450.0}, progress=False
    )
    found = run.accuracy
    assert run.outcome is Outcome.OK
    assert (found.reached, found.horizon) == (True, None)
    sizes = {row.name: row.scale for row in found.quantities}
    pairs = (("crank.phi", "phi1"), ("crank.omega", "omega"), ("slider.x", "x3"))
    for name, column in (*pairs, ("slider.vx", "x3d")):
        error = np.abs(run.series(name)[0] - exact[column])
        assert (error / (sizes[name] + np.abs(exact[column]))).max() <= target
    assert found.estimated <= target
    assert found.estimated == max(row.error for row in found.quantities)


@pytest.mark.parametrize("target", TARGETS)
def test_a_target_takes_two_or_three_runs(compressor: Machine, target: float) -> None:
    found = reached(compressor, 1.0, target)
    assert len(found.runs) in {2, 3}
    rtols = [run.rtol for run in found.runs]
    assert rtols == sorted(rtols, reverse=True)
    assert found.runs[0].difference is None
    last = found.runs[-1]
    settings = attrgetter("method", "formulation", "rtol")
    assert settings(found) == settings(last)
    assert sum(run.evaluations for run in found.runs) <= 3 * last.evaluations


def test_the_second_run_is_much_tighter(library: Callable[[str, str], Machine]) -> None:
    """So that the scatter of both errors is small beside their ratio."""
    chain = library("hard/spring_chain", "struck")
    run = chain.simulate(20.0, accuracy=1e-9, method="dop853", progress=False)
    found = run.accuracy
    first, second, *_ = found.runs
    assert second.rtol <= 1.01e-3 * first.rtol
    assert second.evaluations < 3 * first.evaluations
    last = found.runs[-1]
    assert found.estimated < last.difference
    again = chain.simulate(20.0, run.t, rtol=found.rtol, progress=False)
    np.testing.assert_array_equal(again.samples.q, run.samples.q)
    assert f"between rtol = {found.runs[-2].rtol:.1e} and {found.rtol:.1e}" in found.means
    assert f"this one {last.seconds * 1e3:.3g} ms" in found.sentences()[2]


def test_a_vibration_that_the_looser_run_loses_is_not_resolved() -> None:
    t = np.linspace(0.0, 1.0, 101)
    trembling = 0.01 * np.sin(40.0 * t)[:, None]
    quantities = Quantities(("rod.y",), np.array([1.0]), np.array([1]))
    for lost, resolved in ((1.0, False), (0.05, True)):
        found = difference(t, (1.0 - lost) * trembling, trembling, quantities)
        assert is_resolved(found, trembling, 1e-4) is resolved
        assert is_resolved(found, trembling, 0.02)  # more than all of it


def test_what_stands_still_in_the_tighter_run_is_resolved() -> None:
    """A body that never turns: the looser run's error is no motion that it lost."""
    t = np.linspace(0.0, 1.0, 101)
    quantities = Quantities(("coupler.phi",), np.array([1.0]), np.array([0]))
    noise = 1e-9 * np.sin(40.0 * t)[:, None]
    found = difference(t, 1e-6 * np.sin(3.0 * t)[:, None], noise, quantities)
    assert is_resolved(found, noise, 1e-8)
    assert not is_resolved(difference(t, -noise, noise, quantities), noise, 1e-10)


def test_built_companions_are_taken_and_given_settings_are_kept(
    compressor: Machine, accurate: Result
) -> None:
    assert {run.formulation for run in accurate.accuracy.runs} == {"reduced"}
    fixed = reached(compressor, 0.2, 1e-5, method="dopri5", formulation="cartesian")
    assert {(run.method, run.formulation) for run in fixed.runs} == {("dopri5", "cartesian")}


def test_the_error_of_any_series_can_be_the_target(compressor: Machine) -> None:
    names = ("slider.x", "B.fx", "total")
    found = reached(compressor, 0.5, 1e-6, quantities=names)
    assert {row.name for row in found.quantities} == set(names)
    sizes = {row.name: row.scale for row in found.quantities}
    assert sizes["slider.x"] < 10.0
    assert sizes["B.fx"] > 1e3


def test_a_dead_centre_is_passed_by_the_reduced_runs(
    library: Callable[[str, str], Machine],
) -> None:
    machine = library("hard/n_four_bar", "fall")
    assert machine.mechanism.reduced.branches
    run = machine.simulate(1.0, accuracy=1e-5, progress=False)
    assert run.outcome is Outcome.OK
    assert run.singular
    assert {row.formulation for row in run.accuracy.runs} == {"reduced"}
    assert run.accuracy.runs[0].outcome == "OK"


@pytest.mark.parametrize("target", [1e-8, 1e-9])
def test_a_target_just_above_rounding_is_met(
    library: Callable[[str, str], Machine], target: float
) -> None:
    """Runs through six dead centres, which are right to 1e-9 from 3e-13 on, and not at 1e-14."""
    t = np.linspace(0.0, 10.0, 101)
    run = library("hard/n_four_bar", "fall").simulate(
        10.0, t, accuracy=target, formulation="cartesian", progress=False
    )
    assert run.outcome is Outcome.OK, run.message
    exact = crank_angle(2, t)
    assert np.max(np.abs(run.q("crank_0.phi") - exact) / (1.0 + np.abs(exact))) <= target


# Accuracy that cannot be reached


def test_a_chaotic_motion_ends_at_its_horizon(root: Path, thrown: Machine) -> None:
    exact = reference(root, "double_pendulum")
    t = np.linspace(0.0, 30.0, 601)
    run = thrown.simulate(30.0, t, accuracy=1e-6, progress=False)
    found = run.accuracy
    assert run.outcome is Outcome.INACCURATE
    assert found.chaotic
    assert found.horizon == run.t[-1]
    assert 12.0 < found.horizon < 25.0
    assert 1.5 < found.tenfold < 5.0
    assert all(event.time <= found.horizon for event in run.events)
    assert "errors grow tenfold every" in run.message.lower()
    common, ours, theirs = np.intersect1d(run.t, exact["t"], return_indices=True)
    assert len(common) >= 20
    for name, column in (("upper.phi", "phi1"), ("lower.phi", "phi2"), ("lower.omega", "omega2")):
        expected = exact[column][theirs]
        error = np.abs(run.series(name)[0][ours] - expected) / (1.0 + np.abs(expected))
        assert error.max() <= 1e-6
    shorter = thrown.simulate(4.0, accuracy=1e-6, progress=False)
    assert shorter.outcome is Outcome.OK


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"accuracy": 1e-6, "rtol": 1e-8}, "accuracy = 1e-06 and rtol = 1e-08 are both given"),
        ({"accuracy": 1e-6, "atol": 1e-8}, "accuracy = 1e-06 and atol = 1e-08 are both given"),
        ({"accuracy": 1e-14}, "accuracy = 1e-14 must lie between 1e-12"),
        ({"accuracy": 0.5}, "and 0.1"),
        ({"accuracy": "fine"}, "accuracy is 'fine'; it must be a positive finite number"),
        ({"quantities": ("upper.phi",)}, "give the error too, accuracy=1e-6"),
        ({"accuracy": 1e-6, "quantities": "upper.phi"}, "it must be a sequence of names"),
        ({"accuracy": 1e-6, "quantities": ("upper.fi",)}, "There is no series 'upper.fi'"),
        ({"accuracy": 1e-6, "method": "foo"}, "method 'foo' is none of the methods"),
    ],
)
def test_invalid_targets_are_refused(
    thrown: Machine, given: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError) as caught:
        thrown.simulate(1.0, progress=False, **given)
    assert message in str(caught.value)


def test_a_series_without_values_is_refused(
    thrown: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Result.series

    def series(self: Result, name: str) -> tuple[np.ndarray, str]:
        values, unit = real(self, name)
        return (np.full_like(values, np.nan) if name == "knee.fx" else values), unit

    monkeypatch.setattr(Result, "series", series)
    names = ("upper.phi", "knee.fx", "hinge.fx")
    with pytest.raises(InputError) as caught:
        thrown.simulate(0.5, accuracy=1e-4, quantities=names, progress=False)
    (problem,) = caught.value.problems
    assert "knee.fx is no number at any of the 501 output instants" in problem


def test_a_quantity_counts_once(thrown: Machine) -> None:
    names = ("upper.phi", "hinge.fx", "upper.phi")
    found = reached(thrown, 0.5, 1e-4, quantities=names)
    assert sorted(row.name for row in found.quantities) == ["hinge.fx", "upper.phi"]


# Records


def test_the_accuracy_is_kept_with_the_result(accurate: Result, tmp_path: Path) -> None:
    found = accurate.accuracy
    facts = json.loads(json.dumps(found.facts(), allow_nan=False))
    assert json.loads(accurate.about()["accuracy"]) == facts
    assert summary(accurate, None)["accuracy"] == found.facts()
    assert facts["reached"] is True
    assert len(facts["quantities"]) == 2 * len(accurate.description.coordinates)
    assert found.means in page(accurate).replace("&#x27;", "'")
    assert f"target {found.asked:.1e}" in accurate.message
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.asked = 1.0


def test_a_run_with_tolerances_has_no_accuracy(compressor: Machine) -> None:
    plain = compressor.simulate(0.1, progress=False)
    assert plain.accuracy is None
    assert "accuracy" not in plain.about()
    assert "accuracy" not in summary(plain, None)
    assert "<h2>Accuracy</h2>" not in page(plain)


def test_command_line(thrown: Machine, workshop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(workshop)
    command = ["simulate", "library_double_pendulum", "--t-end", "2", "--accuracy", "1e-6"]
    done = CliRunner().invoke(app, [*command, "--quantity", "upper.phi", "--json"])
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)["accuracy"]
    assert [row["name"] for row in found["quantities"]] == ["upper.phi"]
    assert "Estimated from the difference of two runs" in done.stderr
    assert "Cost: " in done.stderr
    done = CliRunner().invoke(app, [*command, "--rtol", "1e-8"])
    assert done.exit_code == 2
    assert "Leave one of them out" in done.stderr
