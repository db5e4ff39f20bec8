"""A sweep goes on where it stopped, with the same bits; it refuses to be another one."""

import json
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime import load_study, sweep
from runtime.sweeps import Study, block, block_parts, execution, member_run, run_sweep, store
from runtime.sweeps.block import BlockReport
from runtime.sweeps.store_attributes import Layout


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
    real, count = block.run_block, iter(range(100))

    def failing(job: Any, number: int) -> Any:
        if next(count) == 5:
            raise LinkwrightError("The cluster is lost.")
        return real(job, number)

    with monkeypatch.context() as patch:
        patch.setattr(block, "run_block", failing)
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
    real, made = block.run_block, []
    monkeypatch.setattr(block, "run_block", lambda job, k: made.append(k) or real(job, k))
    monkeypatch.setattr(run_sweep, "estimate_of", None)  # no member is run for trial again
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
    group = store.open_group(path, writable=True)
    assert store.unfinished(group) == [5, 6, 7]
    group["max(B.fx)"][4] = 1.0
    shutil.rmtree(path / "message" / "c")
    assert store.unfinished(group) == [*range(8)]
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
    real, count = block.run_block, iter(range(100))

    def interrupted(job: Any, number: int) -> Any:
        if next(count) == 3:
            signal.raise_signal(signal.SIGINT)
        return real(job, number)

    with monkeypatch.context() as patch:
        patch.setattr(block, "run_block", interrupted)
        study = sweep(out=tmp_path / "s.zarr", **request_of)
    assert not study.complete
    assert study.outcomes["OK"] in {9, 12}
    assert "Go on with the same request and --resume" in repr(study)
    whole = sweep(out=tmp_path / "whole.zarr", **request_of)
    assert same(sweep(out=tmp_path / "s.zarr", resume=True, **request_of), whole)


def test_a_store_of_which_another_sweep_is_writing(
    request_of: dict[str, Any], tmp_path: Path
) -> None:
    from runtime.sweeps.execution import store_lock

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
    monkeypatch.setattr(execution, "BLOCKS_A_WORKER", 1)
    with monkeypatch.context() as patch:
        before = counted_runs(patch, last=12)
        real = execution.ThisProcess.next

        def stopped(self: Any, timeout: float) -> Any:
            report = real(self, timeout)
            if report is None:
                signal.raise_signal(signal.SIGINT)
            return report

        patch.setattr(execution.ThisProcess, "next", stopped)
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


def test_rows_of_another_process_are_not_replaced_by_fewer(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A task that lives on after its block was given to another one."""
    jobs: list[Any] = []
    real = block.run_block
    with monkeypatch.context() as patch:
        patch.setattr(block, "run_block", lambda job, k: jobs.append(job) or real(job, k))
        whole = sweep(out=tmp_path / "s.zarr", **request_of)
    group = store.open_group(whole.path, writable=True)
    group["block_mark"][2] = 0
    counts = list[tuple[str, int]]()
    evaluate, write, save = block.evaluate_member, store.write_block, block_parts.write_part

    def other(machine: Any, request: Any, point: Any) -> Any:
        if not counts:
            counts.append(("begun", 0))
            real_block(jobs[0], 2)
        return evaluate(machine, request, point)

    def counted(path: Path, identity: str, request: Any, runs: range, rows: Any) -> int:
        counts.append(("block", len(rows)))
        return write(path, identity, request, runs, rows)

    def saved(path: Path, about: Any, request: Any, number: int, rows: Any) -> None:
        counts.append(("part", len(rows)))
        save(path, about, request, number, rows)

    real_block = block._run_block
    monkeypatch.setattr(block, "SAVE_SECONDS", 0.0)
    monkeypatch.setattr(block, "evaluate_member", other)
    monkeypatch.setattr(store, "write_block", counted)
    monkeypatch.setattr(block_parts, "write_part", saved)
    block._run_block(jobs[0], 2)
    theirs = [("part", 1), ("part", 2), ("block", 3)]
    assert counts == [("begun", 0), *theirs, ("part", 3), ("block", 3)]


class Waiting:
    """Takes four blocks at a time."""

    replaced = 0

    def __init__(self, stop_at: int = -1) -> None:
        self.there, self.taken, self.most, self.stop_at = list[int](), 0, 0, stop_at

    @property
    def room(self) -> int:
        return 4 - len(self.there)

    def submit(self, number: int) -> None:
        self.there.append(number)
        self.taken, self.most = self.taken + 1, max(self.most, len(self.there))
        if number == self.stop_at:
            signal.raise_signal(signal.SIGINT)

    def next(self, timeout: float) -> BlockReport:
        return BlockReport(self.there.pop(0), 1, 1.0, 0.0)

    def close(self) -> None:
        self.there.clear()


def test_tasks_are_handed_out_as_they_are_taken() -> None:
    from codegen.termination_signals import SignalDeferral

    shares, executor, layout = list[float](), Waiting(), Layout(20, 1)
    with SignalDeferral(computing=True) as signals:
        made = execution._make(executor, [*range(5, 20)], layout, signals, shares.append)
    assert [one.block for one in made] == [*range(5, 20)]
    assert (executor.taken, executor.most, shares[-1]) == (15, 4, 1.0)
    executor = Waiting(stop_at=6)
    with SignalDeferral(computing=True) as signals:
        made = execution._make(executor, [*range(5, 20)], layout, signals, shares.append)
        signals.answered = True
    assert (executor.taken, made) == (2, [])
