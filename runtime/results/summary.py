"""A result in a few lines for a person, or as one JSON object for a program."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from runtime.results.samples import plain
from runtime.results.result import Result

_SHOWN = 12  # events, before it says how many more there are


def summary(result: Result, saved: Path | None) -> dict[str, Any]:
    """The JSON object of a run."""
    names, last, some = result.description.coordinates, result.samples, len(result.t) > 0
    return {
        "ok": not result.failed,
        **result.facts(),
        "instants": len(result.t),
        "t": [float(result.t[0]), float(result.t[-1])] if some else [],
        "q": {row.name: plain(last.q[-1, i]) for i, row in enumerate(names)} if some else {},
        "v": {row.velocity: plain(last.v[-1, i]) for i, row in enumerate(names)} if some else {},
        "events": [{"t": e.time, "name": e.name, "what": e.what} for e in result.events],
        "saved": None if saved is None else str(saved),
    }


def last_values(result: Result) -> list[str]:
    """The last state, a line a coordinate."""
    width = max((len(row.name) for row in result.description.coordinates), default=0)
    return [
        f"{row.name:<{width}}  {result.samples.q[-1, i]: .9g} {row.unit}"
        for i, row in enumerate(result.description.coordinates)
    ]


def accuracy(result: Result) -> list[str]:
    """The accuracy of a run with an accuracy target; else nothing."""
    return [] if result.accuracy is None else [f"  {x}" for x in result.accuracy.sentences()[1:]]


def events(result: Result) -> list[str]:
    """The events, a line each; of many, the first and the last ones."""
    happened = result.events
    width = max((len(event.what) for event in happened), default=0)
    lines = [f"  t = {e.time:<14.9g} {e.what:<{width}}  {e.name}" for e in happened]
    if len(lines) <= _SHOWN:
        return lines
    half = _SHOWN // 2
    return [*lines[:half], f"  … {len(lines) - 2 * half} more events …", *lines[-half:]]
