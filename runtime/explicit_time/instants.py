"""The instants that explicit functions of time set for a run: where steps end, and where it ends.

They are known beforehand, for nothing but the time and the parameters decides on them. A run looks
at as much of its time as some thousands of them take, and at the next part when it gets there.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from runtime.core.arrays import Vector
from runtime.explicit_time.function_scan import FunctionScan
from runtime.mechanism.module_tables import Description

_CLOCK = 16.0 * np.finfo(float).eps  # accuracy: of the time; distance of a kink's two sides from it
_NEAR_END = (
    0.1  # measured: of an interval; a step that begins there may go on to the next one's end
)


class Kink(NamedTuple):
    """An instant at which functions of time may bend or jump."""

    before: float  # s; the last instant of the pieces before it
    after: float  # the first of those behind it
    function: int  # its number in the description
    # instant, s, from which on the function is steep, as it grows without bound; None: it does not
    steep: float | None
    jumps: tuple[tuple[int, float], ...] = ()  # (function, by how much) of the places that jump


class TimeInstants(NamedTuple):
    """What explicit functions of time ask of a run, or of a part of it."""

    bounds: Vector  # instants at which steps end, so that nothing hides in one, s
    kinks: tuple[Kink, ...]  # in their order
    end: float  # s; until then all is known
    # instant from which on changes are too many to be followed, s, where they accumulate, the
    # number of the function; None: nowhere
    crowd: tuple[float, float, int] | None = None


def time_instants(
    description: Description, p: Vector, t0: float, t1: float
) -> Iterator[TimeInstants]:
    """The instants between t0 and t1, s, with the parameters `p`, part by part."""
    scans = [FunctionScan(function, p, t0, t1) for function in description.time_functions]
    clock = float(_CLOCK * max(abs(t0), abs(t1)))
    # Rounding may put a break at t0 or t1 beyond them, and not so in the kernels.
    sides = (t0 - clock, t0, t0), (t1, t1 + clock, t1)
    edges = [
        (t, t, number)
        for number, scan in enumerate(scans)
        for a, b, t in sides
        if t1 < np.inf and scan.breaks_within(a, b)
    ]
    begin = behind = t0
    while begin < t1 < np.inf:
        for scan in scans:
            if scan.reach <= begin:
                scan.scan_next_part(0.25 * clock)
        end = min((scan.reach for scan in scans), default=t1)
        bounds, places = [], [edge for edge in edges if begin <= edge[0] <= end]
        for number, scan in enumerate(scans):
            ends, found = scan.pop_until(end)
            bounds.append(ends)
            places += [(*place, number) for place in found]
        kinks: list[Kink] = []
        for low, high, number in sorted(places):
            middle, way = 0.5 * (low + high), clock
            if high - low > clock:  # several breaks, which rounding alone separates
                way += 0.5 * (high - low)
            # t0 and t1 themselves belong to the side that the kernels find there.
            before, after = max(middle - way, t0), min(middle + way, t1)
            joined = bool(kinks) and before <= kinks[-1].after
            if after < t0 or before >= t1 or (after <= behind and behind > t0 and not joined):
                continue
            steep = scans[number].steep_from(middle, way) if before > t0 else None
            size = scans[number].jump(before, after) if before > t0 else 0.0
            jumps = ((number, size),) if size > 0.0 else ()
            if joined:
                last = kinks[-1]
                first = steep if last.steep is None else last.steep
                jumps = (*last.jumps, *jumps)
                after = max(after, last.after)
                kinks[-1] = Kink(last.before, after, last.function, first, jumps)
            else:
                kinks.append(Kink(max(before, behind), after, number, steep, jumps))
            behind = after
        crowds = [(*scan.crowd, k) for k, scan in enumerate(scans) if scan.crowd is not None]
        crowds = [crowd for crowd in crowds if crowd[0] <= end]
        yield TimeInstants(
            _merged_bounds(bounds, begin, end), tuple(kinks), end, min(crowds, default=None)
        )
        begin = end


def _merged_bounds(bounds: list[Vector], t0: float, t1: float) -> Vector:
    """Instants in order, no two of them nearer than the intervals of all functions ask for."""
    edges = [np.concatenate([[t0], found, [t1]]) for found in bounds]
    places, t, stops = [1] * len(edges), t0, []
    while t < t1:
        end = t1
        for i, edge in enumerate(edges):
            while edge[places[i]] - t <= _NEAR_END * (edge[places[i]] - edge[places[i] - 1]):
                if places[i] == len(edge) - 1:
                    break
                places[i] += 1
            end = min(end, float(edge[places[i]]))
        t = end if end > t else t1
        stops.append(t)
    return np.array(stops[:-1])
