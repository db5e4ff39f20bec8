"""Runs of a search: the method and coordinates of each, and the values of its quantities.

Reduced coordinates are two to four times as fast, and contain the derivatives that implicit methods
take; both are companion modules, whose first build takes seconds. They are taken only if they are
built already.
"""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from runtime.accuracy_target.error_norms import require_numbers
from runtime.accuracy_target.run_comparison import Quantities, Run, own_instants
from runtime.core.outcomes import Outcome
from runtime.dynamics.connected_simulation import simulate
from runtime.dynamics.formulations import Coordinates, formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import run_prepared
from runtime.integrate.method import IMPLICIT, LEADING
from runtime.integrate.problem import Correction, Formulation, Options
from runtime.integrate.trajectory import Partitions, Statistics, Trajectory
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result

WIDE = 1e-3  # measured: rtol of the second run over that of the first
_STIFF = 0.03  # measured: the same with an implicit method
_CHANGED = 1.5e-3  # measured: the same with an implicit method after an explicit one
_DECAY = 2.0  # measured: -h Re λ in explicit steps from which on an implicit method costs less,
_COARSE = 1e-8  # measured: and its rtol down to which it does
_SHORT = 25  # measured: such steps below which BDF, which begins at order one, is not worth it
_LARGEST = {"largest_dq"}  # entries of statistics that are no counts


class Choice(NamedTuple):
    """Method and coordinates of a run."""

    method: str
    formulation: Formulation
    coordinates: Coordinates
    reasons: tuple[str, ...] = ()  # for the choice, in clauses


@dataclass
class Choices:
    """How each run is chosen, given those before it."""

    ready: PreparedSimulation
    method: str | None  # this and the formulation are chosen where they are None
    formulation: Formulation | None
    correction: Correction  # that of the coordinates may differ
    contradiction: str = ""  # what a check says of a run in reduced coordinates

    def first(self) -> Choice:
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

    def revised(self, choice: Choice, first: Run) -> Choice:
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
        stiff = ready.mechanism.has_companion("tangents") and not ready.begin.redundant
        method = self.method or ("auto" if formulation == "reduced" or stiff else LEADING)
        coordinates = formulate(ready, formulation, method, self.correction)
        return Choice(method, formulation, coordinates, reasons)


def second_ratio(choice: Choice, first: Trajectory) -> float:
    """rtol of the second run, with this choice, over that of the first.

    A first run whose steps stability limits errs by much more than its tolerance suggests.
    """
    if any(method in IMPLICIT for _, method in first.methods):
        return _STIFF
    return _CHANGED if choice.method in IMPLICIT else WIDE


def make_run(
    ready: PreparedSimulation, choice: Choice, options: Options, quantities: Quantities,
    correction: Correction, progress: Progress,
) -> Run:  # fmt: skip
    """A run with these settings, and the values of the quantities in it.

    Where joints come and go, each part returns onto the constraints by the `correction` asked for,
    or as its own constraints ask for.
    """
    coordinates, about, result = choice.coordinates, ready.mechanism.description, None
    if any(row.reconnects for row in about.watched):
        options = replace(options, correction=correction)
        result, path = _run_with_reconnections(ready, choice.formulation, options, progress)
        seconds = path.statistics.seconds
    else:
        started = clock.process_time()
        path = ready.run(coordinates, options, progress)
        seconds = clock.process_time() - started
    if result is None and quantities.are_states:
        values, wholes = quantities.of_run(path.q, path.v), np.zeros(1)
        ended_by = about.watched[path.stopped_by].name if path.stopped_by >= 0 else ""
        if ended_by and not (len(path.t) and path.t[-1] == path.final_t):
            end = quantities.of_run(path.final_q[None], path.final_v[None])
            values = np.vstack([values, end])
    else:
        found = result or run_prepared(coordinates, options, clock.perf_counter(), silent, path)
        values, wholes = quantities.of_result(found), quantities.wholes(found)
        ended_by = found.ended_by
        if path.outcome is Outcome.OK:  # else another run may go further
            require_numbers(found.description, quantities.names, values)
    instants = {f"t({ended_by})": path.final_t} if ended_by else {}
    return Run(
        choice.formulation, options, path, values, wholes, seconds, ended_by,
        instants if result is None else own_instants(result), result,
    )  # fmt: skip


def _run_with_reconnections(
    ready: PreparedSimulation, formulation: Formulation, options: Options, progress: Progress
) -> tuple[Result, Trajectory]:
    """A run in which joints come and go: its result, and one trajectory of all its parts."""
    paths: list[Trajectory] = []

    def part(
        mechanism: Mechanism, t_end: float, t_eval: Any, max_steps: int | None, **start: Any
    ) -> Result:
        began = clock.perf_counter()
        own = PreparedSimulation(mechanism, t_end, **start)
        coordinates = formulate(own, formulation, options.method, options.correction)
        chosen = replace(
            options, t_eval=own.instants(t_eval), max_steps=max_steps,
            correction=coordinates.correction,
        )  # fmt: skip
        paths.append(own.run(coordinates, chosen, progress))
        return run_prepared(coordinates, chosen, began, silent, paths[-1], repeats=True)

    result = simulate(
        ready.mechanism, ready.t_end, options.t_eval, part=part, max_steps=options.max_steps,
        **ready.given,
    )  # fmt: skip
    return result, _as_one(paths, result, np.asarray(options.t_eval))


def _as_one(paths: Sequence[Trajectory], result: Result, t_eval: Any) -> Trajectory:
    """The last of the parts with the samples of all, in all coordinates, and with all costs."""
    first, last, samples = paths[0], paths[-1], result.samples
    rows = np.isin(samples.t, t_eval)
    chosen = first.partitions.independent
    independent = np.zeros((len(chosen), samples.q.shape[1]), np.bool_)
    independent[:, : chosen.shape[1]] = chosen
    counts = [vars(path.statistics) for path in paths]
    total = {
        name: (max if name in _LARGEST else sum)(one[name] for one in counts) for name in counts[0]
    }
    ended = {"final_q": samples.q[-1], "final_v": samples.v[-1]} if result.ended_by else {}
    return replace(
        last, t=samples.t[rows], q=samples.q[rows], v=samples.v[rows], modes=samples.modes[rows],
        outcome=result.outcome, first_t=first.first_t, statistics=Statistics(**total),
        partitions=Partitions(first.partitions.t, independent),
        methods=tuple(method for path in paths for method in path.methods),
        decay=max(path.decay for path in paths), checkpoints=None, **ended,
    )  # fmt: skip
