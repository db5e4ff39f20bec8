"""The search for a singular position near a motion.

The position is the root of well-conditioned equations, although Φ_q is singular there: the values
of the strong constraints, and all entries of the Schur complement that their elimination leaves of
the weak ones, uᵀ Φ_q in the null directions with u the row combinations that are lost.
(Lyapunov-Schmidt reduction: M. Golubitsky and D. G. Schaeffer, Singularities and Groups in
Bifurcation Theory I, 1985, chapter VII.)
"""

from typing import Any, NamedTuple

import numpy as np

from runtime.core.array_types import Matrix, Vector
from runtime.singularity.motion_polynomial import Motion, nearest_time
from runtime.singularity.pivot_order_reuse import PivotOrder, PivotOrders
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.search_function_table import set_units, unit_jacobian_entries

_PASSES = 3  # safety: searches, each from the position of the last one


class Root(NamedTuple):
    """A singular position, its left and null vectors, of dense ones orthonormal, and its gap."""

    z: Vector  # (q / scale, t speed)
    left: Matrix | Any  # (m', weak); of a large machine sparse, of unit columns, as `null`
    null: Matrix | Any  # (n + 1, free)
    gap: float  # the largest |uᵀ Φ|

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the positions around; one null direction is time's."""
        return int(self.null.shape[1] - self.left.shape[1] - 1)


class Passage(NamedTuple):
    """How a motion passes a root, lengths scaled."""

    veer: Vector  # rate along the nearest branch less that of the motion, (n,)
    weakest: float  # how fast the smallest singular value passes through zero
    direction: Vector  # the null direction that is lost most slowly, (n,)
    lost: int  # number of constraints lost
    shares: Vector  # of each constraint in the left vectors, (m',)


class Search:
    """A search for singular positions near a motion, lengths scaled, time in units of 1 / speed."""

    def __init__(
        self, constraints: ScaledConstraints, orders: PivotOrders, motion: Motion, speed: float
    ) -> None:
        self.constraints, self.orders = constraints, orders
        self.motion, self.speed = motion, speed
        self.path = motion.scaled(constraints.scale, speed)
        self.table, self.arrays = constraints.layout
        set_units(self.table, speed, self.path.position)

    def count_weak(self, s: float) -> int:
        """How many constraints may be lost close to the position after the time s."""
        return self._order(self.path.at(s)[0]).weak

    def find(self, s: float, weak: int) -> tuple[Root, float] | None:
        """The position near the time s where `weak` constraints are lost, and when it is passed."""
        found = None
        for _ in range(_PASSES):
            z = self.path.at(s)[0]
            found = self._root(z, self._order(z), weak)
            if found is None:
                return None
            before, s = s, nearest_time(self.path.series, s, found.z)
            # With one freedom the position is one point, wherever the search for it began.
            if found.freedom <= 1 or abs(s - before) * self.speed < 1e-6:
                break
        return (found, s) if found is not None else None

    def passage(self, root: Root, rate: Vector) -> Passage:
        """How a motion at the rate dz/ds, (n + 1,), passes a root."""
        # Loaded where something is singular.
        from runtime.singularity.nearest_branch import find_branch

        weak, free = root.left.shape[1], root.null.shape[1]
        passing, x = np.empty((weak, free)), np.empty(free)  # of the complement; towards the branch
        find_branch(self.table, root.z, rate, root.left, root.null, passing, x)
        _, rates, right = np.linalg.svd(passing)
        count = len(rates)
        direction = (root.null @ right[count - 1])[:-1]
        shares: Vector = np.linalg.norm(root.left, axis=1)
        return Passage((root.null @ x)[:-1], float(rates[-1]), direction, count, shares)

    def _order(self, z: Vector) -> PivotOrder:
        entries = np.empty(self.constraints.places[0].size)
        unit_jacobian_entries(self.table, z, entries)
        return self.orders.near(entries)

    def _root(self, z: Vector, order: PivotOrder, weak: int) -> Root | None:
        """A position near z at which `weak` constraints are lost, or None."""
        # Loaded where something is singular.
        from runtime.singularity.gauss_newton import find_root

        arrays = self.arrays
        rows, wide = order.row_order.size, order.column_order.size
        arrays["row_order"][:], arrays["column_order"][:] = order.row_order, order.column_order
        arrays["row_place"][order.row_order] = np.arange(rows)
        arrays["column_place"][order.column_order] = np.arange(wide)
        free = wide - rows + weak
        left, null = np.empty((rows, weak)), np.empty((wide, free))
        gap = find_root(self.table, z, left, null)
        return Root(z, left, null, float(gap)) if gap >= 0.0 else None
