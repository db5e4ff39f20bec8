"""The compiled equations that the integrator needs, and their sizes."""

from dataclasses import dataclass

from runtime.core.arrays import Integers
from runtime.core.kernel_abi import Kernels


@dataclass(frozen=True, eq=False, kw_only=True)
class System(Kernels):
    """The kernels of a machine and what describes them."""

    jacobian_rows: Integers  # (nnz,), as the columns: where the values of `jacobian` belong
    jacobian_columns: Integers
    coordinates: int  # n
    constraint_count: int  # m
    switches: int = 0  # s
    rigid: tuple[int, ...] = ()  # switching functions that are gaps of rigid contacts
    sticking: tuple[int, ...] = ()  # switching functions that are slips of frictions that stick
    one_way: tuple[int, ...] = ()  # switching functions that are slips of freewheels
    boundaries: tuple[int, ...] = ()  # of the switching functions, a `Boundary` each; none: open
    table_parts: tuple[int, ...] = ()  # of the switching functions, a `TablePart` each; none: 0
    reaction_rows: int = 0
    power_rows: int = 0
    # of the first of these rows, the powers that change kinetic and potential energy; -1: not all
    # of these are computed
    balanced_rows: int = -1
    powers_of_multipliers: bool = False  # whether any of them depends on multipliers
    # (switching function, row of the force, row of what it may be) of frictions whose pressing
    # force depends on them
    limits: tuple[tuple[int, int, int], ...] = ()
    # (switching function, place in p) of frictions whose stiction force is solved for: in mode 2
    # the kernels exert the force that stands there
    stiction: tuple[tuple[int, int], ...] = ()
    # the same of contacts and frictions whose share of modes 0 and 1 the kernels take in mode 2
    shares: tuple[tuple[int, int], ...] = ()
    # (kind, exponent) of the functions of the position that may peak within a step
    peaks: tuple[tuple[int, float], ...] = ()
    # whether forces that keep functions at zero add up: no friction follows from them
    superposes: bool = True
    linear_reactions: bool = True  # in multipliers: no friction follows from them
    # constraints of which none follows from others everywhere; None: all
    independent: tuple[int, ...] | None = None
    turning: tuple[int, ...] = ()  # of bodies in space, the first of four Euler parameters
    states: tuple[int, ...] = ()  # velocities that are states of first order
    sampled: tuple[int, ...] = ()  # velocities that a clock renews
    sampled_names: tuple[str, ...] = ()
    # of each of them the condition that renews it, -1: a clock
    triggers: tuple[int, ...] = ()
    # conditions that are watched; 1: one ends the run; 2: joints come or go there
    watches: tuple[int, ...] = ()
    controllers: tuple[int, ...] = ()  # numbers of those among them that a run brings
    loops: int = 0  # that the kernels close in closed form, on one branch: those of `dead_centres`

    @property
    def rank(self) -> int:
        """Number of independent constraints."""
        return self.constraint_count if self.independent is None else len(self.independent)
