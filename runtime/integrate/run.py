"""Integrate the equations of motion: the Python face of the compiled loop."""

import time
from collections.abc import Callable

import numpy as np

from runtime.constraints.repartitioning import GROWTH_LIMIT
from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import CORRECTING, EACH_STAGE, MODIFIED, STABILIZED
from runtime.core.modes import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.core.run_record import ConstraintReturn
from runtime.core.system import System
from runtime.core.workspace import (
    ATOL,
    BAND,
    PARTITION,
    PROJECTION,
    ROWS,
    SIZE,
    STRUCK,
    SWITCH_ROWS,
    Y0,
)
from runtime.hybrid.loop_branch_guard import DEAD_CENTRE_NOTE, find_dead_centre
from runtime.hybrid.mode_search import MOST_COMBINED
from runtime.hybrid.sliding_rhs import TIME_SCALE
from runtime.integrate.initialization import start
from runtime.integrate.interrupts import Interrupts
from runtime.integrate.loop import LOG_MARGIN, advance
from runtime.integrate.method import LEADING, Method, find_method
from runtime.integrate.method_change import change_method, fill_method
from runtime.integrate.problem import Options, Problem
from runtime.integrate.recording import Gathered
from runtime.integrate.sampling import INTERVAL, QUADRATURE, STEP_ENDS
from runtime.integrate.signals import UNFINISHED, Signal
from runtime.integrate.singular_crossing.crossing import Crossings
from runtime.integrate.trajectory import Statistics, Trajectory
from runtime.integrate.validation import check
from runtime.integrate.wiring import wire

Progress = Callable[[float, int], None]
"""Called between chunks with the time reached and the steps taken."""

_FIRST_CHUNK = 128  # measured: steps before an interrupt is heard, as before the run
_LONGEST_CHUNK = 16384  # safety: steps before an interrupt is heard, at most
_CHUNK_SECONDS = 0.05  # measured: s between two returns to Python, for progress and interrupts
_FOLLOWED = 2.0  # measured: of Baumgarte's time; in longer steps the stabilisation oscillates
_CORRECTING = {
    "step": ConstraintReturn.BY_PARTITION,
    "stage": ConstraintReturn.BY_PARTITION,
    "projection": ConstraintReturn.BY_PROJECTION,
    "baumgarte": ConstraintReturn.NEVER,
    "hybrid": ConstraintReturn.IF_DRIFTED,
}


def integrate(
    system: System, problem: Problem, options: Options, progress: Progress | None = None
) -> Trajectory:
    """Integrate an initial-value problem.

    Parameters
    ----------
    system
        Kernels and sizes of the machine.
    problem
        Start, end, state and parameters.
    options
        Method, tolerances, samples.
    progress
        Called now and then with the time reached and the number of steps taken. A
        `KeyboardInterrupt`, here or, after 128 steps, from the keyboard, ends the run with
        what was computed; one from the keyboard before that is raised.

    Returns
    -------
    Trajectory
        Samples, events, statistics, and how the run ended.
    """
    check(system, problem, options)
    return _Run(system, problem, options).execute(progress)


def initial_modes(
    system: System, t: float, q: Vector, v: Vector, p: Vector, rtol: float = 1e-8
) -> Integers:
    """Modes at a state: which switching conditions hold, or hold at once when one is zero.

    Parameters
    ----------
    q, v : (n,)
        State, on the constraints.

    Returns
    -------
    (s,) int64
        1 where the condition holds, 0 where it does not; 2 where its function stays at zero: the
        motion slides on its surface, friction sticks, or a rigid contact is closed.
    """
    problem = Problem(t, t + 1.0, q, v, p, np.ones(system.coordinates))
    run = _Run(system, problem, Options(rtol=rtol))
    run.start()
    return run.modes


