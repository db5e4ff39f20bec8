"""An integration: its problem, its options and their checks, and its trajectory."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from codegen.errors import InputError
from runtime.core.arrays import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.kinds import Direction
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.method import METHODS

if TYPE_CHECKING:
    from runtime.integrate.checkpoints import Checkpoints

Correction = Literal["step", "stage", "projection", "baumgarte", "hybrid"]
CORRECTIONS: tuple[str, ...] = get_args(Correction)
STABILIZING = ("baumgarte", "hybrid")
Formulation = Literal["cartesian", "reduced"]

Rows = Callable[[Vector, Matrix, IntegerMatrix], None]
"""Takes times (k,), states (k, 2 n) and modes (k, s) of samples; they are its own to keep."""

Controller = Callable[[float, Vector, Vector], float]
"""(t, q, v) of a sample → the value, in the coordinates of the run."""

MOST_STEPS = 100_000_000  # safety: trial steps of a run if no number is given


WAITS = 2.0  # code: of `held`: it has begun, and what it does is done as the next run begins


class Discrete(NamedTuple):
    """Where the clocks and watched conditions of a run stand, for a run that follows it."""

    ticks: Integers  # numbers of the next sample and of the next to act, (2 count,)
    waiting: Matrix  # samples that wait for their delay, (count, length of the queue)
    held: Vector  # 1 of each watched condition that holds, else 0; WAITS


class Passage(NamedTuple):
    """How a run passes an instant at which an explicit function of time bends or jumps."""

    outcome: Outcome = Outcome.OK  # anything else ends the run there
    row: int = -1  # the constraint that an outcome concerns, or -1
    note: str = ""  # on an outcome
    v: Vector | None = None  # velocities behind it, where they are others
    behind: Callable[[float], bool] | None = None  # whether an instant, s, is one of these
    event: Direction | None = None  # None: nothing to be seen
    source: int = 0  # number of the function of time to which an event belongs
    function: str = ""  # its element

    @property
    def text(self) -> str:
        """Why the run ends: of changes without end the note says all, for no condition switches."""
        if self.outcome is Outcome.ZENO:
            return self.note
        return f"{self.outcome.meaning} {self.note} {self.outcome.advice}"


class Stops(NamedTuple):
    """Instants, known before a run gets there, at which its steps end."""

    times: Vector  # (k,): ascending, s
    kinks: Integers  # (k,): number of the kink, or -1: a step ends, and nothing else
    after: Vector  # (k,): instants at which the run goes on
    # (number of the kink, q, v, modes) of the state before it → how the run passes it
    passage: Callable[[int, Vector, Vector, Integers], Passage]
    # The stops behind the last of these, which is where they are to be asked for; None: no others
    further: Callable[[], "Stops | None"] | None = None


class Problem(NamedTuple):
    """An initial-value problem."""

    t0: float  # start, s
    t_end: float  # end, s; not before the start
    q: Vector  # (n,): state at t0, which must be on the constraints but for rounding
    v: Vector  # (n,)
    p: Vector  # (np,): parameters and derived constants
    scale: Vector  # (n,): typical size of a change of each coordinate, 1 / sqrt(M_kk)
    sizes: ArrayLike = 1.0
    """Typical size of each coordinate, m or rad, and of its velocity a second: a number or (n,)."""
    spreads: ArrayLike = 0.0
    """(s,): how far switching functions go when all that they are made of is changed by its size,
    where that is more than the coordinates' own changes do."""
    shortest: ArrayLike = 0.0  # (m,): see `ScaledConstraints.least_lengths`
    stops: Stops | None = None  # None: the run ends its steps where it likes
    samples_taken: bool = False  # whether clocks have renewed what is due at t0
    # number of a sampled value → what computes its samples
    controllers: Mapping[int, Controller] = {}
    discrete: Discrete | None = None  # None: clocks begin, and no condition has held


