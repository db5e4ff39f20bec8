"""What a .nc file keeps of a result beside its series, so that `load_result` gives it back."""

from typing import Any

from runtime.results.accuracy_target_record import Estimate, ReachedAccuracy, Trial
from runtime.results.event_records import Event, SingularPosition
from runtime.results.packed_values import pack
from runtime.results.result import Result
from runtime.results.samples import Partition

GROUP = "linkwright"
"""Name of the group in a file, and of its only variable."""

KINDS: tuple[type[Any], ...] = (
    Estimate, ReachedAccuracy, Trial, Event, SingularPosition, Partition
)  # fmt: skip
"""Records of a result that are packed as they are."""


def saved_result(result: Result) -> bytes:
    """States, works, events and settings; all else follows from these by the machine."""
    samples, motion = result.samples, result._motion
    return pack(
        {
            "title": result.description.title,
            "analysis": result.analysis,
            "outcome": result.outcome.name,
            "message": result.message,
            "contradiction": result.contradiction,
            "parameters": result.parameters,
            "stats": result.stats,
            "samples": {name: getattr(samples, name) for name in ("t", "q", "v", "modes")},
            "works": result.works,
            "events": list(result.events),
            "partitions": list(result.partitions),
            "not_unique": result.not_unique,
            "singular": list(result.singular),
            "accuracy": result.accuracy,
            "motion": None if motion is None else motion.saved(),
        }
    )
