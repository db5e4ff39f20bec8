"""Comparison of two runs: the size and growth of their difference, and the error that follows.

Runs that a condition ends have ends of their own. These are compared with each other, as are the
instants at which joints come and go: each is a quantity, with an error of its own. The result of a
simulation with an accuracy target has the estimated error, and ends where it is exceeded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.errors import AnalysisError
from codegen.object_display import listed
from runtime.accuracy_target.error_norms import scaled_errors, with_signs_of
from runtime.accuracy_target.runs import Quantities, Run
from runtime.core.arrays import EPS
from runtime.core.outcomes import Outcome
from runtime.mechanism.dense_equations import FloatArray
from runtime.results.motion_at_instants import end_after
from runtime.results.result import Result
from runtime.results.run_records import Estimate, ReachedAccuracy

DIVERGED = 0.1  # accuracy: scaled difference from which on two runs are unrelated
ROUNDING = 2e-13  # accuracy: rtol from which on rounding keeps errors from falling

_SCATTER = 4.0  # measured: scatter of the ratio of two runs' errors about the ratio of their rtol
_SLOWEST = 0.8  # measured: least power of rtol with which errors fall over several powers of ten
_LEAST = 1e-13  # accuracy: difference below which there is only rounding
_MOST = 1e-2  # accuracy: difference from which on its growth is no longer that of a small one
_STRAY = 10.0  # measured: least ratio of a difference to the second run's motion that is an error
_EACH, _ALL = 3.0, 30.0  # measured: exponential growth over a quarter of the time, and over two
_ENOUGH = 16  # safety: least number of instants for an estimate of growth
_NEAR = 0.01  # measured: ratio of rtol from which on two runs may agree by chance
_LEAST_SHARE = 0.1  # safety: least share of a difference where the motions diverge later


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
    new = second[: len(t)]
    old = with_signs_of(new, first[: len(t)], quantities.names)
    # Reactions are not numbers in a singular configuration, and have a size all the same.
    largest = np.maximum(np.abs(np.where(np.isnan(new), 0.0, new)).max(axis=0, initial=0.0), wholes)
    scales = np.where(np.isnan(quantities.scales), largest, quantities.scales)
    scaled = scaled_errors(old, new, scales)
    scaled[~np.isfinite(new) & ~(np.isnan(old) & np.isnan(new))] = np.inf
    return Difference(t, scaled, scales)


def with_instants(
    found: Difference, first: Mapping[str, float], second: Mapping[str, float], t_start: float
) -> Difference:
    """The same with own instants of two runs that began at `t_start`, s, as columns of their own.

    What an instant's error is shows from there on; one behind all others is left out. Its typical
    size is the time of the run.
    """
    t, alike = found.t, (a for a, b in zip(first, second, strict=False) if a == b)
    names = [a for a in alike if len(t) and min(first[a], second[a]) <= t[-1]]
    if not names:
        return found
    old, new = (np.array([run[name] for name in names]) for run in (first, second))
    whole = np.full(len(names), float(t[-1]) - t_start)
    errors = scaled_errors(old[None] - t_start, new[None] - t_start, whole)
    scaled = np.where(t[:, None] >= np.minimum(old, new), errors, 0.0)
    return Difference(
        t, np.hstack([found.scaled, scaled]), np.append(found.scales, whole), tuple(names)
    )


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
        return [*self.loose.instants] == [*self.tight.instants]

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
        one, other = self.loose.path, self.tight.path
        count = min(len(self.loose.t), len(self.tight.t))
        pairs = [(one.q[:count], other.q[:count]), (one.v[:count], other.v[:count])]
        if self.alike and self.tight.ended_by:
            pairs += [(one.final_q[None], other.final_q[None])]
            pairs += [(one.final_v[None], other.final_v[None])]
        same = np.logical_and.reduce([(x == y).all(axis=0) for x, y in pairs])
        free = other.partitions.independent[:1].any(axis=0)
        return bool(same[free].any()) or self.difference.largest == 0.0

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
    def error(self) -> float:
        """Estimated error of the run that is the result.

        Runs of near tolerances may differ by chance by less than either errs, as where bodies
        swing through large angles. Such a run is taken to err by no less than its tolerance times
        the scatter of errors about it.
        """
        loose, tight = self.loose.options.rtol, self.tight.options.rtol
        least = _SCATTER * self.by_merit[0].options.rtol if tight > _NEAR * loose else EPS
        return max(self.share * self.difference.largest, least)

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
    if tight.ended_by and [*loose.instants] == [*tight.instants]:
        t = np.append(tight.t, tight.path.final_t)
        old, new = (
            np.vstack([part, np.repeat(run.values[-1:], len(t) - count, axis=0)])
            for part, run in ((old, loose), (new, tight))
        )
    found = difference(t, old, new, quantities, tight.wholes)
    resolved = is_resolved(found, new, target)
    found = with_instants(found, loose.instants, tight.instants, tight.path.first_t)
    tight.difference = found.largest
    return Pair(loose, tight, found, resolved)


def with_accuracy(
    result: Result, target: float, quantities: Quantities, runs: Sequence[Run], pair: Pair,
    reasons: Sequence[str],
) -> Result:  # fmt: skip
    """The result of the delivered run, up to the instant to which it meets the target.

    Its `ReachedAccuracy` has all runs, and the reasons for the choice of method and coordinates, in
    clauses. Raises AnalysisError if not even the beginning meets the target.
    """
    difference, share = pair.difference, pair.share
    trials = tuple(run.record for run in runs)
    delivered = pair.by_merit[0].record
    of_all = share if difference.largest < DIVERGED else 1.0
    count = difference.within(min(target / share, DIVERGED))
    reached = len(result.t)
    if result.outcome is not Outcome.OK and reached - len(difference.t) <= 1:
        reached = len(difference.t)  # both end by themselves, on either side of an instant
    whole = count >= min(reached, len(difference.t)) and len(difference.t) >= reached
    singular = _singular_position(result, pair)
    accuracy = result.accuracy = ReachedAccuracy(
        asked=target, estimated=max(pair.error, of_all * difference.largest),
        quantities=tuple(_estimates(quantities, difference, of_all)), method=delivered.method,
        formulation=delivered.formulation, rtol=delivered.rtol, runs=trials,
        horizon=None if whole else float(difference.t[count - 1] if count else result.t[0]),
        tenfold=None if singular else tenfold_time(difference),
        means=_explanation(pair, reasons), seconds=sum(trial.seconds for trial in trials),
    )  # fmt: skip
    if whole:
        result.message += f" {accuracy.sentences()[0]}"
        return result
    if count < (1 if difference.scaled[:1].any() else 2):  # the start alone is no motion
        raise AnalysisError(_refusal(result, accuracy, difference))
    end_after(result, count)
    result.message = _message(accuracy, difference, singular)
    result.outcome = Outcome.INACCURATE
    return result


def _estimates(quantities: Quantities, difference: Difference, share: float) -> list[Estimate]:
    """The largest error of each quantity and its instant, the worst first."""
    t, scaled = difference.t, difference.scaled
    if not len(t):  # no common instant
        t, scaled = np.zeros(1), np.zeros((1, len(difference.scales)))
    worst, errors = scaled.argmax(axis=0), np.maximum(share * scaled.max(axis=0), EPS)
    rows = np.stack([difference.scales, errors, t[worst]], axis=1).tolist()
    names = (*quantities.names, *difference.instants)
    estimates = [Estimate(name, *row) for name, row in zip(names, rows, strict=True)]
    return sorted(estimates, key=lambda estimate: -estimate.error)


def _explanation(pair: Pair, reasons: Sequence[str]) -> str:
    """The origin of the estimate."""
    difference, share = pair.difference, pair.share
    delivered, other = (run.record for run in pair.by_merit)
    tight = pair.tight
    text = (
        f"Estimated from the difference of two runs, {difference.largest:.1e} between rtol = "
        f"{other.rtol:.1e} and {delivered.rtol:.1e}"
    )
    if pair.agrees and tight.options.h_max is not None:
        text += (
            "; something moves alike in both, to the last digit, also with steps of at most "
            f"{tight.options.h_max:.3g} s, so that only a shorter pulse would go unseen"
        )
    if delivered.rtol == other.rtol and not pair.agrees and tight.options.h_max is not None:
        text += (
            f", the second with steps of at most {tight.options.h_max:.3g} s, since "
            "runs of two tolerances took the same steps, or moved alike"
        )
    if share < 1.0:
        text += f"; the error of the tighter run is estimated as {share:.2g} times that"
    if other.events != delivered.events:
        text += f"; they have {other.events} and {delivered.events} events"
    if not pair.alike:
        ways = (", ".join(run.instants) or "nothing" for run in reversed(pair.by_merit))
        text += (
            f"; joints come and go, and conditions end them, in other ways: {' and '.join(ways)}"
        )
    for trial in (other, delivered):
        if trial.outcome != Outcome.OK.name:
            text += f"; the run at rtol = {trial.rtol:.1e} ends before ({trial.outcome})"
    return "; ".join([text, *reasons]) + "."


def _singular_position(result: Result, pair: Pair) -> str:
    """A sentence on the first singular position that runs pass or end at; empty without one.

    Errors jump there, and grow before: while they are small, their growth is no sign of chaos then.
    """
    found = [(one.time, listed((*one.drivers, *one.joints))) for one in result.singular]
    for run in (pair.loose, pair.tight):
        path, rows = run.path, result.description.constraints
        if path.outcome is Outcome.SINGULAR and path.index >= 0 and run.result is None:
            found.append((path.final_t, rows[path.index].element))
    t, names = min(found, default=(np.inf, ""))
    compared, small = pair.difference.t, pair.difference.within(_MOST)
    if not found or (small < len(compared) and t > compared[small]):
        return ""
    return (
        f" The motion comes to a singular position at t = {t:.6g} s, where constraints of {names} "
        "become dependent: runs end there, or pass it with an error of rounding that no tolerance "
        "reduces."
    )


def _message(accuracy: ReachedAccuracy, difference: Difference, growth: str) -> str:
    """The message of a result that ends at its horizon; `growth` is a known cause of errors."""
    if accuracy.tenfold is not None:
        growth = (
            f" Errors grow tenfold every {accuracy.tenfold:.3g} s: over this time the motion is "
            "chaotic, and its end depends on digits that no tolerance can provide."
        )
    return (
        f"The accuracy of {accuracy.asked:.1e} is reached up to t = {accuracy.horizon:.6g} s. Over "
        f"all {difference.t[-1] - difference.t[0]:.6g} s the error would be about "
        f"{accuracy.estimated:.1e} at rtol = {accuracy.rtol:.1e}.{growth} {accuracy.means} "
        f"{Outcome.INACCURATE.advice}"
    )


def _refusal(result: Result, accuracy: ReachedAccuracy, difference: Difference) -> str:
    worst = accuracy.quantities[0]
    differs = np.flatnonzero(difference.over_time > 0.0)
    first = float(difference.t[differs[0]] if len(differs) else result.t[0])
    return (
        f"{result.description.title}: an accuracy of {accuracy.asked:.1e} cannot be reached, not "
        f"even up to the first instant, t = {first:.6g} s: at rtol = {accuracy.rtol:.1e} the error "
        f"of {worst.name} is estimated as {worst.error:.1e}, over all the time. {accuracy.means} "
        "Ask for no less than that."
    )
