"""Results as Zarr stores, and the check of a store from elsewhere before anything reads it.

A store of Zarr's format 2 may name the codec `pickle`, which executes what a chunk says. Here only
format 3 is read, with codecs that turn bytes into numbers and texts.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError
from runtime.results.dataset import dataset
from runtime.results.result import Result
from runtime.results.result_signature import signature
from runtime.results.saved_result import GROUP, saved_result

if TYPE_CHECKING:
    import xarray as xr

_METADATA = "zarr.json"
_FORMAT_2 = {".zarray", ".zgroup", ".zattrs", ".zmetadata"}
MOST_METADATA = 1 << 24  # safety: bytes of one file of metadata
_CODECS = {
    *("blosc", "bytes", "crc32c", "gzip", "sharding_indexed", "transpose", "vlen-utf8", "zstd"),
}
"""Codecs that only rearrange, compress or check bytes."""
_TYPES = {"bool", "float32", "float64", "string"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}


def write(result: Result, folder: Path) -> None:
    """Write a store: the variables of the result's dataset, and what `load_result` needs."""
    import zarr

    write_dataset(dataset(result), folder)
    content = saved_result(result)
    group = zarr.open_group(folder, mode="a").create_group(GROUP)
    group.create_array(GROUP, data=np.frombuffer(content, np.uint8), compressors=None)
    group.attrs["signature"] = signature(content)


def write_dataset(data: "xr.Dataset", folder: Path, rows: int | None = None) -> None:
    """Write a dataset of numbers and texts, which xarray.open_zarr reads.

    Variables over time are in chunks of so many `rows`, where these are given.
    """
    plain = data.copy()
    for name, variable in data.variables.items():
        if variable.dtype.kind == "U":
            texts = variable.values.astype(np.dtypes.StringDType())
            plain = plain.assign({name: (variable.dims, texts, variable.attrs)})
        else:
            plain[name].encoding["_FillValue"] = None
        if rows is not None and variable.dims[:1] == ("time",):
            plain[name].encoding["chunks"] = rows, *(max(1, size) for size in variable.shape[1:])
    labels = [name for name in plain.data_vars if name in data.coords]
    plain.set_coords(labels).to_zarr(folder, mode="w", zarr_format=3, consolidated=False)


def read_content(folder: Path) -> tuple[bytes, str]:
    """What `write` added for `load_result`, and its signature; KeyError where there is none."""
    import zarr

    require_plain(folder)
    group: Any = zarr.open_group(folder, mode="r", zarr_format=3)[GROUP]
    content = np.asarray(group[GROUP][:], np.uint8).tobytes()
    return content, str(group.attrs.get("signature", ""))


def require_plain(folder: Path) -> None:
    """Refuse a store whose metadata ask for more than numbers and texts; InputError says where.

    Call it before a library opens a store that comes from elsewhere.
    """
    found, old = list[Path](), list[Path]()
    for path in _files(folder):
        if path.name == _METADATA:
            found.append(path)
        elif path.name in _FORMAT_2:
            old.append(path)
    if old:
        raise InputError(
            f"{folder}: {min(old).relative_to(folder)} is of Zarr's format 2, whose codecs may "
            "execute code. Results are stores of format 3."
        )
    if not found:
        raise InputError(f"{folder} has no {_METADATA}, and is no store of Zarr's format 3.")
    for path in sorted(found):
        place = path.relative_to(folder)
        try:
            if path.stat().st_size > MOST_METADATA:
                raise ValueError(f"it has more than {MOST_METADATA} bytes")
            about = json.loads(path.read_text(encoding="utf-8"))
            strange = sorted(set(_extensions(about)))
        except (OSError, ValueError, RecursionError, KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{folder}: {place} cannot be read ({error}).") from error
        if strange:
            raise InputError(
                f"{folder}: {place} needs {', '.join(strange)}, and a result has numbers and "
                "texts alone. It is not opened."
            )


def _files(folder: Path) -> Iterator[Path]:
    """The files of a store; InputError where it has a link, which leads a library elsewhere."""
    waiting = [folder]
    while waiting:
        with os.scandir(waiting.pop()) as entries:
            for entry in entries:
                if entry.is_symlink():
                    raise InputError(
                        f"{folder}: {Path(entry.path).relative_to(folder)} is a link, and a store "
                        "has files of its own. It is not opened."
                    )
                if entry.is_dir():
                    waiting.append(Path(entry.path))
                else:
                    yield Path(entry.path)


def _extensions(about: dict[str, Any]) -> Iterator[str]:
    """Codecs and types of data of a node, and of those in consolidated metadata, not in the list.

    A field that is none of the format raises KeyError, TypeError or AttributeError.
    """
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
