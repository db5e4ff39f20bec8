"""A sweep goes on where it stopped, with the same bits; it refuses to be another one."""

import json
import shutil
import signal
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from codegen.termination_signals import SignalDeferral
from runtime import load_study, sweep
from runtime.sweeps import block, member_run, workers
from runtime.sweeps.block import BlockReport
from runtime.sweeps.execution import make_blocks
from runtime.sweeps.store import open_store, reopen
from runtime.sweeps.study import Study
from runtime.sweeps.sweep import store_lock
from runtime.sweeps.workers import LostWorkerError


def same(ours: Study, theirs: Study) -> bool:
    """Whether two studies have the same rows, bit for bit."""
    for name in (*ours.factors, *ours.quantities, *ours.series, "outcome", "message", "t_last"):
        first, second = (study.data[name].values for study in (ours, theirs))
        bits = (first.tobytes(), second.tobytes()) if first.dtype.kind == "f" else (first, second)
        if not np.all(bits[0] == bits[1]):
            return False
    return True


@pytest.fixture
def request_of(about: dict[str, Any]) -> dict[str, Any]:
    return {**about, "over": {"J1": "200:1000:24"}, "workers": 0}


@pytest.fixture
def half(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[Path, Study]:
    """A store in which some blocks are done, and the study of an undisturbed sweep."""
    whole = sweep(out=tmp_path / "whole.zarr", **request_of)
    real, count = workers.run_block, iter(range(100))

    def failing(job: Any, number: int) -> Any:
        if next(count) == 5:
            raise LinkwrightError("The cluster is lost.")
        return real(job, number)

    with monkeypatch.context() as patch:
        patch.setattr(workers, "run_block", failing)
        with pytest.raises(LinkwrightError) as caught:
            sweep(out=tmp_path / "half.zarr", **request_of)
    assert caught.value.problems[0] == "The cluster is lost."
    assert "5 of 8 blocks are done" in caught.value.problems[1]
    return tmp_path / "half.zarr", whole


def test_only_what_is_missing_is_made(
    half: tuple[Path, Study], request_of: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, whole = half
    before = load_study(path)
    assert not before.complete
    assert before.outcomes == {"OK": 15, "NOT RUN": 9}
    assert "Stopped before the end" in repr(before)
    real, made = workers.run_block, []
    monkeypatch.setattr(workers, "run_block", lambda job, k: made.append(k) or real(job, k))
    # no member is run for trial again
    monkeypatch.setattr("runtime.sweeps.sweep.estimate_of", None)
    after = sweep(out=path, resume=True, **request_of)
    assert made == [5, 6, 7]
    assert same(after, whole)
    assert sweep(out=path, resume=True, **request_of).complete
    assert len(made) == 3
    assert not path.with_name(f"{path.name}.working").exists()


def test_rows_that_a_crash_has_damaged_are_made_again(
    half: tuple[Path, Study], request_of: dict[str, Any]
) -> None:
    path, whole = half
    store = reopen(path, open_store(path).about["identity"])
    assert store.unfinished() == [5, 6, 7]
    store.group["max(B.fx)"][4] = 1.0
    assert store.unfinished() == [1, 5, 6, 7]
    shutil.rmtree(path / "message" / "c")
    assert store.unfinished() == [*range(8)]
    assert same(sweep(out=path, resume=True, **request_of), whole)


def test_nothing_is_overwritten(half: tuple[Path, Study], request_of: dict[str, Any]) -> None:
    path, _ = half
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    with pytest.raises(InputError, match="exists, and a sweep overwrites nothing"):
        sweep(out=path, **request_of)
    changes: dict[str, Any] = {
        "over": {"J1": "200:1000:25"}, "t_end": 0.06, "rtol": 1e-9, "keep": ["B.fx"],
        "scene": "compressor_massless_rod", "start": {"crank.omega": 20.0}, "points": 22,
        "quantities": ["max:A.fx"], "parameters": {"rod_length": 3.4}, "method": "tsit5",
    }  # fmt: skip
    names = ["the points", "t_end was 0.05 and is 0.06", "options, rtol was not given", "series",
             "the model: its generated module", "start, crank.omega", "instants was 21 and is 22",
             "quantities, max:A.fx", "parameters, rod_length", "options, method"]  # fmt: skip
    for (word, value), name in zip(changes.items(), names, strict=True):
        there = {"quantities": ["max:A.fx"]} if word == "scene" else {}  # a massless rod has no B
        with pytest.raises(InputError, match="it cannot go on") as caught:
            sweep(out=path, resume=True, **request_of | there | {word: value})
        assert name in str(caught.value)
    assert before == {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}


def test_a_changed_model_or_function_is_another_sweep(
    tmp_path: Path, about: dict[str, Any]
) -> None:
    def declared(mass: float) -> Model:
        model = Model("swept", gravity=(0, -9.81))
        bob = model.body("bob", mass=mass, inertia=0.1)
        model.revolute("hinge", model.ground.at(0, 0), bob.at(-model.parameter("l", 1.0), 0))
        model.scene("swing", start={bob.phi: 0.0, bob.omega: 0.0})
        return model

    common = {"over": {"l": [1.0, 2.0]}, "t_end": 0.1, "workers": 0, "folder": tmp_path}
    common |= {"out": "s.zarr", "resume": True, "progress": False}
    first = sweep(declared(1.0), quantities={"x": lambda r: r.t[-1]}, **common)
    assert sweep(declared(1.0), quantities={"x": lambda r: r.t[-1]}, **common).complete
    assert first.member(1).q("bob.x")[0] == pytest.approx(2.0)
    with pytest.raises(InputError, match="quantities, x was function"):
        sweep(declared(1.0), quantities={"x": lambda r: r.t[0]}, **common)
    with pytest.raises(InputError, match="the model: its generated module has another text"):
        sweep(declared(2.0), quantities={"x": lambda r: r.t[-1]}, **common)


def test_an_interrupt_keeps_what_is_done(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, count = workers.run_block, iter(range(100))

    def interrupted(job: Any, number: int) -> Any:
        if next(count) == 3:
            signal.raise_signal(signal.SIGINT)
        return real(job, number)

    with monkeypatch.context() as patch:
        patch.setattr(workers, "run_block", interrupted)
        study = sweep(out=tmp_path / "s.zarr", **request_of)
    assert not study.complete
    assert study.outcomes["OK"] in {9, 12}
    assert "Go on with the same request and --resume" in repr(study)
    whole = sweep(out=tmp_path / "whole.zarr", **request_of)
    assert same(sweep(out=tmp_path / "s.zarr", resume=True, **request_of), whole)


def test_a_store_of_which_another_sweep_is_writing(
    request_of: dict[str, Any], tmp_path: Path
) -> None:
    with (
        store_lock(tmp_path / "s.zarr"),
        pytest.raises(InputError, match="Another sweep is writing"),
    ):
        sweep(out=tmp_path / "s.zarr", **request_of)


def test_a_store_from_elsewhere_runs_nothing(half: tuple[Path, Study]) -> None:
    path, _ = half
    file = path / "t_last" / "zarr.json"
    about = json.loads(file.read_text())
    about["codecs"].append({"name": "numcodecs.pickle", "configuration": {}})
    file.write_text(json.dumps(about))
    with pytest.raises(InputError, match="pickle"):
        load_study(path)
    file.unlink()
    (path / "t_last" / ".zarray").write_text('{"zarr_format": 2}')
    with pytest.raises(InputError, match="format 2"):
        load_study(path)


def counted_runs(monkeypatch: pytest.MonkeyPatch, last: int = 10**6) -> list[float]:
    """The values of J1 of the runs that are made; an interrupt comes after so many."""
    real, made = member_run.run_member, list[float]()

    def run(machine: Any, request: Any, point: Any) -> Any:
        if len(made) == last:
            raise KeyboardInterrupt
        made.append(float(point[0]))
        return real(machine, request, point)

    monkeypatch.setattr(member_run, "run_member", run)
    return made


def test_no_run_is_made_twice(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        made = counted_runs(patch)
        whole = sweep(out=tmp_path / "s.zarr", **request_of)
    assert sorted(made) == whole.data["J1"].values.tolist()
    assert "24 runs in" in repr(whole)
    with monkeypatch.context() as patch:
        patch.setattr("runtime.sweeps.planning._MOST_BYTES", -1)
        made = counted_runs(patch)
        assert same(sweep(out=tmp_path / "t.zarr", **request_of), whole)
    assert len(made) == 24 + 5  # what was run beforehand is too much to go with the tasks


def test_a_block_of_slow_runs_goes_on_where_it_was(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = sweep(out=tmp_path / "whole.zarr", **request_of)
    monkeypatch.setattr(block, "SAVE_SECONDS", 0.0)
    monkeypatch.setattr("runtime.sweeps.sweep.BLOCKS_A_WORKER", 1)
    with monkeypatch.context() as patch:
        before = counted_runs(patch, last=12)
        half = sweep(out=tmp_path / "s.zarr", **request_of)
    assert half.outcomes == {"NOT RUN": 24}  # no block is whole
    assert not half.complete
    assert len(before) == 12
    with monkeypatch.context() as patch:
        after = counted_runs(patch)
        found = sweep(out=tmp_path / "s.zarr", resume=True, **request_of)
    assert same(found, whole)
    assert sorted(after + before)[1:-1] == pytest.approx(np.linspace(200, 1000, 24)[1:-1])
    assert not (found.path / "block_mark" / "parts").exists()


class Waiting:
    """Takes four blocks at a time, of which one is lost once."""

    room, lost = 4, LostWorkerError

    def __init__(self, stop_at: int = -1) -> None:
        self.taken, self.stop_at = list[int](), stop_at

    def submit(self, number: int) -> "Future[BlockReport]":
        future = Future[BlockReport]()
        if number == 7 and number not in self.taken:
            future.set_exception(LostWorkerError("killed"))
        else:
            future.set_result(BlockReport(number, 1, 1.0, 0.0))
        self.taken.append(number)
        if number == self.stop_at:
            signal.raise_signal(signal.SIGINT)
        return future

    def check(self) -> None:
        pass

    def close(self) -> None:
        pass


def test_blocks_are_handed_out_as_they_are_taken() -> None:
    counts, pool = list[int](), Waiting()
    with SignalDeferral(computing=True) as signals:
        made, lost = make_blocks(pool, [*range(5, 20)], signals, counts.append)
    assert sorted(one.block for one in made) == [*range(5, 20)]
    assert (len(pool.taken), lost, counts[-1]) == (16, 1, 15)
    pool = Waiting(stop_at=6)
    with SignalDeferral(computing=True) as signals:
        made, _ = make_blocks(pool, [*range(5, 20)], signals, counts.append)
        signals.answered = True
    assert pool.taken == [5, 6]
    assert len(made) < 3
