"""Integrate the equations of motion: the Python face of the compiled loop."""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from codegen.errors import AnalysisError
from codegen.termination_signals import SignalDeferral
from runtime.core.arrays import Integers, Vector
from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome, Site
from runtime.core.system import System
from runtime.core.workspace_rows import BAND, STRUCK
from runtime.integrate import notes_on_outcomes as notes
from runtime.integrate.clocks import CLOCK
from runtime.integrate.initialization import start
from runtime.integrate.kinks import end_at_pole, pass_kink
from runtime.integrate.loop import advance
from runtime.integrate.method import LEADING
from runtime.integrate.problem import Options, Problem
from runtime.integrate.recording_buffers import Recording, in_order
from runtime.integrate.run_state import COUNTS, RunState
from runtime.integrate.sampling import INTERVAL
from runtime.integrate.singular_crossing.crossing import Crossings
from runtime.integrate.step import Signal
from runtime.integrate.trajectory import Statistics, Trajectory
from runtime.integrate.validation import check

Progress = Callable[[float, int], None]
"""Called between chunks with the time reached and the steps taken."""

Change = Callable[["Run", int], tuple["Run", int]]
"""Called after the start and between chunks with the run and its signal, or code of an outcome.

It answers with those with which the run goes on, perhaps in other coordinates.
"""

_FIRST_CHUNK = 128  # measured: steps before an interrupt is heard, as before the run
_LONGEST_CHUNK = 16384  # safety: steps before an interrupt is heard, at most
_CHUNK_SECONDS = 0.05  # measured: s between two returns to Python, for progress and interrupts
# As integers: looking up a member of an enumeration is slow in Python 3.11.
_GOING, _LOOK, _CHANGE = int(Signal.GOING), int(Signal.LOOK), int(Signal.CHANGE)
_KINK, _SAMPLE, _STOP = int(Signal.KINK), int(Signal.SAMPLE), int(Signal.STOP)
_STUCK = (Outcome.STEP_TOO_SMALL, Outcome.NOT_FINITE, Outcome.NEWTON_FAILED)
_AT_ONE_SITE = {
    *(Outcome.OK, Outcome.MAX_STEPS, Outcome.MEMORY, Outcome.INTERRUPTED, Outcome.OUT_OF_RANGE),
}
_CLOSE = 1e-6  # safety: of the run; nearer to a lock-up, that is why it ends


def integrate(
    system: System, problem: Problem, options: Options, progress: Progress | None = None,
    change: Change | None = None,
) -> Trajectory:  # fmt: skip
    """Integrate an initial-value problem.

    `progress` is called now and then with the time reached and the number of steps taken, `change`
    as its type says. A `KeyboardInterrupt`, here or, after 128 steps, from the keyboard, ends the
    run with what was computed; one from the keyboard before that, or in the last steps, is raised.
    Raises InputError with everything that is wrong with the problem and its options.
    """
    check(system, problem, options)
    path = Run(system, problem, options).execute(progress, change)
    return replace(path, events=in_order(path.events, path.final_t, system.rigid))


def initial_modes(
    system: System, t: float, q: Vector, v: Vector, p: Vector, rtol: float = 1e-8
) -> Integers:
    """Modes (s,) at a state on the constraints: which switching conditions hold, or hold at once.

    1 where the condition holds, 0 where it does not; 2 where its function stays at zero: the motion
    slides on its surface, friction sticks, or a rigid contact is closed. Raises AnalysisError where
    no run starts from the state.
    """
    problem = Problem(t, t + 1.0, q, v, p, np.ones(system.coordinates))
    run = Run(system, problem, Options(rtol=rtol))
    outcome = Outcome(run.start())
    if outcome is not Outcome.OK:
        raise AnalysisError(
            f"There are no modes at t = {t:.9g} s: no run starts from this state ({outcome}), and "
            "the message of `simulate` says why."
        )
    return run.state.modes


