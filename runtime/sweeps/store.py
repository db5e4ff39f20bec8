"""The Zarr store of a sweep: its template, its blocks, and what is done.

The template is written in a folder of another name, which takes its place when it is whole. A block
of runs is one chunk of each array, so that no two tasks write one file; Zarr replaces each file
whole. A block's mark is written last: a hash of its rows, by which rows that a crash of the machine
has damaged are found as well. Nothing depends on when, where or how often a block is made.
"""

import hashlib
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.results.zarr_store import require_plain
from runtime.sweeps.design import Design
from runtime.sweeps.member_run import Row
from runtime.sweeps.request import Request, digest_of

Group = Any  # a `zarr.Group`, whose annotations permit less than it does

FORMAT = 1  # of the attributes below
ATTRIBUTES = "linkwright_sweep"
DONE, OUTCOME, MESSAGE, LAST, TIME, RUN = "block_mark", "outcome", "message", "t_last", "t", "run"
RESERVED = {DONE, OUTCOME, MESSAGE, LAST, TIME, RUN, "block"}
"""Names that no factor, quantity or series of a sweep may have."""


class Layout(NamedTuple):
    """Runs of a sweep, in blocks."""

    runs: int
    block: int  # runs of a block; the last one may have fewer

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.runs // self.block)

    def runs_of(self, block: int) -> range:
        """The runs of a block."""
        return range(block * self.block, min((block + 1) * self.block, self.runs))


class Columns(NamedTuple):
    """Units of all that is stored, by name."""

    factors: Mapping[str, str]
    quantities: Mapping[str, str]
    series: Mapping[str, str]


def stored_name(name: str) -> str:
    """The name of a column's folder: not all file systems permit the colon of a quantity."""
    word, colon, rest = name.partition(":")
    return f"{word}({rest})" if colon else name


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


def create_store(
    path: Path, request: Request, design: Design, columns: Columns, block: int
) -> None:
    """Write the template of a sweep, whole or not at all."""
    zarr, layout = require_zarr(), Layout(len(design.points), block)
    facts = request.facts(design.digest)
    about = {
        "format": FORMAT, "digest": digest_of(facts), "facts": facts, "design": design.facts,
        "quantities": [name for name, _ in request.quantities], "series": [*request.keep],
        "runs": layout.runs, "block": block,
    }  # fmt: skip
    folder = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    try:
        where = folder / "store"
        group = zarr.create_group(
            where, zarr_format=3,
            attributes={ATTRIBUTES: about, "coordinates": " ".join([*design.names, TIME])},
        )  # fmt: skip
        _create_arrays(group, request, design, columns, layout)
        try:
            where.rename(path)
        except OSError:
            raise InputError(f"{path} exists by now: another program has written it.") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _create_arrays(
    group: Group, request: Request, design: Design, columns: Columns, layout: Layout
) -> None:
    runs, block, count = layout.runs, min(layout.block, layout.runs), request.points

    def create(
        name: str, kind: Any, fill: Any, chunks: Sequence[int], dims: Sequence[str], unit: str = "",
        shape: Sequence[int] | None = None, **attributes: str,
    ) -> Any:  # fmt: skip
        labels = {**({"units": unit} if unit else {}), **attributes}
        return group.create_array(
            stored_name(name), shape=tuple(shape or (runs,)), dtype=kind, fill_value=fill,
            chunks=tuple(chunks), dimension_names=tuple(dims), attributes=labels,
        )  # fmt: skip

    for k, name in enumerate(design.names):
        values = create(name, "float64", np.nan, (runs,), (RUN,), columns.factors[name])
        values[:] = design.points[:, k]
    for name, given in request.quantities:
        text = given if isinstance(given, str) else name
        create(name, "float64", np.nan, (block,), (RUN,), columns.quantities[name], quantity=text)
    create(OUTCOME, str, "", (block,), (RUN,))
    create(MESSAGE, str, "", (block,), (RUN,))
    create(LAST, "float64", np.nan, (block,), (RUN,), "s")
    if request.keep:
        instants = np.linspace(request.t_start, request.t_end, count)
        create(TIME, "float64", np.nan, (count,), (TIME,), "s", (count,))[:] = instants
    for name in request.keep:
        create(
            name, "float64", np.nan, (block, count), (RUN, TIME), columns.series[name],
            (runs, count),
        )  # fmt: skip
    create(DONE, "uint64", 0, (1,), ("block",), shape=(layout.blocks,))


