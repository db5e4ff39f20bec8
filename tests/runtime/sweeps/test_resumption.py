"""A sweep goes on where it stopped, with the same bits; it refuses to be another one."""

import functools
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime import load, load_study, sweep
from runtime.core.outcomes import Outcome
from runtime.sweeps import request
from runtime.sweeps import sweep as in_sweep
from runtime.sweeps.execution import _load_job, pickled_job, run_job
from runtime.sweeps.request import KILLED, rows_without_runs
from runtime.sweeps.store import Store, open_store, store_lock, tasks_of
from runtime.sweeps.study import Study
from tests.runtime.sweeps.conftest import GRID, same


def counted_runs(monkeypatch: pytest.MonkeyPatch, last: int = -1) -> list[float]:
    """The values of J1 of the runs that are made; Ctrl-C comes in the run after so many."""
    real, made = request.run_member, list[float]()

    def run(machine: Any, asked: Any, point: Any) -> Any:
        if len(made) == last:
            signal.raise_signal(signal.SIGINT)
        made.append(float(point[0]))
        return real(machine, asked, point)

    monkeypatch.setattr(request, "run_member", run)
    return made


@pytest.mark.parametrize("chunks", [10_000, 2])  # of a task each, or of several
def test_an_interrupt_keeps_what_is_done(
    request_of: dict[str, Any], whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    chunks: int,
) -> None:  # fmt: skip
    monkeypatch.setattr("runtime.sweeps.store.MOST_CHUNKS", chunks)
    with monkeypatch.context() as patch:
        before = counted_runs(patch, last=12)
        half = sweep(out=tmp_path / "s.zarr", **request_of)
    assert not half.complete
    assert len(before) - 1 <= half.outcomes["OK"] <= len(before) <= 15
    assert "Go on with the same request and --resume" in repr(half)
    assert load_study(half.path).outcomes == half.outcomes
    with monkeypatch.context() as patch:
        after = counted_runs(patch)
        found = sweep(out=half.path, resume=True, **request_of)
        assert sweep(out=half.path, resume=True, **request_of).complete
    assert len(after) == half.outcomes["NOT RUN"]
    assert same(found, whole)


