"""The state of a run: arrays and record of the compiled loop, and the methods that step it."""

import numpy as np
from numpy.typing import NDArray

from runtime.constraints.repartitioning import GROWTH_LIMIT
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Integers, Matrix, Vector
from runtime.core.kinds import SLIDING
from runtime.core.loop_record import ConstraintReturn
from runtime.core.system import System
from runtime.hybrid.sliding_motion import TIME_SCALE
from runtime.integrate.clocks import set_clocks
from runtime.integrate.initialization import place_start
from runtime.integrate.loop import LOG_MARGIN
from runtime.integrate.method import Method, find_method
from runtime.integrate.problem import STABILIZING, Discrete, Options, Problem, Statistics, Stops
from runtime.integrate.sampling import QUADRATURE, STEP_ENDS
from runtime.integrate.step_acceptance import FIRST_LOOK
from runtime.integrate.wiring import METHOD_SLOTS, function_table, place, wire

_FOLLOWED = 2.0  # measured: of Baumgarte's time; in longer steps the stabilisation oscillates
_MOST_PATIENCE = 1024  # safety: times the first patience, before a method is changed
_METHOD_NUMBERS = (
    "estimate_order", "last", "stage_calls", "dense_calls", "dense_rows", "foresight", "beta",
    "safety", "shrink", "grow",
)  # fmt: skip
# What a run knows of its switching functions, samples and events whatever its coordinates.
_OF_SWITCHES = ("modes", "switching_rows", "share", "recent_events")
_OF_CLOCKS = ("ticks", "waiting_samples", "watched_before")
_OF_ENERGY = ("balances", "usual_part", "rounding")
_OF_EVENTS = (
    "t", "usual", "samples", "next_sample", "event_span", "flight", "shrinking", "standing",
    "patience", "stop", "next_stop", "sample_at",
)  # fmt: skip
COUNTS = [name for name in Statistics.__dataclass_fields__ if name != "seconds"]
"""What the record of a run counts."""
_CORRECTING = {
    "step": ConstraintReturn.BY_PARTITION,
    "stage": ConstraintReturn.BY_PARTITION,
    "projection": ConstraintReturn.BY_PROJECTION,
    "baumgarte": ConstraintReturn.NEVER,
    "hybrid": ConstraintReturn.IF_DRIFTED,
}
_KEEPING = ("step", "stage", "projection")  # returns onto the constraints