class _Run:
    """Arrays of one run, and their way into and out of the compiled loop."""

    def __init__(self, system: System, problem: Problem, options: Options) -> None:
        self.system = system
        n, m, s = system.coordinates, system.constraint_count, system.switches
        method = find_method(options.method)
        self.n, self.m, self.s = n, m, s
        self.options = options
        t_eval = options.t_eval
        t_eval = None if t_eval is None else np.ascontiguousarray(t_eval, dtype=np.float64)
        p = np.ascontiguousarray(problem.p, dtype=np.float64)
        self.wiring = wire(system, options.method, p, 4 * LOG_MARGIN)
        table, arrays = self.wiring.table, self.wiring.arrays
        self.table, self.p = table, p
        self.modes: Integers = arrays["modes"]
        self.rows = arrays["workspace"].reshape(ROWS, 2, n)
        rows = self.rows
        rows[Y0, 0], rows[Y0, 1] = problem.q, problem.v
        rows[SIZE] = problem.sizes
        fallback = options.rtol * np.minimum(1.0, rows[SIZE])
        rows[ATOL, 0] = fallback[0] if options.atol_q is None else options.atol_q
        rows[ATOL, 1] = fallback[1] if options.atol_v is None else options.atol_v
        rows[PARTITION, 0], rows[PARTITION, 1] = problem.scale**2, problem.scale
        rows[PROJECTION, 0] = problem.scale**2
        self.state = rows[Y0]
        self.switch_rows = arrays["switching_rows"].reshape(SWITCH_ROWS, s)
        self.r = arrays["record"][0]
        self._fill_record(problem, options, method)
        self.methods = [(float(problem.t0), str(options.method))]
        table[CORRECTING] = _CORRECTING[options.correction]
        stabilized = options.correction in ("baumgarte", "hybrid")
        table[STABILIZED] = table[MODIFIED] = int(stabilized)
        duration = problem.t_end - problem.t0
        pull = options.time_scale or 1e-3 * duration or 1.0
        arrays["settings"][TIME_SCALE] = pull
        if stabilized and options.fixed_step is None:
            self.r["h_max"] = min(float(self.r["h_max"]), _FOLLOWED * pull)
        table[EACH_STAGE] = 1 if options.correction == "stage" and m > 0 else 0
        arrays["weights"][:n], arrays["weights"][3 * n :] = problem.scale**2, problem.sizes
        arrays["spreads"][:] = problem.spreads
        interval = INTERVAL if options.quadrature else None
        self.gathered = Gathered(self.wiring, n, s, t_eval, interval)
        self.crossings = Crossings(system, problem, self, method)

    def _fill_record(self, problem: Problem, options: Options, method: Method) -> None:
        r = self.r
        duration = problem.t_end - problem.t0
        r["t"], r["t_end"], r["duration"] = problem.t0, problem.t_end, duration
        r["h_max"] = duration if options.h_max is None else options.h_max
        largest = max(abs(problem.t0), abs(problem.t_end))
        r["h_min"] = 1e-15 * largest if options.h_min is None else options.h_min
        r["h"] = options.first_step or 0.0
        if options.fixed_step is not None:
            r["fixed"], r["h"], r["h_max"] = 1, options.fixed_step, options.fixed_step
        r["rtol"] = options.rtol
        r["max_steps"], r["max_events"] = options.max_steps, options.max_events
        fill_method(r, method)
        r["automatic"], r["patience"] = int(options.method == "auto"), 1
        r["error_old"] = 1e-4
        r["every_step"] = STEP_ENDS if options.t_eval is None else 0
        if options.quadrature:
            r["every_step"] = QUADRATURE
        r["growth_limit"] = r["ratio_limit"] = GROWTH_LIMIT
        r["event_span"] = np.inf
        r["index"] = -1
        r["permitted"] = 1.0
        r["quiet"] = -np.inf
        r["blind_from"] = r["blind_to"] = -np.inf

    def start(self) -> int:
        """Prepare the first step; returns the code of an outcome."""
        given = self.state.copy()
        code: int = start(self.table)
        if code in {Outcome.SINGULAR, Outcome.NEWTON_FAILED}:
            # What did not converge has gone astray: the start values are those given.
            self.state[:] = given
            if self.crossings.begin():
                code = start(self.table)
                if code == Outcome.OK:
                    code = self.crossings.leave()
        self.gathered.flush(self.r)
        if self.s:
            self._log_first_impacts()
        return code

    def _log_first_impacts(self) -> None:
        """The contacts that were struck in the very first instant are events as well."""
        struck = np.flatnonzero(self.switch_rows[STRUCK])
        closed = self.modes[struck] == SLIDING
        kinds = np.where(closed, Direction.HOLDS, Direction.IMPACT).tolist()
        self.gathered.strike(self.r["t"], struck, kinds, self.state.ravel())
        self.r["events"] += len(struck)

    def execute(self, progress: Progress | None) -> Trajectory:
        """Run to the end or to whatever stops the run before."""
        began = time.thread_time()  # others on the machine take no part in it
        with Interrupts() as interrupts:
            code = self.start()
            if code == Outcome.OK:
                code = Signal.GOING
            chunk = self.options.chunk or _FIRST_CHUNK
            while code == Signal.GOING:
                self.gathered.make_room(chunk)
                before = time.perf_counter()
                code = advance(self.table, chunk)
                took = time.perf_counter() - before
                self.gathered.flush(self.r)
                if code in UNFINISHED:
                    interrupts.watch()
                if code == Signal.CHANGE:
                    change_method(self)
                    code = Signal.GOING
                if self.options.chunk is None and took < 0.5 * _CHUNK_SECONDS:
                    chunk = min(2 * chunk, _LONGEST_CHUNK)
                if progress is not None:
                    try:
                        progress(float(self.r["t"]), int(self.r["steps"]))
                    except KeyboardInterrupt:
                        interrupts.seen = True
                if code == Signal.LOOK:
                    code = self.crossings.look()
                if interrupts.seen and code == Signal.GOING:
                    code = Outcome.INTERRUPTED
        return self._result(Outcome(code), time.thread_time() - began)

    def _result(self, outcome: Outcome, seconds: float) -> Trajectory:
        r, n = self.r, self.n
        t, y, modes = self.gathered.samples(r)
        note = ""
        p, kept = self.p, self.wiring.arrays["loop_nearness"]
        loop = find_dead_centre(self.system, float(r["t"]), self.state, p, kept, outcome)
        if loop is not None:
            outcome, r["index"], r["turn"] = Outcome.SINGULAR, loop, r["t"]
        if outcome is Outcome.SINGULAR and int(r["index"]) in self.system.loop_rows:
            note = DEAD_CENTRE_NOTE.format(float(r["turn"]))
        counts = {
            name: int(r[name])
            for name in Statistics.__dataclass_fields__
            if name not in ("largest_dq", "seconds")
        }
        return Trajectory(
            t=t,
            q=y[:, :n],
            v=y[:, n:],
            modes=modes,
            outcome=outcome,
            index=int(r["index"]),
            final_t=float(r["t"]),
            final_q=self.state[0].copy(),
            final_v=self.state[1].copy(),
            final_modes=self.modes,
            statistics=Statistics(**counts, largest_dq=float(r["largest_dq"]), seconds=seconds),
            events=self.gathered.events(),
            partitions=self.gathered.partitions(),
            methods=tuple((t, LEADING if name == "auto" else name) for t, name in self.methods),
            crossings=tuple(self.crossings.passed),
            note=self.crossings.note or self._given_up(outcome) or note,
        )

    def _given_up(self, outcome: Outcome) -> str:
        """What to know where more functions were on their surface than can all be tried."""
        count = int(np.count_nonzero(self.switch_rows[BAND] > 0.0))
        if outcome is not Outcome.INCONSISTENT or count <= MOST_COMBINED:
            return ""
        return (
            f"{count} conditions are on their surface at once; of their combinations only those of "
            f"{MOST_COMBINED} were all tried, and the search was given up: there may be a state "
            "that agrees."
        )
