"""The runs that a global error takes: two of them where the first guess is good.

The error of a run is about C times its relative tolerance, C from 1 to 3000 on most machines and
known of none beforehand; about that line it scatters by a power of ten. So a run is compared with
one of much tighter tolerance. Their difference is the error of the first, or of the second should
that be the larger one by chance. From the first to the second, errors fall by the ratio of the
tolerances as a rule; that they fall by its power 3/4 only is what the estimate of the second takes,
which leaves a factor of four for the scatter at a ratio of 300; below 2e-13 rounding keeps them
from falling. Where this is below what was asked, the second run is the result; else the difference
tells how much tighter the next must be.

A method of order eight costs a third more for a tenth of the tolerance, and less where events cut
its steps, so that a wide gap between the two costs little. In a long smooth motion it costs more:
the second run is the looser one, and the first, when it is found to be good enough, the result;
unless steps are bounded by what was asked, as both would be alike. Else with an implicit method,
where it costs much, the gap is narrow.
"""

import time as clock
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import finish_simulation
from runtime.integrate.method import IMPLICIT, METHODS
from runtime.integrate.problem import Options
from runtime.integrate.wiring import function_table
from runtime.progress_bar import Progress, silent
from runtime.results.reached_accuracy import Trial
from runtime.results.result import Result
from runtime.studies.accuracy_target.error_estimate import Pair, told
from runtime.studies.accuracy_target.method_choice import Choice, after, choose
from runtime.studies.accuracy_target.run_difference import (
    PARTED,
    Columns,
    columns,
    difference,
    resolved,
)
from runtime.studies.accuracy_target.run_pair import SURE, Compared, Run
from runtime.studies.error_norms import require_numbers
from runtime.validation.arguments import instants

if TYPE_CHECKING:
    from runtime.integrate.problem import Correction, Formulation
    from runtime.mechanism.mechanism import Mechanism, Values
    from runtime.results.assembled_state import Assembly

POINTS = 501
"""Output instants where none are asked for."""

_FIRST, _SLOPE = 1e-5, 0.9  # rtol of the first run where 1e-3 is asked; its power of what is asked
_LOOSEST, _TIGHTEST = 1e-3, 1e-14  # rtol of any run
_WIDE = 3e-3  # rtol of the second run by that of the first
_NARROW = 0.03  # the same in long motions, or of the first by that of the second
_STIFF = 0.1  # the same where an implicit method takes part
_LONG = 5000  # evaluations between two events from which on a motion is long
_NEAR, _FAR = 0.3, 1e-6  # rtol of later runs by that of the last
_FALLS = 0.85  # power of rtol with which errors are expected to fall
_MARGIN = 0.7  # of what is asked, that a run is laid out for
_NEXT = 0.01  # rtol of the next run by that of the last, where nothing can be told from it
_MOST_RUNS = 8
_ORDER, _ORDERS = 5, {"dop853": 8}  # powers of the step with which errors fall


def simulate_to(
    mechanism: "Mechanism",
    t_end: float,
    t_eval: npt.ArrayLike | None = None,
    *,
    accuracy: float,
    quantities: Sequence[str] | None = None,
    t_start: float = 0.0,
    method: str | None = None,
    parameters: "Values | None" = None,
    guess: "Values | None" = None,
    start: "Assembly | None" = None,
    correction: "Correction" = "step",
    formulation: "Formulation | None" = None,
    time_scale: float | None = None,
    first_step: float | None = None,
    max_step: float | None = None,
    max_steps: int = 100_000_000,
    progress: Progress = silent,
) -> Result:
    """Integrate with a global error below `accuracy` at the output instants.

    The error of a quantity y is |y - r| / (s + |r|), r the exact one, s its typical size: that of
    `runtime.mechanism.dense_equations` for coordinates, the same a second for velocities, and the
    largest value of the run for all else. `Result.accuracy` says what was reached and how that is
    known. Where it cannot be had over all the time, the result ends at the last instant up
    to which it is, with the outcome `INACCURATE`.

    Parameters
    ----------
    t_eval
        Output instants in s; without them, 501 of equal distance.
    accuracy
        From 1e-12 to 0.1.
    quantities
        Names of series; all coordinates and velocities unless given.
    method, formulation
        Chosen unless given: reduced coordinates where they are built and hold, and the method by
        what the first run shows.

    Raises
    ------
    AnalysisError
        If not even the beginning can be had so accurately.
    InputError
        If a quantity is no series, or has no value at any instant.
    """
    began = clock.perf_counter()
    ready = PreparedSimulation(
        mechanism, t_end, t_start=t_start, parameters=parameters, guess=guess, start=start
    )
    first, last = ready.begin.t, float(t_end)
    times = np.linspace(first, last, POINTS if last > first else 1)
    if t_eval is not None:
        times = instants(t_eval)
    options = Options(
        t_eval=times,
        time_scale=time_scale,
        first_step=first_step,
        h_max=max_step,
        max_steps=max_steps,
    )
    of = columns(mechanism.description, quantities, ready.sizes)
    search = _Search(ready, accuracy, of, options, correction, progress)
    return search.result(choose(ready, method, formulation, correction), began)


