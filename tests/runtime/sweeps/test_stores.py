"""Stores of sweeps: sizes and names, and what no sweep has written."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError
from runtime import load_study
from runtime.sweeps.store import CHUNK_BYTES, MOST_CHUNKS, file_sizes, name_problems, tasks_of
from runtime.sweeps.study import Study


@pytest.fixture
def path(study: Study, tmp_path: Path) -> Path:
    """A copy of a store."""
    return Path(shutil.copytree(study.path, tmp_path / "s.zarr"))


@pytest.mark.parametrize(
    ("runs", "seconds", "row", "size", "chunk"),
    [
        (10**6, 1e-4, 8, 30_000, 30_000),
        (1000, 60.0, 8, 1, 1),
        (10**6, 60.0, 8, 1, 10**6 // MOST_CHUNKS),  # slow runs, of which many share a file
        (10**6, 1e-4, 400_000, CHUNK_BYTES // 400_000, CHUNK_BYTES // 400_000),
        (10, 1e-4, 1 << 40, 1, 1),
    ],
)
def test_tasks_take_seconds_and_files_fit_in_memory(
    runs: int, seconds: float, row: int, size: int, chunk: int
) -> None:
    assert file_sizes(runs, seconds, 2, row) == (size, chunk)


def test_tasks_are_the_missing_runs_of_one_file_each() -> None:
    runs = np.array([0, 1, 2, 3, 5, 6, 7, 8, 9, 14])
    found = tasks_of(runs, 5, 3)
    assert found == [range(3), range(3, 4), range(5, 8), range(8, 10), range(14, 15)]
    assert tasks_of(runs[:0], 5, 3) == []


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["max:B.fx", "max(B.fx)"], "or one folder, max"),
        (["a", "A"], "those of a;"),
        (["a", "a"], "would name several columns"),
        *(([name], "cannot name a column") for name in (
            "", "zarr.json", "Zarr.JSON", "x" * 300, "x\0y", "..\\y", "a/b", ".a", " a", "t",
        )),
    ],
)  # fmt: skip
def test_names_that_no_column_can_have(names: list[str], message: str) -> None:
    (problem,) = name_problems(names)
    assert message in problem


def changed(path: Path, change: Callable[[dict[str, Any]], None], part: str = "") -> None:
    file = path / part / "zarr.json"
    about = json.loads(file.read_text())
    change(about if part else about["attributes"]["linkwright_sweep"])
    file.write_text(json.dumps(about))


@pytest.mark.parametrize(
    "change",
    [
        {"runs": 10**13}, {"runs": 6}, {"runs": "x"}, {"chunk": 0}, {"facts": None}, {"facts": {}},
        {"design": []}, {"seconds": None}, {"format": None}, {"format": 1},
    ],
)  # fmt: skip
def test_attributes_that_no_sweep_has_written(path: Path, change: dict[str, Any]) -> None:
    changed(path, lambda about: about.update(change))
    with pytest.raises(InputError, match=r"not written by a sweep|has format"):
        load_study(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [("quantities", [3]), ("series", ["../x"]), ("instants", 0), ("t_end", None), ("start", 1)],
)
def test_a_request_that_no_sweep_has_written(path: Path, name: str, value: Any) -> None:
    changed(path, lambda about: about["facts"].update({name: value}))
    with pytest.raises(InputError, match="not written by a sweep"):
        load_study(path)


def test_a_store_from_elsewhere_runs_nothing(path: Path) -> None:
    codec = {"name": "numcodecs.pickle", "configuration": {}}
    changed(path, lambda about: about["codecs"].append(codec), "t_last")
    with pytest.raises(InputError, match="pickle"):
        load_study(path)
    (path / "t_last" / "zarr.json").unlink()
    (path / "t_last" / ".zarray").write_text('{"zarr_format": 2}')
    with pytest.raises(InputError, match="format 2"):
        load_study(path)


@pytest.mark.parametrize("shape", [[10**13], [6], [12, 2]])
def test_arrays_of_other_lengths(path: Path, shape: list[int]) -> None:
    changed(path, lambda about: about.update(shape=shape), "t_last")
    with pytest.raises(InputError, match=r"t_last has the shape|not written by a sweep"):
        load_study(path)
