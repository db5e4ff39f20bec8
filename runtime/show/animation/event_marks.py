"""The marks on the time line: events, joints that came or went, and the end of a run."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from runtime.results.result import Result

MAX_MARKS = 2000  # layout: marks of a run
_FLASHES = {"touches", "impact", "strikes", "closes", "engage"}
"""What an event's word, kind or action is where bodies hit each other."""


def event_marks(result: "Result") -> list[dict[str, Any]]:
    """Every mark within the instants of a result, no more than `MAX_MARKS` of each kind.

    A mark has its instant in s, its text, the element that it is of, and whether it flashes.
    """
    if not len(result.t):
        return []
    first, last = float(result.t.min()), float(result.t.max())
    events = [event for event in result.events if first <= event.time <= last]
    changes = [change for change in result.reconnections if first <= change.time <= last]
    marks: list[dict[str, Any]] = [
        {
            "t": float(event.time),
            "text": event.text,
            "element": event.element,
            "flash": event.word in _FLASHES or event.what in _FLASHES,
        }
        for event in events[:MAX_MARKS]
    ]
    marks += [
        {
            "t": float(change.time),
            "text": str(change).rstrip("."),
            "element": change.joint,
            "flash": change.action in _FLASHES,
        }
        for change in changes[:MAX_MARKS]
    ]
    for dropped, what in (
        (len(events) - MAX_MARKS, "events"),
        (len(changes) - MAX_MARKS, "joints"),
    ):
        if dropped > 0:
            text = f"{dropped} more {what} have no marks"
            marks.append({"t": last, "text": text, "element": "", "flash": False})
    if (result.failed or result.ended_by) and _reaches_end(result, last):
        text = f"{result.outcome.name}: {result.message}" if result.failed else result.ended_by
        marks.append({"t": last, "text": text, "element": "", "flash": False})
    return sorted(marks, key=lambda mark: mark["t"])


def _reaches_end(result: "Result", last: float) -> bool:
    """Whether the last instant, s, is that of the run, of which the result may be a part."""
    return result._motion is None or last >= result._motion.span[1]
