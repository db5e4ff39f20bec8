"""The Zarr store of a sweep, which only the sweeping process writes.

A row is written number by number, its outcome last: a run without an outcome is not made, nor one
of whose row a file is missing. Zarr replaces each file whole, so that a process may end anywhere; a
file that a power cut has cut short cannot be read, and its runs are made again.
"""

import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from filelock import FileLock, Timeout
from pydantic import BaseModel, Field, FiniteFloat, PositiveInt, ValidationError

from codegen.errors import InputError, module_of_extra
from codegen.files.whole_files import flush_folder
from codegen.readers.values import shown
from runtime.core.arrays import Integers, Matrix
from runtime.results.zarr_store import require_plain
from runtime.sweeps.design import MOST_RUNS, Design
from runtime.sweeps.request import KILLED, MEMORY, Request, Rows

OUTCOME, MESSAGE, LAST, TIME, RUN = "outcome", "message", "t_last", "t", "run"
RESERVED = {OUTCOME, MESSAGE, LAST, TIME, RUN}
"""Names that no factor, quantity or series of a sweep may have."""
FORMAT = 4  # of the attributes below
_ATTRIBUTES = "linkwright_sweep"
_LONGEST = 200  # safety: bytes of a folder's name; file systems permit 255
_POINTS = 1 << 17  # layout: values of a factor in one chunk
TASK_SECONDS = 3.0  # measured: of runs in a task, beside which handing out and writing is little
CHUNK_BYTES = 64 << 20  # safety: of rows in a file, which a process has in memory twice
MOST_CHUNKS = 10_000  # safety: files of a column
TASKS_A_WORKER = 8  # measured: at least, so that the last ones end together
_UNREADABLE = (OSError, ValueError, RuntimeError, TypeError)
"""What Zarr raises for a file that a power cut has cut short."""


class About(BaseModel, frozen=True):
    """The attributes of a store."""

    format: int
    facts: dict[str, Any]  # of the request
    design: Design
    runs: PositiveInt = Field(le=MOST_RUNS)
    chunk: PositiveInt  # runs of a file
    seconds: FiniteFloat  # of the processor, a run


def stored_name(name: str) -> str:
    """The name of a column's folder: not all file systems permit the colon of a quantity."""
    word, colon, rest = name.partition(":")
    return f"{word}({rest})" if colon else name


def name_problems(names: Sequence[str]) -> Iterator[str]:
    """A sentence for each name that cannot be a column, or would share its folder with another."""
    folders = dict[str, str]()  # as file systems compare them that ignore case → name
    for name in dict.fromkeys(names):
        stored = stored_name(name)
        special = not name.isprintable() or name != name.strip() or any(c in name for c in "/\\")
        unfit = (
            name in RESERVED or stored.casefold() == "zarr.json" or len(stored.encode()) > _LONGEST
        )
        if not name or special or unfit or name.startswith((".", "__")):
            yield f"{shown(name)} cannot name a column of the study; choose another name."
            continue
        other = folders.setdefault(stored.casefold(), name)
        if other != name or names.count(name) > 1:
            yield (
                f"{name} would name several columns of the study, or one folder, {stored}, those "
                f'of {other}; rename the quantity, quantities={{"NAME": ...}}, or leave one out.'
            )


def require_zarr() -> Any:
    """The module `zarr`; InputError with the command that installs it."""
    return module_of_extra("zarr", "sweep", "A sweep needs zarr")


