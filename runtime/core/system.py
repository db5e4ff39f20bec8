"""The compiled equations that the integrator needs, and their sizes."""

from dataclasses import dataclass

from runtime.core.array_types import Integers
from runtime.core.kernel_abi import Kernels


@dataclass(frozen=True, eq=False, kw_only=True)
class System(Kernels):
    """The kernels of a machine and what describes them.

    Attributes
    ----------
    jacobian_rows, jacobian_columns : (nnz,) int64
        Where the values that `jacobian` writes belong.
    coordinates, constraint_count, switches
        n, m and s.
    independent
        Constraints of which none follows from others everywhere; None: all.
    rigid, sticking
        Switching functions that are gaps of rigid contacts, and slips of frictions that stick.
    reaction_rows
        How many reactions there are.
    limits
        (switching function, row of the force, row of what it may be) of frictions whose pressing
        force depends on them.
    stiction
        (switching function, place in p) of frictions whose stiction force is solved for: in mode 2
        the kernels exert the force that stands there.
    loop_rows
        Loops that the kernels close in closed form, on one branch, in the order of `dead_centres`:
        how each is named as `index` of an outcome, by a number not below `constraint_count`.
    """

    jacobian_rows: Integers
    jacobian_columns: Integers
    coordinates: int
    constraint_count: int
    switches: int = 0
    rigid: tuple[int, ...] = ()
    sticking: tuple[int, ...] = ()
    reaction_rows: int = 0
    limits: tuple[tuple[int, int, int], ...] = ()
    stiction: tuple[tuple[int, int], ...] = ()
    independent: tuple[int, ...] | None = None
    loop_rows: tuple[int, ...] = ()

    @property
    def rank(self) -> int:
        """Number of independent constraints."""
        return self.constraint_count if self.independent is None else len(self.independent)
