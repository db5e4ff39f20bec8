"""The modules that a work-precision study builds, and the time of each stage of building."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import LinkwrightError
from runtime import load
from runtime.mechanism.mechanism import Mechanism
from runtime.results.result import Result
from runtime.studies import work_precision
from runtime.studies.diagram import WorkPrecision
from runtime.studies.harness import Runner, Setting
from runtime.studies.reference import find_reference
from runtime.studies.work_precision import build_costs


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
    study: Callable[..., WorkPrecision], monkeypatch: pytest.MonkeyPatch,
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
    rig: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = load(rig, "swing", folder=folder)
    runner = Runner(machine, machine.assemble(), np.array([1.0, 2.0]), 60.0, 10**6)
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


def test_building_leaves_out_companions_that_no_setting_takes() -> None:
    found = build_costs(speck(), speck().scenes["fly"], ())
    assert list(found) == ["derive", "lower", "examine", "emit", "compile", "load, warm"]


@pytest.mark.slow
def test_building_is_timed_stage_by_stage() -> None:
    model = speck()
    found = build_costs(model, model.scenes["fly"])
    assert list(found) == [
        "derive", "lower", "examine", "emit", "compile", "differentiate", "compile derivatives",
        "reduce", "compile reduced", "load, warm",
    ]  # fmt: skip
    assert all(seconds > 0.0 for seconds in found.values())
    assert found["load, warm"] < found["compile"]