@dataclass(frozen=True)
class Options:
    """How to integrate."""

    method: str = "dop853"  # one of `runtime.integrate.method.METHODS`
    rtol: float = 1e-8  # relative tolerance of a step
    # Absolute tolerances, one number or one a coordinate; None: `rtol` times the typical size, at
    # most 1 m or 1 rad.
    atol_q: ArrayLike | None = None
    atol_v: ArrayLike | None = None
    # instants of the samples, ascending; None: the end of every step
    t_eval: ArrayLike | None = None
    # Samples for integrals along the run: the start, then for each interval between steps' ends and
    # `t_eval` its Gauss nodes and its end; see `runtime.integrate.sampling`.
    quadrature: bool = False
    # Return onto the constraints: at the end of every "step", the dependent coordinates from the
    # independent ones, or at every "stage" too; by "projection", at the end of every step, of all
    # coordinates by the least in the metric of the masses; by "baumgarte", never, but accelerations
    # that pull back; by "hybrid", these, and projection where a constraint has drifted by more than
    # the tolerance (T. W. Park and E. J. Haug, Journal of Mechanisms, Transmissions and Automation
    # in Design 108, 1986).
    correction: Correction = "step"
    # τ of Baumgarte's accelerations, s; None: a thousandth of the run
    time_scale: float | None = None
    first_step: float | None = None  # s, as the next two; None: chosen
    h_max: float | None = None
    h_min: float | None = None
    fixed_step: float | None = None  # length of all steps, s; switches error control off
    # trial steps; None: `step_limit`, and a run whose steps get ever shorter ends before
    max_steps: int | None = None
    step_limit: int = MOST_STEPS
    max_bytes: int = 2**30  # of recorded states; those at `t_eval` take what was asked for
    max_events: int = 1_000_000  # changes of modes; more are taken for chattering without end
    # trial steps between two looks at the clock; None: chosen for about 50 ms
    chunk: int | None = None
    sink: Rows | None = None  # takes samples over while the run goes on; None: they are recorded

    def baumgarte_time(self, duration: float) -> float:
        """τ of Baumgarte's accelerations in a run of this length, s."""
        return self.time_scale or 1e-3 * duration or 1.0

    def absolute(self, sizes: Vector, rtol: float) -> Vector:
        """Absolute tolerances of coordinates, then of velocities, of these sizes; (2n,)."""
        own, given = rtol * np.minimum(1.0, sizes), (self.atol_q, self.atol_v)
        return np.concatenate([own if x is None else np.broadcast_to(x, own.shape) for x in given])


@dataclass(frozen=True)
class Statistics:
    """The cost of a run; a Newton iteration within a step calls `accelerations` once a stage."""

    steps: int  # accepted
    rejected: int
    retakes: int  # steps taken again to end at an event
    rhs: int  # calls of `accelerations` by the method
    corrections: int  # calls of `correction`
    returns: int  # onto the constraints, begun at the ends of steps
    iterations: int  # of Newton's method inside the steps of implicit methods
    jacobians: int  # times at which exact derivatives were taken
    factorizations: int  # of matrices; a real and a complex one count as one
    dense_outputs: int  # steps whose dense output was needed
    repartitions: int  # changes of the independent coordinates
    events: int  # changes of modes
    balance_rhs: int  # calls of `accelerations` by the check of the energy's balance
    largest_dq: float  # largest change of a coordinate by which a step was corrected
    seconds: float  # processor time of the thread


@dataclass(frozen=True)
class Events:
    """Changes of modes and impacts, in order of time, each with its `Direction`.

    Of a contact whose bouncing ends the time is the sum of all its flights. States are on the
    constraints; after an impact, with the velocities that it leaves.
    """

    t: Vector  # (e,), s
    index: Integers  # (e,): switching functions
    direction: Integers  # (e,)
    q: Matrix  # (e, n)
    v: Matrix  # (e, n)


