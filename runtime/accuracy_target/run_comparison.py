"""Two runs compared: how large their difference is, when, how it grows, the error that it shows.

Runs that a condition ends have ends of their own. These are compared with each other, as are the
instants at which joints come and go: each is a quantity, with an error of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.accuracy_target.error_norms import group_magnitude, scaled_errors, series_values
from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Formulation, Options
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.results.run_records import Trial

DIVERGED = 0.1  # accuracy: scaled difference of runs that have nothing in common any more
ROUNDING = 2e-13  # accuracy: rtol from which on rounding keeps errors from falling

_SCATTER = 4.0  # measured: of the errors of two runs, about a fall in proportion to rtol
_SLOWEST = 0.8  # measured: power of rtol with which errors fall over several powers of ten
_LEAST = 1e-13  # accuracy: difference below which there is nothing but rounding
_MOST = 1e-2  # accuracy: difference from which on it no longer grows as a small one does
_STRAY = 10.0  # measured: difference over the second run's motion from which on it is an error
_EACH, _ALL = 3.0, 30.0  # measured: growth over a quarter of an exponential divergence, over two
_ENOUGH = 16  # safety: instants from which growth is estimated
_LEAST_SHARE = 0.1  # safety: least share of a difference where the motions diverge later


@dataclass(frozen=True)
class Quantities:
    """Series of a run whose errors count."""

    names: tuple[str, ...]
    scales: FloatArray  # typical sizes, (c,); NaN: the largest value in the run of it or its whole
    state_columns: npt.NDArray[np.int64]  # in [q, v], (c,); -1: of a result, such as a reaction

    @property
    def are_states(self) -> bool:
        """Whether all are coordinates and velocities."""
        return bool(np.all(self.state_columns >= 0))

    def of_run(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """The values, (k, c), where all are coordinates and velocities."""
        values: FloatArray = np.hstack([q, v])[:, self.state_columns]
        return values

    def of_result(self, result: Result) -> FloatArray:
        """The values, (k, c)."""
        return series_values(result, self.names)

    def wholes(self, result: Result) -> FloatArray:
        """Magnitudes of the wholes that the series are parts of, (c,); 0 of those with a size."""
        sizes = zip(self.names, np.isnan(self.scales), strict=True)
        return np.array([group_magnitude(result, name) if free else 0.0 for name, free in sizes])


def quantities_of(
    description: Description, names: Sequence[str] | None, sizes: FloatArray
) -> Quantities:
    """The quantities of these names: all that is integrated without `names`.

    `sizes`, (n,): of coordinates, and of velocities per second. A result refuses unknown names.
    """
    if names is not None and not len(names):
        raise InputError(
            f"{description.title}: quantities is {names!r}; it must be names of series, such as "
            f'("{description.coordinates.names[0]}",).'
        )
    rows = description.coordinates
    states = [*rows.names, *(row.velocity for row in rows)]
    column = {name: k for k, name in enumerate(states)}
    chosen = description.variables if names is None else tuple(dict.fromkeys(names))
    state_columns = np.array([column.get(name, -1) for name in chosen], dtype=np.int64)
    both = np.concatenate([sizes, sizes, [np.nan]])
    return Quantities(chosen, both[state_columns], state_columns)


@dataclass(frozen=True)
class Difference:
    """The difference of two runs."""

    t: FloatArray  # instants that both reached, s, (k,)
    scaled: FloatArray  # |y - r| / (s + |r|) of each quantity, r that of the second run, (k, c)
    scales: FloatArray  # s, (c,)
    instants: tuple[str, ...] = ()  # names of those whose errors are the last columns

    @property
    def largest(self) -> float:
        """Of all quantities and instants."""
        return float(self.scaled.max(initial=0.0))

    @property
    def over_time(self) -> FloatArray:
        """The largest up to each instant, (k,)."""
        largest: FloatArray = np.maximum.accumulate(self.scaled.max(axis=1, initial=0.0))
        return largest

    def within(self, limit: float) -> int:
        """Number of instants before the first with a difference above `limit`."""
        return int(np.searchsorted(self.over_time, limit, side="right"))


def difference(
    t: FloatArray, first: FloatArray, second: FloatArray, quantities: Quantities,
    wholes: FloatArray | float = 0.0,
) -> Difference:  # fmt: skip
    """Compare the values of two runs, (≥ k, c), at the instants of the shorter one, (k,).

    The magnitudes of the wholes that series are parts of, (c,), are those of `Quantities.wholes`.
    """
    old, new = first[: len(t)], second[: len(t)]
    # Reactions are not numbers in a singular configuration, and have a size all the same.
    largest = np.maximum(np.abs(np.where(np.isnan(new), 0.0, new)).max(axis=0, initial=0.0), wholes)
    scales = np.where(np.isnan(quantities.scales), largest, quantities.scales)
    scaled = scaled_errors(old, new, scales)
    scaled[~np.isfinite(new) & ~(np.isnan(old) & np.isnan(new))] = np.inf
    return Difference(t, scaled, scales)


def with_instants(
    found: Difference, names: Sequence[str], first: FloatArray, second: FloatArray, t_start: float
) -> Difference:
    """The same with instants, (m,) s, of two runs that began at `t_start`, as columns of their own.

    What an instant's error is shows from there on; one behind all others is left out. Its typical
    size is the time of the run.
    """
    t = found.t
    shown = np.flatnonzero(np.minimum(first, second) <= t[-1]) if len(t) else np.zeros(0, np.int64)
    first, second = first[shown], second[shown]
    whole = np.full(len(shown), float(t[-1]) - t_start if len(t) else 0.0)
    errors = scaled_errors(first[None] - t_start, second[None] - t_start, whole)
    behind = t[:, None] >= np.minimum(first, second)
    return Difference(
        t, np.hstack([found.scaled, np.where(behind, errors, 0.0)]),
        np.concatenate([found.scales, whole]), tuple(names[k] for k in shown.tolist()),
    )  # fmt: skip


def is_resolved(found: Difference, values: FloatArray, target: float) -> bool:
    """Whether no difference above the target is as large as the second run's motion, (k, c).

    One that is much larger is the first run's own error: what the second one hardly moves is not
    lost in the first.
    """
    if not len(values):
        return True
    spans = np.ptp(np.nan_to_num(values), axis=0)
    gaps = found.scaled.max(axis=0)
    ratio = gaps * found.scales / np.maximum(spans, 1e-300)
    return not bool(np.any((gaps > target) & (ratio > DIVERGED) & (ratio < _STRAY)))


def tenfold_time(found: Difference) -> float | None:
    """Time in which a small difference grows tenfold, s; None unless it grows exponentially.

    The difference is examined while it is neither rounding nor as large as the motion. From one to
    the next of the last three quarters of that time its median must grow by a factor, and by a
    larger one from the second quarter to the fourth. A power t^p, p ≤ 3, grows at most by 2.7 from
    the third quarter to the fourth; a difference that an event leaves does not go on growing.
    """
    begun, small = found.within(_LEAST), found.within(_MOST)
    if small - begun < _ENOUGH:
        return None
    t, sizes = found.t[begun:small], found.scaled.max(axis=1, initial=0.0)[begun:small]
    edges = found.t[0] + (t[-1] - found.t[0]) * np.array([0.25, 0.5, 0.75])
    parts = np.split(sizes, np.searchsorted(t, edges))[1:]
    if min(len(part) for part in parts) < _ENOUGH // 8:
        return None
    second, third, fourth = (float(np.median(part)) for part in parts)
    steady = third > _EACH * second and fourth > _EACH * third and fourth > _ALL * second
    if not (second > 0.0 and steady):
        return None
    later = t >= edges[0]
    logs = np.log10(np.maximum(sizes[later], _LEAST))
    return 1.0 / float(np.polyfit(t[later], logs, 1)[0])


def safe_share(ratio: float) -> float:
    """Share of the looser run's error that the tighter one's may be, for this ratio of rtol."""
    return float(min(1.0, max(_SCATTER * ratio, ratio**_SLOWEST)))


def sufficient_ratio(share: float) -> float:
    """Ratio of rtol for which the error of the tighter run is this share of the looser one's."""
    return float(min(share / _SCATTER, share ** (1.0 / _SLOWEST)))


def own_instants(result: Result) -> dict[str, float]:
    """The instants of a run's changes and of its end by a condition, s: ``t(latch)#2``."""
    ends = [(result.ended_by, float(result.t[-1]))] if result.ended_by else []
    found = dict[str, float]()
    for name, t in [*((one.joint, one.time) for one in result.reconnections), *ends]:
        count = sum(1 for known in found if known.partition("#")[0] == f"t({name})")
        found[f"t({name}){f'#{count + 1}' if count else ''}"] = t
    return found


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
