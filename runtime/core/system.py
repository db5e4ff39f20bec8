"""The compiled equations that the integrator needs, and their sizes."""

from dataclasses import dataclass

from runtime.core.signatures import (
    Integers,
    Kernel,
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
