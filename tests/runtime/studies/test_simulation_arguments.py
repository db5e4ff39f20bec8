"""Studies hand the words of `simulate` to each of their runs."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import Path

import pytest

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime.integrate.simulation_options import OPTIONS
from runtime.machine_facade import Machine
from runtime.studies.effect_ranking import matters
from runtime.studies.harness import takes_simulation_arguments
from runtime.studies.work_precision import accuracy


@pytest.fixture(scope="module")
def pushed() -> Model:
    """A mass that a function of the user's own pushes, against a little air."""
    model = Model("worded")
    mass = model.particle("mass", 2.0)
    model.absolute("rail", mass, "y", 0.0)
    model.force("push", mass, fx=model.sampled("u", 0.1, unit="N"))
    model.force("air", mass, fx=-0.01 * mass.vx)
    model.force("breeze", mass, fx=1e-3)
    model.driver("drive", mass.x, 0.5)
    start = {mass.x: 0.0, mass.vx: 0.0}
    model.scene("runs", ["push", "air", "breeze"], start=start)
    model.scene("free", ["air", "breeze"], start={mass.x: 0.0, mass.vx: 1.0})
    model.scene("driven", ["air", "breeze"], ["drive"])
    return model


def constant(sample: object) -> float:
    return 4.0


def test_a_ranking_runs_with_functions_and_conditions(pushed: Model, tmp_path: Path) -> None:
    words = {"controllers": {"u": constant}, "until": {"far": ("mass.x", ">", 1.0)}}
    found = matters(
        pushed, "runs", asked="mass.vx", t_end=3.0, points=21, rounds=1, folder=tmp_path, **words
    )
    assert found["air"].value == pytest.approx((2 * 4.001 / 2) ** 0.5, rel=1e-8)  # v² = 2 a x
    assert found["push"].verdict == "needed"
    assert "goes on, where the full scene ends where 'far' begins to hold" in found["push"].reason


def test_a_limit_and_a_tolerance_reach_each_run(
    pushed: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen, real = [], Machine.simulate

    @wraps(real)
    def simulate(self: Machine, *given: object, **words: object) -> object:
        seen.append((words["rtol"], words.get("atol"), words.get("correction")))
        return real(self, *given, **words)

    monkeypatch.setattr(Machine, "simulate", simulate)
    matters(
        pushed, "free", asked="mass.x", t_end=1.0, points=11, rounds=1, folder=tmp_path,
        rtol=1e-9, atol=1e-10, correction="projection", fidelities=False,
    )  # fmt: skip
    assert {(round(rtol, 12), kind) for rtol, _, kind in seen} == {
        (1e-7, "projection"), (1e-9, "projection")
    }  # fmt: skip
    for rtol, atol, _ in seen:
        assert atol == pytest.approx(0.1 * rtol)


RANKED, DRIVEN = {"asked": "mass.x"}, {"asked": "drive.fx"}


@pytest.mark.parametrize(
    ("study", "scene", "words", "message"),
    [
        (matters, "free", {"atol": -1, **RANKED}, "atol is -1"),
        (matters, "free", {"max_steps": 1, **RANKED}, "steps"),
        (matters, "driven", {"max_step": 0.1, "atol": 1e-8, **DRIVEN},
         "inverse dynamics integrates nothing, so atol, max_step"),
        (accuracy, "free", {"until": {"far": ("mass.z", ">", 1.0)}}, r"no series 'mass\.z'"),
        (accuracy, "free", {"correction": "stage"}, "unexpected keyword argument 'correction'"),
    ],
)  # fmt: skip
def test_words_that_are_wrong_or_ignored(
    study: Callable[..., object], scene: str, words: dict[str, object], message: str,
    pushed: Model, tmp_path: Path,
) -> None:  # fmt: skip
    with pytest.raises(LinkwrightError, match=message) as caught:
        study(pushed, scene, t_end=1.0, folder=tmp_path, **words)
    assert isinstance(caught.value, InputError) or "max_steps" in words


def test_a_study_of_accuracy_with_functions_and_conditions(pushed: Model, tmp_path: Path) -> None:
    study = accuracy(
        pushed, "runs", t_end=3.0, quick=True, points=20, methods=("dop853", "dopri5"),
        formulations=("cartesian",), modelling=False, folder=tmp_path,
        controllers={"u": constant}, until={"far": ("mass.x", ">", 1.0)}, max_step=0.05,
    )  # fmt: skip
    assert [scale.name for scale in study.quantities][-1] == "t(far)"
    assert 0.9 < study.t_end < 1.1
    for line in study.lines:
        assert all(point.errors is not None for point in line.points)
        assert min(point.counts["steps"] for point in line.points) >= 19


def test_new_words_of_simulate_follow() -> None:
    def study(model: str, **run: object) -> None:
        """Nothing."""

    words = list(signature(takes_simulation_arguments("correction")(study)).parameters)
    assert words[0] == "model"
    assert {"atol", "controllers", "until", "max_bytes"} <= {*words}
    assert not {"correction", "t_end", "rtol", "progress", "run"} & {*words}


def test_options_are_the_words_of_simulate() -> None:
    words = dict(signature(Machine.simulate).parameters)
    for name in ("self", "parameters", "guess", "start", "controllers", "progress", "out"):
        del words[name]
    assert {*words} == {option.name for option in OPTIONS}
    shared = {option.name: option.default for option in OPTIONS if option.of_commands}
    assert shared == {name: words[name].default for name in shared}