class _Search:
    """The runs, each laid out by the ones before."""

    def __init__(
        self,
        ready: PreparedSimulation,
        asked: float,
        of: Columns,
        options: Options,
        correction: "Correction",
        progress: Progress,
    ) -> None:
        self.ready, self.asked, self.of, self.options = ready, asked, of, options
        self.correction, self.progress = correction, progress
        self.trials: list[Trial] = []

    def result(self, choice: Choice, began: float) -> Result:
        """Run until it is accurate enough, or cannot be."""
        rtol = _FIRST * (self.asked / 1e-3) ** _SLOPE
        first, choice = self._first(choice, min(max(rtol, _TIGHTEST / _WIDE), _LOOSEST))
        pair = self._beside(choice, self._second(first), first)
        while not self._over(pair):
            pair = self._beside(choice, self._tighter(pair), pair.tight)
        kept, other = (pair.loose, pair.tight) if pair.unable else (pair.tight, pair.loose)
        made = finish_simulation(self.ready, choice.taken, kept.options, began, silent, kept.path)
        told_of = Pair(self.trials[other.number], self.trials[kept.number], pair.found, pair.share)
        return told(made, self.asked, self.of, self.trials, told_of, choice.reasons)

    def _first(self, choice: Choice, rtol: float) -> tuple[Run, Choice]:
        """The first run that can be compared with others, and what the second one takes."""
        while True:
            run = self._run(choice, rtol)
            self._note(choice, run, None)
            then = after(choice, self.ready, run.path, self.correction)
            if then.formulation == choice.formulation:
                return run, then
            choice = then

    def _second(self, first: Run) -> float:
        """rtol of the second run."""
        rtol, counts = first.options.rtol, first.path.statistics
        if counts.rhs > _LONG * (counts.events + 1):
            free = first.path.outcome is Outcome.OK and self.options.h_max is None
            looser = rtol / _NARROW
            return looser if free and looser <= _LOOSEST else _NARROW * rtol
        stiff = any(method in IMPLICIT for _, method in first.path.methods)
        return rtol * (_STIFF if stiff else _WIDE)

    def _beside(self, choice: Choice, rtol: float, before: Run) -> Compared:
        """Another run, beside one that was made before."""
        run = self._run(choice, rtol)
        loose, tight = (run, before) if rtol > before.options.rtol else (before, run)
        count = min(len(loose.t), len(tight.t))
        found = difference(tight.t[:count], loose.values, tight.values, self.of, tight.wholes)
        self._note(choice, run, found.largest)
        return Compared(loose, tight, found, resolved(found, tight.values[:count], self.asked))

    def _over(self, pair: Compared) -> bool:
        """Whether no further run is needed, or helps."""
        enough = pair.known and pair.found.largest < PARTED
        if enough and pair.share * pair.found.largest <= self.asked:
            return True
        rtol = pair.tight.options.rtol
        return pair.unable or rtol <= _TIGHTEST or len(self.trials) >= _MOST_RUNS

    def _tighter(self, pair: Compared) -> float:
        """rtol of the next run, so that its estimate should be what is asked, less a margin."""
        rtol = pair.tight.options.rtol
        if pair.found.largest >= PARTED or not pair.known:
            return max(_TIGHTEST, _NEXT * rtol)
        off = pair.found.largest * (rtol / pair.loose.options.rtol) ** _FALLS
        wanted = (_MARGIN * self.asked / off) ** (1.0 / SURE)
        return float(max(_TIGHTEST, rtol * min(_NEAR, max(_FAR, wanted))))

    def _run(self, choice: Choice, rtol: float) -> Run:
        options = replace(
            self.options,
            method=choice.method,
            rtol=rtol,
            h_max=self._longest(choice, rtol),
            correction=choice.taken.correction,
        )
        if choice.method in METHODS:  # the run refuses what is none
            function_table(choice.method)  # loaded, or compiled, before time is taken
        began, number = clock.process_time(), len(self.trials)
        path = self.ready.run(choice.taken, options, self.progress)
        seconds = clock.process_time() - began
        if self.of.of_state:
            values = self.of.of_run(path.q, path.v)
            return Run(number, options, path, values, np.zeros(values.shape[1]), seconds)
        made = finish_simulation(
            self.ready, choice.taken, options, clock.perf_counter(), silent, path
        )
        values = self.of.of_result(made)[: len(path.t)]
        if path.outcome is Outcome.OK:  # else another one may go further
            require_numbers(made.description, self.of.names, values)
        return Run(number, options, path, values, self.of.wholes(made), seconds)

    def _longest(self, choice: Choice, rtol: float) -> float | None:
        """The longest step: where it is what bounds the error, it has to fall as tolerances do.

        Else all runs are one, and do not differ by what they all have wrong.
        """
        longest = self.options.h_max
        if longest is None or not self.trials:
            return longest
        order = _ORDERS.get(choice.method, _ORDER)
        return longest * float(min(rtol / self.trials[0].rtol, 1.0) ** (1.0 / order))

    def _note(self, choice: Choice, run: Run, gap: float | None) -> None:
        counts = run.path.statistics
        self.trials.append(
            Trial(
                choice.method,
                choice.formulation,
                run.options.rtol,
                run.seconds,
                counts.rhs,
                counts.steps,
                counts.events,
                run.path.outcome.name,
                gap,
            )
        )
