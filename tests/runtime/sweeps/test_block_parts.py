"""Rows of a block that is not whole: kept through full disks, kills and damage."""

import errno
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from codegen.errors import LinkwrightError
from runtime import load_study, sweep
from runtime.sweeps import block, block_parts, execution, store
from runtime.sweeps.member_run import Row
from runtime.sweeps.request import Request
from tests.runtime.sweeps.test_resumption import counted_runs, same
from tests.runtime.sweeps.test_stores import identity, made, request, rows

RUNS = range(3, 6)


def part(path: Path, found: dict[int, Row]) -> Any:
    """The rows of block 1 of a store, as a task has them."""
    job: Any = SimpleNamespace(store=path, identity=identity(path), request=request(("J1",)))
    return block._Part(job, store.open_group(path), 1, RUNS, found)


def three() -> dict[int, Row]:
    return dict(zip(RUNS, rows(3), strict=True))


def saved(path: Path) -> dict[int, Row]:
    about = store.about_of(store.open_group(path))
    return block_parts.read_part(path, about, request(("J1",)), 1)


def equal(ours: Row, theirs: Row) -> bool:
    numbers = all((a == b).all() for a, b in ((ours[0], theirs[0]), (ours[4], theirs[4])))
    return numbers and ours[1:4] == theirs[1:4]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A store of which two rows of block 1 are made."""
    made(tmp_path / "s.zarr")
    there = three()
    there[5] = there[5]._replace(message="no\0number ä")
    del there[4]
    part(tmp_path / "s.zarr", there).save()
    return tmp_path / "s.zarr"


def test_a_part_has_its_rows_and_is_no_block(path: Path) -> None:
    found = saved(path)
    assert [*found] == [3, 5]
    assert equal(found[3], rows(3)[0])
    assert found[5].message == "no\0number ä"
    assert store.unfinished(store.open_group(path)) == [0, 1, 2]
    study = load_study(path)  # a folder that Zarr does not know would be a warning
    assert study.outcomes == {"NOT RUN": 7}
    assert not study.complete
    part(path, {4: rows(3)[1]}).save()
    assert [*saved(path)] == [3, 4, 5]  # those of two processes
    part(path, three()).finish()
    assert not [*block_parts.parts_folder(path).iterdir()]
    assert store.unfinished(store.open_group(path)) == [0, 2]


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6, 1.0])
def test_a_damaged_part_is_none(path: Path, place: float) -> None:
    file = block_parts.part_file(path, 1)
    content = file.read_bytes()
    file.write_bytes(content[: int(place * len(content)) - 1] if place else b"")
    assert saved(path) == {}
    file.write_bytes(content.replace(b"text", b"tent"))
    assert saved(path) == {}


def test_a_part_of_another_sweep_is_none(path: Path) -> None:
    other = path.with_name("t.zarr")
    made(other)
    block_parts.parts_folder(other).mkdir()
    block_parts.part_file(other, 1).write_bytes(block_parts.part_file(path, 1).read_bytes())
    assert saved(other) == {}
    assert [*saved(path)] == [3, 5]


def test_rows_without_a_mark_are_not_read(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block whose rows are on the disk, and whose mark is not."""

    def full(*arguments: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(store, "mark_of", full)
    with pytest.raises(OSError, match="No space"):
        store.write_block(path, identity(path), request(("J1",)), RUNS, rows(3))
    group = store.open_group(path)
    assert [*group["outcome"][3:6]] == ["OK"] * 3
    study = load_study(path)
    assert study.outcomes == {"NOT RUN": 7}
    assert np.isnan(study.data["max:B.fx"].values).all()
    assert not study.complete


def test_outcomes_are_written_last(path: Path) -> None:
    (*others, last) = store.arrays_of(request(("J1",)), rows(3))
    assert last == "outcome"
    first, second, *_ = store.chunks_of(path, request(("J1",)), 1)
    assert (first.parent.parent.name, second.parent.parent.name) == ("block_mark", "outcome")
    assert others


KILLS = {
    "the part": """
def savez(file, **arrays):
    file.write(b"PK half")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)
numpy.savez = savez
there.save()
""",
    "the removal": """
store._remove_chunk = lambda place: (shutil.rmtree(place.parent, True), os.kill(os.getpid(), 9))
there.finish()
""",
    "the rows": """
real = store.mark_of
end = lambda: os.kill(os.getpid(), 9)
store.mark_of = lambda arrays, seal: real(arrays, seal) if "run" in arrays else end()
there.finish()
""",
}  # fmt: skip


@pytest.mark.parametrize("place", KILLS)
@pytest.mark.parametrize("whole", [False, True])
def test_a_kill_within_a_write_loses_no_earlier_row(path: Path, place: str, whole: bool) -> None:
    if whole:  # a block that is made again, as of KILLED or MEMORY
        part(path, three()).finish()
    program = f"""
import os, shutil, signal, numpy
from pathlib import Path
from runtime.sweeps import block_parts, store
from tests.runtime.sweeps.test_block_parts import part, three
there = part(Path({str(path)!r}), three())
{KILLS[place]}
"""
    assert (
        subprocess.run([sys.executable, "-c", program], check=False).returncode == -signal.SIGKILL
    )
    group = store.open_group(path)
    found = store.rows_made(group, request(("J1",)), RUNS) | saved(path)
    assert {3, 5} <= found.keys()
    assert whole <= (len(found) == 3)
    assert equal(found[3], rows(3)[0])
    part(path, three()).finish()
    assert store.unfinished(group) == [0, 2]
    block_parts.remove_parts(path)
    assert load_study(path).outcomes == {"NOT RUN": 4, "OK": 3}


@pytest.mark.parametrize("place", ["part", "block"])
def test_a_full_disk_loses_no_earlier_row(
    place: str, about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {**about, "over": {"J1": "200:1000:24"}, "workers": 0}
    whole = sweep(out=tmp_path / "whole.zarr", **asked)
    monkeypatch.setattr(block, "SAVE_SECONDS", 0.0)
    monkeypatch.setattr(execution, "BLOCKS_A_WORKER", 1)
    real, calls = np.savez, list[int]()

    def full(*arguments: Any, **words: Any) -> None:
        calls.append(0)
        if place == "block" or len(calls) == 8:
            if place == "part":
                arguments[0].write(b"half")
            raise OSError(errno.ENOSPC, "No space left on device")
        real(*arguments, **words)

    with monkeypatch.context() as patch:
        if place == "part":
            patch.setattr(np, "savez", full)
        else:
            patch.setattr(store, "_remove_chunk", full)
        before = counted_runs(patch)
        with pytest.raises(LinkwrightError, match="No space left on device") as raised:
            sweep(out=tmp_path / "s.zarr", **asked)
    assert "0 of 1 block are done" in str(raised.value)
    assert len(before) == (5 + 8 if place == "part" else 24)
    assert [file.name for file in block_parts.parts_folder(tmp_path / "s.zarr").iterdir()] == [
        "0.npz"
    ]
    with monkeypatch.context() as patch:
        after = counted_runs(patch)
        found = sweep(out=tmp_path / "s.zarr", resume=True, **asked)
    assert len(after) <= 24 - 12 if place == "part" else len(after) <= 1
    assert same(found, whole)


def test_requests_name_their_arrays() -> None:
    asked: Request = request(("J1",))
    assert [*store.arrays_of(asked, ())] == ["max:B.fx", "a.x", "t_last", "message", "outcome"]
