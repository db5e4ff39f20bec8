"""Sweeps one after the other in one process, by other programs, functions, and full disks."""

import functools
import shutil
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
from runtime.sweeps import block, member_run, request, workers
from runtime.sweeps import sweep as in_sweep
from runtime.sweeps.block import run_block
from runtime.sweeps.store import Store, create_store, open_store
from tests.runtime.sweeps.test_resumption import same


@pytest.fixture
def request_of(about: dict[str, Any]) -> dict[str, Any]:
    return {**about, "over": {"J1": "200:1000:24"}, "workers": 0}


def test_a_store_that_is_made_anew_at_the_same_path(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, whole = tmp_path / "s.zarr", sweep(out=tmp_path / "whole.zarr", **request_of)
    for share in (8, 3, 8):  # with blocks of other lengths
        monkeypatch.setattr(in_sweep, "BLOCKS_A_WORKER", share)
        assert same(sweep(out=path, **request_of), whole)
        assert open_store(path).unfinished() == []
        shutil.rmtree(path)


def test_a_late_task_of_another_sweep_writes_nothing(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, jobs = tmp_path / "s.zarr", []
    monkeypatch.setattr(workers, "run_block", lambda job, k: jobs.append(job) or run_block(job, k))
    sweep(out=path, **request_of)
    shutil.rmtree(path)
    whole = sweep(out=path, **request_of | {"t_end": 0.04})
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    with pytest.raises(InputError, match="the store of another sweep by now"):
        run_block(jobs[0], 0)
    assert before == {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    assert whole.complete


@pytest.mark.parametrize("seconds", [30.0, 0.0])  # with rows that are saved meanwhile, or none
def test_a_task_whose_store_is_replaced_while_it_runs_writes_nothing(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seconds: float
) -> None:
    path, other, jobs = tmp_path / "s.zarr", tmp_path / "other.zarr", []
    monkeypatch.setattr(workers, "run_block", lambda job, k: jobs.append(job) or run_block(job, k))
    sweep(out=path, **request_of)
    shutil.rmtree(path / "block_mark" / "c")  # nothing is done
    sweep(out=other, **request_of | {"t_end": 0.04})
    before = {file.relative_to(other): file.read_bytes() for file in files_of(other)}
    real = block.evaluate_member

    def replaced(*given: Any) -> Any:
        if other.exists():
            shutil.rmtree(path)
            other.rename(path)
        return real(*given)

    monkeypatch.setattr(block, "evaluate_member", replaced)
    monkeypatch.setattr(block, "SAVE_SECONDS", seconds)
    with pytest.raises(InputError, match="the store of another sweep by now"):
        run_block(jobs[0], 1)
    assert before == {file.relative_to(path): file.read_bytes() for file in files_of(path)}


def files_of(path: Path) -> list[Path]:
    return [file for file in path.rglob("*") if file.is_file()]


def test_rows_that_do_not_arrive_are_an_error(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(store: Store, number: int, rows: Any) -> None:
        if number:
            real(store, number, rows)

    real = Store.write_block
    monkeypatch.setattr(Store, "write_block", lost)
    with pytest.raises(
        LinkwrightError, match=r"1 block of .* not whole though .* first is 0"
    ) as raised:
        sweep(out=tmp_path / "s.zarr", **request_of)
    assert "7 of 8 blocks are done" in str(raised.value)


def test_a_full_disk_says_how_to_go_on(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Store, "write_block", full)
    with pytest.raises(LinkwrightError, match="No space left on device") as raised:
        sweep(out=tmp_path / "s.zarr", **request_of)
    assert "0 of 8 blocks are done" in str(raised.value)


def test_other_programs_are_another_sweep(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs: list[Any] = []
    with monkeypatch.context() as patch:
        patch.setattr(workers, "run_block", lambda job, k: jobs.append(job) or run_block(job, k))
        study = sweep(out=tmp_path / "s.zarr", **request_of)
    machine = load("slider_crank", scene="compressor")
    facts = request.program_facts()
    for name, said in (
        (request.SOURCES, "the sources of Linkwright have another text"),
        ("llvmlite", f"llvmlite was {facts['llvmlite']} and is 0.1"),
        ("python", "and is 0.1"),
        (request.PROCESSOR, "processor was"),
    ):
        other = {**facts, name: "0.1"}
        for module in ("request", "sweep"):
            monkeypatch.setattr(f"runtime.sweeps.{module}.program_facts", lambda other=other: other)
        with pytest.raises(InputError, match="it cannot go on") as raised:
            sweep(out=study.path, resume=True, **request_of)
        assert said in str(raised.value)
        with pytest.warns(UserWarning, match="may differ in their last digits"):
            again = load_study(study.path, machine=machine)
        assert len(again.member(0).t) == 21
        block._loaded.clear()
        if name == request.PROCESSOR:
            run_block(jobs[0], 0)
        else:
            with pytest.raises(LinkwrightError, match="has other programs than the sweep"):
                run_block(jobs[0], 0)


def test_companions_are_those_of_the_sweep(request_of: dict[str, Any], tmp_path: Path) -> None:
    study = sweep(out=tmp_path / "s.zarr", formulation="reduced", **request_of)
    (kind,) = study.facts()["facts"]["companions"]
    assert kind == "reduced"
    machine = load("slider_crank", scene="compressor")
    assert load_study(study.path, machine=machine).member(1).outcome.name == "OK"


def test_functions_are_known_by_all_that_decides(
    request_of: dict[str, Any], tmp_path: Path
) -> None:
    def at_level(result: Any, level: float) -> float:
        return level

    def swept(level: float) -> Any:
        part = functools.partial(at_level, level=level)
        return sweep(
            out=tmp_path / "s.zarr", resume=True, **request_of | {"quantities": {"q": part}}
        )  # fmt: skip

    assert swept(1.0).complete
    assert swept(1.0).data["q"].values.tolist() == [1.0] * 24
    with pytest.raises(InputError, match="quantities, q was function"):
        swept(2.0)
    with (tmp_path / "log").open("w") as file, pytest.raises(InputError) as raised:
        sweep(
            out=tmp_path / "t.zarr",
            **request_of | {"quantities": {"q": lambda result: file.tell()}},
        )  # fmt: skip
    assert "q: the function" in str(raised.value)
    assert "TextIOWrapper" in str(raised.value)


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
    monkeypatch.setattr(member_run, "run_member", lambda *arguments: ended)
    with pytest.raises(KeyboardInterrupt):
        sweep(out=tmp_path / "s.zarr", **request_of)
    assert not (tmp_path / "s.zarr").exists()


def test_a_sweep_begins_only_where_no_other_has(
    request_of: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another program writes the store while this one builds its machine."""
    real = in_sweep.create_store

    def begun(path: Path, *arguments: Any) -> None:
        path.mkdir()
        (path / "theirs").touch()
        real(path, *arguments)

    monkeypatch.setattr(in_sweep, "create_store", begun)
    with pytest.raises(InputError, match="exists by now"):
        sweep(out=tmp_path / "s.zarr", **request_of)
    assert [file.name for file in (tmp_path / "s.zarr").iterdir()] == ["theirs"]
    assert create_store is real


def test_a_result_replaces_no_study(request_of: dict[str, Any], tmp_path: Path) -> None:
    study = sweep(out=tmp_path / "study.zarr", **request_of)
    result = study.member(0)
    with pytest.raises(InputError, match="left alone"):
        result.save(study.path)
    assert load_study(study.path).complete
    result.save(tmp_path / "run.zarr")
    result.save(tmp_path / "run.zarr")
    xr.Dataset({"a": ("k", [1.0])}).to_zarr(
        tmp_path / "own.zarr", zarr_format=3, consolidated=False
    )
    with pytest.raises(InputError, match="left alone"):
        result.save(tmp_path / "own.zarr")


def test_points_and_their_units(tmp_path: Path) -> None:
    model = Model("metric", gravity=(0, -9.81))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    length = model.parameter("l", 1.0, unit="m")
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    model.scene("swing", start={bob.phi: 0.0, bob.omega: 1.0})
    common: dict[str, Any] = {
        "t_end": 0.1, "points": 11, "folder": tmp_path, "workers": 0, "progress": False,
        "quantities": ["bob.phi"],
    }  # fmt: skip
    points = xr.Dataset({"l": ("run", [1000.0, 2000.0], {"units": "mm"})})
    found = sweep(model, over=points, out="a.zarr", **common)
    assert found.data["l"].values.tolist() == [1.0, 2.0]
    assert found.data["l"].attrs["units"] == "m"
    with pytest.raises(InputError) as misfits:
        sweep(
            model, over=["l=1 kg,2 kg", "k=1 mm,2 mm"], out="a.zarr", resume=True,
            **common | {"quantities": ["no.series"], "t_end": -1.0},
        )  # fmt: skip
    assert [text.split()[0] for text in misfits.value.problems[:1]] == ["l:"]
    assert len(misfits.value.problems) == 4
    failed = sweep(
        model, over={"l": [1.0, 2.0]}, out="b.zarr", max_steps=1,
        **common | {"quantities": ["max:bob.phi", "rate:bob.x"]},
    )  # fmt: skip
    assert set(failed.outcomes) == {"MAX_STEPS"}
    assert failed.data["max:bob.phi"].attrs["units"] == "rad"
    assert failed.data["rate:bob.x"].attrs["units"] == "m/s"
    with pytest.raises(InputError) as raised:
        sweep(
            model, over={"l": [1.0, 2.0]}, out="c.zarr", max_steps=1,
            **common | {"quantities": ["max:no.such", "event:nothing", "max:bob.phj"]},
        )  # fmt: skip
    assert len(raised.value.problems) == 3
    assert sorted(path.name for path in tmp_path.glob("*.zarr")) == ["a.zarr", "b.zarr"]
