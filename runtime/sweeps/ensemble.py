"""An ensemble: many runs of one machine in threads, by a compiled loop as far as that goes."""

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from copy import copy
from threading import Event
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, LinkwrightError
from codegen.termination_signals import SignalDeferral
from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import leave_out_unknown
from runtime.dynamics.simulation import simulate_joints
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.dataset import Labels, labels_of
from runtime.results.result import Result
from runtime.results.samples import Samples, require_memory, sample_bytes
from runtime.sweeps.ensemble_arrays import (
    DONE,
    LEFT,
    WAITING,
    Columns,
    FloatArray,
    Members,
    Preparation,
    Results,
    forbidden_members,
    prepare,
    read_members,
)
from runtime.sweeps.ensemble_loop import run_members

if TYPE_CHECKING:
    import xarray as xr

NOT_RUN = "not run"
"""The outcome of a member that an interruption left out."""
_BLOCK = 32  # measured: members that a thread takes at a time, at most
_SHARES = 8  # safety: blocks for each thread, so that all end at about the same time
_FIRST_STEPS = 512  # measured: trial steps of the first call of the compiled loop
_MOST_STEPS = 1 << 20  # safety: of any call
_CALL_SECONDS = 0.05  # measured: s between two returns to Python, for progress and interrupts
_LOOK = 0.1  # measured: s between two looks at the threads
_TRIED = 64  # safety: members of which the compiled loop must finish a part, to be gone on with
_MOST_LEFT = (
    0.8  # measured: part of them that is left to single runs, from which on it does not pay
)
_MEGABYTE = 1e6  # formula: bytes of a megabyte


def run_ensemble(
    mechanism: Mechanism, t_end: float, times: FloatArray, parameters: Columns | None,
    starts: Columns | None, threads: int, max_bytes: int, progress: Progress, **options: Any,
) -> "xr.Dataset":  # fmt: skip
    """One row a member; see `Machine.ensemble`. `options` are those of `simulate`."""
    members, title = read_members(mechanism, parameters, starts), f"{mechanism.title}: ensemble"
    if any(row.reconnects for row in mechanism.description.watched):
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
    require_memory(title, what, needed, "Take fewer instants or runs.")
    runs = Runs(mechanism, t_end, members, times, options)
    try:
        first = runs.make_pattern()
        make_runs(runs, first, threads, progress)
    except KeyboardInterrupt:
        pass  # members that were not run say so
    return runs.dataset()


class Runs:
    """The runs so far, over run, time and their own dimensions, and how one is made singly."""

    def __init__(
        self, mechanism: Mechanism, t_end: float, members: Members, times: FloatArray,
        options: Mapping[str, Any],
    ) -> None:  # fmt: skip
        self.mechanism, self.t_end, self.options = mechanism, t_end, options
        self.members, self.times, count = members, times, members.count
        self.outcomes, self.messages = [NOT_RUN] * count, [""] * count
        # What the compiled loop says of its members: see `ensemble_arrays.Results`.
        self.status, self.steps, self.events, self.logged = np.zeros((4, count), np.int64)
        self.status[forbidden_members(mechanism, members)] = LEFT  # to a run, which says why
        self.unresolved = np.zeros((0, 0, 0))
        self.placed = np.zeros(count, np.bool_)  # whether a member's row is that of the loop
        self.made: Preparation | None = None  # what the compiled loop takes
        self.first: Result | None = None  # of the runs, which share its labels
        self.labels = Labels([], {})
        self.arrays: dict[str, FloatArray] = {}  # of each variable, (runs, k, ...)

    def make(self, run: int, progress: Progress = silent) -> Result | None:
        """Make the run of a member by `simulate`; None where it is refused.

        Raises KeyboardInterrupt where the run was interrupted; its row is kept.
        """
        parameters, start = (values or None for values in self.members.of(run))
        try:
            result = simulate_joints(
                self.mechanism, self.t_end, self.times, parameters=parameters, start=start,
                progress=progress, **self.options,
            )  # fmt: skip
        except LinkwrightError as error:
            self.outcomes[run], self.messages[run] = type(error).__name__, str(error)
            return None
        self.take(run, result)
        if result.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return result

    def make_pattern(self) -> int:
        """Make runs up to the first that ends well, the pattern of the others; what follows it."""
        for run in range(self.members.count):
            result = self.make(run)
            if result is not None and result.outcome is Outcome.OK:
                given = self.mechanism, self.t_end, self.times, self.members, run, result
                self.made = prepare(*given, self.options)
                return run + 1
        return self.members.count

    def take(self, run: int, result: Result) -> None:
        """Copy a run's variables up to the last of the instants that it reached."""
        if self.first is None:  # make room for the variables of all runs, which have its form
            count, self.first, self.labels = self.members.count, result, labels_of(result)
            for row in self.labels.variables:
                rest = row.values(result).shape[1:]
                self.arrays[row.name] = np.empty((count, len(self.times), *rest))
            self.unresolved = np.zeros((count, result.samples.modes.shape[1], 4))
        # the last state of a run that ended early is none of the instants
        at = np.minimum(np.searchsorted(self.times, result.t), len(self.times) - 1)
        kept = self.times[at] == result.t
        for row in self.labels.variables:
            array = self.arrays[row.name]
            array[run] = np.nan
            array[run, at[kept]] = row.values(result)[kept]
        self.events[run] = len(result.events)
        self.outcomes[run], self.messages[run] = str(result.outcome), result.message

    def place(self, first: int, done: npt.NDArray[np.bool_], samples: Samples) -> None:
        """Copy the variables of the members from `first` on that are `done`, (b,).

        `samples` are those of a block, (b, k, ...), of which the first rows are these members.
        """
        whole, count, last = copy(cast(Result, self.first)), len(done), first + len(done)
        columns = (
            array[:count].reshape(count * len(self.times), *array.shape[2:]) for array in samples
        )
        whole.samples = Samples(*cast(Any, columns))
        leave_out_unknown(whole.description, whole.samples)
        chosen: Any = slice(None) if done.all() else done
        for row in self.labels.variables:
            values = row.values(whole)
            values = values.reshape(count, len(self.times), *values.shape[1:])
            self.arrays[row.name][first:last][chosen] = values[chosen]
        self.placed[first:last] = done

    def dataset(self) -> "xr.Dataset":
        """All rows with their outcomes, messages and the values that were given.

        Members without a run are no numbers, and have no events.
        """
        import xarray as xr

        made = self.made
        for run in np.flatnonzero(self.placed).tolist() if made else ():
            self.outcomes[run] = str(Outcome.OK)
            self.messages[run] = cast(Preparation, made).message(
                int(self.steps[run]), self.members.of(run)[1], self.unresolved[run],
                int(self.logged[run]),
            )  # fmt: skip
        without = np.array([said not in Outcome.__members__ for said in self.outcomes])
        self.events[without] = 0
        for array in self.arrays.values():
            array[without] = np.nan
        variables: dict[str, Any] = {
            "outcome": ("run", np.array(self.outcomes, dtype=np.str_)),
            "message": ("run", np.array(self.messages, dtype=np.str_)),
            "event_count": ("run", self.events, {"units": "1"}),
        }
        given = ("parameter", self.members.parameters), ("start", self.members.starts)
        for kind, columns in given:
            variables |= {f"{kind}_{name}": ("run", column) for name, column in columns.items()}
        for row in self.labels.variables:
            variables[row.name] = ("run", *row.dims), self.arrays[row.name], row.about
        coords: dict[str, Any] = {
            "run": np.arange(self.members.count), "time": ("time", self.times, {"units": "s"})
        }  # fmt: skip
        return xr.Dataset(variables, coords=coords | self.labels.coords)


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
            _run_all(workers, blocks, tell, stopped)
    if signals.answered:
        raise KeyboardInterrupt


