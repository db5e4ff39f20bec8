"""The Zarr store of a sweep: its blocks, and which of them are done.

A block of runs is one chunk of each array, so that no two tasks write one file; Zarr replaces each
file whole. A block is written once all its runs are made, its mark last: a hash of its rows, by
which rows that a crash of the machine has damaged are found as well. Nothing of a block counts
without its mark. Nothing depends on when, where or how often a block is made.
A store has an identity, by which a task that is late finds that another one lies at its path.
"""

import hashlib
import json
import math
import shutil
import tempfile
import uuid
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.files.whole_files import flush_folder
from codegen.readers.values import shown
from runtime.results.zarr_store import MOST_METADATA, require_plain
from runtime.sweeps.design import MOST_RUNS, Design
from runtime.sweeps.member_run import Row
from runtime.sweeps.request import Request, digest_of

Arrays = dict[str, npt.NDArray[Any]]
DONE, OUTCOME, MESSAGE, LAST, TIME, RUN = "block_mark", "outcome", "message", "t_last", "t", "run"
RESERVED = {DONE, OUTCOME, MESSAGE, LAST, TIME, RUN, "block"}
"""Names that no factor, quantity or series of a sweep may have."""
_LONGEST = 200  # safety: bytes of a folder's name; file systems permit 255
FORMAT = 3  # of the attributes below, and of the marks
ATTRIBUTES = "linkwright_sweep"
_POINTS = 1 << 17  # layout: values of a factor in one chunk, of which a task reads those it needs
_UNREADABLE = (OSError, ValueError, RuntimeError, TypeError)
"""What Zarr raises for a file that a power cut has cut short."""
_FORM: dict[str, Any] = {
    "identity": "", "digest": "", "quantities": [""], "series": [""], "runs": 1, "block": 1,
    "seconds": 0.0,
    "design": {"kind": "", "names": [""], "factors": {}, "axes": {}},
    "facts": {
        "model": "", "generated module": "", "analysis": "", "start values": [""], "series": [""],
        "instants": 1, "t_start": 0.0, "t_end": 0.0, "parameters": {}, "guess": {}, "start": {},
        "companions": {}, "quantities": {}, "options": {},
    },
}  # fmt: skip
"""Attributes of a store by an example of each: 1 stands for a count, 0.0 for any number."""


def stored_name(name: str) -> str:
    """The name of a column's folder: not all file systems permit the colon of a quantity."""
    word, colon, rest = name.partition(":")
    return f"{word}({rest})" if colon else name


def name_problems(names: Sequence[str]) -> Iterator[str]:
    """A sentence for each name that cannot be a column, or would share its folder with another."""
    folders = dict[str, str]()  # as file systems compare them that ignore case → name
    for name in dict.fromkeys(names):
        stored = stored_name(name)
        if not _permitted(name, stored):
            yield f"{shown(name)} cannot name a column of the study; choose another name."
            continue
        other = folders.setdefault(stored.casefold(), name)
        if names.count(name) > 1:
            yield (
                f"{name} would name several columns of the study; rename the quantity, "
                'quantities={"NAME": ...}, or leave one out.'
            )
        elif other != name:
            yield (
                f"{name} and {other} would be kept in one folder of the study, {stored}; rename "
                'one, quantities={"NAME": ...}.'
            )


def _permitted(name: str, stored: str) -> bool:
    special = not name.isprintable() or name != name.strip() or any(c in name for c in "/\\")
    length = len(stored.encode("utf-8", "replace"))
    reserved = name in RESERVED or stored.casefold() == "zarr.json"
    return bool(name) and not (
        special or reserved or name.startswith((".", "__")) or length > _LONGEST
    )


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


