"""Results as Zarr stores, and the check of a store from elsewhere before anything reads it.

A store of Zarr's format 2 may name the codec `pickle`, which executes what a chunk says. Here only
format 3 is read, with codecs that turn bytes into numbers and texts.

A store that is written while its run goes on is readable after every chunk of rows: the root's
metadata, which have those of all variables, are replaced by one renaming when the rows of all of
them are on the disk. Its attribute `outcome` is RUNNING until the run has ended.
"""

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.files.whole_files import whole_folder
from runtime.core.outcomes import Outcome
from runtime.mechanism.module_tables import Description
from runtime.results.dataset import dataset
from runtime.results.result import Result
from runtime.results.samples import FloatArray, Samples, empty_samples, sample_bytes
from runtime.results.saved_result import GROUP, saved_result

if TYPE_CHECKING:
    import xarray as xr


RUNNING = "RUNNING"
"""The outcome of a store whose run has not ended, or was killed."""
FAILED = "FAILED"
"""The outcome of a store whose run ended with an error, of which `message` has the text."""
_CHUNK_BYTES = 2**22  # measured: of all variables of a chunk; more are no faster
_LEAST, _MOST = 16, 2**14  # safety: rows of a chunk

_METADATA = "zarr.json"
_FORMAT_2 = {".zarray", ".zgroup", ".zattrs", ".zmetadata"}
MOST_METADATA = 1 << 24  # safety: bytes of one file of metadata
_CODECS = {
    *("blosc", "bytes", "crc32c", "gzip", "sharding_indexed", "transpose", "vlen-utf8", "zstd")
}
"""Codecs that only rearrange, compress or check bytes."""
_TYPES = {"bool", "float32", "float64", "string"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}


def write_store(result: Result, folder: Path) -> None:
    """Write a store: the variables of the result's dataset, and what `load_result` needs."""
    import zarr

    write_dataset(dataset(result), folder)
    content = saved_result(result)
    group = zarr.open_group(folder, mode="a").create_group(GROUP)
    group.create_array(GROUP, data=np.frombuffer(content, np.uint8), compressors=None)


def write_dataset(data: "xr.Dataset", folder: Path, rows: int | None = None) -> None:
    """Write a dataset of numbers and texts, which xarray.open_zarr reads.

    Variables over time are in chunks of so many `rows`, where these are given.
    """
    texts = {
        name: (labels.dims, labels.values.astype(np.dtypes.StringDType()), labels.attrs)
        for name, labels in data.coords.items() if labels.dtype.kind == "U"
    }  # fmt: skip
    encoding: dict[Any, Any] = {
        name: {"_FillValue": None} for name in data.variables if name not in texts
    }
    for name, variable in data.variables.items():
        if rows is not None and variable.dims[:1] == ("time",):
            encoding[name]["chunks"] = rows, *(max(1, size) for size in variable.shape[1:])
    plain = data.assign_coords(texts)
    plain.to_zarr(folder, mode="w", zarr_format=3, consolidated=False, encoding=encoding)


def read_content(folder: Path) -> bytes:
    """What `write_store` added for `load_result`; KeyError where there is none."""
    import zarr

    require_plain(folder)
    group: Any = zarr.open_group(folder, mode="r", zarr_format=3)[GROUP]
    return np.asarray(group[GROUP][:], np.uint8).tobytes()


def require_plain(folder: Path) -> None:
    """Refuse a store whose metadata ask for more than numbers and texts; InputError says where.

    Call it before a library opens a store that comes from elsewhere.
    """
    files = sorted(_files(folder))
    if old := [path for path in files if path.name in _FORMAT_2]:
        raise InputError(
            f"{folder}: {old[0].relative_to(folder)} is of Zarr's format 2, whose codecs may "
            "execute code. Results are stores of format 3."
        )
    found = [path for path in files if path.name == _METADATA]
    if not found:
        raise InputError(f"{folder} has no {_METADATA}, and is no store of Zarr's format 3.")
    for path in found:
        place = path.relative_to(folder)
        try:
            if path.stat().st_size > MOST_METADATA:
                raise ValueError(f"it has more than {MOST_METADATA} bytes")
            strange = sorted({*_extensions(json.loads(path.read_text(encoding="utf-8")))})
        except (OSError, ValueError, RecursionError, KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{folder}: {place} cannot be read ({error}).") from error
        if strange:
            raise InputError(
                f"{folder}: {place} needs {', '.join(strange)}, and a result has numbers and "
                "texts alone. It is not opened."
            )


def _files(folder: Path) -> Iterator[Path]:
    """The files of a store; InputError where it has a link, which leads a library elsewhere."""
    for path in folder.rglob("*"):
        if path.is_symlink():
            raise InputError(
                f"{folder}: {path.relative_to(folder)} is a link, and a store has files of its "
                "own. It is not opened."
            )
        if path.is_file():
            yield path


def _extensions(about: dict[str, Any]) -> Iterator[str]:
    """Codecs and types of data that are not in the list, of a node and of those in its metadata."""
    if about["zarr_format"] != 3:
        yield f"format {about['zarr_format']!r}"
    if about["node_type"] == "array":
        yield from (f"codec {name!r}" for name in _codec_names(about["codecs"]))
        if about["data_type"] not in _TYPES:
            yield f"data type {about['data_type']!r}"
        if about.get("storage_transformers"):
            yield "storage transformers"
    for node in ((about.get("consolidated_metadata") or {}).get("metadata") or {}).values():
        yield from _extensions(node)


def _codec_names(codecs: list[Any]) -> Iterator[str]:
    for codec in codecs:
        name, options = (codec, {}) if isinstance(codec, str) else (codec["name"], codec)
        if name not in _CODECS:
            yield name
        inner = options.get("configuration") or {}
        yield from _codec_names([*inner.get("codecs", ()), *inner.get("index_codecs", ())])


class ResultStore:
    """The rows of one run, in a Zarr store at `path`, which a run writes while it goes on.

    The same rows go into temporary files beside it, which the `Result` of the run maps into memory,
    so that what a run holds does not grow with its length.
    """

    def __init__(self, path: Path, description: Description, p: FloatArray) -> None:
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
            message="the run has not ended",
        )  # fmt: skip
        data = dataset(block)
        if self.count == 0:
            data.attrs["outcome"] = RUNNING
            with whole_folder(self.path, _METADATA) as folder:
                write_dataset(data, folder, rows=self.rows)
                _write_root(folder, data.attrs)
        else:
            self._extend(data)
        self.count += len(samples.t)

    def _extend(self, data: "xr.Dataset") -> None:
        import zarr

        group: Any = zarr.open_group(self.path, mode="r+", use_consolidated=False)
        for name, variable in data.variables.items():
            if "time" in variable.dims:
                group[name].append(variable.values)
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
        columns = list[npt.NDArray[Any]]()
        for file, of_one in zip(self._columns, empty_samples(self.description, 1), strict=True):
            shape, kind = (self.count, *of_one.shape[1:]), of_one.dtype
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
