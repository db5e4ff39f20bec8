"""What studies share: words of `simulate` for each of their runs, times of runs, quantities."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime.integrate.simulation_options import OPTIONS
from runtime.machine_facade import Machine
from runtime.studies import harness
from runtime.studies.effect_ranking import matters
from runtime.studies.harness import TimeLimit, processor_time, time_runs, time_to_error
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

    words = list(signature(harness.takes_simulation_arguments("correction")(study)).parameters)
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


def test_runs_take_turns_and_one_that_is_cut_short_ends() -> None:
    order: list[str] = []

    def run(name: str) -> float | None:
        order.append(name)
        return None if order.count("b") == 2 and name == "b" else float(len(order))

    runs = [lambda name=name: run(name) for name in "abc"]
    times = time_runs(runs, [0.5] * 3, 3, 0.6)
    assert order == list("abcabc")
    assert times == [[1.0, 4.0], [2.0], [3.0, 6.0]]
    assert time_runs([lambda: None], [0.2], 5, 1.0) == [[0.2]]


@pytest.mark.parametrize(
    ("took", "first", "rounds", "least", "count"),
    [
        (0.5, 0.5, 5, 1.0, 5),
        (0.01, 0.01, 5, 1.0, 30),
        (2.0, 2.0, 5, 1.0, 2),
        (2.0, 2.0, 3, 0.0, 3),
        (0.1, float("nan"), 3, 0.0, 3),
    ],
)
def test_runs_are_repeated_for_a_time(
    took: float, first: float, rounds: int, least: float, count: int
) -> None:
    assert time_runs([lambda: took], [first], rounds, least) == [[took] * count]


def test_a_time_limit_counts_from_the_first_sign_of_life() -> None:
    limit = TimeLimit(0.0)
    limit(0.0)
    assert not limit.exceeded
    with pytest.raises(KeyboardInterrupt):
        limit(0.5)
    assert limit.exceeded
    answer, seconds = processor_time(lambda: sum(range(1000)))
    assert answer == 499500
    assert seconds >= 0.0


@pytest.mark.parametrize(("error", "seconds"), [(1e-3, 2.0), (0.1, 1.0), (1e-5, np.inf)])
def test_times_to_an_error_lie_on_lines_in_logarithms(error: float, seconds: float) -> None:
    assert time_to_error([(1e-2, 1.0), (1e-4, 4.0)], error) == pytest.approx(seconds)
    assert time_to_error([], error) == np.inf


def test_a_library_without_metadata_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(harness, "LIBRARIES", ("numpy", "no-such-library"))
    facts = harness.environment()
    assert facts["numpy"] == np.__version__
    assert "no-such-library" not in facts
