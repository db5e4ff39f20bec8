"""Work-precision studies: every setting at every tolerance, against closed forms and by counts."""

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.errors import InputError, LinkwrightError
from runtime import accuracy, load
from runtime.integrate.method import METHODS
from runtime.results.result import Result
from runtime.studies import harness
from runtime.studies.harness import FORMULATIONS, Runner, all_settings
from runtime.studies.pictures import draw_diagram
from runtime.studies.timing import time_runs
from runtime.studies.work_precision import Setting, WorkPrecision
from runtime.studies.work_precision.interpretation import best_at, sentences
from runtime.studies.work_precision.measurement import Measurement
from runtime.studies.work_precision.reference import find_reference
from runtime.studies.work_precision.study import FURTHER, RTOLS

SETTINGS = all_settings(METHODS, FORMULATIONS)


def silent(line: str) -> None:
    """Progress is not shown."""


def table(path: Path, names: Sequence[str], *columns: np.ndarray) -> Path:
    np.savetxt(
        path, np.column_stack(columns), delimiter=",", header=",".join(("t", *names)),
        comments="", fmt="%.17g",
    )  # fmt: skip
    return path


def exact(path: Path) -> Path:
    t = np.linspace(0.0, 2.0, 41)
    x, v = 0.5 * np.cos(5.0 * t), -2.5 * np.sin(5.0 * t)
    return table(path, ("body.x", "body.vx"), t, x, v)


def test_the_grid_is_that_of_the_definition() -> None:
    assert len(RTOLS) == 17
    assert_allclose((RTOLS[0], RTOLS[1], RTOLS[-1]), (1e-2, 10**-2.5, 1e-10))
    assert_allclose((FURTHER[0], FURTHER[-1]), (10**-10.5, 1e-12))


def test_every_setting_is_run_at_every_tolerance(swing: WorkPrecision) -> None:
    assert [line.setting for line in swing.lines] == list(SETTINGS)
    assert len(swing.lines) == 2 * len(METHODS) + 2
    assert [scale.name for scale in swing.quantities] == ["body.x", "body.vx"]
    for line in swing.lines:
        assert [point.rtol for point in line.points] == [1e-3, 1e-6, 1e-9]
        assert not line.refused
        worst = [point.errors.worst for point in line.done if point.errors]
        assert len(worst) == 3
        assert worst[0] > worst[1] > worst[2] > 0.0
        for point in line.points:
            assert point.counts["steps"] > 0
            assert point.counts["rhs_evaluations"] > point.counts["steps"]
            assert point.seconds > 0.0
            assert point.spread >= 1.0
            assert point.position_residual < 1e-12
            assert point.velocity_residual < 1e-12
            assert point.energy is not None
            assert point.errors is not None
            # |m v dv| and |k x dx| over m v²/2, with |dv| <= 5 E, |dx| <= 1.5 E and |x| <= 0.5
            assert point.energy <= (4.0 + 6.0) * point.errors.worst
    assert swing.energy == "start"
    work = [point.counts["rhs_evaluations"] for point in swing["dop853, cartesian"].points]
    assert work == sorted(work)
    radau = swing["radau5, reduced"].points[-1].counts
    assert radau["jacobians"] > 0
    assert radau["factorizations"] > 0
    assert radau["stage_iterations"] > 0


def test_self_made_reference_agrees_with_the_closed_form(
    swing: WorkPrecision, rig: str, folder: Path, tmp_path: Path, about: dict[str, Any]
) -> None:
    path = exact(tmp_path / "exact.csv")
    given = accuracy(rig, "swing", folder=folder, reference=path, **{**about, "t_end": None})
    assert given.reference.independent
    assert given.reference.source == str(path)
    assert (given.t_end, given.instants) == (2.0, 40)
    assert not swing.reference.independent
    assert swing.reference.floor < 1e-11
    assert given.reference.floor < 1e-11
    assert swing.reference.horizon is None
    assert all(check.error < 1e-10 for check in swing.reference.checks)
    floor = swing.reference.floor + given.reference.floor
    for one, other in zip(swing.lines, given.lines, strict=True):
        for here, there in zip(one.points, other.points, strict=True):
            assert here.errors is not None
            assert there.errors is not None
            assert abs(here.errors.worst - there.errors.worst) < 3.0 * floor + 1e-6 * here.rtol
            assert here.counts["steps"] == there.counts["steps"]