class Store:
    """A store that lies at a path: what its attributes say, and its arrays."""

    def __init__(self, path: Path, group: Any) -> None:
        self.path, self.group = path, group
        self.about: dict[str, Any] = dict(group.attrs[ATTRIBUTES])
        self.runs, self.block = self.about["runs"], self.about["block"]
        self.blocks = -(-self.runs // self.block)
        self.columns = (*self.about["quantities"], LAST)  # of numbers, one a run
        self.series: tuple[str, ...] = tuple(self.about["series"])
        self.instants = self.about["facts"]["instants"]
        self.seal = f"{self.about['identity']} {self.about['digest']}"

    def runs_of(self, block: int) -> range:
        """The runs of a block; the last one may have fewer."""
        return range(block * self.block, min((block + 1) * self.block, self.runs))

    def points(self, runs: range) -> npt.NDArray[np.float64]:
        """The points of these runs, (runs, factors)."""
        names = self.about["design"]["names"]
        return np.stack([self.group[name][runs.start : runs.stop] for name in names], axis=1)

    def arrays_of(self, rows: Sequence[Row]) -> Arrays:
        """The arrays of a block, by name."""
        text = np.dtypes.StringDType()
        table = np.array([(*row.quantities, row.t_last) for row in rows])
        arrays: Arrays = dict(zip(self.columns, table.T, strict=True))
        for k, name in enumerate(self.series):
            arrays[name] = np.array([row.series[k] for row in rows])
        arrays[MESSAGE] = np.array([row.message for row in rows], dtype=text)
        arrays[OUTCOME] = np.array([row.outcome for row in rows], dtype=text)
        return arrays

    def write_block(self, block: int, rows: Sequence[Row]) -> None:
        """Write the rows of a block, and then its mark.

        What an earlier process has left of the block is removed first, its mark before all.

        Raises
        ------
        InputError
            If another store lies there by now: the runs may have taken long.
        """
        reopen(self.path, self.about["identity"])
        runs, arrays = self.runs_of(block), self.arrays_of(rows)
        for place in self.chunks(block):
            if place.is_dir():  # of a kept series
                shutil.rmtree(place)
            else:
                place.unlink(missing_ok=True)
        for name, values in arrays.items():
            self.group[stored_name(name)][runs.start : runs.stop] = values
        self.group[DONE][block] = self.mark_of(arrays)

    def chunks(self, block: int) -> list[Path]:
        """Where the chunks of a block lie, that of its mark first."""
        names = (DONE, OUTCOME, MESSAGE, *self.columns, *self.series)
        return [self.path / stored_name(name) / "c" / str(block) for name in names]

    def mark_of(self, arrays: Mapping[str, npt.NDArray[Any]]) -> int:
        """A hash of a block's rows and of its sweep, never 0."""
        found = hashlib.blake2b(self.seal.encode(), digest_size=8)
        for name in sorted(arrays):
            values = arrays[name]
            found.update(f"{name}:{values.shape}".encode())
            if values.dtype.kind == "f":
                found.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
            else:
                found.update("\0".join(map(str, values.tolist())).encode())
        return int.from_bytes(found.digest(), "little") or 1

    def mark(self, block: int) -> int:
        """The mark of a block, 0 where there is none or it cannot be read."""
        try:
            return int(self.group[DONE][block])
        except _UNREADABLE:
            return 0

    def read_block(self, block: int) -> Arrays | None:
        """The arrays of a block; None where its mark is missing, or is not that of its rows."""
        mark, runs = self.mark(block), self.runs_of(block)
        names = (*self.columns, *self.series, OUTCOME, MESSAGE)
        try:
            region = slice(runs.start, runs.stop)
            arrays = {name: self.group[stored_name(name)][region] for name in names} if mark else {}
        except _UNREADABLE:
            return None
        return arrays if arrays and mark == self.mark_of(arrays) else None

    def rows(self, block: int) -> dict[int, Row]:
        """Run → row of a block that is written; nothing of one that is not."""
        arrays, found = self.read_block(block), dict[int, Row]()
        for k, run in enumerate(self.runs_of(block) if arrays else ()):
            assert arrays is not None
            *quantities, last = (float(arrays[name][k]) for name in self.columns)
            texts = str(arrays[OUTCOME][k]), str(arrays[MESSAGE][k])
            series = np.array([arrays[name][k] for name in self.series])
            series = series.reshape(-1, self.instants)
            found[run] = Row(np.array(quantities), *texts, last, series)
        return found

    def unfinished(
        self, blocks: Iterable[int] | None = None, repeated: Collection[str] = ()
    ) -> list[int]:
        """Those of the blocks whose mark is missing, cannot be read, or is not that of their rows.

        A block of which a run has one of the outcomes `repeated` is one of them.
        """
        found = range(self.blocks) if blocks is None else blocks
        arrays = ((block, self.read_block(block)) for block in found)
        return [
            block for block, there in arrays
            if there is None or not {*repeated}.isdisjoint(map(str, there[OUTCOME].tolist()))
        ]  # fmt: skip

    def runs_written(self) -> npt.NDArray[np.bool_]:
        """Whether the block of each run is written, (runs,)."""
        try:
            marks = np.asarray(self.group[DONE][:])
        except _UNREADABLE:
            marks = np.array([self.mark(block) for block in range(self.blocks)])
        return np.repeat(marks != 0, self.block)[: self.runs]


def open_store(path: Path) -> Store:
    """A store that a sweep wrote; InputError where it is none.

    Nothing of it is run: arrays with codecs that might are refused before they are read.
    """
    zarr = require_zarr()
    if not path.is_dir():
        raise InputError(f"There is no study {path}. Name the folder that a sweep has written.")
    require_plain(path)
    try:
        group = zarr.open_group(path, mode="r", zarr_format=3)
        about = group.attrs[ATTRIBUTES]
        version = about["format"]
        if version == FORMAT:
            _require_attributes(about)
            shapes = {name: getattr(group.get(name), "shape", None) for name in _shapes(about)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        why = f"{type(error).__name__}: {error}"
        raise InputError(f"{path} was not written by a sweep of Linkwright ({why}).") from None
    if version != FORMAT:
        raise InputError(
            f"{path} has format {shown(version)}, and this version reads {FORMAT}. Install the "
            "version that wrote it."
        )
    problems = [
        f"{path} is damaged: {name} has the shape {shapes[name]}, and not {shape}."
        for name, shape in _shapes(about).items() if shapes[name] != shape
    ]  # fmt: skip
    if problems:
        raise InputError(problems)
    return Store(path, group)


def reopen(path: Path, identity: str) -> Store:
    """A store that `open_store` has read before, to be written.

    Raises
    ------
    InputError
        If another store lies there by now.
    """
    try:
        found = Store(path, require_zarr().open_group(path, mode="r+", zarr_format=3))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path} cannot be opened any more ({type(error).__name__}: {error})."
        ) from error
    if found.about["identity"] != identity:
        raise InputError(f"{path} is the store of another sweep by now.")
    return found


