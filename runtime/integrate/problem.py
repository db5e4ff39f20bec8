"""What is asked of an integration: the equations, start and end, and how to solve them."""

from dataclasses import dataclass
from typing import Literal

from numpy.typing import ArrayLike

from runtime.core.signatures import (
    Integers,
    Kernel,
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

Correction = Literal["step", "stage", "projection", "baumgarte", "hybrid"]
Formulation = Literal["cartesian", "reduced"]


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
    sought
        (switching function, place in p) of frictions whose force at rest is sought: in mode 2 the
        kernels exert the force that stands there.
    dead_centres, loop_rows
        (t, q, v, p, out): x² and its rate, of each loop that the kernels close in closed form, on
        one branch; x vanishes at its dead centres. How each is told of, as `index` of an outcome:
        a number not below `constraint_count`.
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
    sought: tuple[tuple[int, int], ...] = ()
    independent: tuple[int, ...] | None = None
    dead_centres: Kernel = no_switching
    loop_rows: tuple[int, ...] = ()

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
    spreads : (s,)
        How far switching functions go when all that they are made of is changed by its size, where
        that is more than what the coordinates' own changes do.
    """

    t0: float
    t_end: float
    q: Vector
    v: Vector
    p: Vector
    scale: Vector
    sizes: ArrayLike = 1.0
    spreads: ArrayLike = 0.0


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
