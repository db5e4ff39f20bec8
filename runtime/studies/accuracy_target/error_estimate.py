"""What a search for an accuracy tells with its result, which ends where the accuracy does."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from codegen.errors import AnalysisError
from runtime.core.outcomes import Outcome
from runtime.results.reached_accuracy import Estimate, ReachedAccuracy, Trial
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.studies.accuracy_target.run_difference import PARTED, Columns, Difference, tenfold


@dataclass(frozen=True)
class Pair:
    """Two runs that were compared.

    Attributes
    ----------
    other, delivered
        The second one is the result.
    found
        Their difference.
    share
        How much of it the error of the result is taken to be.
    """

    other: Trial
    delivered: Trial
    found: Difference
    share: float


def told(
    made: Result,
    asked: float,
    of: Columns,
    trials: Sequence[Trial],
    pair: Pair,
    reasons: Sequence[str],
) -> Result:
    """The result with its `ReachedAccuracy`, up to the instant to which it is as accurate as asked.

    Parameters
    ----------
    made
        The run that is delivered.
    trials
        All runs.
    reasons
        Why method and coordinates are what they are, in clauses.

    Raises
    ------
    AnalysisError
        If not even the beginning is.
    """
    found, share, delivered = pair.found, pair.share, pair.delivered
    of_all = share if found.largest < PARTED else 1.0
    count = found.within(min(asked / share, PARTED))
    reached = len(made.t)
    if made.outcome is not Outcome.OK and reached - len(found.t) <= 1:
        reached = len(found.t)  # both end by themselves, on either side of an instant
    whole = count >= min(reached, len(found.t)) and len(found.t) >= reached
    accuracy = ReachedAccuracy(
        asked=asked,
        estimated=of_all * found.largest,
        quantities=_estimates(of, found, of_all),
        method=delivered.method,
        formulation=delivered.formulation,
        rtol=delivered.rtol,
        runs=tuple(trials),
        horizon=None if whole else float(found.t[count - 1]) if count else float(made.t[0]),
        tenfold=tenfold(found),
        means=_means(pair, reasons),
        seconds=sum(trial.seconds for trial in trials),
    )
    made.accuracy = accuracy
    if not whole:
        nothing = 1 if found.scaled[:1].any() else 2  # the start alone is no motion
        if count < nothing:
            raise AnalysisError(_refusal(made, accuracy, found))
        _cut(made, count)
        made.message = _ends(made, accuracy, found)
        made.outcome = Outcome.INACCURATE
    else:
        made.message += f" {accuracy.sentences()[0]}"
    return made


def _estimates(of: Columns, found: Difference, share: float) -> tuple[Estimate, ...]:
    rows = []
    for k, name in enumerate(of.names):
        column = found.scaled[:, k]
        worst = int(column.argmax()) if len(column) else 0
        error, t = (share * float(column[worst]), float(found.t[worst])) if len(column) else (0, 0)
        rows.append(Estimate(name, float(found.scales[k]), error, t))
    return tuple(sorted(rows, key=lambda row: -row.error))


def _means(pair: Pair, reasons: Sequence[str]) -> str:
    """By what means the estimate was found."""
    other, delivered = pair.other, pair.delivered
    text = (
        f"Estimated from the difference of two runs, {pair.found.largest:.1e} between rtol = "
        f"{other.rtol:.1e} and {delivered.rtol:.1e}"
    )
    if pair.share < 1.0:
        text += f", and the tighter one is taken to err by {pair.share:.2g} times that"
    if other.events != delivered.events:
        text += f"; they have {other.events} and {delivered.events} events"
    for trial in (other, delivered):
        if trial.outcome != Outcome.OK.name:
            text += f"; that at rtol = {trial.rtol:.1e} ends before ({trial.outcome})"
    for reason in reasons:
        text += f"; {reason}"
    return f"{text}."


def _ends(made: Result, accuracy: ReachedAccuracy, found: Difference) -> str:
    """The message of a result that ends at its horizon."""
    growth = (
        f" Errors grow tenfold every {accuracy.tenfold:.3g} s: the motion is chaotic over the time "
        "asked, and what happens later hangs on digits that no tolerance gives."
        if accuracy.tenfold is not None
        else ""
    )
    return (
        f"The accuracy of {accuracy.asked:.1e} is had up to t = {accuracy.horizon:.6g} s. Over all "
        f"{found.t[-1] - found.t[0]:.6g} s the error would be about {accuracy.estimated:.1e} at "
        f"rtol = {accuracy.rtol:.1e}.{growth} {accuracy.means} {Outcome.INACCURATE.advice}"
    )


def _refusal(made: Result, accuracy: ReachedAccuracy, found: Difference) -> str:
    worst = accuracy.quantities[0]
    return (
        f"{made.description.title}: an accuracy of {accuracy.asked:.1e} cannot be had, not even up "
        f"to the first instant, t = {_first(made, found):.6g} s: at rtol = {accuracy.rtol:.1e} "
        f"the error of {worst.name} is estimated as {worst.error:.1e}, over all the time "
        f"asked. {accuracy.means} Ask for no less than that."
    )


def _first(made: Result, found: Difference) -> float:
    """The first instant at which the runs differ, s; of a run that was not compared, its first."""
    differs = np.flatnonzero(found.over_time > 0.0)
    return float(found.t[differs[0]] if len(differs) else made.t[0])


def _cut(made: Result, count: int) -> None:
    """Keep the first instants of a result, and what happened until then."""
    made.samples = Samples._make(array[:count] for array in made.samples)
    last = float(made.t[-1])
    made.works = {name: work[:count] for name, work in made.works.items()}
    made.events = tuple(event for event in made.events if event.time <= last)
    made.partitions = tuple(one for one in made.partitions if one.time <= last)
    made.singular = tuple(one for one in made.singular if one.time <= last)