def test_a_reference_of_another_machine_is_seen(
    rig: str, folder: Path, tmp_path: Path, few: dict[str, Any]
) -> None:
    t = np.linspace(0.0, 2.0, 21)
    path = table(tmp_path / "other.csv", ("body.x",), t, 0.5 * np.cos(5.1 * t))
    found = accuracy(rig, "swing", folder=folder, reference=path, modelling=False, **few)
    assert found.reference.floor > 0.1
    assert found.reference.horizon is not None
    assert found.reference.horizon <= t[1]
    assert best_at(found, 1e-3) is None
    assert any("another machine" in line for line in sentences(found))


def test_other_models_are_compared_with_the_declared_scene(
    rig: str, folder: Path, few: dict[str, Any]
) -> None:
    found = accuracy(rig, "rubbing", folder=folder, **few)
    (choice,) = found.choices
    assert (choice.title, choice.kind) == ("rub as sticking", "friction")
    assert choice.point is not None
    assert choice.point.errors is not None
    assert found.energy == "reference"
    t = np.linspace(0.0, 2.0, 41)[1:]
    smooth, dry = (
        load(rig, scene, folder=folder).simulate(2.0, t, rtol=1e-11, method="dopri5")
        for scene in ("rubbing", "sticking")
    )
    x, v = smooth.q("body.x"), smooth.v("body.vx")
    by = {scale.name: scale.value for scale in found.quantities}
    worst = max(
        (np.abs(dry.q("body.x") - x) / (by["body.x"] + np.abs(x))).max(),
        (np.abs(dry.v("body.vx") - v) / (by["body.vx"] + np.abs(v))).max(),
    )
    assert 1e-6 < worst < 1e-1
    assert abs(choice.point.errors.worst - worst) < 0.11 * worst
    assert not any(line.refused for line in found.lines)
    assert any(line.startswith("rub as sticking keeps") for line in sentences(found))


def test_scenes_that_the_user_names_are_compared_too(
    rig: str, folder: Path, few: dict[str, Any]
) -> None:
    about = {**few, "modelling": False, "quantities": ("body.x|sled.x",)}
    found = accuracy(rig, "swing", folder=folder, beside=("rubbing", "swing"), **about)
    rubbing, itself = found.choices
    assert (rubbing.title, rubbing.kind, rubbing.scene) == ("rubbing", "scene", "rubbing")
    assert rubbing.point is not None
    assert 0.0 < rubbing.point.digits < 3.0
    assert itself.point is not None
    assert itself.point.digits > 7.0
    with pytest.raises(InputError, match="no scene 'rubbin'; did you mean 'rubbing'"):
        accuracy(rig, "swing", folder=folder, beside=("rubbin",), **about)


def test_formulations_that_a_scene_cannot_take_say_why(
    rig: str, folder: Path, about: dict[str, Any]
) -> None:
    one = {**about, "methods": ("dop853",), "modelling": False}
    found = accuracy(rig, "sticking", folder=folder, **one)
    refused = found["dop853, reduced"]
    assert not refused.points
    assert "rub" in refused.refused
    assert "creep=" in refused.refused
    assert len(found["dop853, cartesian"].done) == 3
    assert any(line.startswith("Not tried: dop853, reduced.") for line in sentences(found))
    labels = draw_diagram(found).axes[0].get_legend_handles_labels()[1]
    assert "dop853, reduced: refused" in labels


def test_failures_are_points(rig: str, folder: Path, few: dict[str, Any]) -> None:
    found = accuracy(rig, "swing", folder=folder, steps=60, modelling=False, **few)
    line = found["dopri5, cartesian"]
    assert [point.outcome for point in line.points] == ["OK", "OK", "MAX_STEPS"]
    assert line.failed == line.points[2:]
    assert all(math.isnan(point.digits) and point.errors is None for point in line.failed)
    assert all(point.seconds > 0.0 for point in line.failed)
    assert any(
        "dopri5, cartesian: 1 of 3 runs did not reach the end: MAX_STEPS" in text
        for text in sentences(found)
    )
    axes = draw_diagram(found).axes[0]
    assert axes.get_xlim()[0] < -1.0
    crosses = [entry for entry in axes.collections if len(entry.get_offsets()) == 1]
    assert any((entry.get_offsets()[:, 0] < 0.0).all() for entry in crosses)
    with pytest.raises(LinkwrightError, match="no run at rtol 1e-13 reaches t = 2 s"):
        accuracy(rig, "swing", folder=folder, steps=1, modelling=False, **few)