class RunState:
    """All that a run needs to go on from where it stands."""

    def __init__(self, system: System, problem: Problem, options: Options) -> None:
        self.system, self.options = system, options
        self.p = np.ascontiguousarray(problem.p, dtype=np.float64)  # with derived constants
        self.wiring = wire(system, options.method, self.p, 4 * LOG_MARGIN)
        self.table, arrays = self.wiring
        self.record: np.void = arrays["record"][0]  # see `core.loop_record`
        self.words: Integers = arrays["record"].view(np.int64)  # the same, which is soon copied
        # (ROWS, 2, n) and (SWITCH_ROWS, s), see `core.workspace_rows`
        self.rows: NDArray[np.float64] = arrays["workspace"].reshape(ws.ROWS, 2, system.coordinates)
        self.switch_rows: Matrix = arrays["switching_rows"].reshape(ws.SWITCH_ROWS, system.switches)
        self.modes: Integers = arrays["modes"]
        self.methods = [(float(problem.t0), str(options.method))]  # from when on, and its name
        self._fill_record(problem)
        self._place_start(problem)
        self._take(find_method(options.method))
        self._choose_return(problem)
        self.set_stops(problem.stops)
        if system.sampled:
            clocks = arrays["sample_clocks"].reshape(-1, 2)
            set_clocks(float(problem.t0), clocks, arrays["ticks"], taken=problem.samples_taken)
        if problem.discrete is not None:
            self._take_discrete(problem.discrete)

    @property
    def discrete(self) -> Discrete | None:
        """Where clocks and watched conditions stand; None where there are none."""
        if not (self.system.sampled or self.system.watches):
            return None
        arrays = self.wiring.arrays
        names = ("ticks", "waiting_samples", "watched_before")
        return Discrete(*(np.array(arrays[name]) for name in names))

    def _take_discrete(self, discrete: Discrete) -> None:
        """Go on with the clocks and conditions of another run."""
        arrays = self.wiring.arrays
        arrays["watched_before"][:] = discrete.held
        if self.system.sampled:
            arrays["ticks"][:] = discrete.ticks
            shape = self.table[ft.SAMPLED], self.table[ft.QUEUE]
            arrays["waiting_samples"].reshape(shape)[:] = discrete.waiting.reshape(shape)

    @property
    def y(self) -> Matrix:
        """q and v at the start of the next step, (2, n)."""
        y: Matrix = self.rows[ws.Y0]
        return y

    def _place_start(self, problem: Problem) -> None:
        n, options = self.system.coordinates, self.options
        given = problem.sizes, options.atol_q, options.atol_v
        sizes, *atol = (np.full(n, np.nan if x is None else x, np.float64) for x in given)
        q, v, scale = (np.array(x, np.float64) for x in (problem.q, problem.v, problem.scale))
        place_start(self.table, q, v, sizes, scale, np.concatenate(atol))

    def _fill_record(self, problem: Problem) -> None:
        r, options = self.record, self.options
        duration = problem.t_end - problem.t0
        r["t"], r["t_end"], r["duration"] = problem.t0, problem.t_end, duration
        r["h_max"] = duration if options.h_max is None else options.h_max
        largest = max(abs(problem.t0), abs(problem.t_end))
        r["h_min"] = 1e-15 * largest if options.h_min is None else options.h_min
        r["h"] = options.first_step or 0.0
        if options.fixed_step is not None:
            r["fixed"], r["h"], r["h_max"] = 1, options.fixed_step, options.fixed_step
        r["rtol"] = options.rtol
        r["max_steps"] = options.max_steps or options.step_limit
        r["max_events"] = options.max_events
        r["automatic"], r["patience"] = int(options.method == "auto"), 1
        r["error_old"] = 1e-4
        r["pace_start"], r["limit"] = problem.t0, np.inf
        r["pace_steps"], r["unlimited"] = FIRST_LOOK, int(options.max_steps is not None)
        r["every_step"] = STEP_ENDS if options.t_eval is None else 0
        if options.quadrature:
            r["every_step"] = QUADRATURE
        # Stabilised constraints, and steps without control of their error, keep no energy.
        keeps = options.fixed_step is None and options.correction in _KEEPING
        r["power_rows"] = self.system.balanced_rows if keeps else -1
        r["balance_at"] = 0 if r["power_rows"] >= 0 else np.iinfo(np.int64).max
        r["energy"], r["balances"] = np.nan, 1
        r["growth_limit"] = r["ratio_limit"] = GROWTH_LIMIT
        r["event_span"] = r["sample_at"] = np.inf
        r["index"] = r["stopped_by"] = -1
        r["permitted"] = 1.0
        r["quiet"] = r["blind_from"] = r["blind_to"] = r["doubtful"] = -np.inf

    def _choose_return(self, problem: Problem) -> None:
        """When steps return onto the constraints, and Baumgarte's terms."""
        r, options, arrays = self.record, self.options, self.wiring.arrays
        stabilized = options.correction in STABILIZING
        self.table[ft.CORRECTING] = _CORRECTING[options.correction]
        self.table[ft.STABILIZED] = self.table[ft.MODIFIED] = int(stabilized)
        each_stage = options.correction == "stage" and self.system.constraint_count > 0
        self.table[ft.EACH_STAGE] = int(each_stage)
        tau = options.baumgarte_time(float(r["duration"]))
        arrays["settings"][TIME_SCALE] = tau
        if stabilized and options.fixed_step is None:
            r["h_max"] = min(float(r["h_max"]), _FOLLOWED * tau)
        arrays["spreads"][:] = problem.spreads

    def set_stops(self, stops: Stops | None) -> None:
        """Write the instants at which steps end into the table; a fixed step keeps its length."""
        self.stops = stops
        times, kinks = (np.zeros(0), np.zeros(0, np.int64)) if stops is None else stops[:2]
        if self.options.fixed_step is not None:
            times, kinks = times[kinks >= 0], kinks[kinks >= 0]
        self.table[ft.STOPS] = len(times)
        place(self.table, self.wiring.arrays, "stop_times", times)
        place(self.table, self.wiring.arrays, "stop_kinds", kinks)
        self.record["next_stop"] = 0
        self.record["stop"] = times[0] if len(times) else np.inf

    def find_stop(self, t: float) -> None:
        """Look for the next of the instants known beforehand, where the run stands at `t`, s."""
        arrays, r = self.wiring.arrays, self.record
        self.set_stops(self.stops)
        while self.stops is not None and self.stops.further and self.stops.times[-1] < t:
            self.set_stops(self.stops.further())
        times = arrays["stop_times"]
        r["next_stop"] = np.searchsorted(times, t)
        r["stop"] = times[r["next_stop"]] if r["next_stop"] < len(times) else np.inf

    def leave_kink(self) -> None:
        """Stand behind the kink before which the run stands."""
        assert self.stops is not None
        r, times = self.record, self.wiring.arrays["stop_times"]
        # By its number: at the same instant a step may end for another reason.
        number = self.wiring.arrays["stop_kinds"][r["next_stop"]]
        r["t"] = self.stops.after[np.argmax(self.stops.kinks == number)]
        r["energy"] = np.nan  # velocities and forces are others from here on
        r["next_stop"] += 1
        r["stop"] = times[r["next_stop"]] if r["next_stop"] < len(times) else np.inf

    def take_over(self, other: "RunState", fresh: Integers, q: Vector, v: Vector) -> None:
        """Go on from where a run of the same machine in other coordinates stands.

        `fresh` are the words of this run's record before its start, (q, v), (n,), the state in its
        coordinates.
        """
        r, theirs, arrays = self.record, other.record, self.wiring.arrays
        if other.stops is not self.stops:
            self.set_stops(other.stops)
        counted = {name: r[name] for name in (*COUNTS, *_OF_ENERGY)}
        self.words[:] = fresh
        for name, count in counted.items():
            r[name] = count
        for name in _OF_EVENTS:
            r[name] = theirs[name]
        r["h"], r["resumed"] = theirs["usual"] if theirs["usual"] > 0.0 else theirs["h"], 1
        r["max_steps"] -= theirs["steps"] + theirs["rejected"]
        r["max_events"] -= theirs["events"]
        r["look_at"] = -np.inf
        self.y[0], self.y[1] = q, v
        if self.system.switches:
            for name in _OF_SWITCHES:
                arrays[name][:] = other.wiring.arrays[name]
            sliding = int(np.count_nonzero(self.modes == SLIDING))
            self.table[ft.SLIDING_COUNT] = sliding
            self.table[ft.MODIFIED] = sliding + self.table[ft.STABILIZED]
        if self.system.sampled or self.system.watches:
            for name in _OF_CLOCKS:
                arrays[name][:] = other.wiring.arrays[name]
        self.methods = other.methods
        self.use_method(self.methods[-1][1])

    def _take(self, method: Method) -> None:
        """Write the numbers of the method into the record."""
        self.method = method
        for name in _METHOD_NUMBERS:
            self.record[name] = getattr(method, name)
        self.record["exponent"] = 1.0 / method.estimate_order
        self.record["followed"], self.record["radius"] = np.inf, 0.0

    def set_functions(self, name: str) -> None:
        """Write the functions of the method `name` into the table."""
        self.method = find_method(name)
        self.table[METHOD_SLOTS] = function_table(name)

    def use_method(self, name: str) -> None:
        """Take the next steps with the method `name`, for which nothing is to be remembered."""
        self.set_functions(name)
        self._take(self.method)
        self.wiring.arrays["method_integers"][:] = 0
        self.method.restart(self.table, self.record["t"], self.record["h"])

    @property
    def mean_decay(self) -> float:
        """Mean of -h Re λ over all steps, λ the fastest motion's; 0 unless "auto" was asked for."""
        if self.options.method != "auto" or len(self.methods) > 1:
            return 0.0
        from runtime.integrate.implicit.stiffness_switching import mean_decay

        return mean_decay(self.wiring.arrays["method_floats"], int(self.record["steps"]))

    def change_method(self) -> None:
        """Go on with the method that suits: the state and its derivative are all that it needs.

        Each change doubles the number of steps that have to speak for the next one.
        """
        # Most runs need none of its functions.
        from runtime.integrate.implicit.stiffness_switching import successor

        r, system = self.record, self.system
        independent = int(np.count_nonzero(self.rows[ws.PARTITION, 0] == 0.0))
        freedoms = independent if system.constraint_count else system.coordinates
        name = successor(self.methods[-1][1], freedoms, self.options.rtol)
        self.methods.append((float(r["t"]), name))
        r["patience"] = min(2 * r["patience"], _MOST_PATIENCE)
        self.use_method(name)