class Run:
    """One run: its state, what it records, and its way into and out of the compiled loop."""

    def __init__(self, system: System, problem: Problem, options: Options) -> None:
        self.state = RunState(system, problem, options)
        t_eval = options.t_eval
        t_eval = None if t_eval is None else np.ascontiguousarray(t_eval, dtype=np.float64)
        interval = INTERVAL if options.quadrature else None
        n, s = system.coordinates, system.switches
        self.recording = Recording(self.state.wiring, n, s, t_eval, interval, options.sink)
        self.crossings = Crossings(self.state, problem)
        self.first_t = float(problem.t0)
        self.controllers = problem.controllers
        self.note = ""  # on the outcome
        self.fresh = self.state.record.copy()
        self.most = _LONGEST_CHUNK  # steps until `Change` is called again

    def take_over(self, other: "Run", q: Vector, v: Vector) -> int:
        """Go on from where `other` stands, in other coordinates; returns the code of an outcome.

        (q, v), (n,) each, is the state in the coordinates of this run. What it has recorded before
        is forgotten.
        """
        self.state.take_over(other.state, self.fresh, q, v)
        self.recording.bytes = other.recording.bytes
        self.recording.begin()
        self.crossings.begin()
        return self.start()

    def start(self) -> int:
        """Prepare the first step; returns the code of an outcome."""
        y, table = self.state.y, self.state.table
        if self.state.system.sampled and not self.state.record["resumed"]:
            self._take_first_samples()
        given = y.copy()
        code: int = start(table)
        if code in {Outcome.SINGULAR, Outcome.NEWTON_FAILED}:
            # What did not converge has gone astray: the start values are those given.
            y[:] = given
            if self.crossings.prepare_start():
                code = start(table)
                if code == Outcome.OK:
                    code = self.crossings.leave_start()
            elif self.crossings.note:
                code = Outcome.SINGULAR  # whichever way the search for a start ended
                self.state.record["site"] = Site.START_ASTRAY
        if code == Outcome.OK and self.state.system.watches and not self.state.record["resumed"]:
            before = self.state.modes.copy()
            code = self.watch_start()
            changed = np.flatnonzero(self.state.modes != before)
            self.recording.replace_first(y.ravel(), changed, self.state.modes)
        self.recording.flush()
        if self.state.system.switches and not self.state.record["resumed"]:
            self._log_first_impacts()
        if code == Outcome.OK:
            self.state.record["site"], self.state.record["index"] = Site.NOWHERE, -1
        return code

    def _log_first_impacts(self) -> None:
        """The contacts that were struck in the very first instant are events as well."""
        record = self.state.record
        struck = np.flatnonzero(self.state.switch_rows[STRUCK])
        closed = self.state.modes[struck] == SLIDING
        kinds = np.where(closed, Direction.HOLDS, Direction.IMPACT).tolist()
        self.recording.add_events(record["t"], struck, kinds, self.state.y.ravel())
        record["events"] += len(struck)

    def execute(
        self, progress: Progress | None, change: Change | None = None, *, started: bool = False
    ) -> Trajectory:
        """Run to the end or to whatever stops the run before.

        Where `change` goes on in other coordinates, the result is that of the last run. A run that
        has `started` goes on.
        """
        began = time.thread_time()  # others on the machine take no part in it
        run, fixed_chunk, stopped = self, self.state.options.chunk, False
        with SignalDeferral(computing=True, at_once=False) as signals:
            code = _GOING if started else self.start()
            if code == Outcome.OK:
                code = _GOING
            if change is not None:
                run, code = change(run, code)
            chunk = fixed_chunk or _FIRST_CHUNK
            while code == _GOING:
                steps = min(chunk, run.most, run.recording.most_steps or chunk)
                run.recording.make_room(steps)
                before = time.perf_counter()
                code = advance(run.state.table, steps)
                took = time.perf_counter() - before
                if code == _SAMPLE:  # before the samples of the step are taken over
                    code = run._take_samples()
                run.recording.flush()
                if code < 0:
                    signals.begin()
                if code == _KINK:
                    code = pass_kink(run)
                if code == _CHANGE:
                    run.state.change_method()
                    code = _GOING
                if fixed_chunk is None and took < 0.5 * _CHUNK_SECONDS:
                    chunk = min(2 * chunk, _LONGEST_CHUNK)
                elif fixed_chunk is None and took > 2.0 * _CHUNK_SECONDS:
                    chunk = max(1, int(chunk * _CHUNK_SECONDS / took))
                if progress is not None:
                    record = run.state.record
                    try:
                        progress(float(record["t"]), int(record["steps"]))
                    except KeyboardInterrupt:
                        stopped = True
                if code == _LOOK:
                    code = run.crossings.decide()
                    run.state.record["energy"] = np.nan
                    if code == _GOING:  # what ends the run later has another reason
                        run.state.record["index"] = -1
                if change is not None:
                    run, code = change(run, code)
                if code == _GOING and run.recording.bytes > run.state.options.max_bytes:
                    code, run.note = int(Outcome.MEMORY), notes.memory_note(run.recording)
                if code == _GOING and (signals.arrived or stopped):
                    code, signals.answered = int(Outcome.INTERRUPTED), not stopped
            code = int(Outcome.OK) if code == _STOP else code
            if code in (*_STUCK, Outcome.CONTRADICTED):
                code = run._end_at_lock_up(end_at_pole(run, code))
        return run.result(Outcome(code), time.thread_time() - began)

    def _end_at_lock_up(self, code: int) -> int:
        """SINGULAR where drivers ask for ever more speed up to a position that is close by."""
        r = self.state.record
        of_event = code == Outcome.CONTRADICTED and r["index"] >= 0
        if of_event or code not in (*_STUCK, Outcome.CONTRADICTED):
            return code
        row = self.crossings.find_lock_up(_CLOSE * float(r["duration"]))
        if row < 0:
            return code
        r["index"], r["site"] = row, Site.LOCK_UP
        return int(Outcome.SINGULAR)

    def watch_start(self) -> int:
        """What begins with a condition that holds from the first instant on; a code or STOP."""
        from runtime.integrate.sampled_values import watch_now

        code = int(watch_now(self.state.table))
        return int(Outcome.OK) if code == Signal.PROCEED else code

    def _take_first_samples(self) -> None:
        """Let the values that clocks renew at the very first instant act from there on."""
        from runtime.integrate.sampled_values import compute_samples, take_samples

        compute_samples(self.state.table)
        self._compute_by_controllers()
        take_samples(self.state.table)

    def _take_samples(self) -> int:
        """Go on with samples that functions in Python compute."""
        from runtime.integrate.sampled_values import go_on

        self._compute_by_controllers()
        code: int = go_on(self.state.table)
        return _GOING if code == Signal.PROCEED else code

    def _compute_by_controllers(self) -> None:
        """Replace the samples of the values that the run's own functions compute."""
        arrays, state, system = self.state.wiring.arrays, self.state, self.state.system
        for k in system.controllers:
            if arrays["due"][k]:
                q, v = state.y
                value = self.controllers[k](float(state.record["t"]), q.copy(), v.copy())
                arrays["sample_values"][k] = value

    def result(self, outcome: Outcome, seconds: float) -> Trajectory:
        """What was recorded since the start, or since the run took over from another."""
        state, r = self.state, self.state.record
        n, stopped = state.system.coordinates, float(r["t"])
        note = self.note or self.crossings.note
        if outcome is Outcome.CONTRADICTED:
            note = notes.energy_note(r)
        elif outcome is Outcome.INCONSISTENT and not note:
            note = notes.mode_search_note(state.switch_rows[BAND])
        elif outcome in {Outcome.OK, Outcome.MAX_STEPS}:
            note = notes.passed_accumulation_note(r)
        elif outcome in {Outcome.STEP_TOO_SMALL, Outcome.ZENO} and not note:
            note = notes.accumulation_note(r)
        t, y, modes = self.recording.samples()
        return Trajectory(
            t=t,
            q=y[:, :n],
            v=y[:, n:],
            modes=modes,
            outcome=outcome,
            discrete=state.discrete,
            stopped_by=int(r["stopped_by"]),
            index=int(r["index"]),
            site=Site.NOWHERE if outcome in _AT_ONE_SITE else Site(int(r["site"])),
            first_t=self.first_t,
            final_t=stopped,
            final_q=state.y[0].copy(),
            final_v=state.y[1].copy(),
            final_modes=state.modes,
            statistics=Statistics(**{name: r[name].item() for name in COUNTS}, seconds=seconds),
            events=self.recording.events(),
            partitions=self.recording.partitions(),
            methods=tuple((t, LEADING if name == "auto" else name) for t, name in state.methods),
            decay=state.mean_decay,
            crossings=tuple(self.crossings.passed),
            note=note,
            samples_taken=bool(r["sample_at"] > stopped + CLOCK * abs(stopped)),
        )
