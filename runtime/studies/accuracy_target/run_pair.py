"""A run, and a pair of runs: the instants at which they are compared, and what that shows.

Runs that a condition ends have ends of their own. These are compared with each other, as are the
instants at which joints come and go: each is a quantity, with an error of its own.
"""

from dataclasses import dataclass, field

import numpy as np

from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Formulation, Options
from runtime.integrate.trajectory import Trajectory
from runtime.results.accuracy_target_record import Trial
from runtime.results.result import Result
from runtime.studies.accuracy_target.run_difference import (
    DIVERGED,
    ROUNDING,
    Difference,
    Quantities,
    difference,
    is_resolved,
    safe_share,
    with_instants,
)
from runtime.studies.series_by_name import FloatArray

_LEAST_SHARE = 0.1  # safety: least share of a difference where the motions diverge later


@dataclass
class Run:
    """A run with the settings that it had."""

    formulation: Formulation
    options: Options
    path: Trajectory
    values: FloatArray  # of the quantities, (≥ k, c); of a run that a condition ended, there too
    wholes: FloatArray  # magnitudes of the wholes that they are parts of, (c,) or (1,)
    seconds: float  # processor time
    ended_by: str = ""  # the condition that ended it
    # of joints that came or went, of that end, s
    instants: dict[str, float] = field(default_factory=dict)
    result: Result | None = None  # of a run in which joints come and go
    difference: float | None = None  # largest, from the run with which it was compared

    @property
    def t(self) -> FloatArray:
        """Instants that are compared with those of the same time in other runs, s."""
        path = self.path
        return path.t[path.t < path.final_t] if self.ended_by else path.t

    @property
    def passed(self) -> tuple[str, ...]:
        """Names of its instants."""
        return tuple(self.instants)

    @property
    def record(self) -> Trial:
        """Settings, cost and outcome."""
        counts, options = self.path.statistics, self.options
        return Trial(
            options.method, self.formulation, options.rtol, self.seconds, counts.rhs, counts.steps,
            counts.events, self.path.outcome.name, self.difference,
        )  # fmt: skip


@dataclass(frozen=True)
class Pair:
    """Two runs, the second with the tighter tolerance, and their difference.

    A vibration that the loose run does not resolve at all makes a difference of its own size, which
    shows nothing about the tight run.
    """

    loose: Run
    tight: Run
    difference: Difference
    resolved: bool

    @property
    def tight_fails(self) -> bool:
        """Whether the tighter run fails before the end of the looser one."""
        failed = self.tight.path.outcome is not Outcome.OK
        return failed and len(self.tight.t) < len(self.loose.t)

    @property
    def alike(self) -> bool:
        """Whether the same joints come and go in both, and the same condition ends them."""
        return self.loose.passed == self.tight.passed

    @property
    def conclusive(self) -> bool:
        """Whether all of the tighter run was compared with a run that resolves all motions."""
        compared = len(self.loose.t) >= len(self.tight.t) or bool(self.tight.ended_by)
        return self.resolved and self.alike and compared and not self.tight_fails

    @property
    def agrees(self) -> bool:
        """Whether an independent coordinate moves in both runs alike, to the last digit.

        Two runs with different steps err differently, unless nothing acts at the instants at which
        they look.
        """
        runs, count = (self.loose.path, self.tight.path), min(len(self.loose.t), len(self.tight.t))
        free = runs[1].partitions.independent[:1].any(axis=0)
        one, other = (np.hstack([run.q[:count, free], run.v[:count, free]]) for run in runs)
        if self.alike and self.tight.ended_by:
            ends = (np.hstack([run.final_q[free], run.final_v[free]]) for run in runs)
            one, other = (np.vstack(pair) for pair in zip((one, other), ends, strict=True))
        same = (one == other).all(axis=0).reshape(2, -1).all(axis=0)
        return bool(same.any()) or self.difference.largest == 0.0

    @property
    def share(self) -> float:
        """Share of the difference that the error of the tighter run is estimated to be."""
        largest = self.difference.largest
        if not self.conclusive or largest <= ROUNDING:  # rounding, in both runs alike
            return 1.0
        loose, tight = (max(run.options.rtol, ROUNDING) for run in (self.loose, self.tight))
        share = safe_share(tight / loose)
        return max(share, _LEAST_SHARE) if largest >= DIVERGED else share

    @property
    def by_merit(self) -> tuple[Run, Run]:
        """The run that is the result, and the one with which it was compared."""
        return (self.loose, self.tight) if self.tight_fails else (self.tight, self.loose)


def compare(loose: Run, tight: Run, quantities: Quantities, target: float) -> Pair:
    """Two runs at the instants of the tighter one that the looser one reached.

    Behind the end of a looser run that a condition ended, and at the end of the tighter one, it is
    their ends that are compared.
    """
    count = min(len(loose.t), len(tight.t))
    t, old, new = tight.t[:count], loose.values[:count], tight.values[:count]
    if tight.ended_by and loose.passed == tight.passed:
        rows = len(tight.t) - count + 1
        t = np.append(tight.t, tight.path.final_t)
        old, new = (
            np.vstack([part, np.repeat(run.values[-1:], rows, axis=0)])
            for part, run in ((old, loose), (new, tight))
        )
    found = difference(t, old, new, quantities, tight.wholes)
    resolved = is_resolved(found, new, target)
    common = [
        (name, first, second)
        for (name, first), (other, second) in zip(
            loose.instants.items(), tight.instants.items(), strict=False
        )
        if name == other
    ]
    if common:
        names, *instants = zip(*common, strict=True)
        first, second = np.array(instants)
        found = with_instants(found, names, first, second, tight.path.first_t)
    tight.difference = found.largest
    return Pair(loose, tight, found, resolved)
