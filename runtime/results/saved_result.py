"""The data beside the series in .nc and .zarr files, from which `load_result` restores a result.

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
from runtime.results.result import Result
from runtime.results.run_records import (
    Estimate,
    Event,
    ReachedAccuracy,
    Reconnection,
    SingularPosition,
    Trial,
)
from runtime.results.samples import Partition

GROUP = "linkwright"
"""Name of the group in a file, and of its only variable."""
KINDS = (Estimate, ReachedAccuracy, Trial, SingularPosition, Reconnection)
"""Records of a result that are packed as they are."""
_LEFT_OUT = ("Checkpoint", "Crossing", "RunsSnapshot", "Snapshot")
"""Records of checkpoints in files of older versions: they are not read."""


def pack(value: Any) -> bytes:
    """Bytes of nested mappings, sequences, named tuples, data classes, arrays and numbers."""
    arrays = dict[str, Any]()

    def marked(value: Any) -> Any:
        """The value with marks for what JSON does not tell apart."""
        if isinstance(value, np.ndarray):
            arrays[f"a{len(arrays)}"] = value
            return {"array": len(arrays) - 1}
        if isinstance(value, np.generic):
            return value.item()
        if isinstance(value, dict):
            return {"dict": [[key, marked(part)] for key, part in value.items()]}
        if isinstance(value, list):
            return [*map(marked, value)]
        if is_dataclass(value):
            parts = [marked(getattr(value, field.name)) for field in fields(value)]
            return {"kind": type(value).__name__, "of": parts}
        if isinstance(value, tuple):
            parts, is_named = [*map(marked, value)], hasattr(value, "_fields")
            return {"kind": type(value).__name__, "of": parts} if is_named else {"tuple": parts}
        return value

    text, file = json.dumps(marked(value)), io.BytesIO()
    np.savez_compressed(file, **arrays, json=np.frombuffer(text.encode(), np.uint8))
    return file.getvalue()


def unpack(content: bytes, kinds: Sequence[type[Any]]) -> Any:
    """The value again; `kinds` are the named tuples and data classes that may be in it.

    Raises ValueError or KeyError where the bytes are none of `pack`, or have another kind.
    """
    known: dict[str, Any] = {kind.__name__: kind for kind in kinds}
    known |= dict.fromkeys(_LEFT_OUT, lambda *_: None)
    known["Handover"] = lambda _, length: length  # of older versions

    def read(marked: dict[str, Any]) -> Any:
        match marked:
            case {"array": number}:
                return file[f"a{number}"]
            case {"tuple": parts}:
                return tuple(parts)
            case {"dict": pairs}:
                return dict(pairs)
        return known[marked["kind"]](*marked["of"])

    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        return json.loads(file["json"].tobytes().decode(), object_hook=read)


FACTS = "analysis", "message", "accuracy", "ended_by"
"""Attributes of a result that are kept as they are."""
OF_ONE_RUN = "contradiction", "stats", "works", "work_at_end", "not_unique"
"""Those that a run with other joints in each part has of its parts."""


def saved_result(result: Result) -> bytes:
    """States, works, events and settings; all else follows from these by the machine."""
    return pack(saved_fields(result))


def saved_fields(result: Result) -> dict[str, Any]:
    """What is kept of a result, by name.

    Of a run with other joints in each part these are the parts, and what is said of the whole.
    """
    samples, motion = result.samples, result._motion
    kept = None if motion is None else motion.saved()
    has_parts = kept is not None and "parts" in kept
    found = {
        "title": result.description.title,
        "outcome": result.outcome.name,
        "parameters": result.parameters,
        "site": result.site,
        "until": [tuple(one) for one in result._until],
        "motion": kept,
    }
    found |= {name: getattr(result, name) for name in (*FACTS, *(() if has_parts else OF_ONE_RUN))}
    if has_parts:
        return {**found, "t": result.t}
    return {
        **found,
        "samples": {name: getattr(samples, name) for name in ("t", "q", "v", "modes")},
        "events": _event_columns(result.events),
        "partitions": _partition_columns(result.partitions),
        "singular": list(result.singular),
    }


def _numbered(values: Sequence[Any]) -> tuple[list[Any], npt.NDArray[np.int64]]:
    """The values that differ, in order, and the number of each value among them."""
    numbers = {value: k for k, value in enumerate(dict.fromkeys(values))}
    return list(numbers), np.array([numbers[value] for value in values], np.int64)


def _event_columns(events: Sequence[Event]) -> dict[str, Any]:
    """Many events in few arrays; they have states of the same shape."""
    names, numbers = _numbered([event.name for event in events])
    arrays = ("time", "direction", "q", "v")
    return {
        "names": names, "name": numbers, "words": [event.word for event in events],
        "impulses": [event.impulse for event in events],
        **{name: np.array([getattr(event, name) for event in events]) for name in arrays},
    }  # fmt: skip


def events_of(columns: dict[str, Any]) -> tuple[Event, ...]:
    """The events again."""
    names = [columns["names"][k] for k in columns["name"]]
    times, directions = columns["time"].tolist(), columns["direction"].tolist()
    impulses = columns.get("impulses", [None] * len(names))  # older files have none
    states = columns["q"], columns["v"], columns["words"], impulses
    return tuple(map(Event._make, zip(names, times, directions, *states, strict=True)))


def _partition_columns(partitions: Sequence[Partition]) -> dict[str, Any]:
    """Many partitions, of which few differ."""
    sets, numbers = _numbered([one.independent for one in partitions])
    return {"sets": sets, "set": numbers, "time": np.array([one.time for one in partitions])}


def partitions_of(columns: dict[str, Any]) -> tuple[Partition, ...]:
    """The partitions again."""
    rows = zip(columns["time"].tolist(), columns["set"], strict=True)
    return tuple(Partition(time, columns["sets"][k]) for time, k in rows)


def samples_of(kept: Mapping[str, Any], description: Description) -> dict[str, Any]:
    """Instants, states and modes of a file: t, q, v and modes by name.

    Raises InputError where one has another shape than the machine's, KeyError where one is missing.
    """
    n, switches = len(description.coordinates), len(description.switches)
    t, modes = floats(kept["t"], (-1,), "t"), np.asarray(kept["modes"])
    is_whole = modes.dtype.kind in "iu" and modes.shape == (len(t), switches)
    if not is_whole or not np.isin(modes, (0, 1, 2)).all():
        raise _misfit("modes", modes, (len(t), switches))
    states = {name: floats(kept[name], (len(t), n), name) for name in "qv"}
    return {"t": t, **states, "modes": modes.astype(np.int64)}


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
