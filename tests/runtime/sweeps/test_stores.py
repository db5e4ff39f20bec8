"""Stores of sweeps: their identity, damage, names, sizes, and what no sweep has written."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError
from runtime import load_study
from runtime.sweeps.design import design_of
from runtime.sweeps.factors import read_factors
from runtime.sweeps.member_run import KILLED, MEMORY, REPEATED, Row
from runtime.sweeps.request import Request
from runtime.sweeps.store import Store, create_store, name_problems, open_store, reopen
from runtime.sweeps.sweep import BLOCK_BYTES, MOST_BLOCKS, block_size, store_lock

QUANTITY = "max:B.fx"
RUNS, BLOCK = 7, 3


def request(names: tuple[str, ...], parameters: dict[str, float] | None = None) -> Request:
    quantities = {QUANTITY: QUANTITY}
    return Request(
        "m", "s", "0" * 64, "simulate", names, (), quantities, ("a.x",), 0.0, 1.0, 11,
        parameters=parameters or {},
    )  # fmt: skip


def made(path: Path, over: str = f"J1=1:7:{RUNS}", **words: Any) -> Request:
    """A store without rows."""
    design = design_of(read_factors([over]), None, None, 0)
    asked = request(design.names, **words)
    create_store(path, asked, design, {QUANTITY: "N", "a.x": "m"}, BLOCK, 0.01)
    return asked


def rows(count: int, outcome: str = "OK") -> list[Row]:
    return [
        Row(np.array([1.5 * k]), outcome, "text", 1.0, np.full((1, 11), 1.0 * k))
        for k in range(count)
    ]


def writable(path: Path) -> Store:
    return reopen(path, open_store(path).about["identity"])


def write(path: Path) -> None:
    """All blocks."""
    store = writable(path)
    for block in range(store.blocks):
        store.write_block(block, rows(len(store.runs_of(block))))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    made(tmp_path / "s.zarr")
    write(tmp_path / "s.zarr")
    assert open_store(tmp_path / "s.zarr").unfinished() == []
    return tmp_path / "s.zarr"


def test_rows_of_another_sweep_have_no_valid_mark(path: Path) -> None:
    other, late = path.with_name("t.zarr"), open_store(path).about["identity"]
    made(other)
    for part in ("block_mark", "max(B.fx)", "outcome", "message", "t_last", "a.x"):
        shutil.rmtree(other / part)
        shutil.copytree(path / part, other / part)
    assert open_store(other).unfinished() == [0, 1, 2]
    with pytest.raises(InputError, match="the store of another sweep by now"):
        reopen(other, late)


@pytest.mark.parametrize("name", ["max(B.fx)", "outcome", "message", "t_last", "a.x", "block_mark"])
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_file_that_is_cut_short_is_a_block_to_make_again(
    path: Path, name: str, share: float
) -> None:
    for block in (1, 2):  # the last one is not full
        files = [x for x in (path / name / "c" / str(block)).rglob("*") if x.is_file()]
        (file,) = files or [path / name / "c" / str(block)]
        content = file.read_bytes()
        file.write_bytes(content[: int(share * len(content))])
    assert open_store(path).unfinished() == [1, 2]
    if name not in {"a.x", "block_mark"}:
        with pytest.raises(InputError, match="cannot be read"):
            _ = load_study(path).data
    write(path)
    assert open_store(path).unfinished() == []
    assert load_study(path).data[QUANTITY].values.tolist() == [0, 1.5, 3, 0, 1.5, 3, 0]


@pytest.mark.parametrize("outcome", [KILLED, MEMORY, "REFUSED"])
def test_outcomes_of_another_day_are_repeated(path: Path, outcome: str) -> None:
    store = writable(path)
    store.write_block(1, rows(3, outcome))
    assert store.unfinished() == []
    assert store.unfinished(repeated=REPEATED) == ([1] if outcome != "REFUSED" else [])


def test_a_factor_of_many_values(tmp_path: Path) -> None:
    made(tmp_path / "s.zarr", "J1=1:2:1000001")
    assert (tmp_path / "s.zarr" / "zarr.json").stat().st_size < 1 << 16
    assert load_study(tmp_path / "s.zarr").factors == ("J1",)


def test_a_request_that_no_reader_would_take_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="bytes as JSON"):
        made(tmp_path / "s.zarr", parameters={f"{k:0100d}": 1.0 for k in range(10**5)})
    assert not list(tmp_path.iterdir())


def test_a_block_fits_in_memory() -> None:
    row = 8 * 5 * 10_000  # of five series
    assert block_size(10**6, 1e-4, 2, row) * row <= BLOCK_BYTES
    assert block_size(10**6, 1e-4, 2, 8) == 30_000
    assert block_size(10, 1e-4, 2, 1 << 40) == 1


def test_slow_runs_share_blocks_where_they_are_many() -> None:
    assert block_size(1000, 60.0, 4, 8) == 1
    assert block_size(10**6, 60.0, 4, 8) == 10**6 // MOST_BLOCKS


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["max:B.fx", "max(B.fx)"], "would be kept in one folder of the study, max"),
        (["a", "A"], "would be kept in one folder"),
        (["a", "a"], "would name several columns"),
        *(([name], "cannot name a column") for name in (
            "", "zarr.json", "Zarr.JSON", "x" * 300, "x\0y", "..\\y", "a/b", ".a", " a", "t",
        )),
    ],
)  # fmt: skip
def test_names_that_no_column_can_have(names: list[str], message: str) -> None:
    (problem,) = name_problems(names)
    assert message in problem


def test_a_lock_is_never_that_of_two(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, inner = tmp_path / "s.zarr", []
    real = shutil.rmtree

    def removing(folder: Path, **words: Any) -> None:
        """Another sweep begins while this one ends."""
        if not inner:
            inner.append(folder)
            with pytest.raises(InputError, match="Another sweep is writing"), store_lock(path):
                pass
        real(folder, **words)

    monkeypatch.setattr(shutil, "rmtree", removing)
    with store_lock(path):
        (tmp_path / "s.zarr.working").mkdir()
        inner.clear()
    assert inner
    assert [file.name for file in tmp_path.iterdir()] == [".s.zarr.lock"]
    with store_lock(path):
        pass


def changed(path: Path, change: Callable[[dict[str, Any]], None], part: str = "") -> None:
    file = path / part / "zarr.json"
    about = json.loads(file.read_text())
    change(about if part else about["attributes"]["linkwright_sweep"])
    file.write_text(json.dumps(about))


@pytest.mark.parametrize(
    "change",
    [
        {"runs": 10**13}, {"runs": 6}, {"runs": "7"}, {"block": 0}, {"block": 2}, {"facts": None},
        {"facts": {}}, {"design": []}, {"quantities": [3]}, {"series": ["../x"]}, {"identity": 1},
        {"format": None}, {"format": 1},
    ],
)  # fmt: skip
def test_attributes_that_no_sweep_has_written(path: Path, change: dict[str, Any]) -> None:
    changed(path, lambda about: about.update(change))
    with pytest.raises(InputError, match=r"not written by a sweep|is damaged|has format"):
        load_study(path)


@pytest.mark.parametrize("shape", [[10**13], [6], [7, 2]])
def test_arrays_of_other_lengths(path: Path, shape: list[int]) -> None:
    changed(path, lambda about: about.update(shape=shape), "t_last")
    with pytest.raises(InputError, match=r"t_last has the shape|not written by a sweep"):
        load_study(path)


def test_a_link_out_of_a_store_is_not_followed(path: Path) -> None:
    shutil.move(path / "t_last", path.with_name("elsewhere"))
    (path / "t_last").symlink_to("../elsewhere")
    with pytest.raises(InputError, match="t_last is a link"):
        load_study(path)