def _fits(value: object, form: Any) -> bool:
    """Whether a value of JSON has the kind of an example."""
    if isinstance(form, dict):
        return isinstance(value, dict) and all(
            k in value and _fits(value[k], form[k]) for k in form
        )
    if isinstance(form, list):
        return isinstance(value, list) and all(_fits(entry, form[0]) for entry in value)
    if isinstance(form, float):
        return type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]
    return type(value) is type(form) and (form != 1 or 1 <= value <= MOST_RUNS)  # type: ignore[operator]


def _require_attributes(about: Mapping[str, Any]) -> None:
    """Refuse attributes that no sweep has written: ValueError with what is wrong."""
    for name, form in _FORM.items():
        if not _fits(about.get(name), form):
            raise ValueError(f"{name} is {shown(about.get(name))}")
    runs, axes, names = about["runs"], about["design"]["axes"], about["design"]["names"]
    fits = all(_fits(count, 1) for count in axes.values())
    if axes and not (fits and math.prod(axes.values()) == runs and {*axes} == {*names}):
        raise ValueError(f"the grid has the axes {shown(axes)}, for {runs} runs")
    for problem in name_problems([*names, *about["quantities"], *about["series"]]):
        raise ValueError(problem)


def _shapes(about: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    """Stored column → its shape."""
    runs, blocks = about["runs"], -(-about["runs"] // about["block"])
    names = [*about["design"]["names"], *about["quantities"], OUTCOME, MESSAGE, LAST]
    shapes: dict[str, tuple[int, ...]] = {stored_name(name): (runs,) for name in names}
    series = (stored_name(name) for name in about["series"])
    return {**shapes, **dict.fromkeys(series, (runs, about["facts"]["instants"])), DONE: (blocks,)}


def create_store(
    path: Path, request: Request, design: Design, units: Mapping[str, str], block: int,
    seconds: float,
) -> None:  # fmt: skip
    """Write the store of a sweep, whole or not at all: all its arrays, empty but for the points.

    `units` are those of all columns by name; a block has so many runs, each of so many seconds.
    """
    facts = request.facts(design.digest)
    about = {
        "format": FORMAT, "identity": uuid.uuid4().hex, "digest": digest_of(facts),
        "facts": facts, "design": design.facts, "quantities": [*request.quantities],
        "series": [*request.keep], "runs": len(design.points), "block": block, "seconds": seconds,
    }  # fmt: skip
    size = len(json.dumps(about))
    if size > MOST_METADATA // 2:
        raise InputError(
            f"The request takes {size} bytes as JSON, and a store has {MOST_METADATA // 2} for it. "
            "Give fewer names, parameters or options."
        )
    attributes = {ATTRIBUTES: about, "coordinates": " ".join([*design.names, TIME])}
    with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as folder:
        where = Path(folder, "store")
        group = require_zarr().create_group(where, zarr_format=3, attributes=attributes)
        _create_arrays(group, request, design, units, block)
        flush_folder(where)  # before a name that leads to it is there
        try:
            where.rename(path)
        except OSError:
            raise InputError(f"{path} exists by now: another program has written it.") from None


def _create_arrays(
    group: Any, request: Request, design: Design, units: Mapping[str, str], block: int
) -> None:
    runs, instants = len(design.points), request.points
    block, units = min(block, runs), {**units, LAST: "s", TIME: "s"}

    def create(
        name: str, kind: Any = "float64", dims: tuple[str, ...] = (RUN,),
        chunks: tuple[int, ...] = (block,), shape: tuple[int, ...] = (runs,), **labels: str,
    ) -> Any:  # fmt: skip
        if units.get(name):
            labels = {"units": units[name], **labels}
        fill = {"float64": np.nan, str: "", "uint64": 0}[kind]
        return group.create_array(
            stored_name(name), shape=shape, dtype=kind, fill_value=fill, chunks=chunks,
            dimension_names=dims, attributes=labels,
        )  # fmt: skip

    for k, name in enumerate(design.names):
        create(name, chunks=(min(runs, _POINTS),))[:] = design.points[:, k]
    for name, given in request.quantities.items():
        create(name, quantity=given if isinstance(given, str) else name)
    create(OUTCOME, str)
    create(MESSAGE, str)
    create(LAST)
    if request.keep:
        times = np.linspace(request.t_start, request.t_end, instants)
        create(TIME, dims=(TIME,), chunks=(instants,), shape=(instants,))[:] = times
    for name in request.keep:
        create(name, dims=(RUN, TIME), chunks=(block, instants), shape=(runs, instants))
    create(DONE, "uint64", ("block",), (1,), (-(-runs // block),))
