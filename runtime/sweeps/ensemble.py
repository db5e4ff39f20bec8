"""An ensemble: many runs of one machine in threads, by a compiled loop as far as that goes."""

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError, LinkwrightError
from codegen.termination_signals import SignalDeferral
from runtime.core.outcomes import Outcome
from runtime.dynamics.simulation import simulate_joints
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.sweeps.ensemble_arrays import DONE, LEFT, WAITING, Preparation, Results, prepare
from runtime.sweeps.ensemble_loop import run_members
from runtime.sweeps.ensemble_rows import (
    Columns,
    FloatArray,
    Members,
    Rows,
    forbidden_members,
    read_members,
    require_room,
)

if TYPE_CHECKING:
    import xarray as xr

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


def run_ensemble(
    mechanism: Mechanism, t_end: float, times: FloatArray, parameters: Columns | None,
    starts: Columns | None, threads: int, max_bytes: int, progress: Progress, **options: Any,
) -> "xr.Dataset":  # fmt: skip
    """One row a member; see `Machine.ensemble`. `options` are those of `simulate`."""
    members = read_members(mechanism, parameters, starts)
    if any(row.reconnects for row in mechanism.description.watched):
        raise InputError(
            f"{mechanism.title}: ensemble: joints come and go in this scene, and its runs do not "
            "have the same variables. Use a sweep."
        )
    require_room(mechanism, members.count, len(times), max_bytes)
    rows = Rows(members, times)
    rows.status[forbidden_members(mechanism, members)] = LEFT  # to a single run, which says why
    single = SingleRuns(mechanism, t_end, members, rows, options)
    made = None
    try:
        first, made = single.prepare()
        make_runs(single, made, first, threads, progress)
    except KeyboardInterrupt:
        pass  # members that were not run say so
    if made is not None:
        for run in np.flatnonzero(rows.placed).tolist():
            rows.outcomes[run] = str(Outcome.OK)
            rows.messages[run] = made.message(
                int(rows.steps[run]), members.start_of(run), rows.unresolved[run],
                int(rows.logged[run]),
            )  # fmt: skip
    rows.leave_out_failures()
    return rows.dataset()


@dataclass(frozen=True)
class SingleRuns:
    """Members that `simulate` runs: the first, and those that the compiled loop leaves."""

    mechanism: Mechanism
    t_end: float
    members: Members
    rows: Rows
    options: Mapping[str, Any]

    def make(self, run: int, progress: Progress = silent) -> Result | None:
        """Make the run of a member; None where it is refused.

        Raises KeyboardInterrupt where the run was interrupted; its row is kept.
        """
        start = self.members.start_of(run) or None
        values = self.members.parameters_of(run) or None
        try:
            result = simulate_joints(
                self.mechanism, self.t_end, self.rows.times, parameters=values, start=start,
                progress=progress, **self.options,
            )  # fmt: skip
        except LinkwrightError as error:
            self.rows.outcomes[run], self.rows.messages[run] = type(error).__name__, str(error)
            return None
        self.rows.take(run, result)
        if result.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return result

    def prepare(self) -> tuple[int, Preparation | None]:
        """Make runs up to the first that ends well: the pattern of the others.

        Returns the member that follows it, and what all have in common.
        """
        for run in range(self.members.count):
            result = self.make(run)
            if result is not None and result.outcome is Outcome.OK:
                given = self.mechanism, self.t_end, self.rows.times, self.members, run, result
                return run + 1, prepare(*given, self.options)
        return self.members.count, None


def make_runs(
    single: SingleRuns, made: Preparation | None, first: int, threads: int, progress: Progress
) -> None:
    """Make the runs from the member `first` on, in so many threads at most.

    One thread is the caller's. Raises KeyboardInterrupt where runs are interrupted, after all
    threads have ended, and what a thread raises.
    """
    total, stopped = single.members.count, Event()
    size = max(1, min(_BLOCK, (total - first) // (_SHARES * threads)))
    blocks = iter(range(first, total, size))
    threads = max(1, min(threads, -(-(total - first) // size)))
    workers = [Worker(single, made, size, stopped) for _ in range(threads)]
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

    def __init__(
        self, single: SingleRuns, made: Preparation | None, size: int, stopped: Event
    ) -> None:
        self.single, self.rows, self.size, self.stopped = single, single.rows, size, stopped
        self.made, self.steps, self.tried, self.left = made, _FIRST_STEPS, 0, 0
        self.ended = 0  # members with a row
        if made is not None:
            self.own, self.pointed_to = made.own()
            rows, samples = single.rows, self.own.samples
            cubes = (np.zeros((size, *field.shape)) for field in samples)
            counts = rows.status, rows.steps, rows.events, rows.logged, rows.unresolved
            self.results = Results(Samples(*cubes), *counts)

    def run(self, blocks: Iterator[int], tell: Callable[[], None] = lambda: None) -> None:
        """Make the runs of blocks that nobody else has taken."""
        for first in blocks:
            last = min(first + self.size, self.single.members.count)
            try:
                self._run_compiled(first, last, tell)
            finally:
                done = self.rows.status[first:last] == DONE
                if done.any():
                    self.rows.place(first, done, self.results.samples)
            for run in range(first, last):
                if self.stopped.is_set():
                    return
                if self.rows.status[run] in (WAITING, LEFT):
                    self.single.make(run, self._look)
                    self.ended += 1
                    tell()

    def _run_compiled(self, first: int, last: int, tell: Callable[[], None]) -> None:
        """Make as many runs of a block as the compiled loop can; others are LEFT or WAITING."""
        made, at = self.made, first
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
            self.ended += int((self.rows.status[before:at] != LEFT).sum())
            tell()
        self.tried += last - first
        self.left += int((self.rows.status[first:last] == LEFT).sum())
        if self.tried >= _TRIED and self.left > _MOST_LEFT * self.tried:
            self.made = None  # a scene of which single runs make most members anyway

    def _look(self, fraction: float) -> None:
        """Interrupt a single run where all are to stop."""
        if self.stopped.is_set():
            raise KeyboardInterrupt
