"""Search for a tolerance with which the global error meets a target: two runs or a few more.

The error of a run is about C times its relative tolerance, with C from 1 to 3000 on most machines
and known for none beforehand; it scatters about that line by a power of ten. A run is therefore
compared with another of much tighter tolerance. Their difference is the error of the first run, or
of the second if that is larger by chance. From the first to the second, errors fall by the ratio of
the tolerances as a rule; `run_comparison` says what is counted on. If the estimate is below the
target, the second run is the result; otherwise the difference shows how much tighter the next run
must be.

A method of order eight costs a third more for a tenth of the tolerance, and less where events cut
its steps. A first run with a thousand times the tolerance of the second costs half as much, and
scatter matters little over so wide a gap; from runs that are nearer, and may err alike, less is
concluded. With an implicit method, where it costs more, the gap is narrower.

Reduced coordinates are two to four times as fast, and contain the derivatives that implicit methods
take; both are companion modules, whose first build takes seconds. They are taken only if they are
built already.
"""

import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.termination_signals import SignalDeferral
from runtime.accuracy_target.error_norms import require_numbers
from runtime.accuracy_target.run_comparison import (
    DIVERGED,
    ROUNDING,
    Pair,
    compare,
    sufficient_ratio,
    with_accuracy,
)
from runtime.accuracy_target.runs import (
    Quantities,
    Run,
    own_instants,
    quantities_of,
    run_with_reconnections,
)
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import Coordinates, formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import note_repetition, run_prepared
from runtime.integrate.method import IMPLICIT, LEADING, REGISTER
from runtime.integrate.problem import Correction, Formulation, Options
from runtime.integrate.wiring import function_table
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result

FINEST = 1e-12  # accuracy: tightest target; rounding shows below it
COARSEST = 0.1  # accuracy: loosest target
WIDE = 1e-3  # measured: rtol of the second run over that of the first
_STIFF = 0.03  # measured: the same with an implicit method
_CHANGED = 1.5e-3  # measured: the same if an implicit method follows an explicit one
_DECAY = 2.0  # measured: -h Re λ in explicit steps from which on an implicit method costs less,
_COARSE = 1e-8  # measured: and its rtol down to which it does
_SHORT = 25  # measured: explicit steps; if they are fewer, BDF, which begins at order 1, is slower
_FIRST, _SLOPE = 5e-4, 0.9  # measured: rtol of the first run for a target of 1e-3; its power law
_LOOSEST, _TIGHTEST = 1e-3, 1e-14  # safety: rtol of any run
_LAST = 3e-14  # measured: the same where errors are small; with a smaller rtol rounding grows
_NEAR, _FAR = 0.1, 1e-6  # safety: rtol of later runs over that of the last
_EXPECTED_POWER = 0.85  # measured: power of rtol with which errors are expected to fall
_MARGIN = 0.5  # safety: share of the target for which a run is planned, and by which it is judged
_NEXT = 0.03  # measured: rtol of the next run over that of the last, if the last shows nothing
_MOST_RUNS = 8  # safety
_PACED = 1.2  # safety: ratio of numbers of steps below which samples limit them, not tolerances
_SAMPLED = 1e-3  # safety: of the whole time; longest step if two runs agree to the last digit


