"""Search for a tolerance with which the global error meets a target: two runs if well guessed.

The error of a run is about C times its relative tolerance, with C from 1 to 3000 on most machines
and known for none beforehand; it scatters about that line by a power of ten. A run is therefore
compared with another of much tighter tolerance. Their difference is the error of the first run, or
of the second if that is larger by chance. From the first to the second, errors fall by the ratio of
the tolerances as a rule; the estimate assumes that they fall by its power 3/4 only, which leaves a
factor of four for the scatter at a ratio of 300; below 2e-13 rounding keeps them from falling. If
the estimate is below the target, the second run is the result; otherwise the difference shows how
much tighter the next run must be.

A method of order eight costs a third more for a tenth of the tolerance, and less where events cut
its steps, so that a wide gap between the two runs costs little. In a long smooth motion it costs
more: there the second run is the looser one, and the first, if it is found accurate enough, the
result; unless the user bounded the steps, which would make both runs alike. With an implicit
method, where it costs much, the gap is narrow.
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
from runtime.integrate.method import IMPLICIT, REGISTER
from runtime.integrate.problem import Options
from runtime.integrate.wiring import function_table
from runtime.progress_bar import Progress, silent
from runtime.results.reached_accuracy import Trial
from runtime.results.result import Result
from runtime.studies.accuracy_target.error_estimate import with_accuracy
from runtime.studies.accuracy_target.method_choice import Choice, choose, revise
from runtime.studies.accuracy_target.run_difference import (
    DIVERGED,
    Quantities,
    difference,
    is_resolved,
    quantities_of,
)
from runtime.studies.accuracy_target.run_pair import SAFE_POWER, Compared, Run
from runtime.studies.series import require_numbers
from runtime.studies.timing import processor_time
from runtime.validation.arguments import instants

if TYPE_CHECKING:
    from runtime.integrate.problem import Correction, Formulation
    from runtime.mechanism.mechanism import Mechanism, Values
    from runtime.results.assembled_state import Assembly

POINTS = 501
"""Output instants if the user gives none."""

_FIRST, _SLOPE = 1e-5, 0.9  # measured: rtol of the first run for a target of 1e-3; its power law
_LOOSEST, _TIGHTEST = 1e-3, 1e-14  # safety: rtol of any run
_WIDE = 3e-3  # measured: rtol of the second run over that of the first
_NARROW = 0.03  # measured: the same in long motions, or of the first over that of the second
_STIFF = 0.1  # measured: the same with an implicit method
_LONG = 5000  # measured: evaluations between two events from which on a motion is long
_NEAR, _FAR = 0.3, 1e-6  # safety: rtol of later runs over that of the last
_EXPECTED_POWER = 0.85  # measured: power of rtol with which errors are expected to fall
_MARGIN = 0.7  # safety: share of the target that a run is planned for
_NEXT = 0.01  # measured: rtol of the next run over that of the last, if that shows nothing
_MOST_RUNS = 8  # safety


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
    `runtime.mechanism.dense_equations` for coordinates, the same per second for velocities, and
    the largest value in the run for all others. `Result.accuracy` has the accuracy reached and the
    evidence for it. Where the target cannot be met over all the time, the result ends at the last
    instant up to which it is, with the outcome `INACCURATE`.

    Parameters
    ----------
    t_eval
        Output instants in s; without them, 501, equally spaced.
    accuracy
        From 1e-12 to 0.1.
    quantities
        Names of series; all coordinates and velocities unless given.
    method, formulation
        Chosen unless given: reduced coordinates where they are built and stay valid, and the method
        that suits the first run.

    Raises
    ------
    AnalysisError
        If not even the beginning can be computed so accurately.
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
    chosen = quantities_of(mechanism.description, quantities, ready.sizes)
    search = _Search(ready, accuracy, chosen, options, correction, progress)
    return search.result(choose(ready, method, formulation, correction), began)


class _Search:
    """The runs, each planned from those before."""

    def __init__(
        self,
        ready: PreparedSimulation,
        target: float,
        quantities: Quantities,
        options: Options,
        correction: "Correction",
        progress: Progress,
    ) -> None:
        self.ready, self.target, self.options = ready, target, options
        self.quantities, self.correction, self.progress = quantities, correction, progress
        self.trials: list[Trial] = []

    def result(self, choice: Choice, began: float) -> Result:
        """Run until the target is met, or cannot be met."""
        rtol = _FIRST * (self.target / 1e-3) ** _SLOPE
        first, choice = self._first(choice, min(max(rtol, _TIGHTEST / _WIDE), _LOOSEST))
        pair = self._compare(choice, self._second(first), first)
        while not self._is_final(pair):
            pair = self._compare(choice, self._tighter(pair), pair.tight)
        run = pair.delivered
        result = finish_simulation(self.ready, choice.taken, run.options, began, silent, run.path)
        return with_accuracy(
            result, self.target, self.quantities, self.trials, pair, choice.reasons
        )

    def _first(self, choice: Choice, rtol: float) -> tuple[Run, Choice]:
        """The first run that can be compared with others, and the choice for the second."""
        while True:
            run = self._run(choice, rtol)
            self._record(choice, run, None)
            then = revise(choice, self.ready, run.path, self.correction)
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

    def _compare(self, choice: Choice, rtol: float, before: Run) -> Compared:
        """Another run, compared with an earlier one."""
        run = self._run(choice, rtol)
        loose, tight = (run, before) if rtol > before.options.rtol else (before, run)
        count = min(len(loose.t), len(tight.t))
        found = difference(
            tight.t[:count], loose.values, tight.values, self.quantities, tight.wholes
        )
        self._record(choice, run, found.largest)
        resolved = is_resolved(found, tight.values[:count], self.target)
        return Compared(loose, tight, found, resolved)

    def _is_final(self, pair: Compared) -> bool:
        """Whether no further run is needed, or helps."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        if pair.conclusive and largest < DIVERGED and pair.share * largest <= self.target:
            return True
        return pair.tight_fails or rtol <= _TIGHTEST or len(self.trials) >= _MOST_RUNS

    def _tighter(self, pair: Compared) -> float:
        """rtol of the next run, so that its estimated error is the target less a margin."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        if largest >= DIVERGED or not pair.conclusive:
            return max(_TIGHTEST, _NEXT * rtol)
        error = largest * (rtol / pair.loose.options.rtol) ** _EXPECTED_POWER
        factor = (_MARGIN * self.target / error) ** (1.0 / SAFE_POWER)
        return float(max(_TIGHTEST, rtol * min(_NEAR, max(_FAR, factor))))

    def _run(self, choice: Choice, rtol: float) -> Run:
        options = replace(
            self.options,
            method=choice.method,
            rtol=rtol,
            h_max=self._longest_step(choice, rtol),
            correction=choice.taken.correction,
        )
        if choice.method in REGISTER:  # the run refuses an unknown name
            function_table(choice.method)  # loaded, or compiled, before time is measured
        path, seconds = processor_time(lambda: self.ready.run(choice.taken, options, self.progress))
        number, chosen = len(self.trials), self.quantities
        if chosen.are_states:
            values = chosen.of_run(path.q, path.v)
            return Run(number, options, path, values, np.zeros(values.shape[1]), seconds)
        result = finish_simulation(
            self.ready, choice.taken, options, clock.perf_counter(), silent, path
        )
        values = chosen.of_result(result)[: len(path.t)]
        if path.outcome is Outcome.OK:  # else another run may go further
            require_numbers(result.description, chosen.names, values)
        return Run(number, options, path, values, chosen.wholes(result), seconds)

    def _longest_step(self, choice: Choice, rtol: float) -> float | None:
        """The longest step: where it bounds the error, it must decrease as tolerances do.

        Otherwise all runs have the same steps, and their difference does not show their error.
        """
        longest = self.options.h_max
        if longest is None or not self.trials:
            return longest
        order = REGISTER[choice.method].order
        return longest * float(min(rtol / self.trials[0].rtol, 1.0) ** (1.0 / order))

    def _record(self, choice: Choice, run: Run, largest: float | None) -> None:
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
                largest,
            )
        )
