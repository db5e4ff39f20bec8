"""An ensemble: many runs of one machine in threads, in a compiled loop where that is possible."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import suppress
from copy import copy
from functools import partial
from threading import Event
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import AnalysisError, InputError, LinkwrightError
from codegen.termination_signals import SignalDeferral
from runtime.assembly.mirrored_joints import are_mirrored
from runtime.core.arrays import Vector
from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import leave_out_unknown
from runtime.dynamics.simulation import simulate_joints
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.dataset import dataset, require_dask
from runtime.results.result import Result
from runtime.results.samples import Samples, empty_samples, require_memory, sample_bytes
from runtime.sweeps.ensemble_arguments import DRIVEN, Columns, Members, read_members
from runtime.sweeps.ensemble_arrays import DONE, LEFT, WAITING, Preparation, Results, prepare
from runtime.sweeps.ensemble_loop import run_members

if TYPE_CHECKING:
    import xarray as xr

NOT_RUN = "not run"
"""The outcome of a member that an interruption left out."""
_BLOCK = 32  # measured: members that a thread takes at a time, at most
_SHARES = 8  # safety: blocks for each thread, so that all end at about the same time
_FIRST_STEPS = 512  # measured: trial steps of the first call of the compiled loop
_MOST_STEPS = 1 << 20  # safety: of any call
# measured: s of a call; its steps double if it takes less, and halve if it takes twice as long.
# After a call a thread checks whether it is to stop
_CALL = 0.025
_LOOK = 0.1  # measured: s between two looks at the threads
_TRIED = 64  # safety: members after which the use of the compiled loop is judged
# measured: part of them that is left to single runs, from which on the loop is not worth it
_MOST_LEFT = 0.8
_MEGABYTE = 1e6  # formula: bytes of a megabyte


def run_ensemble(
    mechanism: Mechanism, t_end: float, times: Vector, columns: Mapping[str, Columns | None],
    analysis: str, threads: int, max_bytes: int, progress: Progress, **options: Any,
) -> "xr.Dataset":  # fmt: skip
    """One row a member; see `Machine.ensemble`. `options` are those of the analysis."""
    members, title = read_members(mechanism, **columns), f"{mechanism.title}: ensemble"
    require_dask()
    if analysis == "simulate" and any(row.reconnects for row in mechanism.description.watched):
        raise InputError(
            f"{title}: joints come and go in this scene, and its runs do not have the same "
            "variables. Use a sweep."
        )
    needed = members.count * len(times) * sample_bytes(mechanism.description)
    what = f"{members.count} runs of {len(times)} instants"
    if needed > max_bytes:
        raise InputError(
            f"{title}: {what} take {needed / _MEGABYTE:.0f} MB, and max_bytes permits "
            f"{max_bytes / _MEGABYTE:.0f} MB. Take fewer instants or runs, or raise max_bytes."
        )
    # The dataset is made while the samples that it is made of are still there.
    require_memory(title, what, 2 * needed, "Take fewer instants or runs.")
    runs = Runs(mechanism, t_end, members, times, options, analysis)
    with suppress(KeyboardInterrupt):  # members that were not run say so
        make_runs(runs, runs.make_pattern(), threads, progress)
    return runs.dataset()


def _single_run(
    mechanism: Mechanism, analysis: str, t_end: float, times: Vector
) -> Callable[..., Result]:
    """The analysis of one member."""
    if analysis == "simulate":
        return partial(simulate_joints, mechanism, t_end, times)
    from runtime.dynamics import prescribed_motion  # which compiles where it is used

    return partial(getattr(prescribed_motion, analysis), mechanism, times)


class Runs:
    """The samples of all members, (r, k, ...), and how one of them is made singly."""

    def __init__(
        self, mechanism: Mechanism, t_end: float, members: Members, times: Vector,
        options: Mapping[str, Any], analysis: str = "simulate",
    ) -> None:  # fmt: skip
        self.mechanism, self.t_end, self.options = mechanism, t_end, options
        self.analysis, self.analyse = analysis, _single_run(mechanism, analysis, t_end, times)
        self.members, self.times, self.shape = members, times, (members.count, len(times))
        self.outcomes, self.messages = [NOT_RUN] * members.count, [""] * members.count
        every = empty_samples(mechanism.description, members.count * len(times))
        samples = Samples._make(x.reshape(*self.shape, *x.shape[1:]) for x in every)
        status, steps, events, logged = np.zeros((4, members.count), np.int64)
        unresolved = np.zeros((members.count, samples.modes.shape[2], 4))
        self.results = Results(samples, status, steps, events, logged, unresolved)
        for name, column in members.parameters.items():
            sign = mechanism.description.parameters[name].sign
            if sign:  # of another sign it is left to a run, which says so
                status[column <= 0.0 if sign == "positive" else column < 0.0] = LEFT
        self.reached = np.zeros(self.shape, np.bool_)  # whether a row has numbers
        self.works: dict[str, Vector] = {}  # (r, k)
        self.first: Result | None = None  # of the runs, which share its labels
        self.made: Preparation | None = None  # what the compiled loop takes

    def make(self, run: int, progress: Progress = silent) -> Result | None:
        """Make the run of a member by a single analysis; None where it is refused.

        Raises KeyboardInterrupt where the run was interrupted; its row is kept. Raises
        AnalysisError where no values of members suit the analysis.
        """
        try:
            result = self.analyse(**self.members.of(run), progress=progress, **self.options)
        except LinkwrightError as error:
            if isinstance(error, AnalysisError) and self._suits_no_values:
                raise
            self.outcomes[run], self.messages[run] = type(error).__name__, str(error)
            return None
        if self.first is None:
            self.first, nothing = result, np.full(self.shape, np.nan)
            self.works = {name: nothing.copy() for name in result.works}
        # the last state of a run that ended early is none of the instants
        at = np.minimum(np.searchsorted(self.times, result.t), len(self.times) - 1)
        kept = self.times[at] == result.t
        for all_rows, rows in zip(self.results.samples, result.samples, strict=True):
            all_rows[run, at[kept]] = rows[kept]
        for name, work in result.works.items():
            self.works[name][run, at[kept]] = work[kept]
        self.reached[run, at[kept]] = True
        self.results.events[run] = len(result.events)
        self.outcomes[run], self.messages[run] = str(result.outcome), result.message
        if result.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return result

    @property
    def _suits_no_values(self) -> bool:
        """Whether the scene lacks what the analysis needs, whatever the values of a member."""
        about = self.mechanism.description
        is_free = len(about.constraints) < len(about.coordinates)
        if self.analysis in DRIVEN and (is_free or about.rigid):
            return True
        return self.analysis != "kinematics" and not about.has_masses

    def make_pattern(self) -> int:
        """Make runs up to the first that ends well, the pattern of the others; what follows it."""
        for run in range(self.members.count):
            result = self.make(run)
            if result is not None and result.outcome is Outcome.OK:
                given = self.mechanism, self.t_end, self.times, self.members, run, result
                self.made = prepare(*given, self.options) if self.analysis == "simulate" else None
                return run + 1
        return self.members.count

    def dataset(self) -> "xr.Dataset":
        """All rows with their outcomes, messages and the values that were given."""
        import xarray as xr

        results, members = self.results, self.members
        if self.made is not None:
            done = results.status == DONE
            self.reached[done] = True
            for run in np.flatnonzero(done).tolist():
                self.outcomes[run] = str(Outcome.OK)
                self.messages[run] = self.made.message(results, run, members.of(run)["start"])
        variables: dict[str, Any] = {
            "outcome": ("run", np.array(self.outcomes, dtype=np.str_)),
            "message": ("run", np.array(self.messages, dtype=np.str_)),
            "event_count": ("run", results.events, {"units": "1"}),
        }
        of_kinds = members.parameters, members.starts, members.guesses
        for kind, columns in zip(("parameter", "start", "guess"), of_kinds, strict=True):
            variables |= {f"{kind}_{name}": ("run", column) for name, column in columns.items()}
        coords: dict[str, Any] = {
            "run": np.arange(members.count), "time": ("time", self.times, {"units": "s"})
        }  # fmt: skip
        about = self.mechanism.description
        attrs = {"model": about.model, "scene": about.scene}
        if self.first is not None:
            attrs["analysis"] = self.first.analysis
            whole, size = copy(self.first), self.reached.size
            whole.samples = Samples._make(x.reshape(size, *x.shape[2:]) for x in results.samples)
            whole.works = {name: work.ravel() for name, work in self.works.items()}
            leave_out_unknown(whole.description, whole.samples)
            data = dataset(whole)
            coords = {str(name): one.variable for name, one in data.coords.items()} | coords
            for name, variable in data.data_vars.items():
                values = variable.values.astype(np.float64, copy=False)
                values[~self.reached.ravel()] = np.nan
                values = values.reshape(*self.shape, *values.shape[1:])
                variables[str(name)] = ("run", *variable.dims), values, variable.attrs
        return xr.Dataset(variables, coords=coords, attrs=attrs)


def make_runs(runs: Runs, first: int, threads: int, progress: Progress) -> None:
    """Make the runs from the member `first` on, in so many threads at most.

    One thread is the caller's. Raises KeyboardInterrupt where runs are interrupted, after all
    threads have ended, and what a thread raises.
    """
    total, stopped = runs.members.count, Event()
    size = max(1, min(_BLOCK, (total - first) // (_SHARES * threads)))
    blocks = iter(range(first, total, size))
    threads = max(1, min(threads, -(-(total - first) // size)))
    workers = [Worker(runs, size, stopped) for _ in range(threads)]
    # Raised amid the work of a pool, an interrupt would leave locks behind that nobody opens.
    with SignalDeferral(computing=True) as signals:

        def tell() -> None:
            progress((first + sum(worker.ended for worker in workers)) / total)
            if signals.arrived:
                signals.answered = True
                stopped.set()

        if threads == 1:
            workers[0].run(blocks, tell)
        else:
            with ThreadPoolExecutor(threads, "ensemble") as pool:
                running = {pool.submit(worker.run, blocks) for worker in workers}
                try:
                    while running:
                        done, running = wait(running, _LOOK, FIRST_COMPLETED)
                        tell()
                        for future in done:
                            future.result()
                finally:
                    stopped.set()
    if signals.answered:
        raise KeyboardInterrupt


class Worker:
    """Makes runs in one thread, by the compiled loop as far as that goes."""

    def __init__(self, runs: Runs, size: int, stopped: Event) -> None:
        self.runs, self.size, self.stopped, self.made = runs, size, stopped, runs.made
        self.steps, self.tried, self.left = _FIRST_STEPS, 0, 0  # left: to single runs
        self.ended = 0  # members with a row
        if self.made is not None:
            self.own, self.pointed_to = self.made.own()

    def run(self, blocks: Iterator[int], tell: Callable[[], None] = lambda: None) -> None:
        """Make the runs of blocks that nobody else has taken."""
        for first in blocks:
            last = min(first + self.size, self.runs.members.count)
            self._run_compiled(first, last, tell)
            for run in range(first, last):
                if self.stopped.is_set():
                    return
                if self.runs.results.status[run] in (WAITING, LEFT):
                    self.runs.make(run, self._look)
                    self.ended += 1
                    tell()

    def _run_compiled(self, first: int, last: int, tell: Callable[[], None]) -> None:
        """Make as many runs of a block as the compiled loop can; others are LEFT or WAITING."""
        made, at, results = self.made, first, self.runs.results
        if made is None:
            return
        while at < last and not self.stopped.is_set():
            began, before = perf_counter(), at
            at = run_members(made.common, self.own, results, at, last, self.steps)
            took = perf_counter() - began
            if took < _CALL:
                self.steps = min(2 * self.steps, _MOST_STEPS)
            elif took > 2.0 * _CALL:
                self.steps = max(1, self.steps // 2)
            self.ended += int((results.status[before:at] != LEFT).sum())
            tell()
        done = first + np.flatnonzero(results.status[first:last] == DONE)
        again = done[are_mirrored(self.runs.mechanism.description, results.samples.q[done, 0])]
        results.status[again], results.events[again] = LEFT, 0  # to runs, which refuse or tell
        self.ended -= len(again)
        self.tried += last - first
        self.left += int((results.status[first:last] == LEFT).sum())
        if self.tried >= _TRIED and self.left > _MOST_LEFT * self.tried:
            self.made = None  # a scene of which single runs make most members anyway

    def _look(self, fraction: float) -> None:
        """Interrupt a single run where all are to stop."""
        if self.stopped.is_set():
            raise KeyboardInterrupt
