"""What a .nc file keeps of a result beside its series, so that `load_result` gives it back."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.results.accuracy_target_record import Estimate, ReachedAccuracy, Trial
from runtime.results.event_records import Event, SingularPosition
from runtime.results.packed_values import pack
from runtime.results.reconnection import Reconnection
from runtime.results.result import Result
from runtime.results.samples import Partition

GROUP = "linkwright"
"""Name of the group in a file, and of its only variable."""

KINDS: tuple[type[Any], ...] = (
    Estimate, ReachedAccuracy, Trial, SingularPosition, Reconnection
)  # fmt: skip
"""Records of a result that are packed as they are."""


def saved_result(result: Result) -> bytes:
    """States, works, events and settings; all else follows from these by the machine."""
    return pack(saved_fields(result))


def saved_fields(result: Result) -> dict[str, Any]:
    """What is kept of a result, by name."""
    samples, motion = result.samples, result._motion
    kept = None if motion is None else motion.saved()
    if kept is not None and "parts" in kept:
        return _fields_of_parts(result, kept)
    return {
        "title": result.description.title,
        "analysis": result.analysis,
        "outcome": result.outcome.name,
        "message": result.message,
        "contradiction": result.contradiction,
        "parameters": result.parameters,
        "stats": result.stats,
        "samples": {name: getattr(samples, name) for name in ("t", "q", "v", "modes")},
        "works": result.works,
        "events": _event_columns(result.events),
        "partitions": _partition_columns(result.partitions),
        "not_unique": result.not_unique,
        "singular": list(result.singular),
        "accuracy": result.accuracy,
        "motion": kept,
        "work_at_end": result.work_at_end,
        "ended_by": result.ended_by,
        "reconnections": list(result.reconnections),
        "until": [tuple(one) for one in result._until],
    }


def _numbered(values: Sequence[Any]) -> tuple[list[Any], npt.NDArray[np.int64]]:
    """The values that differ, in order, and the number of each value among them."""
    numbers = {value: k for k, value in enumerate(dict.fromkeys(values))}
    return list(numbers), np.array([numbers[value] for value in values], np.int64)


def _fields_of_parts(result: Result, parts: dict[str, Any]) -> dict[str, Any]:
    """Of a run with other joints in each part: the parts, what changed and what is said of it."""
    return {
        "title": result.description.title,
        "analysis": result.analysis,
        "parameters": result.parameters,
        "outcome": result.outcome.name,
        "message": result.message,
        "t": result.t,
        "ended_by": result.ended_by,
        "until": [tuple(one) for one in result._until],
        "accuracy": result.accuracy,
        "motion": parts,
    }


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
    return {
        "sets": sets,
        "set": numbers,
        "time": np.array([one.time for one in partitions]),
    }


def partitions_of(columns: dict[str, Any]) -> list[Partition]:
    """The partitions again."""
    times = columns["time"].tolist()
    return [Partition(t, columns["sets"][k]) for t, k in zip(times, columns["set"], strict=True)]
