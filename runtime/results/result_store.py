"""A result that is written as a Zarr store while its run goes on, in chunks of rows.

The store is readable after every chunk: the root's metadata, which have those of all variables, are
replaced by one renaming when the rows of all of them are on the disk. Its attribute `outcome` is
RUNNING until the run has ended. The same rows go into temporary files beside it, which the `Result`
of the run maps into memory, so that what a run holds does not grow with its length.
"""

import json
import os
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.files.whole_files import whole_folder
from runtime.core.outcomes import Outcome
from runtime.mechanism.module_tables import Description
from runtime.results.dataset import dataset
from runtime.results.export import check_place
from runtime.results.memory import sample_bytes
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.results.zarr_store import write_dataset

FloatArray = npt.NDArray[np.float64]

RUNNING = "RUNNING"
"""The outcome of a store whose run has not ended, or was killed."""
FAILED = "FAILED"
"""The outcome of a store whose run ended with an error, of which `message` has the text."""
_METADATA = "zarr.json"
_CHUNK_BYTES = 2**22  # measured: of all variables of a chunk; more are no faster
_LEAST, _MOST = 16, 2**14  # safety: rows of a chunk


class ResultStore:
    """The rows of one run, in a Zarr store at `path` and in files that memory maps.

    Raises InputError where something stands at `path`, or nothing can be written there.
    """

    def __init__(self, path: Path, description: Description, p: FloatArray) -> None:
        if path.suffix.lower() != ".zarr":
            raise InputError(
                f"out={str(path)!r}: rows are written into a Zarr store while the run goes on. "
                "Choose a name that ends in .zarr, or save the result: Result.save."
            )
        if path.exists():
            raise InputError(f"{path} is there already. Choose another name, or remove it.")
        check_place(path)
        self.path, self.description, self.p = path, description, p
        rows = _CHUNK_BYTES // sample_bytes(description)
        self.rows = max(_LEAST, min(_MOST, rows))  # of a chunk
        self.count = 0  # of rows in the store
        self._files = ExitStack()
        self._columns: list[IO[bytes]] = [
            self._files.enter_context(
                tempfile.TemporaryFile(dir=path.resolve().parent)  # noqa: SIM115 (the stack closes it)
            )
            for _ in Samples._fields
        ]

    def append(self, samples: Samples) -> None:
        """Write rows, `rows` of them but for the last time."""
        for file, column in zip(self._columns, samples, strict=True):
            file.write(np.ascontiguousarray(column).data)
        block = Result(
            self.description, samples, self.p, analysis="simulation", outcome=Outcome.OK,
            message="the run has not ended", stats={},
        )  # fmt: skip
        data = dataset(block)
        if self.count == 0:
            data.attrs["outcome"] = RUNNING
            with whole_folder(self.path, _METADATA) as folder:
                write_dataset(data, folder, rows=self.rows)
                _write_root(folder, data.attrs)
        else:
            self._extend({str(name): variable for name, variable in data.variables.items()})
        self.count += len(samples.t)

    def _extend(self, variables: Mapping[str, Any]) -> None:
        import zarr

        group: Any = zarr.open_group(self.path, mode="r+", use_consolidated=False)
        for name, variable in variables.items():
            if "time" in variable.dims:
                values = variable.values
                array = group[name]
                array.resize((self.count + len(values), *values.shape[1:]))
                array[self.count :] = values
        _write_root(self.path, dict(group.attrs))

    def finish(self, facts: Mapping[str, str]) -> None:
        """Replace the store's attributes by those of the run that has ended."""
        if self.count:
            _write_root(self.path, facts)

    def fail(self, error: BaseException) -> None:
        """Note an error in a store that has rows."""
        if self.count:
            root = json.loads((self.path / _METADATA).read_text(encoding="utf-8"))
            message = f"{type(error).__name__}: {error}"
            _write_root(self.path, {**root["attributes"], "outcome": FAILED, "message": message})

    def mapped(self) -> Samples:
        """All rows so far, in memory that the files back; the store takes no more rows."""
        description = self.description
        n, s = len(description.coordinates), len(description.switches)
        m, effects = len(description.constraints), len(description.powers)
        widths = 0, n, n, n, m, len(description.reactions), effects, 2, 2, s, s
        columns = list[npt.NDArray[Any]]()
        for name, file, width in zip(Samples._fields, self._columns, widths, strict=True):
            kind = np.int64 if name == "modes" else np.float64
            shape = (self.count, width) if name != "t" else (self.count,)
            file.flush()
            if 0 in shape:
                columns.append(np.zeros(shape, kind))
            else:
                columns.append(np.asarray(np.memmap(cast(Any, file), kind, "r+", shape=shape)))
        self.close()
        return Samples._make(columns)

    def close(self) -> None:
        """Let go of the files; what is mapped stays."""
        self._files.close()


def _write_root(folder: Path, attributes: Mapping[str, str]) -> None:
    """Replace the metadata of the root, which have those of all variables, by one renaming."""
    nodes = {
        place.parent.name: json.loads(place.read_text(encoding="utf-8"))
        for place in sorted(folder.glob(f"*/{_METADATA}"))
    }
    about = {"kind": "inline", "must_understand": False, "metadata": nodes}
    root = {
        "zarr_format": 3, "node_type": "group", "attributes": dict(attributes),
        "consolidated_metadata": about,
    }  # fmt: skip
    written = folder / f".{_METADATA}"
    with written.open("w", encoding="utf-8") as file:
        json.dump(root, file)
        file.flush()
        os.fsync(file.fileno())
    written.replace(folder / _METADATA)
