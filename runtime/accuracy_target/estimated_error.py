"""The estimated error of a simulation with an accuracy target, which ends where it is exceeded."""

from collections.abc import Sequence

import numpy as np

from codegen.errors import AnalysisError
from runtime.accuracy_target.run_comparison import (
    DIVERGED,
    Difference,
    Pair,
    Quantities,
    Run,
    tenfold_time,
)
from runtime.core.arrays import EPS
from runtime.core.outcomes import Outcome
from runtime.results.motion_at_instants import end_after
from runtime.results.result import Result
from runtime.results.run_records import Estimate, ReachedAccuracy


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
    accuracy = result.accuracy = ReachedAccuracy(
        asked=target, estimated=max(EPS, of_all * difference.largest),
        quantities=tuple(_estimates(quantities, difference, of_all)), method=delivered.method,
        formulation=delivered.formulation, rtol=delivered.rtol, runs=trials,
        horizon=None if whole else float(difference.t[count - 1] if count else result.t[0]),
        tenfold=tenfold_time(difference),
        means=_explanation(pair, reasons), seconds=sum(trial.seconds for trial in trials),
    )  # fmt: skip
    if whole:
        result.message += f" {accuracy.sentences()[0]}"
        return result
    if count < (1 if difference.scaled[:1].any() else 2):  # the start alone is no motion
        raise AnalysisError(_refusal(result, accuracy, difference))
    end_after(result, count)
    result.message = _message(accuracy, difference)
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
        ways = (", ".join(run.passed) or "nothing" for run in reversed(pair.by_merit))
        text += (
            f"; joints come and go, and conditions end them, in other ways: {' and '.join(ways)}"
        )
    for trial in (other, delivered):
        if trial.outcome != Outcome.OK.name:
            text += f"; the run at rtol = {trial.rtol:.1e} ends before ({trial.outcome})"
    return "; ".join([text, *reasons]) + "."


def _message(accuracy: ReachedAccuracy, difference: Difference) -> str:
    """The message of a result that ends at its horizon."""
    growth = ""
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
