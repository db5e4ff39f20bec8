"""What a search for an accuracy tells with its result, which ends where the accuracy does."""

from codegen.errors import AnalysisError
from runtime.analyses.accurate.answer import Accuracy, Estimate, Trial
from runtime.analyses.accurate.comparing import Columns, Difference, tenfold
from runtime.outcomes import Outcome
from runtime.results.result import Result
from runtime.results.samples import Samples


def told(
    made: Result,
    asked: float,
    of: Columns,
    trials: tuple[Trial, ...],
    delivered: Trial,
    found: Difference,
    share: float,
    reasons: tuple[str, ...],
) -> Result:
    """The result with its `Accuracy`, up to the instant to which it is as accurate as asked.

    Parameters
    ----------
    made
        The run that is delivered.
    delivered
        The same among `trials`.
    found, share
        Its difference from another run, and how much of that is its own error at most.

    Raises
    ------
    AnalysisError
        If not even the beginning is.
    """
    count = found.within(asked / share)
    reached = len(made.t) if made.outcome is Outcome.OK else len(found.t)
    whole = count >= min(reached, len(found.t)) and len(found.t) >= reached
    accuracy = Accuracy(
        asked=asked,
        estimated=share * found.largest,
        quantities=_estimates(of, found, share),
        method=delivered.method,
        formulation=delivered.formulation,
        rtol=delivered.rtol,
        runs=trials,
        horizon=None if whole else float(found.t[count - 1]) if count else float(made.t[0]),
        tenfold=tenfold(found),
        means=_means(trials, delivered, found, share, reasons),
        seconds=sum(trial.seconds for trial in trials),
    )
    made.accuracy = accuracy
    if not whole:
        if count < 2:
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


def _means(
    trials: tuple[Trial, ...],
    delivered: Trial,
    found: Difference,
    share: float,
    reasons: tuple[str, ...],
) -> str:
    """By what means the estimate was found."""
    place = trials.index(delivered)
    other = trials[place - 1] if share < 1.0 else trials[-1]
    text = (
        f"Estimated from the difference of two runs, {found.largest:.1e} between rtol = "
        f"{other.rtol:.1e} and {delivered.rtol:.1e}"
    )
    if share < 1.0:
        text += f", of which the tighter one is taken to err by at most {share:.2g} times that"
    if other.events != delivered.events:
        text += f"; they have {other.events} and {delivered.events} events"
    for reason in reasons:
        text += f"; {reason}"
    return f"{text}."


def _ends(made: Result, accuracy: Accuracy, found: Difference) -> str:
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
        f"rtol = {accuracy.rtol:.1e}.{growth} {Outcome.INACCURATE.advice}"
    )


def _refusal(made: Result, accuracy: Accuracy, found: Difference) -> str:
    worst = accuracy.quantities[0]
    return (
        f"{made.description.title}: an accuracy of {accuracy.asked:.1e} cannot be had, not even at "
        f"the beginning: at rtol = {accuracy.rtol:.1e} the error of {worst.name} is estimated as "
        f"{worst.error:.1e}, over all the time asked. {accuracy.means} Ask for no less than that."
    )


def _cut(made: Result, count: int) -> None:
    """Keep the first instants of a result, and what happened until then."""
    made.samples = Samples._make(array[:count] for array in made.samples)
    last = float(made.t[-1])
    made.works = {name: work[:count] for name, work in made.works.items()}
    made.events = tuple(event for event in made.events if event.time <= last)
    made.partitions = tuple(one for one in made.partitions if one.time <= last)
    made.singular = tuple(one for one in made.singular if one.time <= last)