def _run_all(
    workers: list["Worker"], blocks: Iterator[int], tell: Callable[[], None], stopped: Event
) -> None:
    """Let each worker run in a thread; what one raises ends all."""
    with ThreadPoolExecutor(len(workers), "ensemble") as pool:
        running = {pool.submit(worker.run, blocks) for worker in workers}
        try:
            while running:
                done, running = wait(running, _LOOK, FIRST_COMPLETED)
                tell()
                for future in done:
                    future.result()
        finally:
            stopped.set()


class Worker:
    """Makes runs in one thread, by the compiled loop as far as that goes."""

    def __init__(self, runs: Runs, size: int, stopped: Event) -> None:
        self.runs, self.size, self.stopped = runs, size, stopped
        self.made, self.steps, self.tried, self.left = runs.made, _FIRST_STEPS, 0, 0
        self.ended = 0  # members with a row
        if self.made is not None:
            self.own, self.pointed_to = self.made.own()
            cubes = (np.zeros((size, *field.shape)) for field in self.own.samples)
            counts = runs.status, runs.steps, runs.events, runs.logged, runs.unresolved
            self.results = Results(Samples(*cubes), *counts)

    def run(self, blocks: Iterator[int], tell: Callable[[], None] = lambda: None) -> None:
        """Make the runs of blocks that nobody else has taken."""
        for first in blocks:
            last = min(first + self.size, self.runs.members.count)
            status = self.runs.status[first:last]
            try:
                self._run_compiled(first, last, tell)
            finally:
                if (status == DONE).any():
                    self.runs.place(first, status == DONE, self.results.samples)
            for run in range(first, last):
                if self.stopped.is_set():
                    return
                if self.runs.status[run] in (WAITING, LEFT):
                    self.runs.make(run, self._look)
                    self.ended += 1
                    tell()

    def _run_compiled(self, first: int, last: int, tell: Callable[[], None]) -> None:
        """Make as many runs of a block as the compiled loop can; others are LEFT or WAITING."""
        made, at, status = self.made, first, self.runs.status
        if made is None:
            return
        while at < last and not self.stopped.is_set():
            began, before = time.perf_counter(), at
            at = run_members(made.common, self.own, self.results, first, at, last, self.steps)
            took = time.perf_counter() - began
            if took < 0.5 * _CALL_SECONDS:
                self.steps = min(2 * self.steps, _MOST_STEPS)
            elif took > _CALL_SECONDS:
                self.steps = max(1, self.steps // 2)
            self.ended += int((status[before:at] != LEFT).sum())
            tell()
        self.tried += last - first
        self.left += int((status[first:last] == LEFT).sum())
        if self.tried >= _TRIED and self.left > _MOST_LEFT * self.tried:
            self.made = None  # a scene of which single runs make most members anyway

    def _look(self, fraction: float) -> None:
        """Interrupt a single run where all are to stop."""
        if self.stopped.is_set():
            raise KeyboardInterrupt
