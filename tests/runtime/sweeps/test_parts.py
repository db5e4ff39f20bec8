"""Rows of a block that is not whole: kept through full disks, kills and damage."""

import errno
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.errors import LinkwrightError
from runtime import load_study, sweep
from runtime.sweeps import block
from runtime.sweeps.block import finish_block, part_file, read_part, remove_parts, write_part
from runtime.sweeps.member_run import Row
from runtime.sweeps.store import Store, open_store
from tests.runtime.sweeps.test_resumption import counted_runs, same
from tests.runtime.sweeps.test_stores import made, rows, writable

RUNS = range(3, 6)


def three() -> dict[int, Row]:
    return dict(zip(RUNS, rows(3), strict=True))


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
    write_part(writable(tmp_path / "s.zarr"), 1, there)
    return tmp_path / "s.zarr"


def test_a_part_has_its_rows_and_is_no_block(path: Path) -> None:
    store = writable(path)
    found = read_part(store, 1)
    assert [*found] == [3, 5]
    assert equal(found[3], rows(3)[0])
    assert found[5].message == "no\0number ä"
    assert store.unfinished() == [0, 1, 2]
    study = load_study(path)  # a folder that Zarr does not know would be a warning
    assert study.outcomes == {"NOT RUN": 7}
    assert not study.complete
    finish_block(store, 1, three())
    assert not [*part_file(path, 1).parent.iterdir()]
    assert store.unfinished() == [0, 2]


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6, 1.0])
def test_a_damaged_part_is_none(path: Path, place: float) -> None:
    file = part_file(path, 1)
    content = file.read_bytes()
    file.write_bytes(content[: int(place * len(content)) - 1] if place else b"")
    assert read_part(open_store(path), 1) == {}
    file.write_bytes(content.replace(np.float64(3.0).tobytes(), np.float64(2.5).tobytes()))
    assert content != file.read_bytes()
    assert read_part(open_store(path), 1) == {}


def test_a_part_of_another_sweep_is_none(path: Path) -> None:
    other = path.with_name("t.zarr")
    made(other)
    part_file(other, 1).parent.mkdir()
    shutil.copy(part_file(path, 1), part_file(other, 1))
    assert read_part(open_store(other), 1) == {}
    assert [*read_part(open_store(path), 1)] == [3, 5]


def test_rows_without_a_mark_are_not_read(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block whose rows are on the disk, and whose mark is not."""

    def full(*arguments: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Store, "mark_of", full)
    with pytest.raises(OSError, match="No space"):
        writable(path).write_block(1, rows(3))
    assert [*open_store(path).group["outcome"][3:6]] == ["OK"] * 3
    study = load_study(path)
    assert study.outcomes == {"NOT RUN": 7}
    assert np.isnan(study.data["max:B.fx"].values).all()
    assert not study.complete


KILLS = {
    "the part": """
def savez(file, **arrays):
    file.write(b"PK half")
    file.flush()
    end()
numpy.savez = savez
write_part(store, 1, three())
""",
    "the removal": """
unlink = Path.unlink
Path.unlink = lambda place, missing_ok=False: (unlink(place, missing_ok), end())
finish_block(store, 1, three())
""",
    "the rows": """
Store.mark_of = lambda store, arrays: end()
finish_block(store, 1, three())
""",
}  # fmt: skip


@pytest.mark.parametrize("place", KILLS)
@pytest.mark.parametrize("whole", [False, True])
def test_a_kill_within_a_write_loses_no_earlier_row(path: Path, place: str, whole: bool) -> None:
    if whole:  # a block that is made again, as of KILLED or MEMORY
        finish_block(writable(path), 1, three())
    program = f"""
import os, numpy
from pathlib import Path
from runtime.sweeps.block import finish_block, write_part
from runtime.sweeps.store import Store
from tests.runtime.sweeps.test_parts import three
from tests.runtime.sweeps.test_stores import writable
store, end = writable(Path({str(path)!r})), lambda: os.kill(os.getpid(), 9)
{KILLS[place]}
"""
    done = subprocess.run([sys.executable, "-c", program], check=False)
    assert done.returncode == -signal.SIGKILL
    store = writable(path)
    found = store.rows(1) | read_part(store, 1)
    assert {3, 5} <= found.keys()
    assert whole <= (len(found) == 3)
    assert equal(found[3], rows(3)[0])
    finish_block(store, 1, three())
    assert store.unfinished() == [0, 2]
    remove_parts(path)
    assert load_study(path).outcomes == {"NOT RUN": 4, "OK": 3}


def test_a_full_disk_loses_no_earlier_row(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {**about, "over": {"J1": "200:1000:24"}, "workers": 0}
    whole = sweep(out=tmp_path / "whole.zarr", **asked)
    monkeypatch.setattr(block, "SAVE_SECONDS", 0.0)
    monkeypatch.setattr("runtime.sweeps.sweep.BLOCKS_A_WORKER", 1)
    real, calls = np.savez, list[int]()

    def full(*arguments: Any, **words: Any) -> None:
        calls.append(0)
        if len(calls) == 8:
            arguments[0].write(b"half")
            raise OSError(errno.ENOSPC, "No space left on device")
        real(*arguments, **words)

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez", full)
        before = counted_runs(patch)
        with pytest.raises(LinkwrightError, match="No space left on device") as raised:
            sweep(out=tmp_path / "s.zarr", **asked)
    assert "0 of 1 block are done" in str(raised.value)
    assert len(before) == 5 + 8
    assert [file.name for file in part_file(tmp_path / "s.zarr", 0).parent.iterdir()] == ["0.npz"]
    with monkeypatch.context() as patch:
        after = counted_runs(patch)
        found = sweep(out=tmp_path / "s.zarr", resume=True, **asked)
    assert len(after) <= 24 - 12
    assert same(found, whole)