def simulate_to(
    mechanism: Mechanism, t_end: float, t_eval: npt.ArrayLike | int | str | None, *,
    accuracy: float | None, quantities: Sequence[str] | None, rtol: float | None, atol: Any,
    method: str | None, formulation: Formulation | None, correction: Correction,
    time_scale: float | None, first_step: float | None, max_step: float | None,
    max_steps: int | None, max_bytes: int, progress: Progress, **begin: Any,
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
    problems = [*_conflicts(mechanism, accuracy, quantities or (), rtol=rtol, atol=atol)]
    if accuracy is None or problems:
        raise InputError(problems)
    ready = PreparedSimulation(mechanism, t_end, **begin)
    if isinstance(t_eval, str):
        raise InputError(
            f'{mechanism.title}: t_eval = "steps" and accuracy are both given; an accuracy '
            "compares runs at the same instants, which are no steps. Give instants, or how many."
        )
    options = Options(
        t_eval=ready.instants(t_eval), time_scale=time_scale, first_step=first_step,
        h_max=max_step, max_steps=max_steps, max_bytes=max_bytes,
    )  # fmt: skip
    chosen = quantities_of(mechanism.description, quantities, ready.sizes)
    search = _Search(
        ready, method, formulation, correction, accuracy, chosen, options, progress
    )  # fmt: skip
    return search.result(began)


def _conflicts(
    mechanism: Mechanism, accuracy: float | None, names: Sequence[str], **tolerances: Any
) -> Iterator[str]:
    """Why there is no such target: its value, tolerances beside it, names that are no series."""
    description = mechanism.description
    if accuracy is None:
        yield f"{mechanism.title}: quantities without accuracy: give the error too, accuracy=1e-6."
    elif not FINEST <= accuracy <= COARSEST:
        yield (
            f"{mechanism.title}: accuracy = {accuracy:g} must lie between {FINEST:g}, below which "
            f"rounding shows, and {COARSEST:g}."
        )
    for name, value in tolerances.items():
        if accuracy is not None and value is not None:
            yield (
                f"{mechanism.title}: accuracy = {accuracy:g} and {name} = {value:g} are both "
                "given; an accuracy chooses the tolerances. Leave one of them out."
            )
    # Where joints come and go, a scene that follows has series of its own: the result says.
    for name in names if not any(row.reconnects for row in description.watched) else ():
        try:
            description.series.find(name)
        except InputError as error:
            yield from error.problems


class Choice(NamedTuple):
    """Method and coordinates of a run."""

    method: str
    formulation: Formulation
    coordinates: Coordinates
    reasons: tuple[str, ...] = ()  # for the choice, in clauses


class _InterruptedError(Exception):
    """The user wants no more runs."""


@dataclass
class _Search:
    """The runs, each planned from those before."""

    ready: PreparedSimulation
    method: str | None  # this and the formulation are chosen where they are None
    formulation: Formulation | None
    correction: Correction  # that of the coordinates may differ
    target: float
    quantities: Quantities
    options: Options
    progress: Progress
    contradiction: str = ""  # what a check says of a run in reduced coordinates
    signals: SignalDeferral = field(default_factory=lambda: SignalDeferral(computing=True))
    runs: list[Run] = field(default_factory=list)
    pair: Pair | None = None  # the last runs that were compared

    def result(self, began: float) -> Result:
        """Run until the target is met, cannot be met, or the user interrupts."""
        with self.signals:
            try:
                return self._search(began)
            except _InterruptedError:
                self.signals.answered = True
                return self._interrupted(began)

    def _search(self, began: float) -> Result:
        choice = self._first_choice()
        rtol = min(max(_FIRST * (self.target / 1e-3) ** _SLOPE, _LAST / WIDE), _LOOSEST)
        while True:  # until there is a run that can be compared with others
            first = self._run(choice, rtol)
            previous, choice = choice, self._revised(choice, first)
            if choice.formulation == previous.formulation:
                break
        second = max(_LAST, rtol * _second_ratio(choice, first))
        pair = self._compare(choice, second, first)
        longest = self._sampled if self._is_unseen(pair) else np.inf
        if self._is_paced(pair):
            path = pair.tight.path  # its mean step, which `_run` shortens by the tolerance
            longest = min(longest, (path.final_t - self.ready.begin.t) / path.statistics.steps)
        if longest < np.inf:
            longest = min(self.options.h_max or np.inf, longest)
            self.options = replace(self.options, h_max=longest)
            pair = self._compare(choice, pair.tight.options.rtol, pair.tight)
        while not self._is_final(pair):
            pair = self._compare(choice, self._tighter(pair), pair.tight)
        run, _ = pair.by_merit
        result = run.result or run_prepared(
            choice.coordinates, run.options, began, silent, run.path
        )
        if result.outcome is Outcome.CONTRADICTED and choice.formulation == "reduced":
            self.contradiction = result.contradiction
            return self._search(began)
        result = with_accuracy(
            result, self.target, self.quantities, self.runs, pair, choice.reasons
        )
        if self.contradiction:
            note_repetition(result, self.contradiction)
        return result

    def _interrupted(self, began: float) -> Result:
        """The run whose error is known best; before two were compared, that which went farthest."""
        pair = self.pair
        run = pair.by_merit[0] if pair else max(self.runs, key=lambda run: len(run.path.t))
        taken = formulate(self.ready, run.formulation, run.options.method, self.correction)
        result = run.result or run_prepared(
            taken, run.options, began, silent, run.path, works=False
        )
        error = "its error is not known, since it was compared with no other run"
        if pair is not None:
            error = f"its error is about {pair.error:.1e}"
        advice, result.outcome = Outcome.INTERRUPTED.advice, Outcome.INTERRUPTED
        result.message = (
            f"Interrupted in run {len(self.runs)} of the search for an accuracy of "
            f"{self.target:.1e}. Of these runs the best is kept, that at rtol = "
            f"{run.options.rtol:.1e}, up to t = {run.path.final_t:.6g} s; {error}. {advice}"
        )
        return result

    def _first_choice(self) -> Choice:
        """Method and coordinates of the first run."""
        if self.contradiction:
            found = self.contradiction.rstrip(".")
            return self._choice(
                "cartesian", f"a check contradicts the run in reduced coordinates ({found})"
            )
        if self.formulation is not None:
            return self._choice(self.formulation)
        reason = "reduced coordinates are not built (linkwright build --reduced)"
        if self.ready.mechanism.has_companion("reduced"):
            try:
                return self._choice("reduced")
            except InputError as error:
                reason = f"reduced coordinates are refused ({error.problems[0]})"
        return self._choice("cartesian", reason)

    def _revised(self, choice: Choice, first: Run) -> Choice:
        """The choice for the next run, given the first."""
        run = first.path
        if choice.formulation == "reduced" and run.outcome is not Outcome.OK:
            if self.formulation is not None:
                return choice
            end = f"t = {run.final_t:.6g} s ({run.outcome.name})"
            return self._choice("cartesian", f"in reduced coordinates the run ends at {end}")
        if choice.method == "auto" and self.method is None and len(run.methods) == 1:
            if run.decay < _DECAY or first.options.rtol * _CHANGED < _COARSE:
                return choice._replace(method=LEADING)
            # In too few steps for the run to change by itself.
            return choice._replace(method="radau5" if run.statistics.steps < _SHORT else "bdf")
        return choice

    def _choice(self, formulation: Formulation, *reasons: str) -> Choice:
        """With the method that detects stiffness, where its derivatives exist; else explicit."""
        ready = self.ready
        stiff = ready.mechanism.has_companion("tangents")
        method = self.method or ("auto" if formulation == "reduced" or stiff else LEADING)
        coordinates = formulate(ready, formulation, method, self.correction)
        return Choice(method, formulation, coordinates, reasons)

    def _compare(self, choice: Choice, rtol: float, loose: Run) -> Pair:
        """Another run, of a tighter tolerance, compared with an earlier one."""
        self.pair = compare(loose, self._run(choice, rtol), self.quantities, self.target)
        return self.pair

    @property
    def _sampled(self) -> float:
        """Longest step over which a short pulse is not taken to go unseen, s."""
        return _SAMPLED * (self.ready.t_end - self.ready.begin.t)

    def _is_unseen(self, pair: Pair) -> bool:
        """Whether runs that agree may both have missed a pulse: without error, or in few steps."""
        steps = pair.loose.path.statistics.steps
        return pair.agrees and (pair.difference.largest == 0.0 or steps * _SAMPLED < 1.0)

    def _is_paced(self, pair: Pair) -> bool:
        """Whether samples cut the steps of both runs, which then take the same and err alike."""
        steps, loose = (run.path.statistics.steps for run in (pair.tight, pair.loose))
        return bool(self.ready.mechanism.description.sampled) and steps < _PACED * loose

    def _is_final(self, pair: Pair) -> bool:
        """Whether no further run is needed, or helps."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        margin = _MARGIN if rtol > ROUNDING else 1.0  # a tighter run errs as much
        small = largest < DIVERGED and pair.error <= margin * self.target
        if pair.conclusive and small:
            return True
        return pair.tight_fails or rtol <= _tightest(pair) or len(self.runs) >= _MOST_RUNS

    def _tighter(self, pair: Pair) -> float:
        """rtol of the next run, so that its estimated error is the target less a margin."""
        largest, rtol = pair.difference.largest, pair.tight.options.rtol
        if largest >= DIVERGED or not pair.conclusive:
            return max(_TIGHTEST, _NEXT * rtol)
        error = largest * (rtol / pair.loose.options.rtol) ** _EXPECTED_POWER
        factor = sufficient_ratio(_MARGIN * self.target / error)
        following = rtol * min(_NEAR, max(_FAR, factor))
        return max(following, ROUNDING if rtol > ROUNDING else _tightest(pair))

    def _run(self, choice: Choice, rtol: float) -> Run:
        """A run, whose longest step decreases with the tolerance: else all would step alike."""
        longest = self.options.h_max
        if choice.method in REGISTER:  # the run refuses an unknown name
            function_table(choice.method)  # loaded, or compiled, before time is measured
            if longest is not None and self.runs:
                ratio = min(rtol / self.runs[0].options.rtol, 1.0)
                longest *= float(ratio ** (1.0 / REGISTER[choice.method].order))
        options = replace(
            self.options, method=choice.method, rtol=rtol, h_max=longest,
            correction=choice.coordinates.correction,
        )  # fmt: skip
        made = self._made(choice, options)
        self.runs.append(made)
        if self.signals.arrived or made.path.outcome is Outcome.INTERRUPTED:
            raise _InterruptedError
        return made

    def _made(self, choice: Choice, options: Options) -> Run:
        """A run with these settings, and the values of the quantities in it."""
        ready, quantities, result, wholes = self.ready, self.quantities, None, np.zeros(1)
        watched = ready.mechanism.description.watched
        if any(row.reconnects for row in watched):
            options = replace(options, correction=self.correction)
            result, path = run_with_reconnections(ready, choice.formulation, options, self.progress)
            ended_by, instants = result.ended_by, own_instants(result)
        else:
            path = ready.run(choice.coordinates, options, self.progress)
            ended_by = watched[path.stopped_by].name if path.stopped_by >= 0 else ""
            instants = {f"t({ended_by})": path.final_t} if ended_by else {}
        if result is None and quantities.are_states:
            states = np.hstack([path.q, path.v])
            if ended_by and not (len(path.t) and path.t[-1] == path.final_t):
                states = np.vstack([states, np.hstack([path.final_q, path.final_v])])
            values = states[:, quantities.state_columns]
        else:
            found = result or run_prepared(
                choice.coordinates, options, clock.perf_counter(), silent, path
            )
            values, wholes = quantities.of_result(found), quantities.wholes(found)
            if path.outcome is Outcome.OK:  # else another run may go further
                require_numbers(found.description, quantities.names, values)
        return Run(choice.formulation, options, path, values, wholes, ended_by, instants, result)


def _tightest(pair: Pair) -> float:
    """Tightest rtol after these two runs."""
    near = pair.conclusive and pair.difference.largest < DIVERGED
    return _LAST if near else _TIGHTEST


def _second_ratio(choice: Choice, first: Run) -> float:
    """rtol of the second run, with this choice, over that of the first."""
    if any(method in IMPLICIT for _, method in first.path.methods):  # stability limited its steps
        return _STIFF
    return _CHANGED if choice.method in IMPLICIT else WIDE