@dataclass(frozen=True)
class Partitions:
    """Sets of independent coordinates: the first, then every change."""

    t: Vector  # (c,): times from which on each holds, s
    independent: np.ndarray[tuple[int, int], np.dtype[np.bool_]]  # (c, n)


@dataclass(frozen=True)
class Crossing:
    """A singular position that was passed, on the branch on which the velocity is continuous."""

    t: float  # s
    # the constraint with the largest share in the dependence, then others with a large one
    rows: tuple[int, ...]
    lost: int  # constraints that ceased to be independent
    direction: Vector  # (n,): null direction not along the motion, scaled by masses, unit length
    error: float  # estimate for the step across it, over the tolerance


class Trajectory(NamedTuple):
    """The result of a run, also where it did not reach its end."""

    t: Vector  # (k,): times of the samples, s
    q: Matrix  # (k, n): states there, on the constraints
    v: Matrix  # (k, n)
    modes: IntegerMatrix  # (k, s): in force on the step that ends at or contains the sample
    outcome: Outcome
    discrete: Discrete | None  # of clocks and watched conditions, at the end
    stopped_by: int  # the condition that has ended the run; -1: none
    # the switching function or constraint that the outcome concerns; -1: none
    index: int  # type: ignore[assignment]
    first_t: float  # where the run began
    final_t: float  # where the run stopped, ready to go on from
    final_q: Vector
    final_v: Vector
    final_modes: Integers
    statistics: Statistics
    events: Events
    partitions: Partitions
    site: Site = Site.NOWHERE  # where the outcome was set
    crossings: tuple[Crossing, ...] = ()
    note: str = ""  # what else is to be said about the outcome; empty as a rule
    methods: tuple[tuple[float, str], ...] = ()  # from when on each was used: one, but for "auto"
    decay: float = 0.0  # of the fastest motion in a step of "auto": mean of -h Re λ
    samples_taken: bool = True  # whether clocks have renewed what is due where the run stopped
    checkpoints: "Checkpoints | None" = None  # None: it was not asked to make any

    @property
    def end(self) -> tuple[float, Vector, Vector]:
        """Instant, coordinates and velocities where the run stopped."""
        return self.final_t, self.final_q, self.final_v


def refuse_misfits(problem: Problem, options: Options) -> None:
    """Raise InputError with all names, tolerances and instants that do not fit a problem."""
    n, first, last, problems = len(problem.q), problem.t0, problem.t_end, list[str]()
    if not first <= last:
        problems.append(
            f"The run must not end (t_end = {last}) before t0 = {first} s, where it begins, as "
            "t_start or the state of start= says. Give a later t_end."
        )
    if (method := options.method) not in METHODS:
        known = ", ".join(METHODS)
        problems.append(f"method {method!r} is none of the methods; choose one of {known}.")
    if (correction := options.correction) not in CORRECTIONS:
        problems.append(f"correction = {correction!r} must be one of {', '.join(CORRECTIONS)}.")
    if not 1e-15 <= options.rtol <= 1.0:
        problems.append(f"rtol = {options.rtol} must lie between 1e-15 and 1.")
    for atol in (options.atol_q, options.atol_v)[: 1 + (options.atol_q is not options.atol_v)]:
        if atol is not None and np.shape(atol) not in ((), (n,)):
            problems.append(f"atol = {atol} must be one number or {n}.")
    times = np.asarray(() if options.t_eval is None else options.t_eval)
    if len(times) and not first <= times[0] <= times[-1] <= last:
        problems.append(
            f"t_eval runs from {times[0]} to {times[-1]}; it must lie between t0 = {first} and "
            f"t_end = {last}."
        )
    if options.time_scale is not None and correction not in STABILIZING:
        problems.append(
            f"time_scale = {options.time_scale} is the time of Baumgarte's stabilisation, and "
            f"correction={correction!r} has none: leave it out, or give "
            'correction="baumgarte" or "hybrid".'
        )
    if problems:
        raise InputError(problems)
