"""Work-precision studies: every setting at every tolerance, against closed forms and by counts."""

import dataclasses
import math
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime import load
from runtime.dynamics.formulations import FORMULATIONS
from runtime.integrate.method import METHODS
from runtime.mechanism.mechanism import Mechanism
from runtime.results.result import Result
from runtime.studies import harness, work_precision
from runtime.studies.diagram import WorkPrecision, best_at
from runtime.studies.harness import Runner, Setting, all_settings
from runtime.studies.pictures import draw_diagram
from runtime.studies.reference import ReferenceSolution, find_reference
from runtime.studies.work_precision import FURTHER, RTOLS, Measurement, build_costs

SETTINGS = all_settings(METHODS, FORMULATIONS)
Study = Callable[..., WorkPrecision]


def table(path: Path, names: Sequence[str], *columns: np.ndarray) -> Path:
    np.savetxt(
        path, np.column_stack(columns), delimiter=",", header=",".join(("t", *names)),
        comments="", fmt="%.17g",
    )  # fmt: skip
    return path


@pytest.fixture(scope="module")
def runner(rig: str, folder: Path) -> Runner:
    machine = load(rig, "swing", folder=folder)
    return Runner(machine, machine.assemble(), np.array([1.0, 2.0]), 60.0, 10**6)


def reference_of(runner: Runner) -> ReferenceSolution:
    return find_reference(runner, ("body.x",), None, lambda line: None, SETTINGS)


def test_the_grid_is_that_of_the_definition() -> None:
    assert_allclose(RTOLS + FURTHER, np.logspace(-2.0, -12.0, 21))
    assert len(RTOLS) == 17


def test_every_setting_is_run_at_every_tolerance(swing: WorkPrecision) -> None:
    assert [line.setting for line in swing.lines] == list(SETTINGS)
    assert len(swing.lines) == 2 * len(METHODS) + 2
    assert [scale.name for scale in swing.quantities] == ["body.x", "body.vx"]
    for line in swing.lines:
        assert [point.rtol for point in line.points] == [1e-3, 1e-6, 1e-9]
        assert not line.refused
        worst = [point.worst for point in line.done]
        assert len(worst) == 3
        assert worst[0] > worst[1] > worst[2] > 0.0
        for point in line.points:
            assert point.counts["rhs_evaluations"] > point.counts["steps"] > 0
            assert point.seconds > 0.0
            assert point.spread >= 1.0
            assert max(point.position_residual, point.velocity_residual) < 1e-12
            # |m v dv| and |k x dx| over m v²/2, with |dv| <= 5 E, |dx| <= 1.5 E and |x| <= 0.5
            assert point.energy <= (4.0 + 6.0) * point.worst
    assert swing.energy == "start"
    work = [point.counts["rhs_evaluations"] for point in swing["dop853, cartesian"].points]
    assert work == sorted(work)
    radau = swing["radau5, reduced"].points[-1].counts
    assert min(radau[name] for name in ("jacobians", "factorizations", "stage_iterations")) > 0


def test_self_made_reference_agrees_with_the_closed_form(
    swing: WorkPrecision, study: Study, tmp_path: Path
) -> None:
    t = np.linspace(0.0, 2.0, 41)
    x, v = 0.5 * np.cos(5.0 * t), -2.5 * np.sin(5.0 * t)
    path = table(tmp_path / "exact.csv", ("body.x", "body.vx"), t, x, v)
    given = study(reference=path, t_end=None, methods=METHODS, formulations=FORMULATIONS)
    assert given.reference.independent
    assert given.reference.source == str(path)
    assert (given.t_end, given.instants) == (2.0, 40)
    assert not swing.reference.independent
    assert max(swing.reference.floor, given.reference.floor) < 1e-11
    assert swing.reference.horizon is None
    assert all(check.error < 1e-10 for check in swing.reference.checks)
    floor = swing.reference.floor + given.reference.floor
    for one, other in zip(swing.lines, given.lines, strict=True):
        for here, there in zip(one.points, other.points, strict=True):
            assert abs(here.worst - there.worst) < 3.0 * floor + 1e-6 * here.rtol
            assert here.counts["steps"] == there.counts["steps"]


