"""The result of an integration: samples, events and changes between them, and its cost."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from runtime.core.arrays import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.problem import Discrete

if TYPE_CHECKING:
    from runtime.integrate.checkpoints import Checkpoints


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


@dataclass(frozen=True)
class Trajectory:
    """The result of a run, also where it did not reach its end."""

    t: Vector  # (k,): times of the samples, s
    q: Matrix  # (k, n): states there, on the constraints
    v: Matrix  # (k, n)
    modes: IntegerMatrix  # (k, s): in force on the step that ends at or contains the sample
    outcome: Outcome
    discrete: Discrete | None  # of clocks and watched conditions, at the end
    stopped_by: int  # the condition that has ended the run; -1: none
    index: int  # the switching function or constraint that the outcome concerns; -1: none
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