def test_a_scene_beside_whose_drivers_leave_no_freedom_is_tried(
    rig: str, folder: Path, few: dict[str, Any]
) -> None:
    found = accuracy(rig, "swing", folder=folder, beside=("driven",), modelling=False, **few)
    (driven,) = found.choices
    assert driven.point is not None
    assert driven.point.outcome == "OK"
    assert not driven.reason


def test_tolerances_go_on_until_nine_digits(rig: str, folder: Path) -> None:
    machine = load(rig, "swing", folder=folder)
    runner = Runner(machine, machine.assemble(), np.array([1.0, 2.0]), {}, 60.0, 10**6)
    reference = find_reference(runner, ("body.x",), None, silent, SETTINGS)
    measurement = Measurement(runner, reference, 2, 0.0, silent)
    (line,) = measurement.lines((Setting("dop853"),), (1e-2, 1e-3), (1e-6, 1e-11, 1e-12))
    assert [point.rtol for point in line.points] == [1e-2, 1e-3, 1e-6, 1e-11]
    worst = [point.errors.worst for point in line.points if point.errors]
    assert worst[2] > 1e-9 >= worst[3]


def test_the_limit_of_steps_leaves_the_check_for_crowding_on(
    rig: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A `max_steps` is a user's, and switches it off."""
    machine, given = load(rig, "swing", folder=folder), []
    real = harness.simulate

    def watched(*arguments: Any, **words: Any) -> Result:
        given.append(words)
        return real(*arguments, **words)

    monkeypatch.setattr(harness, "simulate", watched)
    runner = Runner(machine, machine.assemble(), np.array([1.0, 2.0]), {}, 60.0, 5)
    result = runner.run(Setting("dop853"), 1e-8)
    assert result.outcome.name == "MAX_STEPS"
    assert result.stats["steps"] <= 5
    assert "max_steps" not in given[0]


def test_after_two_timeouts_tighter_tolerances_are_not_tried(rig: str, folder: Path) -> None:
    machine = load(rig, "swing", folder=folder)
    instants = np.linspace(0.0, 200.0, 3)[1:]
    runner = Runner(machine, machine.assemble(), instants, {}, 60.0, 10**6)
    reference = find_reference(runner, ("body.x",), None, silent, SETTINGS)
    hasty = dataclasses.replace(runner, limit=1e-9)
    measurement = Measurement(hasty, reference, 2, 0.0, silent)
    (line,) = measurement.lines((Setting("dopri5"),), (1e-6, 1e-7, 1e-8, 1e-9), (1e-10,))
    assert [point.outcome for point in line.points] == ["TIMEOUT"] * 2 + ["NOT_TRIED"] * 2
    first = runner.run(Setting("dop853"), 1e-3)
    watch = runner.stopwatch(Setting("dop853"), 1e-3, first.stats["integration_seconds"])
    time_runs([watch], 4, 100.0)
    assert len(watch.times) == 30
    assert watch.seconds == min(watch.times)


def test_a_quantity_counts_once(rig: str, folder: Path, few: dict[str, Any]) -> None:
    names = ("body.x", "sled.x|body.x", "body.vx", "body.x")
    found = accuracy(rig, "swing", quantities=names, folder=folder, modelling=False, **few)
    assert [scale.name for scale in found.quantities] == ["body.x", "body.vx"]


def test_a_series_without_values_is_refused(
    rig: str, folder: Path, few: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Result.series

    def series(self: Result, name: str) -> tuple[np.ndarray, str]:
        values, unit = real(self, name)
        return (np.full_like(values, np.nan) if name == "guide.fy" else values), unit

    monkeypatch.setattr(Result, "series", series)
    about = {**few, "quantities": ("body.x", "guide.fy")}
    with pytest.raises(InputError, match=r"guide\.fy is no number at any of the 40") as caught:
        accuracy(rig, "swing", folder=folder, modelling=False, **about)
    assert len(caught.value.problems) == 1
