"""Where a disk is full, an error names the file and what to do, and nothing half is left."""

import errno
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from codegen.errors import GeneratedFileError, InputError
from codegen.files.whole_files import whole_file
from codegen.generated_files.generated_file import write_if_changed
from linkwright.cli.analyses import save as save_or_rescue
from linkwright.cli.application import app
from runtime.machine_facade import Machine
from runtime.results.result import Result


@pytest.fixture(scope="module")
def result(pendulum: Machine) -> Result:
    return pendulum.simulate(1.0, np.linspace(0.0, 1.0, 501), progress=False)


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file may be larger than `size` bytes: its writing fails as on a disk that is full."""
    limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))


@pytest.mark.parametrize("size", [0, 4096, 12000])
@pytest.mark.parametrize("ending", [".nc", ".csv", ".parquet", ".html"])
def test_every_format_names_the_file_and_leaves_nothing_half(
    result: Result, tmp_path: Path, ending: str, size: int
) -> None:
    path = tmp_path / f"run{ending}"
    path.write_text("of an earlier run")
    with room_for(size), pytest.raises(InputError) as caught:
        result.save(path)
    text = str(caught.value)
    assert text.startswith(f"cannot write {path}: ")
    assert "KiB free" in text
    assert "free some space, or choose a place on another disk" in text
    assert path.read_text() == "of an earlier run"
    assert list(tmp_path.iterdir()) == [path]
    open_files = [os.path.realpath(fd) for fd in Path("/proc/self/fd").iterdir()]
    assert not [name for name in open_files if str(tmp_path) in name]


def test_a_generated_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "rod.py"
    with room_for(10), pytest.raises(GeneratedFileError, match=r"cannot write .*rod\.py: .*free"):
        write_if_changed(path, "x = 1\n" * 10)
    assert not path.exists()


def test_a_result_that_took_time_is_saved_elsewhere(
    result: Result,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    save = Result.save

    def full(self: Result, path: Path) -> Path:
        if path.parent == tmp_path:
            raise InputError("cannot write it: no space")
        return save(self, path)

    monkeypatch.setattr(Result, "save", full)
    saved = save_or_rescue(result, tmp_path / "run.csv")
    assert saved.parent != tmp_path
    assert len(saved.read_text().splitlines()) == 502
    assert "error: cannot write it: no space" in capsys.readouterr().err


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    left, new = tmp_path / ".linkwright-left", tmp_path / ".linkwright-new"
    for folder in (left, new):
        folder.mkdir()
        (folder / "run.csv").write_text("half")
    os.utime(left, (0, 0))
    with whole_file(tmp_path / "run.csv") as temporary:
        temporary.write_text("whole")
    assert sorted(path.name for path in tmp_path.iterdir()) == [new.name, "run.csv"]


def test_another_reason_has_another_advice(tmp_path: Path) -> None:
    with (
        pytest.raises(InputError, match=r"run\.csv: Permission denied\. Choose another folder"),
        whole_file(tmp_path / "run.csv"),
    ):
        raise PermissionError(errno.EACCES, "Permission denied")


@pytest.mark.parametrize("library", ["netCDF4", "pyarrow"])
def test_a_missing_library_is_named_before_the_run(
    workshop: Path, pendulum: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, library: str
) -> None:
    monkeypatch.setitem(__import__("sys").modules, library, None)
    monkeypatch.setattr(Machine, "simulate", lambda *_, **__: pytest.fail("it was run"))
    monkeypatch.chdir(workshop)
    ending = {"netCDF4": ".nc", "pyarrow": ".parquet"}[library]
    out = str(tmp_path / f"run{ending}")
    done = CliRunner().invoke(app, ["simulate", "rod_pendulum", "--t-end", "1", "--out", out])
    assert done.exit_code == 2
    assert f"needs the library {library}" in done.stderr
