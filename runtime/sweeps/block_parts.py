"""Rows of a block that is not whole yet: one file a block, written by renaming, in the store.

A block of slow runs takes minutes. Its rows so far stand in such a file until the block is written
with its mark; a process that takes up the block reads them. The file has a mark of its own. It lies
in the folder of an array, where no reader of Zarr looks for members of the group.
"""

import json
import os
import shutil
import uuid
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.sweeps import store
from runtime.sweeps.column_names import DONE, MESSAGE, OUTCOME, RUN
from runtime.sweeps.member_run import Row
from runtime.sweeps.request import Request

_TEXTS, _MARK = (OUTCOME, MESSAGE), "mark"
_DAMAGE = (
    OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error
)  # fmt: skip


def parts_folder(path: Path) -> Path:
    """The folder of the parts in a store."""
    return path / DONE / "parts"


def part_file(path: Path, block: int) -> Path:
    """The file of a block's part."""
    return parts_folder(path) / f"{block}.npz"


def write_part(
    path: Path, about: Mapping[str, Any], request: Request, block: int, rows: Mapping[int, Row]
) -> None:
    """Replace the part of a block by these rows, run → row; the older one stays where that fails.

    Raises
    ------
    OSError
        If it cannot be written: a disk that is full.
    """
    file, runs = part_file(path, block), sorted(rows)
    arrays = _with_runs(store.arrays_of(request, [rows[run] for run in runs]), runs)
    texts = json.dumps([arrays[name].tolist() for name in _TEXTS]).encode()
    plain: dict[str, Any] = {f"a{k}": arrays[name] for k, name in enumerate(_numbers(request))}
    plain |= {RUN: arrays[RUN], "texts": np.frombuffer(texts, np.uint8)}
    plain[_MARK] = np.uint64(store.mark_of(arrays, store.seal_of(about)))
    file.parent.mkdir(exist_ok=True)
    temporary = file.with_name(f".{uuid.uuid4().hex}")
    try:
        with temporary.open("wb") as written:
            np.savez(written, **plain)
            written.flush()
            os.fsync(written.fileno())  # the name must not reach the disk before the content
        temporary.replace(file)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def read_part(path: Path, about: Mapping[str, Any], request: Request, block: int) -> dict[int, Row]:
    """Run → row of the part of a block; nothing where there is none, or its mark does not fit."""
    try:
        with (
            part_file(path, block).open("rb") as file,
            np.load(file, allow_pickle=False) as there,
        ):
            runs, mark = there[RUN].tolist(), int(there[_MARK])
            texts = json.loads(there["texts"].tobytes())
            arrays = {name: there[f"a{k}"] for k, name in enumerate(_numbers(request))}
        for name, values in zip(_TEXTS, texts, strict=True):
            arrays[name] = np.array(values, dtype=np.dtypes.StringDType())
        fits = mark == store.mark_of(_with_runs(arrays, runs), store.seal_of(about))
        return store.rows_of(arrays, request, runs) if fits else {}
    except _DAMAGE:
        return {}


def remove_part(path: Path, request: Request, block: int) -> None:
    """Remove the part of a block that is written, once the block is on the disk."""
    file = part_file(path, block)
    if not file.exists():
        return
    for place in store.chunks_of(path, request, block):
        for chunk in place.rglob("*") if place.is_dir() else (place,):
            if chunk.is_file():
                with chunk.open("rb") as written:
                    os.fsync(written.fileno())
    file.unlink(missing_ok=True)


def remove_parts(path: Path) -> None:
    """Remove what is left of parts in a store whose blocks are all written."""
    shutil.rmtree(parts_folder(path), ignore_errors=True)


def _numbers(request: Request) -> list[str]:
    """The arrays of numbers of a block, in one order."""
    return sorted({*store.arrays_of(request, ())} - {*_TEXTS})


def _with_runs(
    arrays: Mapping[str, npt.NDArray[Any]], runs: Sequence[int]
) -> dict[str, npt.NDArray[Any]]:
    return {**arrays, RUN: np.array(runs, dtype=np.int64)}