def test_no_run_is_made_twice(
    request_of: dict[str, Any], whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = counted_runs(monkeypatch)
    found = sweep(out=tmp_path / "s.zarr", **request_of)
    assert sorted(made) == whole.data["J1"].values.tolist()
    assert "24 runs in" in repr(found)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (OSError(28, "No space left on device"), "No space left on device"),
        (LinkwrightError("The cluster is lost."), "The cluster is lost."),
    ],
)
def test_what_ends_a_sweep_says_how_to_go_on(
    request_of: dict[str, Any], whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    error: Exception, text: str,
) -> None:  # fmt: skip
    real, calls = Store.write, list[int]()

    def full(*arguments: Any) -> None:
        calls.append(1)
        if len(calls) == 4:
            raise error
        real(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(Store, "write", full)
        with pytest.raises(LinkwrightError, match=text) as raised:
            sweep(out=tmp_path / "s.zarr", **request_of)
    made = load_study(tmp_path / "s.zarr").outcomes["OK"]
    assert f"{made} of 24 runs are done and kept" in str(raised.value)
    assert 0 < made < 24
    assert same(sweep(out=tmp_path / "s.zarr", resume=True, **request_of), whole)


KILL = """
import os
from types import SimpleNamespace
from runtime import sweep
from runtime.sweeps.store import Store

class Killer:
    def __setitem__(self, place, values):
        os.kill(os.getpid(), 9)

def write(store, runs, rows):
    if isinstance(runs, range) and runs.start > 10:
        store.columns["COLUMN"] = SimpleNamespace(oindex=Killer())
    real(store, runs, rows)

real, Store.write = Store.write, write
sweep(out=OUT, **REQUEST)
"""


@pytest.mark.parametrize("column", ["crank.omega", "outcome"])
def test_rows_without_an_outcome_are_none(
    request_of: dict[str, Any], whole: Study, tmp_path: Path, column: str
) -> None:
    """The process is killed when the numbers of a row are on the disk, and its outcome is not."""
    out = tmp_path / "s.zarr"
    column = f"end:{column}" if column == "crank.omega" else column
    program = KILL.replace("COLUMN", column).replace("OUT", repr(str(out)))
    done = subprocess.run(
        [sys.executable, "-c", program.replace("REQUEST", repr(request_of))], check=False
    )
    assert done.returncode == -signal.SIGKILL
    numbers = open_store(out).columns["max:B.fx"][:]
    study = load_study(out)
    unmade = study.data["outcome"].values == "NOT RUN"
    assert np.isfinite(numbers[unmade]).any()
    assert np.isnan(study.data["max:B.fx"].values[unmade]).all()
    assert same(sweep(out=out, resume=True, **request_of), whole)


@pytest.mark.parametrize("name", ["max(B.fx)", "outcome", "message", "t_last", "crank.phi"])
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_files_that_a_power_cut_has_cut_short_are_made_again(
    study: Study, about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    name: str, share: float,
) -> None:  # fmt: skip
    path = tmp_path / "s.zarr"
    shutil.copytree(study.path, path)
    place = path / name / "c"
    # of the second file; all of its runs are refused, so that it has no numbers, in the first
    (file,) = [x for x in (place / "1", place / "1" / "0") if x.is_file()]
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    if name != "crank.phi":
        with pytest.raises(InputError, match="cannot be read"):
            _ = load_study(path).data
    made = counted_runs(monkeypatch)
    found = sweep(out=path, workers=0, resume=True, **GRID, **about)
    assert len(made) == open_store(path).about.chunk
    assert same(found, study)


@pytest.mark.parametrize("name", ["max(B.fx)", "message", "t_last", "crank.phi", "outcome"])
def test_rows_of_which_a_file_is_missing_are_none(
    study: Study, about: dict[str, Any], tmp_path: Path, name: str
) -> None:
    """As of a store that was copied in part; of refused runs the files are there, too."""
    path = tmp_path / "s.zarr"
    shutil.copytree(study.path, path)
    chunk, (file, *_) = study._store.about.chunk, [x for x in (path / name / "c").rglob("1") if x]
    (shutil.rmtree if file.is_dir() else Path.unlink)(file)
    data = load_study(path).data
    gone = data["outcome"].values == "NOT RUN"
    assert np.flatnonzero(gone).tolist() == [*range(chunk, 2 * chunk)]
    assert np.isnan(data["t_last"].values[gone]).all()
    found = sweep(out=path, workers=0, resume=True, **GRID, **about)
    assert same(found, study)


def test_outcomes_are_read_before_the_columns(
    whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row that a sweep writes meanwhile is not made, or whole."""
    path, real = tmp_path / "s.zarr", xr.open_zarr
    shutil.copytree(whole.path, path)
    store = open_store(path, "r+")
    store.write(range(24), rows_without_runs(store.request, 24))

    def meanwhile(*arguments: Any, **options: Any) -> xr.Dataset:
        found: xr.Dataset = real(*arguments, **options).load()
        store.write(range(24), rows_without_runs(store.request, 24, "OK"))
        return found

    monkeypatch.setattr(xr, "open_zarr", meanwhile)
    assert load_study(path).outcomes == {"NOT RUN": 24}
    assert load_study(path).outcomes == {"OK": 24}


def test_a_store_that_the_system_refuses_to_read_is_left_alone(
    whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(whole.path, tmp_path / "s.zarr")
    store = open_store(tmp_path / "s.zarr", "r+")
    before = {file: file.read_bytes() for file in store.path.rglob("*") if file.is_file()}

    class Refused:
        def __getitem__(self, place: Any) -> Any:
            raise OSError(24, "Too many open files")

    monkeypatch.setitem(store.columns, "t_last", Refused())
    with pytest.raises(InputError, match="Too many open files"):
        store.unmade()
    assert before == {file: file.read_bytes() for file in store.path.rglob("*") if file.is_file()}


def test_runs_that_ended_their_workers_come_last(whole: Study, tmp_path: Path) -> None:
    """So that a region of them does not keep a sweep from going on."""
    shutil.copytree(whole.path, tmp_path / "s.zarr")
    store = open_store(tmp_path / "s.zarr", "r+")
    for run, outcome in ((3, KILLED), (4, KILLED), (20, "")):
        store.write(range(run, run + 1), rows_without_runs(store.request, 1, outcome))
    assert store.unmade().tolist() == [20, 3, 4]
    assert tasks_of(store.unmade(), 24, 24) == [range(20, 21), range(3, 5)]


def test_rows_go_into_no_other_store(whole: Study, tmp_path: Path) -> None:
    path = tmp_path / "s.zarr"
    shutil.copytree(whole.path, path)
    store, rows = open_store(path, "r+"), rows_without_runs(whole._request, 24)
    path.rename(tmp_path / "first.zarr")
    with pytest.raises(OSError, match="No such file"):
        store.write(range(24), rows)
    shutil.copytree(whole.path, path)
    with pytest.raises(InputError, match="another store by now"):
        store.write(range(24), rows)
    assert load_study(path).complete


def test_slow_tasks_are_handed_back_in_part(
    request_of: dict[str, Any], whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(request, "_LONG", 0.0)
    made = counted_runs(monkeypatch)
    assert same(sweep(out=tmp_path / "s.zarr", **request_of), whole)
    assert len(made) == 24


def test_nothing_is_overwritten(
    request_of: dict[str, Any], whole: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = whole.path
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
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
    monkeypatch.setattr(in_sweep, "load", lambda *x, **y: pytest.fail("a model is loaded"))
    with pytest.raises(InputError, match="exists, and a sweep overwrites nothing"):
        sweep(out=path, **request_of)
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

    def at_level(result: Any, level: float) -> float:
        return level

    def swept(mass: float, level: float) -> Study:
        quantities = {"x": functools.partial(at_level, level=level)}
        return sweep(
            declared(mass), over={"l": [1.0, 2.0]}, t_end=0.1, workers=0, folder=tmp_path,
            out="s.zarr", resume=True, progress=False, quantities=quantities,
        )  # fmt: skip

    assert swept(1.0, 5.0).member(1).q("bob.x")[0] == pytest.approx(2.0)
    assert swept(1.0, 5.0).data["x"].values.tolist() == [5.0, 5.0]
    with pytest.raises(InputError, match="quantities, x was function"):
        swept(1.0, 6.0)
    with pytest.raises(InputError, match="the model: its generated module has another text"):
        swept(2.0, 5.0)
    with (tmp_path / "log").open("w") as file, pytest.raises(InputError) as raised:
        sweep(over={"J1": [1.0]}, out=tmp_path / "t.zarr",
              **about | {"quantities": {"q": lambda result: file.tell()}})  # fmt: skip
    assert "q: the function" in str(raised.value)
    assert "TextIOWrapper" in str(raised.value)


def test_other_programs_are_another_sweep(
    request_of: dict[str, Any], whole: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = load("slider_crank", scene="compressor")
    facts, asked = request.program_facts(), open_store(whole.path).request
    point, job = np.array([[450.0]]), pickled_job(machine, asked)
    for name, said in (
        (request.SOURCES, "the sources of Linkwright have another text"),
        ("llvmlite", f"llvmlite was {facts['llvmlite']} and is 0.1"),
        ("python", "and is 0.1"),
        (request.PROCESSOR, "processor was"),
    ):
        other = {**facts, name: "0.1"}
        monkeypatch.setattr(request, "program_facts", lambda other=other: other)
        with pytest.raises(InputError, match="it cannot go on") as raised:
            sweep(out=whole.path, resume=True, **request_of)
        assert said in str(raised.value)
        with pytest.warns(UserWarning, match="may differ in their last digits"):
            again = load_study(whole.path, machine=machine)
        assert len(again.member(0).t) == 21
        _load_job.cache_clear()
        if name == request.PROCESSOR:
            assert run_job(job, point).outcomes == ["OK"]
        else:
            with pytest.raises(LinkwrightError, match="has other programs than the sweep"):
                run_job(job, point)


def test_companions_are_those_of_the_sweep(request_of: dict[str, Any], tmp_path: Path) -> None:
    study = sweep(out=tmp_path / "s.zarr", formulation="reduced", **request_of)
    (kind,) = study.facts()["facts"]["companions"]
    assert kind == "reduced"
    machine = load("slider_crank", scene="compressor")
    assert load_study(study.path, machine=machine).member(1).outcome.name == "OK"
    asked = open_store(study.path).request.model_copy(update={"companions": {"reduced": "0"}})
    with pytest.raises(LinkwrightError, match="have another text than when the sweep began"):
        run_job(pickled_job(machine, asked), np.array([[450.0]]))


def test_runs_without_memory_are_made_again(request_of: dict[str, Any], tmp_path: Path) -> None:
    place = tmp_path / "scarce"

    def hungry(result: Any) -> float:
        if place.exists() and result.parameters["J1"] == 200.0:
            raise MemoryError("all is taken")
        return 1.0

    wanted = request_of | {"quantities": {"hungry": hungry}}
    place.touch()
    found = sweep(out=tmp_path / "s.zarr", **wanted)
    assert found.outcomes == {"OK": 23, "MEMORY": 1}
    assert np.isnan(found.data["hungry"][0])
    place.unlink()
    found = sweep(out=tmp_path / "s.zarr", resume=True, **wanted)
    assert found.outcomes == {"OK": 24}
    assert found.data["hungry"][0] == 1.0


def test_an_interrupt_of_a_trial_member_ends_the_sweep(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = SimpleNamespace(outcome=Outcome.INTERRUPTED, failed=True)
    monkeypatch.setattr(request, "run_member", lambda *arguments: ended)
    with pytest.raises(KeyboardInterrupt):
        sweep(out=tmp_path / "s.zarr", **request_of)
    assert not (tmp_path / "s.zarr").exists()


def test_a_sweep_begins_only_where_no_other_has(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "s.zarr"
    with store_lock(path), pytest.raises(InputError, match="Another sweep is writing"):
        sweep(out=path, **request_of)
    assert [file.name for file in tmp_path.iterdir()] == [".s.zarr.lock"]
    real = in_sweep.create_store

    def begun(path: Path, *arguments: Any) -> None:
        """Another program writes the store while this one builds its machine."""
        path.mkdir()
        (path / "theirs").touch()
        real(path, *arguments)

    monkeypatch.setattr(in_sweep, "create_store", begun)
    with pytest.raises(InputError, match="exists by now"):
        sweep(out=path, **request_of)
    assert [file.name for file in path.iterdir()] == ["theirs"]
