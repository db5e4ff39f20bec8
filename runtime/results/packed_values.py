"""Nested values in bytes, of which nothing is executed: JSON, and NumPy's format for arrays."""

import io
import json
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_JSON = "json"


def pack(value: Any) -> bytes:
    """Bytes of nested mappings, sequences, named tuples, data classes, arrays and numbers."""
    arrays: list[np.ndarray] = []
    text = json.dumps(_written(value, arrays))
    file = io.BytesIO()
    named: dict[str, Any] = {f"a{k}": array for k, array in enumerate(arrays)}
    named[_JSON] = np.frombuffer(text.encode(), np.uint8)
    np.savez_compressed(file, **named)
    return file.getvalue()


def unpack(content: bytes, kinds: Iterable[type[Any]]) -> Any:
    """The value again; `kinds` are the named tuples and data classes that may be in it.

    Raises ValueError or KeyError where the bytes are none of `pack`, or have another kind.
    """
    known = {kind.__name__: kind for kind in kinds}
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = [file[f"a{k}"] for k in range(len(file.files) - 1)]
        return _read(json.loads(file[_JSON].tobytes().decode()), arrays, known)


def _written(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, np.generic):
        return value.item()
    if is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, field.name) for field in fields(value)]
        return {"kind": type(value).__name__, "of": [_written(part, arrays) for part in parts]}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {"kind": type(value).__name__, "of": [_written(part, arrays) for part in value]}
    if isinstance(value, tuple):
        return {"tuple": [_written(part, arrays) for part in value]}
    if isinstance(value, list):
        return [_written(part, arrays) for part in value]
    if isinstance(value, dict):
        return {"dict": [[key, _written(part, arrays)] for key, part in value.items()]}
    return value


def _read(value: Any, arrays: list[np.ndarray], known: dict[str, type[Any]]) -> Any:
    if isinstance(value, list):
        return [_read(part, arrays, known) for part in value]
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "tuple" in value:
        return tuple(_read(part, arrays, known) for part in value["tuple"])
    if "dict" in value:
        return {key: _read(part, arrays, known) for key, part in value["dict"]}
    return known[value["kind"]](*(_read(part, arrays, known) for part in value["of"]))
