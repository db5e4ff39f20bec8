"""What an integration gives: samples, what happened between them, and what it cost."""

from dataclasses import dataclass

import numpy as np

from runtime.core.array_types import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.outcomes import Outcome


@dataclass(frozen=True)
class Statistics:
    """What a run cost.

    Attributes
    ----------
    steps, rejected, retakes
        Accepted steps, rejected ones, and steps taken again to end at a crossing.
    rhs
        Calls of `accelerations` by the method.
    corrections, newton
        Calls of `correction`, and Newton iterations begun at the ends of steps.
    iterations, jacobians, factorizations
        Of implicit methods: Newton iterations inside steps, each with one call of `accelerations`
        a stage; times at which exact derivatives were taken; matrices factored, a real and a
        complex one counted as one.
    dense_outputs
        Steps whose dense output was needed.
    repartitions, events
        Changes of the independent coordinates, and of modes.
    largest_dq
        Largest change of a coordinate by which a step was corrected.
    seconds
        Processor time of the thread.
    """

    steps: int
    rejected: int
    retakes: int
    rhs: int
    corrections: int
    newton: int
    iterations: int
    jacobians: int
    factorizations: int
    dense_outputs: int
    repartitions: int
    events: int
    largest_dq: float
    seconds: float


@dataclass(frozen=True)
class Events:
    """Changes of modes and impacts, in order of time.

    Attributes
    ----------
    t : (e,)
        Times, s; of a contact whose bouncing ends, the sum of all its flights.
    index : (e,) int64
        Switching functions.
    direction : (e,) int64
        1: the condition began to hold, or the contact opened; -1: it ceased; 0: the motion stays
        on its surface; 2: an impact, after which the contact is open.
    q, v : (e, n)
        States, on the constraints; after an impact, with the velocities that it leaves.
    """

    t: Vector
    index: Integers
    direction: Integers
    q: Matrix
    v: Matrix


@dataclass(frozen=True)
class Partitions:
    """Sets of independent coordinates: the first, then every change.

    Attributes
    ----------
    t : (c,)
        Times from which on each holds, s.
    independent : (c, n) bool
        True for the independent coordinates.
    """

    t: Vector
    independent: np.ndarray[tuple[int, int], np.dtype[np.bool_]]


@dataclass(frozen=True)
class Crossing:
    """A singular position that was passed, on the branch on which the velocity is continuous.

    Attributes
    ----------
    t
        When, s.
    row
        The constraint with the largest share in what ceased to be independent.
    lost
        How many constraints did.
    direction : (n,)
        The null direction that the motion does not follow, scaled by the masses, of unit length.
    error
        Estimated error of the step across it, over the tolerance.
    """

    t: float
    row: int
    lost: int
    direction: Vector
    error: float


@dataclass(frozen=True)
class Trajectory:
    """What a run gave, also where it did not reach its end.

    Attributes
    ----------
    t : (k,)
        Times of the samples, s.
    q, v : (k, n)
        States there, on the constraints.
    modes : (k, s) int64
        Modes in force on the step that ends at or contains the sample.
    outcome
        How the run ended.
    index
        The switching function (`INCONSISTENT`, `ZENO`) or constraint (`SINGULAR`) concerned; -1
        otherwise.
    final_t, final_q, final_v, final_modes
        Where the run stopped, ready to go on from.
    statistics, events, partitions, crossings
        As their classes say.
    note
        What else is to be said about how the run ended; empty as a rule.
    methods
        Times from which on each method was used, with its name: one, but for "auto".
    """

    t: Vector
    q: Matrix
    v: Matrix
    modes: IntegerMatrix
    outcome: Outcome
    index: int
    final_t: float
    final_q: Vector
    final_v: Vector
    final_modes: Integers
    statistics: Statistics
    events: Events
    partitions: Partitions
    crossings: tuple[Crossing, ...] = ()
    note: str = ""
    methods: tuple[tuple[float, str], ...] = ()
