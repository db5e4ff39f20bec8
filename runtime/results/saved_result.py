"""What .nc and .zarr files keep of a result beside its series, so that `load_result` gives it back.

Nested values are bytes of JSON, and of NumPy's format for arrays: nothing is executed. Compiled
code checks no index, so that arrays which reach it are of the machine's shapes, or refused.
Checkpoints of a run, which are copies of the memory of compiled code, never stand in a file.
"""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.mechanism.module_tables import Description
from runtime.results.event_records import Event, SingularPosition
from runtime.results.result import Result
from runtime.results.run_records import Estimate, ReachedAccuracy, Reconnection, Trial
from runtime.results.samples import Partition

GROUP = "linkwright"
"""Name of the group in a file, and of its only variable."""
KINDS = (Estimate, ReachedAccuracy, Trial, SingularPosition, Reconnection)
"""Records of a result that are packed as they are."""
_LEFT_OUT = ("Checkpoint", "Crossing", "RunsSnapshot", "Snapshot")
"""Records of checkpoints in files of older versions: they are not read."""
_JSON = "json"
_HIGHEST_MODE = 2  # of a switching function that stays at zero


def pack(value: Any) -> bytes:
    """Bytes of nested mappings, sequences, named tuples, data classes, arrays and numbers."""
    arrays: list[np.ndarray] = []
    text = json.dumps(_written(value, arrays))
    file = io.BytesIO()
    named: dict[str, Any] = {f"a{k}": array for k, array in enumerate(arrays)}
    named[_JSON] = np.frombuffer(text.encode(), np.uint8)
    np.savez_compressed(file, **named)
    return file.getvalue()


def unpack(content: bytes, kinds: Sequence[type[Any]]) -> Any:
    """The value again; `kinds` are the named tuples and data classes that may be in it.

    Raises ValueError or KeyError where the bytes are none of `pack`, or have another kind.
    """
    known: dict[str, Any] = {kind.__name__: kind for kind in kinds}
    known |= dict.fromkeys(_LEFT_OUT, lambda *_: None)
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = [file[f"a{k}"] for k in range(len(file.files) - 1)]
        return _read(json.loads(file[_JSON].tobytes().decode()), arrays, known)


def _written(value: Any, arrays: list[np.ndarray]) -> Any:
    def listed(values: Any) -> list[Any]:
        return [_written(part, arrays) for part in values]

    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, np.generic):
        return value.item()
    if is_dataclass(value):
        return {
            "kind": type(value).__name__,
            "of": listed(getattr(value, field.name) for field in fields(value)),
        }
    if isinstance(value, tuple):
        named = hasattr(value, "_fields")
        return {"kind": type(value).__name__, "of": listed(value)} if named else {
            "tuple": listed(value)
        }  # fmt: skip
    if isinstance(value, list):
        return listed(value)
    if isinstance(value, dict):
        return {"dict": [[key, _written(part, arrays)] for key, part in value.items()]}
    return value


def _read(value: Any, arrays: list[np.ndarray], known: dict[str, Any]) -> Any:
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


def saved_result(result: Result) -> bytes:
    """States, works, events and settings; all else follows from these by the machine."""
    return pack(saved_fields(result))


def saved_fields(result: Result) -> dict[str, Any]:
    """What is kept of a result, by name.

    Of a run with other joints in each part these are the parts, and what is said of the whole.
    """
    samples, motion = result.samples, result._motion
    kept = None if motion is None else motion.saved()
    about = {
        "title": result.description.title,
        "analysis": result.analysis,
        "outcome": result.outcome.name,
        "message": result.message,
        "site": result.site,
        "parameters": result.parameters,
        "accuracy": result.accuracy,
        "ended_by": result.ended_by,
        "until": [tuple(one) for one in result._until],
        "motion": kept,
    }
    if kept is not None and "parts" in kept:
        return {**about, "t": result.t}
    return {
        **about,
        "contradiction": result.contradiction,
        "stats": result.stats,
        "samples": {name: getattr(samples, name) for name in ("t", "q", "v", "modes")},
        "works": result.works,
        "work_at_end": result.work_at_end,
        "events": _event_columns(result.events),
        "partitions": _partition_columns(result.partitions),
        "not_unique": result.not_unique,
        "singular": list(result.singular),
    }


def _numbered(values: Sequence[Any]) -> tuple[list[Any], npt.NDArray[np.int64]]:
    """The values that differ, in order, and the number of each value among them."""
    numbers = {value: k for k, value in enumerate(dict.fromkeys(values))}
    return list(numbers), np.array([numbers[value] for value in values], np.int64)


def _event_columns(events: Sequence[Event]) -> dict[str, Any]:
    """Many events in few arrays; they have states of the same shape."""
    names, numbers = _numbered([event.name for event in events])
    return {
        "names": names,
        "name": numbers,
        "time": np.array([event.time for event in events]),
        "direction": np.array([event.direction for event in events], np.int64),
        "words": [event.word for event in events],
        "q": np.array([event.q for event in events]),
        "v": np.array([event.v for event in events]),
    }


def events_of(columns: dict[str, Any]) -> list[Event]:
    """The events again."""
    names = [columns["names"][k] for k in columns["name"]]
    times, directions = columns["time"].tolist(), columns["direction"].tolist()
    return [
        Event(*row)
        for row in zip(
            names, times, directions, columns["q"], columns["v"], columns["words"], strict=True
        )
    ]


def _partition_columns(partitions: Sequence[Partition]) -> dict[str, Any]:
    """Many partitions, of which few differ."""
    sets, numbers = _numbered([one.independent for one in partitions])
    return {"sets": sets, "set": numbers, "time": np.array([one.time for one in partitions])}


def partitions_of(columns: dict[str, Any]) -> list[Partition]:
    """The partitions again."""
    times = columns["time"].tolist()
    return [Partition(t, columns["sets"][k]) for t, k in zip(times, columns["set"], strict=True)]


def samples_of(kept: Mapping[str, Any], description: Description) -> dict[str, Any]:
    """Instants, states and modes of a file: t, q, v and modes by name.

    Raises InputError where one has another shape than the machine's, KeyError where one is missing.
    """
    n, switches = len(description.coordinates), len(description.switches)
    t, modes = floats(kept["t"], (-1,), "t"), np.asarray(kept["modes"])
    if modes.shape != (len(t), switches) or modes.dtype.kind not in "iu" or not (
        (modes >= 0) & (modes <= _HIGHEST_MODE)
    ).all():  # fmt: skip
        raise _misfit("modes", modes, (len(t), switches))
    return {
        "t": t,
        "q": floats(kept["q"], (len(t), n), "q"),
        "v": floats(kept["v"], (len(t), n), "v"),
        "modes": modes.astype(np.int64),
    }


def floats(value: Any, shape: tuple[int, ...], name: str) -> npt.NDArray[np.float64]:
    """An array of a file as floats of a shape, of which -1 is any length, or InputError."""
    found = np.asarray(value)
    fits = found.ndim == len(shape) and all(
        wanted in (-1, length) for wanted, length in zip(shape, found.shape, strict=True)
    )
    if not fits or found.dtype.kind not in "fiu":
        raise _misfit(name, found, shape)
    return np.ascontiguousarray(found, np.float64)


def _misfit(name: str, found: npt.NDArray[Any], shape: tuple[int, ...]) -> InputError:
    return InputError(
        f"the array {name} of the file has the shape {found.shape} and numbers of type "
        f"{found.dtype}, where the machine has {shape}: the file is damaged, or was made by hand."
    )
