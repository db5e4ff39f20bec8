"""End of a run that differs from looser ones by more than its tolerance makes up for.

The estimated error of a run is a share of its largest difference from a looser one, which only
grows as the run goes on. Once that is above what the target permits, the rest of the run is of no
use: another is planned by the difference at the end, which is foreseen by a power of time.
"""

from collections.abc import Callable, Sequence

import numpy as np

from runtime.integrate.run import States
from runtime.studies.accuracy_target.run_difference import (
    Quantities,
    Run,
    safe_share,
    sufficient_ratio,
)
from runtime.studies.error_norms import scaled_errors

_LOOKS = 8  # measured: comparisons in a run
_LATEST = 0.8  # measured: of the time; a run that has gone so far is useful when it is whole
_GROWTH = 1.5  # measured: power of time with which differences grow
_RESERVE = 0.3  # measured: share of the permitted error for which the next run is planned
_LARGE = 0.05  # accuracy: foreseen difference from which on a looser run shows nothing
_CLOSEST = 0.5  # safety: rtol of the next run over that of the ended one, at most
_TIGHTEST = 5e-13  # measured: rtol of the next run below which this one had better be whole
_SHORTEST, _LONGEST = 16, 128  # measured: trial steps between two looks at the clock


class EarlyTermination:
    """Compares a run with looser ones while it is made, and ends it where it will not do.

    `permitted` is the error that the run may have, `begin` and `end` are its instants, s.
    """

    def __init__(
        self, rtol: float, loose: Sequence[Run], permitted: float, quantities: Quantities,
        begin: float, end: float,
    ) -> None:  # fmt: skip
        self.rtol, self.loose, self.permitted, self.quantities = rtol, loose, permitted, quantities
        self.begin, self.span = begin, end - begin
        self.limits = [permitted / safe_share(rtol / run.options.rtol) for run in loose]
        self.largest = [0.0] * len(loose)  # difference from each
        self.count = 0  # instants that were compared
        self.look_at = begin + self.span / _LOOKS
        self.following: float | None = None  # rtol of the next run, once this one has ended

    @property
    def chunk(self) -> int:
        """Trial steps between two calls, the same whatever the speed of the machine."""
        steps = self.loose[-1].path.statistics.steps // _LOOKS
        return min(max(steps, _SHORTEST), _LONGEST)

    def __call__(self, t: float, states: Callable[[], States]) -> bool:
        """Whether the run, which has reached t, ends; see `runtime.integrate.run.Watch`."""
        if not self.look_at <= t <= self.begin + _LATEST * self.span:
            return False
        self.look_at = t + self.span / _LOOKS
        times, q, v = states()
        grid = self.loose[0].path.t
        first = int(np.searchsorted(grid, times[0])) if len(times) else 0
        since = max(first, self.count)
        self.count = first + len(times)
        if self.count <= since or grid[self.count - 1] <= self.begin:
            return False
        values = self.quantities.of_run(q[since - first :], v[since - first :])
        for j, run in enumerate(self.loose):
            found = scaled_errors(run.values[since : self.count], values, self.quantities.scales)
            self.largest[j] = max(self.largest[j], float(found.max()))
        if any(largest <= limit for largest, limit in zip(self.largest, self.limits, strict=True)):
            return False
        growth = (self.span / (float(grid[self.count - 1]) - self.begin)) ** _GROWTH
        sufficient = [
            run.options.rtol * sufficient_ratio(_RESERVE * self.permitted / (growth * largest))
            for run, largest in zip(self.loose, self.largest, strict=True)
            if growth * largest < _LARGE
        ]
        following = min(max(sufficient, default=0.0), _CLOSEST * self.rtol)
        # Near rounding errors hardly fall: the next run is compared with this one then.
        if following > _TIGHTEST:
            self.following = following
        return following > _TIGHTEST
