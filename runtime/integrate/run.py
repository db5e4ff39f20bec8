"""A run: the Python face of the compiled loop."""

import time
from collections.abc import Callable

import numpy as np

from codegen.errors import AnalysisError
from codegen.termination_signals import SignalDeferral
from runtime.core import function_table_slots as ft
from runtime.core.arrays import Integers, Vector
from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome, Site
from runtime.core.system import System
from runtime.core.workspace_rows import BAND, STRUCK
from runtime.hybrid.mode_selection import MOST_COMBINED
from runtime.integrate.clocks import CLOCK
from runtime.integrate.initialization import start, start_anew
from runtime.integrate.loop import advance
from runtime.integrate.method import LEADING
from runtime.integrate.problem import (
    MOST_STEPS,
    Options,
    Passage,
    Problem,
    Statistics,
    Trajectory,
)  # fmt: skip
from runtime.integrate.recording_buffers import Recording
from runtime.integrate.run_state import COUNTS, RunState
from runtime.integrate.sampling import STEP_ENDS
from runtime.integrate.singular_crossings import Crossings
from runtime.integrate.step import Signal

Progress = Callable[[float, int], None]
"""Called between chunks with the time reached and the steps taken."""

Change = Callable[["Run", int], tuple["Run", int]]
"""Called after the start and between chunks with the run and its signal, or code of an outcome.

It returns the run and the signal to go on with: usually the same run, else one in other
coordinates.
"""

_FIRST_CHUNK = 128  # measured: first number of steps before an interrupt is heard
_LONGEST_CHUNK = 16384  # safety: largest number of steps before an interrupt is heard
_CHUNK_SECONDS = 0.05  # measured: s between two returns to Python, for progress and interrupts
# As integers: looking up a member of an enumeration is slow in Python 3.11.
_GOING, _LOOK, _CHANGE = int(Signal.GOING), int(Signal.LOOK), int(Signal.CHANGE)
_KINK, _SAMPLE, _STOP = int(Signal.KINK), int(Signal.SAMPLE), int(Signal.STOP)
_STUCK = (Outcome.STEP_TOO_SMALL, Outcome.NOT_FINITE, Outcome.NEWTON_FAILED)
_AT_ONE_SITE = {
    *(Outcome.OK, Outcome.MAX_STEPS, Outcome.MEMORY, Outcome.INTERRUPTED, Outcome.OUT_OF_RANGE)
}
_CLOSE = 1e-6  # safety: of the run; a pole or a lock-up that is nearer to the end is its cause