def write_block(group: Group, request: Request, runs: range, rows: Sequence[Row]) -> None:
    """Write the rows of a block into its region, and then its mark."""
    region, about = slice(runs.start, runs.stop), about_of(group)
    for name, values in _arrays(request, rows).items():
        group[stored_name(name)][region] = values
    group[DONE][runs.start // about["block"]] = mark_of(_arrays(request, rows))


def _arrays(request: Request, rows: Sequence[Row]) -> dict[str, npt.NDArray[Any]]:
    """The arrays of a block, by name."""
    quantities = np.array([row.quantities for row in rows]).reshape(len(rows), -1)
    text = np.dtypes.StringDType()
    arrays: dict[str, npt.NDArray[Any]] = {
        name: quantities[:, k] for k, (name, _) in enumerate(request.quantities)
    }
    arrays[OUTCOME] = np.array([row.outcome for row in rows], dtype=text)
    arrays[MESSAGE] = np.array([row.message for row in rows], dtype=text)
    arrays[LAST] = np.array([row.t_last for row in rows])
    for k, name in enumerate(request.keep):
        arrays[name] = np.array([row.series[k] for row in rows])
    return arrays


def mark_of(arrays: Mapping[str, npt.NDArray[Any]]) -> int:
    """A hash of a block's rows, never 0."""
    found = hashlib.blake2b(digest_size=8)
    for name in sorted(arrays):
        values = arrays[name]
        found.update(f"{name}:{values.shape}".encode())
        if values.dtype.kind == "f":
            found.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
        else:
            found.update("\0".join(map(str, values.tolist())).encode())
    return int.from_bytes(found.digest(), "little") or 1


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
        about = group.attrs.get(ATTRIBUTES)
        names = {*about["quantities"], *about["series"], *about["design"]["names"], OUTCOME, DONE}
        every = (*names, MESSAGE, LAST)
        missing = [name for name in every if stored_name(name) not in group]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        why = f"{type(error).__name__}: {error}"
        raise InputError(f"{path} was not written by a sweep of Linkwright ({why}).") from None
    if missing:
        raise InputError(f"{path} is damaged: it lacks {', '.join(missing)}.")
    if about["format"] != FORMAT:
        raise InputError(
            f"{path} has format {about['format']}, and this version reads {FORMAT}. Install the "
            f"version that wrote it: {about['facts'].get('linkwright')}."
        )
    return group


def about_of(group: Group) -> dict[str, Any]:
    """The attributes that a sweep has written."""
    about: dict[str, Any] = dict(group.attrs[ATTRIBUTES])
    return about


def layout_of(group: Group) -> Layout:
    """Runs and blocks of a store."""
    about = about_of(group)
    return Layout(int(about["runs"]), int(about["block"]))


def unfinished(group: Group) -> list[int]:
    """Blocks whose mark is missing, or is not that of their rows."""
    layout, marks = layout_of(group), group[DONE][:]
    about = about_of(group)
    names = [*about["quantities"], OUTCOME, MESSAGE, LAST, *about["series"]]
    waiting = []
    for block in range(layout.blocks):
        runs = layout.runs_of(block)
        if marks[block]:
            region = slice(runs.start, runs.stop)
            if mark_of({name: group[stored_name(name)][region] for name in names}) == int(
                marks[block]
            ):
                continue
        waiting.append(block)
    return waiting
