"""What an integration starts from and what it gives."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from runtime.integrate.signatures import (
    IntegerMatrix,
    Integers,
    Kernel,
    Matrix,
    Vector,
    no_accelerations_tangent,
    no_correction_tangent,
    no_forces,
    no_mass,
    no_reactions,
    no_restitution,
    no_right_side,
    no_state_right_side,
    no_switched_reactions,
    no_switching,
    no_switching_rates,
    plain_holds,
)
from runtime.outcomes import Outcome

Correction = Literal["step", "stage", "projection", "baumgarte", "hybrid"]


@dataclass(frozen=True, eq=False)
class System:
    """The compiled equations that the integrator needs, and their sizes.

    Attributes
    ----------
    accelerations, correction, jacobian, switching, switching_rates, constraints, velocity_rhs, \
    acceleration_rhs, mass, applied_forces, gap_accelerations, accelerations_tangent, \
    correction_tangent
        Kernels with the signatures in `signatures`; those that the method and the scene have no
        use for may be left out.
    jacobian_rows, jacobian_columns : (nnz,) int64
        Where the values that `jacobian` writes belong.
    coordinates, constraint_count, switches
        n, m and s.
    independent
        Constraints of which none follows from others everywhere; None: all.
    holds, restitution
        Fill the bounds of the shares, and the coefficients of restitution, from the parameters.
    rigid, sticking
        Switching functions that are gaps of rigid contacts, and slips of frictions that stick.
    reactions, switched_reactions, reaction_rows
        Kernels that fill reactions, and how many there are.
    limits
        (switching function, row of the force, row of what it may be) of frictions whose pressing
        force depends on them.
    """

    accelerations: Kernel
    correction: Kernel
    jacobian: Kernel
    jacobian_rows: Integers
    jacobian_columns: Integers
    coordinates: int
    constraint_count: int
    switches: int = 0
    switching: Kernel = no_switching
    switching_rates: Kernel = no_switching_rates
    constraints: Kernel = no_right_side
    velocity_rhs: Kernel = no_right_side
    acceleration_rhs: Kernel = no_state_right_side
    mass: Kernel = no_mass
    applied_forces: Kernel = no_forces
    gap_accelerations: Kernel = no_switching_rates
    accelerations_tangent: Kernel = no_accelerations_tangent
    correction_tangent: Kernel = no_correction_tangent
    holds: Kernel = plain_holds
    restitution: Kernel = no_restitution
    rigid: tuple[int, ...] = ()
    sticking: tuple[int, ...] = ()
    reactions: Kernel = no_reactions
    switched_reactions: Kernel = no_switched_reactions
    reaction_rows: int = 0
    limits: tuple[tuple[int, int, int], ...] = ()
    independent: tuple[int, ...] | None = None

    @property
    def rank(self) -> int:
        """Number of independent constraints."""
        return self.constraint_count if self.independent is None else len(self.independent)


@dataclass(frozen=True)
class Problem:
    """An initial-value problem.

    Attributes
    ----------
    t0, t_end
        Start and end, s; t_end >= t0.
    q, v : (n,)
        State at t0, which must be on the constraints but for rounding.
    p : (np,)
        Parameters and derived constants.
    scale : (n,)
        Typical size of a change of each coordinate, 1 / sqrt(M_kk).
    sizes
        Typical size of each coordinate, m or rad, and of its velocity a second; one number or
        (n,).
    """

    t0: float
    t_end: float
    q: Vector
    v: Vector
    p: Vector
    scale: Vector
    sizes: ArrayLike = 1.0


@dataclass(frozen=True)
class Options:
    """How to integrate.

    Attributes
    ----------
    method
        "dopri5" or "dop853", explicit; "radau5" or "bdf", implicit, for stiff equations: these take
        the derivatives of the kernels; "auto", which starts with "dop853" and changes to and fro.
    rtol
        Relative tolerance of a step.
    atol_q, atol_v
        Absolute tolerances, one number or one a coordinate; None: `rtol` times the typical size,
        at most 1 m or 1 rad.
    t_eval
        Instants of the samples, ascending; None: the end of every step.
    correction
        Return onto the constraints: at the end of every "step", the dependent coordinates from the
        independent ones, or at every "stage" too; by "projection", at the end of every step, of
        all coordinates by the least in the metric of the masses; by "baumgarte", never, but
        accelerations that pull back; by "hybrid", these, and projection where a constraint has
        drifted by more than the tolerance (T. W. Park and E. J. Haug, Journal of Mechanisms,
        Transmissions and Automation in Design 108, 1986).
    time_scale
        τ of Baumgarte's accelerations, s; None: a thousandth of the run.
    first_step, h_max, h_min
        Lengths in s; None: chosen.
    fixed_step
        Length of all steps, s; switches error control off.
    max_steps
        Trial steps permitted.
    max_events
        Changes of modes permitted; more are taken for chattering without end.
    chunk
        Trial steps between two looks at the clock; None: chosen for about 50 ms.
    """

    method: Literal["dopri5", "dop853", "bdf", "radau5", "auto"] = "dop853"
    rtol: float = 1e-8
    atol_q: ArrayLike | None = None
    atol_v: ArrayLike | None = None
    t_eval: ArrayLike | None = None
    correction: Correction = "step"
    time_scale: float | None = None
    first_step: float | None = None
    h_max: float | None = None
    h_min: float | None = None
    fixed_step: float | None = None
    max_steps: int = 100_000_000
    max_events: int = 1_000_000
    chunk: int | None = None


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
        Wall time.
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


@dataclass
class Samples:
    """Rows gathered chunk by chunk."""

    parts: list[tuple[np.ndarray, ...]] = field(default_factory=list)

    def take(self, count: int, *arrays: np.ndarray) -> None:
        """Copy the first `count` rows of each array."""
        if count:
            self.parts.append(tuple(array[:count].copy() for array in arrays))

    def joined(self, *empty: np.ndarray) -> tuple[np.ndarray, ...]:
        """All rows of each array; where there are none, none of `empty`'s shape."""
        if not self.parts:
            return tuple(array[:0].copy() for array in empty)
        return tuple(np.concatenate(column) for column in zip(*self.parts, strict=True))