def initial_modes(system: System, t: float, q: Vector, v: Vector, p: Vector) -> Integers:
    """Modes (s,) at a state on the constraints: which switching conditions hold, or hold at once.

    1 where the condition holds, 0 where it does not; 2 where its function stays at zero: the motion
    slides on its surface, friction sticks, or a rigid contact is closed. Raises AnalysisError where
    no run starts from the state.
    """
    run = Run(system, Problem(t, t + 1.0, q, v, p, np.ones(system.coordinates)), Options())
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
        self.recording = Recording(self.state.wiring, system, options)
        self.crossings = Crossings(self.state, problem)
        self.first_t = float(problem.t0)
        self.controllers = problem.controllers
        self.note = ""  # on the outcome
        self.fresh = self.state.words.copy()
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
            code = self._watch_start()
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
        if not len(struck):
            return
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
                    code = run._pass_kink()
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
                    code, r = int(Outcome.MEMORY), run.state.record
                    run.note = (
                        f"The states that were recorded in {r['steps']} steps and {r['events']} "
                        f"events take {run.recording.bytes:.3g} bytes."
                    )
                if code == _GOING and (signals.arrived or stopped):
                    code, signals.answered = int(Outcome.INTERRUPTED), not stopped
            code = int(Outcome.OK) if code == _STOP else code
            if code in (*_STUCK, Outcome.CONTRADICTED):
                code = run._end_at_lock_up(run._end_at_pole(code))
        return run.result(Outcome(code), time.thread_time() - began)

    def _end_at_lock_up(self, code: int) -> int:
        """SINGULAR where drivers ask for ever more speed up to a position that is close by.

        Or where the machine just misses a position in which its motions cross.
        """
        r = self.state.record
        of_event = code == Outcome.CONTRADICTED and r["index"] >= 0
        if of_event or code not in (*_STUCK, Outcome.CONTRADICTED):
            return code
        row = self.crossings.find_lock_up(_CLOSE * float(r["duration"]))
        if row >= 0:
            r["index"], r["site"] = row, Site.LOCK_UP
        elif code == Outcome.CONTRADICTED or not self.crossings.is_near_miss():
            return code
        return int(Outcome.SINGULAR)

    def _watch_start(self) -> int:
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
        t, y, modes = self.recording.samples()
        return Trajectory(
            t=t, q=y[:, :n], v=y[:, n:], modes=modes, outcome=outcome, discrete=state.discrete,
            stopped_by=int(r["stopped_by"]), index=int(r["index"]), first_t=self.first_t,
            site=Site.NOWHERE if outcome in _AT_ONE_SITE else Site(int(r["site"])),
            final_t=stopped, final_q=state.y[0].copy(), final_v=state.y[1].copy(),
            final_modes=state.modes,
            statistics=Statistics(*(*r[COUNTS].item(), seconds)),
            events=self.recording.events(), partitions=self.recording.partitions(),
            methods=tuple((t, LEADING if name == "auto" else name) for t, name in state.methods),
            decay=state.mean_decay, crossings=tuple(self.crossings.passed),
            note=self._note(outcome),
            samples_taken=bool(r["sample_at"] > stopped + CLOCK * abs(stopped)),
        )  # fmt: skip

    def _note(self, outcome: Outcome) -> str:
        """What else is to be said of the outcome, with the numbers that show it; mostly nothing."""
        r, note = self.state.record, self.note or self.crossings.note
        t, limit = float(r["t"]), float(r["limit"])
        crowded, unlimited = bool(np.isfinite(limit)), bool(r["unlimited"])
        if outcome is Outcome.CONTRADICTED:
            work = float(r["explained"])
            change = float(r["unexplained"] + r["explained"])
            if r["index"] >= 0:
                note = "which no force and no impact explains"
                return f"The energy jumps there by {change:.6g} J, {note}."
            return (
                f"Up to t = {r['end']:.9g} s the energy changes by {change:.6g} J, and the work of "
                f"effects and drivers is {work:.6g} J."
            )
        if outcome in {Outcome.OK, Outcome.MAX_STEPS}:
            if not (crowded and unlimited):
                return ""
            return (
                f"Towards about t = {limit:.6g} s its steps got ever shorter, as where a motion "
                "turns or switches infinitely often, and only the number given as max_steps= let "
                "it go on: look at the motion about there."
            )
        if note:
            return note
        at_once = int(np.count_nonzero(self.state.switch_rows[BAND] > 0.0))
        if outcome is Outcome.INCONSISTENT and at_once > MOST_COMBINED:
            return (
                f"{at_once} conditions are on their surface at once; of their combinations only "
                f"those of {MOST_COMBINED} were all tried, and the search was given up: there may "
                "be a state that agrees."
            )
        if outcome in {Outcome.STEP_TOO_SMALL, Outcome.ZENO} and crowded and not unlimited:
            return (
                f"In {r['steps']} steps the run has come to t = {t:.9g} s; each doubling of their "
                f"number covers less time than the one before, {float(r['pace']):.3g} s at last, "
                f"and all that are to come add up to t = {limit:.9g} s, {limit - t:.3g} s later, "
                f"where the run is to reach {float(r['t_end']):.9g} s. If its steps stop shrinking "
                f"before, go on with a number of your own, such as max_steps={MOST_STEPS}, which "
                "switches this check off."
            )
        return ""

    # -- explicit functions of time ----------------------------------------------------------

    def _end_at_pole(self, code: int) -> int:
        """The outcome of a run whose steps get ever shorter up to an instant known beforehand."""
        r, arrays, stops = self.state.record, self.state.wiring.arrays, self.state.stops
        ahead = np.flatnonzero(arrays["stop_kinds"][r["next_stop"] :] >= 0) + r["next_stop"]
        if not len(ahead) or (stops is not None and stops.further is not None and len(ahead) == 1):
            return code
        way = float(arrays["stop_times"][ahead[0]] - r["t"])
        if way > _CLOSE * float(r["duration"]):
            return code
        passage = self._passage(ahead[0])
        if passage.outcome is not Outcome.OK:
            return passage.outcome
        if passage.function:  # else it has no value at the first instant
            self.note = (
                f"At t = {r['t'] + way:.9g} s, {way:.3g} s later, a function of time in "
                f"'{passage.function}' bends or ends: its derivatives may grow without bound there."
            )
        return code

    def _passage(self, stop: int) -> Passage:
        """How the run passes the kink that is a stop of this number."""
        state, r = self.state, self.state.record
        assert state.stops is not None
        q, v = state.y
        kink = int(state.wiring.arrays["stop_kinds"][stop])
        passage = state.stops.passage(kink, q.copy(), v.copy(), state.modes.copy())
        if passage.outcome is not Outcome.OK:
            r["index"], r["site"], self.note = passage.row, Site.NOWHERE, passage.note
        return passage

    def _pass_kink(self) -> int:
        """Go on behind a kink of an explicit function of time, or end before it."""
        state, r = self.state, self.state.record
        last = r["next_stop"] == state.table[ft.STOPS] - 1
        if last and state.stops is not None and state.stops.further is not None:
            state.set_stops(state.stops.further())
            return _GOING
        passage = self._passage(int(r["next_stop"]))
        if passage.outcome is not Outcome.OK:
            return passage.outcome
        before = state.y.ravel().copy(), state.modes.copy()
        state.leave_kink()
        if passage.v is not None:
            state.y[1] = passage.v
        code: int = start_anew(state.table)
        self.recording.flush()
        self._sample_kink(before, passage)
        if passage.event is not None:
            number = np.array([state.system.switches + passage.source])
            self.recording.add_events(r["t"], number, [passage.event], state.y.ravel())
            r["events"] += 1
        if code == Outcome.OK and state.system.watches:
            code = self._watch_start()
        return _GOING if code == Outcome.OK else code

    def _sample_kink(self, before: tuple[Vector, Integers], passage: Passage) -> None:
        """Take the samples that are asked for between the two sides of a kink."""
        state, r, times = self.state, self.state.record, self.state.wiring.arrays["sample_times"]
        while r["next_sample"] < len(times) and times[r["next_sample"]] <= r["t"]:
            at = float(times[r["next_sample"]])
            after = passage.behind is None or passage.behind(at)
            if r["every_step"] != STEP_ENDS:
                y, modes = (state.y.ravel(), state.modes) if after else before
                self.recording.add_sample(at, y, modes)
            r["next_sample"] += 1
        if r["every_step"] == STEP_ENDS and r["t"] >= r["t_end"]:
            self.recording.add_sample(float(r["t"]), state.y.ravel(), state.modes)
