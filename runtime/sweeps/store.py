"""The Zarr store of a sweep: its blocks, and what is done.

A block of runs is one chunk of each array, so that no two tasks write one file; Zarr replaces each
file whole. A block is written once all its runs are made, its mark last: a hash of its rows, by
which rows that a crash of the machine has damaged are found as well. Nothing of a block counts
without its mark. Nothing depends on when, where or how often a block is made.
A store has an identity, by which a task that is late finds that another one lies at its path.
"""

import hashlib
import shutil
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.values import shown
from runtime.results.zarr_store import require_plain
from runtime.sweeps.column_names import DONE, LAST, MESSAGE, OUTCOME, stored_name
from runtime.sweeps.member_run import Row
from runtime.sweeps.request import Request
from runtime.sweeps.store_attributes import (
    ATTRIBUTES,
    FORMAT,
    Layout,
    lengths,
    require_attributes,
)

Group = Any  # a `zarr.Group`, whose annotations permit less than it does


def require_zarr() -> Any:
    """The module `zarr`; InputError with the command that installs it."""
    try:
        import zarr
    except ImportError as error:
        raise InputError(
            "A sweep needs zarr, which is not installed. Run pip install 'linkwright[sweep]', in "
            "the checkout pip install '.[sweep]'."
        ) from error
    return zarr


def write_block(
    path: Path, identity: str, request: Request, runs: range, rows: Sequence[Row]
) -> int:
    """Write the rows of a block, its outcomes behind all others, and then its mark.

    What an earlier process has left of the block is removed first, in the opposite order.

    Raises
    ------
    InputError
        If the store is that of another sweep by now.
    """
    group = reopen(path, identity)
    region, about = slice(runs.start, runs.stop), about_of(group)
    block, arrays = runs.start // about["block"], arrays_of(request, rows)
    for place in chunks_of(path, request, block):
        _remove_chunk(place)
    for name, values in arrays.items():
        group[stored_name(name)][region] = values
    mark = mark_of(arrays, seal_of(about))
    group[DONE][block] = mark
    return mark


def chunks_of(path: Path, request: Request, block: int) -> list[Path]:
    """Where the chunks of a block lie, in the order in which they are removed."""
    names = (DONE, *reversed(arrays_of(request, ())))
    return [path / stored_name(name) / "c" / str(block) for name in names]


def _remove_chunk(place: Path) -> None:
    """Remove a chunk: a file, of a kept series a folder of one."""
    if place.is_dir():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)


def arrays_of(request: Request, rows: Sequence[Row]) -> dict[str, npt.NDArray[Any]]:
    """The arrays of a block, by name, in the order in which they are written: outcomes last."""
    text = np.dtypes.StringDType()
    arrays: dict[str, npt.NDArray[Any]] = {
        name: np.array([row.quantities[k] for row in rows], dtype=float)
        for k, (name, _) in enumerate(request.quantities)
    }
    for k, name in enumerate(request.keep):
        arrays[name] = np.array([row.series[k] for row in rows])
    arrays[LAST] = np.array([row.t_last for row in rows])
    arrays[MESSAGE] = np.array([row.message for row in rows], dtype=text)
    arrays[OUTCOME] = np.array([row.outcome for row in rows], dtype=text)
    return arrays


def mark_of(arrays: Mapping[str, npt.NDArray[Any]], seal: str) -> int:
    """A hash of a block's rows and of its sweep, never 0."""
    found = hashlib.blake2b(seal.encode(), digest_size=8)
    for name in sorted(arrays):
        values = arrays[name]
        found.update(f"{name}:{values.shape}".encode())
        if values.dtype.kind == "f":
            found.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
        else:
            found.update("\0".join(map(str, values.tolist())).encode())
    return int.from_bytes(found.digest(), "little") or 1


def seal_of(about: Mapping[str, Any]) -> str:
    """What tells the blocks of this store from those of all others."""
    return f"{about['identity']} {about['digest']}"


def open_group(path: Path, *, writable: bool = False) -> Group:
    """The group of a store that a sweep wrote; InputError where it is none.

    Nothing of it is run: arrays with codecs that might are refused before they are read.
    """
    zarr = require_zarr()
    if not path.is_dir():
        raise InputError(f"There is no study {path}. Name the folder that a sweep has written.")
    require_plain(path)
    try:
        group = zarr.open_group(path, mode="r+" if writable else "r", zarr_format=3)
        about = group.attrs[ATTRIBUTES]
        version = about["format"]
        if version == FORMAT:
            require_attributes(about)
            shapes = {n: group[n].shape for n in map(stored_name, lengths(about)) if n in group}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        why = f"{type(error).__name__}: {error}"
        raise InputError(f"{path} was not written by a sweep of Linkwright ({why}).") from None
    if version != FORMAT:
        raise InputError(
            f"{path} has format {shown(version)}, and this version reads {FORMAT}. Install the "
            "version that wrote it."
        )
    _require_arrays(path, about, shapes)
    return group


