"""The end of a result at one of its instants, behind which it is not what was asked for."""

from runtime.results.result import Result
from runtime.results.samples import Samples


def end_after(result: Result, count: int) -> None:
    """Keep the first instants of a result, and what happened until then."""
    result.samples = Samples._make(array[:count] for array in result.samples)
    last = float(result.t[-1])
    result.works = {name: work[:count] for name, work in result.works.items()}
    result.events = tuple(event for event in result.events if event.time <= last)
    result.partitions = tuple(one for one in result.partitions if one.time <= last)
    result.singular = tuple(one for one in result.singular if one.time <= last)
    result.reconnections = tuple(one for one in result.reconnections if one.time <= last)
    result.ended_by = ""
