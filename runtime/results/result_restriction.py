"""Restriction of a result to some of its instants, and what happened about them."""

import numpy as np
import numpy.typing as npt

from runtime.results.result import Result
from runtime.results.samples import Samples


def keep(result: Result, rows: npt.NDArray[np.bool_], first: float, last: float) -> None:
    """Keep these rows, (k,), and what happened behind `first` and up to `last`, s.

    Of the partitions the one in force at `first` is kept from there on.
    """
    result.samples = Samples._make(array[rows] for array in result.samples)
    result.works = {name: work[rows] for name, work in result.works.items()}
    result.events = tuple(event for event in result.events if first < event.time <= last)
    result.singular = tuple(one for one in result.singular if first < one.time <= last)
    changes = (one for one in result.reconnections if first < one.time <= last)
    result.reconnections = tuple(changes)
    sets = [one for one in result.partitions if one.time <= last]
    before = [one._replace(time=first) for one in sets if one.time <= first][-1:]
    result.partitions = (*before, *(one for one in sets if one.time > first))


def end_after(result: Result, count: int) -> None:
    """Let a result end at one of its instants, behind which it is not what was asked for."""
    last = float(result.t[count - 1])
    keep(result, np.arange(len(result.t)) < count, -np.inf, last)
    result.ended_by = ""
