"""Numbers and sentences about the runs of a study."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from codegen.errors import InputError
from codegen.object_display import counted
from codegen.readers.values import one_line
from runtime.core.outcomes import Outcome
from runtime.sweeps.member_run import FAILED_TO_RUN

if TYPE_CHECKING:
    import pandas as pd

    from runtime.sweeps.execution import Execution
    from runtime.sweeps.study import Study

SHARES = (0.00135, 0.5, 0.99865)  # layout: three standard deviations of a normal distribution
_SHOWN = 3  # layout: failed runs of one outcome that sentences name
_LONGEST = 160  # layout: characters of a message in a sentence


def statistics_of(study: "Study", shares: Sequence[float]) -> "pd.DataFrame":
    """One row a quantity; see `Study.statistics`."""
    import pandas as pd

    wrong = [share for share in shares if not 0.0 <= share <= 1.0]
    if wrong:
        raise InputError(f"A share is {wrong[0]:g}; it must lie from 0 to 1.")
    rows = []
    for name in study.quantities:
        values = study.data[name].values
        known = values[np.isfinite(values)]
        row = {"unit": study.data[name].attrs.get("units", ""), "runs": len(known)}
        if len(known):
            row |= {"mean": known.mean(), "sd": known.std(ddof=1) if len(known) > 1 else np.nan}
            row |= {"min": known.min(), "max": known.max()}
            row |= {f"{share:g}": np.quantile(known, share) for share in shares or SHARES}
        rows.append(row)
    return pd.DataFrame(rows, index=pd.Index(study.quantities, name="quantity"))


def sentences_of(study: "Study", execution: "Execution | None") -> Iterator[str]:
    """Outcomes, extremes of the quantities, the first failures, and the time."""
    from runtime.sweeps.study import NOT_RUN

    known = FAILED_TO_RUN | {one.name: one.meaning for one in Outcome}
    for outcome, count in study.outcomes.items():
        meaning = known.get(outcome, "not run yet").rstrip(".")
        yield f"{outcome}: {counted(count, 'run')} ({meaning[:1].lower() + meaning[1:]})"
        if outcome in {"OK", NOT_RUN}:
            continue
        where = np.flatnonzero(study.data["outcome"].values == outcome)
        for run in where[:_SHOWN]:
            point = ", ".join(
                f"{name} = {value:g}" for name, value in study.point(int(run)).items()
            )
            message = one_line(study.data["message"].values[run], _LONGEST)
            yield f"  run {run}, {point}: {message}"
    for name in study.quantities:
        values = study.data[name].values
        if not np.isfinite(values).any():
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        unit = study.data[name].attrs.get("units", "")
        yield (
            f"{name}: from {values[low]:.6g} (run {low}) to {values[high]:.6g} {unit}".rstrip()
            + f" (run {high})"
        )
    if execution is not None:
        yield _time(execution)
    if not study.complete:
        yield "Stopped before the end. Go on with the same request and --resume (resume=True)."


def _time(execution: "Execution") -> str:
    lost = f"; {counted(execution.replaced, 'lost worker')} replaced" if execution.replaced else ""
    made = f"{counted(execution.runs, 'run')} in {execution.seconds:.1f} s"
    if not execution.simulation:  # of blocks whose runs were all made before
        return f"{made}{lost}"
    share = execution.simulation / (execution.simulation + execution.overhead)
    return f"{made}; {share:.1%} of the processor time is simulation{lost}"
