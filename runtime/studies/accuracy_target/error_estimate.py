"""The estimated error of a simulation with an accuracy target, which ends where it is exceeded."""

from collections.abc import Sequence

import numpy as np

from codegen.errors import AnalysisError
from runtime.core.outcomes import Outcome
from runtime.results.reached_accuracy import Estimate, ReachedAccuracy, Trial
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.studies.accuracy_target.run_difference import (
    DIVERGED,
    Difference,
    Quantities,
    tenfold_time,
)
from runtime.studies.accuracy_target.run_pair import Compared


def with_accuracy(
    result: Result,
    target: float,
    quantities: Quantities,
    trials: Sequence[Trial],
    pair: Compared,
    reasons: Sequence[str],
) -> Result:
    """The result with its `ReachedAccuracy`, up to the instant to which it meets the target.

    Parameters
    ----------
    result
        Of the delivered run.
    trials
        All runs.
    reasons
        For the choice of method and coordinates, in clauses.

    Raises
    ------
    AnalysisError
        If not even the beginning meets the target.
    """
    difference, share = pair.difference, pair.share
    other, delivered = trials[pair.other.number], trials[pair.delivered.number]
    of_all = share if difference.largest < DIVERGED else 1.0
    count = difference.within(min(target / share, DIVERGED))
    reached = len(result.t)
    if result.outcome is not Outcome.OK and reached - len(difference.t) <= 1:
        reached = len(difference.t)  # both end by themselves, on either side of an instant
    whole = count >= min(reached, len(difference.t)) and len(difference.t) >= reached
    accuracy = ReachedAccuracy(
        asked=target,
        estimated=of_all * difference.largest,
        quantities=_estimates(quantities, difference, of_all),
        method=delivered.method,
        formulation=delivered.formulation,
        rtol=delivered.rtol,
        runs=tuple(trials),
        horizon=None if whole else float(difference.t[count - 1] if count else result.t[0]),
        tenfold=tenfold_time(difference),
        means=_explanation(other, delivered, difference, share, reasons),
        seconds=sum(trial.seconds for trial in trials),
    )
    result.accuracy = accuracy
    if whole:
        result.message += f" {accuracy.sentences()[0]}"
        return result
    least = 1 if difference.scaled[:1].any() else 2  # the start alone is no motion
    if count < least:
        raise AnalysisError(_refusal(result, accuracy, difference))
    _cut(result, count)
    result.message = _message(accuracy, difference)
    result.outcome = Outcome.INACCURATE
    return result


def _estimates(
    quantities: Quantities, difference: Difference, share: float
) -> tuple[Estimate, ...]:
    rows = []
    for k, name in enumerate(quantities.names):
        column = difference.scaled[:, k]
        error, t = 0.0, 0.0
        if len(column):
            worst = int(column.argmax())
            error, t = share * float(column[worst]), float(difference.t[worst])
        rows.append(Estimate(name, float(difference.scales[k]), error, t))
    return tuple(sorted(rows, key=lambda row: -row.error))


def _explanation(
    other: Trial, delivered: Trial, difference: Difference, share: float, reasons: Sequence[str]
) -> str:
    """The origin of the estimate."""
    text = (
        f"Estimated from the difference of two runs, {difference.largest:.1e} between rtol = "
        f"{other.rtol:.1e} and {delivered.rtol:.1e}"
    )
    if share < 1.0:
        text += f"; the error of the tighter run is estimated as {share:.2g} times that"
    if other.events != delivered.events:
        text += f"; they have {other.events} and {delivered.events} events"
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


def _cut(result: Result, count: int) -> None:
    """Keep the first instants of a result, and the events until then."""
    result.samples = Samples._make(array[:count] for array in result.samples)
    last = float(result.t[-1])
    result.works = {name: work[:count] for name, work in result.works.items()}
    result.events = tuple(event for event in result.events if event.time <= last)
    result.partitions = tuple(one for one in result.partitions if one.time <= last)
    result.singular = tuple(one for one in result.singular if one.time <= last)