class Store:
    """A store that lies at a path: what its attributes say, and its arrays."""

    def __init__(self, path: Path, group: Any) -> None:
        self.path, self.group = path, group
        self.about = About.model_validate(group.attrs[_ATTRIBUTES])
        self.request = Request.model_validate(self.about.facts)
        names = (*self.request.quantities, LAST, *self.request.series, MESSAGE, OUTCOME)
        with require_zarr().config.set({"array.write_empty_chunks": True}):
            self.columns = {name: group[stored_name(name)] for name in names}
        self.identity = self._identity()
        self.broken = set[int]()  # numbers of the files that are written anew, with their rows

    def _identity(self) -> tuple[int, int]:
        root = (self.path / "zarr.json").stat()
        return root.st_ino, root.st_mtime_ns

    def _files(self, chunk: int) -> list[Path]:
        """The files of some runs, that of their outcomes last."""
        ends = dict.fromkeys(self.request.series, "0")
        return [
            self.path.joinpath(stored_name(name), "c", str(chunk), ends.get(name, ""))
            for name in self.columns
        ]

    def write(self, runs: range | Integers, rows: Rows) -> None:
        """Write the rows of some runs, their outcomes last.

        InputError where another store lies in its place by now.
        """
        if self._identity() != self.identity:
            raise InputError(f"{self.path} is another store by now, which is left alone.")
        for chunk in self.broken & {run // self.about.chunk for run in runs}:
            for file in reversed(self._files(chunk)):
                file.unlink(missing_ok=True)
            self.broken.remove(chunk)
        text = np.dtypes.StringDType()
        columns = [*rows.numbers.T, *np.moveaxis(rows.series, 1, 0)]
        columns += [np.array(texts, dtype=text) for texts in (rows.messages, rows.outcomes)]
        place = slice(runs.start, runs.stop) if isinstance(runs, range) else runs
        for array, values in zip(self.columns.values(), columns, strict=True):
            array.oindex[place] = values

    def outcomes(self) -> npt.NDArray[np.object_]:
        """The outcome of each run; empty where it has none, or a file of its row is missing."""
        found = np.asarray(self.columns[OUTCOME][:]).astype(object)
        for chunk in range(math.ceil(self.about.runs / self.about.chunk)):
            if not all(file.exists() for file in self._files(chunk)):
                found[chunk * self.about.chunk :][: self.about.chunk] = ""
        return found

    def unmade(self) -> Integers:
        """The runs to make: those without an outcome, then those that another day may make.

        Where a file is missing or cannot be read, all of its runs are: its number is in `broken`.

        Raises InputError if the system refuses to read a file, or none of several can be read.
        """
        runs, size, unread = self.about.runs, self.about.chunk, list[Exception]()
        found = np.full(runs, "", object)
        for chunk in range(math.ceil(runs / size)):
            part = slice(chunk * size, (chunk + 1) * size)
            whole = all(file.exists() for file in self._files(chunk))
            try:
                *_, outcomes = (array[part] for array in self.columns.values())
            except _UNREADABLE as error:
                unread.append(error)
                whole = False
                if getattr(error, "errno", None):
                    break
            if whole:
                found[part] = outcomes
            else:
                self.broken.add(chunk)
        if unread and (getattr(unread[-1], "errno", None) or (len(unread) > 1 and not any(found))):
            raise InputError(
                f"{self.path} cannot be read ({type(unread[-1]).__name__}: {unread[-1]}). It is "
                "left as it is: find out why, or begin a store of another name."
            )
        return np.concatenate(
            [np.flatnonzero(found == ""), np.flatnonzero((found == KILLED) | (found == MEMORY))]
        )


def open_store(path: Path, mode: str = "r") -> Store:
    """A store that a sweep wrote; InputError where it is none.

    Nothing of it is run: arrays with codecs that might are refused before they are read.
    """
    zarr = require_zarr()
    if not path.is_dir():
        raise InputError(f"There is no study {path}. Name the folder that a sweep has written.")
    require_plain(path)
    try:
        group = zarr.open_group(path, mode=mode, zarr_format=3)
        version = group.attrs[_ATTRIBUTES]["format"]
        if isinstance(version, int) and version != FORMAT:
            raise InputError(
                f"{path} has format {version}, and this version reads {FORMAT}. Install the "
                "version that wrote it."
            )
        store = Store(path, group)
        _require_fit(store)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        why = f"{type(error).__name__}: {error}"
        if isinstance(error, ValidationError):  # one line of many
            first = error.errors()[0]
            why = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
        raise InputError(f"{path} was not written by a sweep of Linkwright ({why}).") from None
    return store


def _require_fit(store: Store) -> None:
    """Refuse arrays and names that no sweep has written: ValueError with what is wrong."""
    about, request = store.about, store.request
    axes, names = about.design.axes, request.factors
    if axes and (math.prod(axes.values()) != about.runs or {*axes} != {*names}):
        raise ValueError(f"the grid has the axes {shown(axes)}, for {about.runs} runs")
    for problem in name_problems([*names, *request.quantities, *request.series]):
        raise ValueError(problem)
    factors = {name: store.group[stored_name(name)] for name in names}
    for name, array in {**factors, **store.columns}.items():
        if array.shape != (about.runs, request.instants)[: 1 + (name in request.series)]:
            raise ValueError(f"{name} has the shape {array.shape}, for {about.runs} runs")


def create_store(
    path: Path, request: Request, design: Design, points: Matrix, units: Mapping[str, str],
    chunk: int, seconds: float,
) -> None:  # fmt: skip
    """Write the store of a sweep, whole or not at all: all its arrays, empty but for the points.

    `units` are those of all columns by name; a file has so many runs, each of so many seconds.
    """
    runs, instants = len(points), request.instants
    about = About(
        format=FORMAT, facts=request.facts(points), design=design, runs=runs, chunk=chunk,
        seconds=seconds,
    )  # fmt: skip
    attributes = {
        _ATTRIBUTES: about.model_dump(mode="json"),
        "coordinates": " ".join([*request.factors, TIME]),
    }
    units = {**units, LAST: "s", TIME: "s"}

    def create(
        name: str, *dims: str, kind: Any = "float64", chunk: int = chunk, **labels: str
    ) -> Any:  # fmt: skip
        sizes = {RUN: (runs, chunk), TIME: (instants, instants)}
        shape, chunks = zip(*(sizes[dim] for dim in dims), strict=True)
        labels |= {"units": units[name]} if units.get(name) else {}
        return group.create_array(
            stored_name(name), shape=shape, dtype=kind, fill_value="" if kind is str else np.nan,
            chunks=chunks, dimension_names=dims, attributes=labels,
        )  # fmt: skip

    with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as folder:
        where = Path(folder, "store")
        group = require_zarr().create_group(where, zarr_format=3, attributes=attributes)
        for name, column in zip(request.factors, points.T, strict=True):
            create(name, RUN, chunk=min(runs, _POINTS))[:] = column
        for name, given in request.quantities.items():
            create(name, RUN, quantity=given if isinstance(given, str) else name)
        create(OUTCOME, RUN, kind=str)
        create(MESSAGE, RUN, kind=str)
        create(LAST, RUN)
        if request.series:
            create(TIME, TIME)[:] = np.linspace(request.t_start, request.t_end, instants)
        for name in request.series:
            create(name, RUN, TIME)
        flush_folder(where)  # before a name that leads to it is there
        try:
            where.rename(path)
        except OSError:
            raise InputError(f"{path} exists by now: another program has written it.") from None


def file_sizes(runs: int, seconds: float, workers: int, row: int) -> tuple[int, int]:
    """Runs of a task, and of a file, which has one task or more.

    A task takes seconds, each worker gets several, and its rows fit in memory; `seconds` is the
    time of a run, `row` the bytes of its row. Of many slow runs a file has several tasks.
    """
    by_time = TASK_SECONDS / max(seconds, 1e-6)
    by_share = runs / (TASKS_A_WORKER * max(workers, 1))
    most = max(1, min(runs, CHUNK_BYTES // max(row, 1)))
    size = max(1, min(most, math.ceil(min(by_time, by_share))))
    return size, min(most, max(size, math.ceil(runs / MOST_CHUNKS)))


def tasks_of(runs: Integers, chunk: int, size: int) -> list[range]:
    """Runs as ranges of at most `size`, each of one file of `chunk` runs."""
    places = runs // chunk * chunk + runs % chunk // size
    cuts = np.flatnonzero((np.diff(runs) != 1) | (np.diff(places) != 0)) + 1
    parts = np.split(runs, cuts) if len(runs) else []
    return [range(int(part[0]), int(part[-1]) + 1) for part in parts]


@contextmanager
def store_lock(path: Path) -> Iterator[None]:
    """Keep other sweeps off a store.

    The file of the lock stays: were it removed, two sweeps could lock two files of its name.
    """
    place = path.with_name(f".{path.name}.lock")
    try:
        held = FileLock(place, timeout=0).acquire()
    except Timeout:
        raise InputError(f"Another sweep is writing {path}. Wait until it has ended.") from None
    except OSError as error:
        raise InputError(f"{place} cannot be written: {error.strerror or error}.") from error
    with held:
        yield
