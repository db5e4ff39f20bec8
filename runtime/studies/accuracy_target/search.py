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

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import finish_simulation
from runtime.integrate.method import IMPLICIT, REGISTER
from runtime.integrate.problem import Correction, Formulation, Options
from runtime.integrate.wiring import function_table
from runtime.mechanism.loaded_mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result
from runtime.studies.accuracy_target import run_difference as runs
from runtime.studies.accuracy_target.method_choice import Choice, choose, revise
from runtime.studies.accuracy_target.result_within_accuracy import with_accuracy
from runtime.studies.accuracy_target.run_difference import Pair, Quantities, Run
from runtime.studies.series_by_name import require_numbers
from runtime.studies.timing import processor_time
from runtime.validation.arguments import instants

POINTS = 501  # output instants if the user gives none

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
    mechanism: Mechanism, t_end: float, t_eval: npt.ArrayLike | None, *, accuracy: float,
    quantities: Sequence[str] | None, t_start: float, method: str | None,
    parameters: Values | None, guess: Values | None, start: Assembly | None,
    correction: Correction, formulation: Formulation | None, time_scale: float | None,
    first_step: float | None, max_step: float | None, max_steps: int, progress: Progress,
) -> Result:  # fmt: skip
    """Integrate with a global error below `accuracy` at the output instants.

    The error of a quantity y is |y - r| / (s + |r|), r the exact one, s its typical size: that of
    `runtime.mechanism.dense_equations` for coordinates, the same per second for velocities, and
    the largest value in the run for all others. `Result.accuracy` has the accuracy reached and the
    evidence for it. Where the target cannot be met over all the time, the result ends at the last
    instant up to which it is, with the outcome `INACCURATE`.

    Method and formulation are chosen unless given: reduced coordinates where they are built and
    stay valid, and the method that suits the first run. See `Machine.simulate`.
    """
    began = clock.perf_counter()
    ready = PreparedSimulation(
        mechanism, t_end, t_start=t_start, parameters=parameters, guess=guess, start=start
    )
    first, last = ready.begin.t, float(t_end)
    times = np.linspace(first, last, POINTS if last > first else 1)
    options = Options(
        t_eval=times if t_eval is None else instants(t_eval), time_scale=time_scale,
        first_step=first_step, h_max=max_step, max_steps=max_steps,
    )  # fmt: skip
    chosen = runs.quantities_of(mechanism.description, quantities, ready.sizes)
    search = _Search(ready, accuracy, chosen, options, progress)
    return search.result(choose(ready, method, formulation, correction), began)


class _Search:
    """The runs, each planned from those before."""

    def __init__(
        self, ready: PreparedSimulation, target: float, quantities: Quantities, options: Options,
        progress: Progress,
    ) -> None:  # fmt: skip
        self.ready, self.target, self.options = ready, target, options
        self.quantities, self.progress = quantities, progress
        self.runs: list[Run] = []

    def result(self, choice: Choice, began: float) -> Result:
        """Run until the target is met, or cannot be met."""
        rtol = min(max(_FIRST * (self.target / 1e-3) ** _SLOPE, _TIGHTEST / _WIDE), _LOOSEST)
        while True:  # until there is a run that can be compared with others
            first = self._run(choice, rtol)
            previous, choice = choice, revise(choice, self.ready, first.path)
            if choice.formulation == previous.formulation:
                break
        pair = self._compare(choice, self._second(first), first)
        while not self._is_final(pair):
            pair = self._compare(choice, self._tighter(pair), pair.tight)
        run, _ = pair.by_merit
        result = finish_simulation(
            self.ready, choice.coordinates, run.options, began, silent, run.path
        )
        return with_accuracy(result, self.target, self.quantities, self.runs, pair, choice.reasons)

    def _second(self, first: Run) -> float:
        """rtol of the second run."""
        rtol, counts = first.options.rtol, first.path.statistics
        if counts.rhs > _LONG * (counts.events + 1):
            free = first.path.outcome is Outcome.OK and self.options.h_max is None
            looser = rtol / _NARROW
            return looser if free and looser <= _LOOSEST else _NARROW * rtol
        stiff = any(method in IMPLICIT for _, method in first.path.methods)
        return rtol * (_STIFF if stiff else _WIDE)

    def _compare(self, choice: Choice, rtol: float, before: Run) -> Pair:
        """Another run, compared with an earlier one."""
        run = self._run(choice, rtol)
        loose, tight = (run, before) if rtol > before.options.rtol else (before, run)
        t = min(loose.t, tight.t, key=len)
        found = runs.difference(t, loose.values, tight.values, self.quantities, tight.wholes)
        run.difference = found.largest
        resolved = runs.is_resolved(found, tight.values[: len(t)], self.target)
        return Pair(loose, tight, found, resolved)

    def _is_final(self, pair: Pair) -> bool:
        """Whether no further run is needed, or helps."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        if pair.conclusive and largest < runs.DIVERGED and pair.share * largest <= self.target:
            return True
        return pair.tight_fails or rtol <= _TIGHTEST or len(self.runs) >= _MOST_RUNS

    def _tighter(self, pair: Pair) -> float:
        """rtol of the next run, so that its estimated error is the target less a margin."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        if largest >= runs.DIVERGED or not pair.conclusive:
            return max(_TIGHTEST, _NEXT * rtol)
        error = largest * (rtol / pair.loose.options.rtol) ** _EXPECTED_POWER
        factor = (_MARGIN * self.target / error) ** (1.0 / runs.SAFE_POWER)
        return float(max(_TIGHTEST, rtol * min(_NEAR, max(_FAR, factor))))

    def _run(self, choice: Choice, rtol: float) -> Run:
        options = replace(
            self.options, method=choice.method, rtol=rtol, h_max=self._longest_step(choice, rtol),
            correction=choice.coordinates.correction,
        )  # fmt: skip
        if choice.method in REGISTER:  # the run refuses an unknown name
            function_table(choice.method)  # loaded, or compiled, before time is measured
        ready, chosen, names = self.ready, choice.coordinates, self.quantities.names
        path, seconds = processor_time(lambda: ready.run(chosen, options, self.progress))
        if self.quantities.are_states:
            values = self.quantities.of_run(path.q, path.v)
            wholes = np.zeros(values.shape[1])
        else:
            began = clock.perf_counter()
            result = finish_simulation(ready, chosen, options, began, silent, path)
            values = self.quantities.of_result(result)[: len(path.t)]
            if path.outcome is Outcome.OK:  # else another run may go further
                require_numbers(result.description, names, values)
            wholes = self.quantities.wholes(result)
        self.runs.append(Run(choice.formulation, options, path, values, wholes, seconds))
        return self.runs[-1]

    def _longest_step(self, choice: Choice, rtol: float) -> float | None:
        """The longest step: where it bounds the error, it must decrease as tolerances do.

        Otherwise all runs have the same steps, and their difference does not show their error.
        """
        longest = self.options.h_max
        if longest is None or not self.runs:
            return longest
        order = REGISTER[choice.method].order
        return longest * float(min(rtol / self.runs[0].options.rtol, 1.0) ** (1.0 / order))