def _require_arrays(path: Path, about: Mapping[str, Any], shapes: Mapping[str, Any]) -> None:
    """Refuse a store that lacks arrays, or has some of other lengths than it says."""
    problems = []
    for name, length in lengths(about).items():
        shape = shapes.get(stored_name(name))
        dimensions = 2 if name in about["series"] else 1
        if shape is None:
            problems.append(f"{path} is damaged: it lacks {name}.")
        elif shape[:1] != (length,) or len(shape) != dimensions:
            problems.append(f"{path} is damaged: {name} has the shape {shape}, for {length} rows.")
        elif dimensions == 2 and shape[1] != about["facts"]["instants"]:
            problems.append(f"{path} is damaged: {name} has {shape[1]} instants.")
    if problems:
        raise InputError(problems)


def reopen(path: Path, identity: str) -> Group:
    """The group of a store that `open_group` has read before, to be written.

    Raises
    ------
    InputError
        If another store lies there by now.
    """
    zarr = require_zarr()
    try:
        group = zarr.open_group(path, mode="r+", zarr_format=3)
        same = about_of(group)["identity"] == identity
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path} cannot be opened any more ({type(error).__name__}: {error})."
        ) from error
    if not same:
        raise InputError(f"{path} is the store of another sweep by now.")
    return group


def about_of(group: Group) -> dict[str, Any]:
    """The attributes that a sweep has written."""
    about: dict[str, Any] = dict(group.attrs[ATTRIBUTES])
    return about


def layout_of(group: Group) -> Layout:
    """Runs and blocks of a store."""
    about = about_of(group)
    return Layout(int(about["runs"]), int(about["block"]))


def unfinished(
    group: Group, blocks: Iterable[int] | None = None, repeated: Collection[str] = ()
) -> list[int]:
    """Those of the blocks whose mark is missing, cannot be read, or is not that of their rows.

    A block of which a run has one of the outcomes `repeated` is one of them.
    """
    about, layout, again = about_of(group), layout_of(group), {*repeated}
    found = range(layout.blocks) if blocks is None else blocks
    arrays = ((block, _arrays(group, about, layout.runs_of(block))) for block in found)
    return [
        block for block, there in arrays
        if there is None or not again.isdisjoint(map(str, there[OUTCOME].tolist()))
    ]  # fmt: skip


def rows_made(group: Group, request: Request, runs: range) -> dict[int, Row]:
    """Run → row of a block that is written; nothing of one that is not."""
    arrays = _arrays(group, about_of(group), runs)
    return {} if arrays is None else rows_of(arrays, request, runs)


def rows_of(
    arrays: Mapping[str, npt.NDArray[Any]], request: Request, runs: Sequence[int]
) -> dict[int, Row]:
    """Run → row of arrays that have a row for each of these runs."""
    found, names = dict[int, Row](), [name for name, _ in request.quantities]
    for k, run in enumerate(runs):
        texts = (str(arrays[OUTCOME][k]), str(arrays[MESSAGE][k]))
        quantities = np.array([arrays[name][k] for name in names])
        series = np.array([arrays[name][k] for name in request.keep])
        last = float(arrays[LAST][k])
        found[run] = Row(quantities, *texts, last, series.reshape(-1, request.points))
    return found


def runs_written(group: Group) -> npt.NDArray[np.bool_]:
    """Whether the block of each run is written, (runs,)."""
    layout = layout_of(group)
    try:
        marks = np.asarray(group[DONE][:])
    except (OSError, ValueError, RuntimeError, TypeError):
        marks = np.array([mark_there(group, block) for block in range(layout.blocks)])
    return np.repeat(marks != 0, layout.block)[: layout.runs]


def mark_there(group: Group, block: int) -> int:
    """The mark of a block, 0 where there is none or it cannot be read."""
    try:
        return int(group[DONE][block])
    except (OSError, ValueError, RuntimeError, TypeError):  # a file that a power cut has cut short
        return 0


def _arrays(
    group: Group, about: Mapping[str, Any], runs: range
) -> dict[str, npt.NDArray[Any]] | None:
    """The arrays of a block; None where its mark is missing, or is not that of its rows."""
    names = [*about["quantities"], OUTCOME, MESSAGE, LAST, *about["series"]]
    mark = mark_there(group, runs.start // about["block"])
    if not mark:
        return None
    region = slice(runs.start, runs.stop)
    try:
        arrays = {name: group[stored_name(name)][region] for name in names}
    except (OSError, ValueError, RuntimeError, TypeError):
        return None
    return arrays if mark == mark_of(arrays, seal_of(about)) else None
