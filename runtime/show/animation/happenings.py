"""The marks on the time line: events, joints that came or went, and the end of a run."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from runtime.results.result import Result

_MOST = 2000  # layout: marks of a run
_FLASHES = {"touches", "impact", "strikes", "closes", "engage"}
"""What an event's word, kind or action is where bodies hit each other."""


def happenings(result: "Result") -> list[dict[str, Any]]:
    """Every mark: its instant in s, its text, the element that it is of, whether it flashes."""
    marks: list[dict[str, Any]] = [
        {
            "t": float(event.time),
            "text": event.text,
            "element": event.name.partition(":")[0],
            "flash": event.word in _FLASHES or event.what in _FLASHES,
        }
        for event in result.events[:_MOST]
    ]
    marks += [
        {
            "t": float(change.time),
            "text": str(change).rstrip("."),
            "element": change.joint,
            "flash": change.action in _FLASHES,
        }
        for change in result.reconnections[:_MOST]
    ]
    if len(result.t) and (result.failed or result.ended_by):
        text = f"{result.outcome.name}: {result.message}" if result.failed else result.ended_by
        marks.append({"t": float(result.t[-1]), "text": text, "element": "", "flash": False})
    return sorted(marks, key=lambda mark: mark["t"])