def test_a_reference_of_another_machine_is_seen(study: Study, tmp_path: Path) -> None:
    t = np.linspace(0.0, 2.0, 21)
    path = table(tmp_path / "other.csv", ("body.x",), t, 0.5 * np.cos(5.1 * t))
    found = study(reference=path)
    assert found.reference.floor > 0.1
    assert found.reference.horizon <= t[1]
    assert best_at(found, 1e-3) is None
    assert any("another machine" in line for line in found.sentences())


def test_other_models_are_compared_with_the_declared_scene(
    study: Study, rig: str, folder: Path
) -> None:
    found = study("rubbing", modelling=True)
    (choice,) = found.choices
    assert (choice.title, choice.kind) == ("rub as sticking", "friction")
    assert found.energy == "reference"
    t = np.linspace(0.0, 2.0, 41)[1:]
    smooth, dry = (
        load(rig, scene, folder=folder).simulate(2.0, t, rtol=1e-11, method="dopri5")
        for scene in ("rubbing", "sticking")
    )
    worst = max(
        (np.abs(dry.series(by.name)[0] - r) / (by.value + np.abs(r))).max()
        for by in found.quantities
        for r in [smooth.series(by.name)[0]]
    )
    assert 1e-6 < worst < 1e-1
    assert abs(choice.point.worst - worst) < 0.11 * worst
    assert not any(line.refused for line in found.lines)
    assert any(line.startswith("rub as sticking keeps") for line in found.sentences())


def test_scenes_that_the_user_names_are_compared_too(study: Study) -> None:
    """Also one whose drivers leave no freedom."""
    about = {"quantities": ("body.x|sled.x",)}
    rubbing, itself, driven = study(beside=("rubbing", "swing", "driven"), **about).choices
    assert (rubbing.title, rubbing.kind, rubbing.scene) == ("rubbing", "scene", "rubbing")
    assert 0.0 < rubbing.point.digits < 3.0
    assert itself.point.digits > 7.0
    assert driven.point.outcome == "OK"
    assert not driven.reason
    with pytest.raises(InputError, match="no scene 'rubbin'; did you mean 'rubbing'"):
        study(beside=("rubbin",), **about)


def test_formulations_that_a_scene_cannot_take_say_why(study: Study) -> None:
    found = study("sticking", methods=("dop853",), formulations=FORMULATIONS)
    refused = found["dop853, reduced"]
    assert not refused.points
    assert "rub" in refused.refused
    assert "creep=" in refused.refused
    assert len(found["dop853, cartesian"].done) == 3
    assert any(line.startswith("Not tried: dop853, reduced.") for line in found.sentences())
    labels = draw_diagram(found).axes[0].get_legend_handles_labels()[1]
    assert "dop853, reduced: refused" in labels


def test_failures_are_points(study: Study) -> None:
    found = study(steps=60)
    line = found["dopri5, cartesian"]
    assert [point.outcome for point in line.points] == ["OK", "OK", "MAX_STEPS"]
    (failed,) = line.failed
    assert failed is line.points[2]
    assert math.isnan(failed.digits)
    assert failed.seconds > 0.0
    assert any(
        "dopri5, cartesian: 1 of 3 runs did not reach the end: MAX_STEPS" in text
        for text in found.sentences()
    )
    axes = draw_diagram(found).axes[0]
    assert axes.get_xlim()[0] < -1.0
    crosses = [entry for entry in axes.collections if len(entry.get_offsets()) == 1]
    assert any((entry.get_offsets()[:, 0] < 0.0).all() for entry in crosses)
    with pytest.raises(LinkwrightError, match="no run at rtol 1e-13 reaches t = 2 s"):
        study(steps=1)


