"""The input of an integration: start and end, and how to solve the equations."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from runtime.core.arrays import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.kinds import Direction
from runtime.core.outcomes import Outcome

Correction = Literal["step", "stage", "projection", "baumgarte", "hybrid"]
STABILIZING = ("baumgarte", "hybrid")
Formulation = Literal["cartesian", "reduced"]

Rows = Callable[[Vector, Matrix, IntegerMatrix], None]
"""Takes times (k,), states (k, 2 n) and modes (k, s) of samples; they are its own to keep."""

Controller = Callable[[float, Vector, Vector], float]
"""(t, q, v) of a sample → the value, in the coordinates of the run."""

MOST_STEPS = 100_000_000  # safety: trial steps of a run, where no number is given


class Discrete(NamedTuple):
    """Where the clocks and watched conditions of a run stand, for a run that follows it."""

    ticks: Integers  # numbers of the next sample and of the next to act, (2 count,)
    waiting: Matrix  # samples that wait for their delay, (count, length of the queue)
    held: Vector  # 1 of each watched condition that holds, else 0; 2: it has its turn anew


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


@dataclass(frozen=True)
class Problem:
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
    stops: Stops | None = None  # None: the run ends its steps where it likes
    samples_taken: bool = False  # whether clocks have renewed what is due at t0
    # number of a sampled value → what computes its samples
    controllers: Mapping[int, Controller] = field(default_factory=dict)
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