def test_tolerances_go_on_until_nine_digits(runner: Runner) -> None:
    measurement = Measurement(runner, reference_of(runner), 2, 0.0, lambda line: None)
    (line,) = measurement.lines((Setting("dop853"),), (1e-2, 1e-3), (1e-6, 1e-11, 1e-12))
    assert [point.rtol for point in line.points] == [1e-2, 1e-3, 1e-6, 1e-11]
    worst = [point.worst for point in line.points]
    assert worst[2] > 1e-9 >= worst[3]


def test_the_limit_of_steps_leaves_the_check_for_crowding_on(
    runner: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A `max_steps` is a user's, and switches it off."""
    given, real = {}, harness.simulate
    monkeypatch.setattr(
        harness, "simulate", lambda *some, **words: given.update(words) or real(*some, **words)
    )
    result = dataclasses.replace(runner, steps=5).run(Setting("dop853"), 1e-8)
    assert result.outcome.name == "MAX_STEPS"
    assert result.stats["steps"] <= 5
    assert "max_steps" not in given


def test_after_two_timeouts_tighter_tolerances_are_not_tried(runner: Runner) -> None:
    runner = dataclasses.replace(runner, instants=np.linspace(0.0, 200.0, 3)[1:])
    hasty = dataclasses.replace(runner, limit=1e-9)
    measurement = Measurement(hasty, reference_of(runner), 2, 0.0, lambda line: None)
    (line,) = measurement.lines((Setting("dopri5"),), (1e-6, 1e-7, 1e-8, 1e-9), (1e-10,))
    assert [point.outcome for point in line.points] == ["TIMEOUT"] * 2 + ["NOT_TRIED"] * 2


def test_a_quantity_counts_once(study: Study) -> None:
    names = ("body.x", "sled.x|body.x", "body.vx", "body.x")
    found = study(quantities=names)
    assert [scale.name for scale in found.quantities] == ["body.x", "body.vx"]


def test_a_series_without_values_is_refused(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    real = Result.series

    def series(self: Result, name: str) -> tuple[np.ndarray, str]:
        values, unit = real(self, name)
        return (np.full_like(values, np.nan) if name == "guide.fy" else values), unit

    monkeypatch.setattr(Result, "series", series)
    with pytest.raises(InputError, match=r"guide\.fy is no number at any of the 40") as caught:
        study(quantities=("body.x", "guide.fy"))
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    ("scene", "options", "message"),
    [
        ("swing", {"quantities": ("body.fi",)}, "There is no series 'body.fi'; nearest: body.phi"),
        ("swing", {"quantities": ("a.x|b.x",)}, "There is no series 'a.x'"),
        ("swing", {"quantities": "body.x"}, "quantities is 'body.x'; it must be a sequence"),
        ("swing", {"methods": "dop853"}, "methods is 'dop853'; it must be a sequence"),
        ("swing", {"formulations": "reduced"}, "formulations is 'reduced'; it must be a sequence"),
        ("swing", {"beside": "rubbing"}, "beside is 'rubbing'; it must be a sequence"),
        ("swing", {"t_end": None}, "t_end is missing"),
        ("swing", {"t_end": -1.0}, "from 0 to -1 s must be finite and positive"),
        ("swing", {"methods": ("dop85",)}, "There is no method 'dop85'; nearest: dop853"),
        ("swing", {"methods": ()}, "there is no method to try"),
        ("swing", {"rtols": []}, "rtols is []; there is no tolerance to try; name one"),
        ("swing", {"formulations": ("polar",)}, "There is no formulation 'polar'"),
        ("swing", {"rtols": (1e-14,)}, "rtols is (1e-14,); it must be numbers from 1e-12 to 0.1"),
        ("swing", {"points": 1}, "points is 1; it must be a whole number from 2"),
        ("swing", {"limit": 0.0}, "limit is 0.0; it must be a positive time"),
        ("swing", {"steps": 0}, "steps is 0; it must be a whole number from 1"),
        ("swing", {"parameters": {"zz": 1.0}}, "There is no parameter 'zz'"),
        ("swong", {}, "no scene 'swong'; did you mean 'swing'"),
        ("driven", {}, "drivers leave no freedom, so nothing is integrated"),
        ("drawn", {}, "there is nothing to integrate"),
    ],
)
def test_wrong_input_is_refused(
    scene: str, options: dict[str, Any], message: str, study: Study
) -> None:
    with pytest.raises(InputError) as caught:
        study(scene, **options)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("t,body.x\n0,0.5\n1,0.2\n2,0.1\n", {"quantities": ("body.vx",)}, "no column body.vx"),
        ("time, body.x\n1,0.2\n2,0.1\n", {}, "there is no column t; it has time, body.x"),
        ("t,body.xx\n1,0.2\n2,0.1\n", {}, "There is no series 'body.xx'; nearest: body.x"),
        ("# a run\nt,body.x\n1,0.2\n2,oops\n", {}, "the 2. line of numbers is 2, oops"),
        ("t,body.x\n1,0.2\n2\n", {}, "the 2. line of numbers is 2"),
        ("t,body.x\n2,0.2\n1,0.1\n", {}, "each later than the one before"),
        ("t,body.x\n1,0.2\n2,0.1\n", {"t_end": 3.0}, "it ends at t = 2 s, before 3 s"),
        ("t\n1\n2\n", {}, "there is no column beside t"),
        ("", {}, "reference.csv: cannot be read: No columns"),
        (None, {}, "reference.csv: cannot be read: "),
    ],
)
def test_unusable_reference_files_are_refused(
    text: str | None, options: dict[str, Any], message: str, study: Study, tmp_path: Path
) -> None:
    path = tmp_path / "reference.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        study(**{"t_end": None, "reference": path, **options})
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("methods", "formulations", "built"),
    [
        (("dop853", "dopri5"), ("cartesian",), set()),
        (("dop853",), ("reduced",), {"reduced"}),
        (("dop853", "radau5"), ("cartesian",), {"tangents"}),
    ],
)
def test_nothing_is_built_that_no_setting_takes(
    methods: tuple[str, ...], formulations: tuple[str, ...], built: set[str],
    study: Study, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    loaded: list[str] = []
    timed: list[Collection[str]] = []
    real = Mechanism.companion

    def companion(machine: Any, kind: Any) -> Any:
        loaded.append(kind)
        return real(machine, kind)

    monkeypatch.setattr(Mechanism, "companion", companion)
    monkeypatch.setattr(work_precision, "build_costs", lambda *given: timed.append(given[2]) or {})
    found = study(building=True, methods=methods, formulations=formulations)
    assert set(loaded) == built
    assert {kind for kind in timed[0] if kind} == built
    assert found.reference.floor < 1e-11
    assert found.reference.checks


def test_derivatives_are_built_where_nothing_else_confirms(
    runner: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Runner.run

    def run(self: Runner, setting: Setting, rtol: float) -> Result:
        if setting.method == "dopri5":
            raise LinkwrightError("too stiff")
        return real(self, setting, rtol)

    monkeypatch.setattr(Runner, "run", run)
    about = find_reference(runner, ("body.x",), None, lambda line: None, (Setting("dop853"),)).about
    assert about.source == "dop853, cartesian, rtol 1e-13"
    assert [check.title for check in about.checks] == ["radau5, cartesian, rtol 1e-13"]


def speck() -> Model:
    model = Model("speck")
    ball = model.particle("ball", mass=1.0)
    model.force("wind", on=ball, fx=1.0)
    model.scene("fly", ["wind"], start={ball.x: 0.0, ball.vx: 0.0})
    return model


COMPANIONS = ["differentiate", "compile derivatives", "reduce", "compile reduced"]


@pytest.mark.parametrize(
    ("companions", "stages"),
    [((), []), pytest.param(("tangents", "reduced"), COMPANIONS, marks=pytest.mark.slow)],
)
def test_building_is_timed_stage_by_stage(companions: tuple[str], stages: list[str]) -> None:
    """Companions that no setting takes are left out."""
    model = speck()
    found = build_costs(model, model.scenes["fly"], companions)
    assert [*found] == ["derive", "examine", "lower", "emit", "compile", *stages, "load, warm"]
    assert all(seconds > 0.0 for seconds in found.values())
    assert found["load, warm"] < found["compile"]
