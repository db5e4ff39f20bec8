"""The search for a singular position near a motion of a large machine, without dense matrices.

The equations are those of `singular_root_search`: values of the strong rows, and all entries of the
Schur complement of the weak ones. But the complement, its derivatives and the equations of a step
are sparse, so that a search takes time and memory in proportion to the number of coordinates where
constraints are lost here and there. (P. Deuflhard, Newton Methods for Nonlinear Problems, 4.3.)
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu, spsolve_triangular

from runtime.core.array_types import Vector
from runtime.singularity.motion_polynomial import Motion
from runtime.singularity.pivot_order_reuse import PivotOrder, PivotOrders
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.singular_root_search import Passage, Root, Search
from runtime.singularity.sparse_branch import nearest_passage
from runtime.singularity.sparse_complement import Complement, Order, SparseJacobian
from runtime.singularity.sparse_forms import differentiate, entries_at

_ITERATIONS = 40  # safety: Newton iterations
_KEEP = 5  # measured: iterations with the same second derivatives, but for the first one's
_CONVERGED = 1e-12  # accuracy: a step over 1 + |z| that is the last
_FAR = 0.5  # safety: of a coordinate's size: a root so far from where the search began is another
_FLAT = 1e-6  # accuracy: the largest entry of the complement at a singular position
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing


class SparseSearch(Search):
    """A search for singular positions near a motion of a large machine; roots are sparse."""

    def __init__(
        self, constraints: ScaledConstraints, orders: PivotOrders, motion: Motion, speed: float
    ) -> None:
        super().__init__(constraints, orders, motion, speed)
        self.jacobian = SparseJacobian(constraints)

    def passage(self, root: Root, rate: Vector) -> Passage:
        """How a motion at the rate dz/ds, (n + 1,), passes a root."""
        return nearest_passage(self.jacobian, root, rate)

    def _root(self, z: Vector, order: PivotOrder, weak: int) -> Root | None:
        """A position near z at which `weak` constraints are lost, or None."""
        places, origin = Order(order.row_order, order.column_order, order.row_order.size), z.copy()
        flatten: Callable[[Complement], Vector] | None = None
        for iteration in range(_ITERATIONS):
            left = self.jacobian.eliminate(z, places, weak)
            if left is None:
                return None
            if iteration % _KEEP == 0 or iteration == 1:
                flatten = _flattener(self.jacobian, z, left)
            if flatten is None:
                return None
            step = left.step + left.null @ flatten(left)
            z = z - step
            moved = float(np.linalg.norm(step))
            if not (moved < np.inf and float(np.abs(z - origin).max()) < _FAR):
                return None
            if moved < _CONVERGED * (1.0 + float(np.linalg.norm(z))):
                break
        left = self.jacobian.eliminate(z, places, weak)
        if left is None or not abs(left.between).max() <= _FLAT:
            return None
        return Root(z, left.left, left.null, largest_lost_gap(left))


def _flattener(
    jacobian: SparseJacobian, z: Vector, at: Complement
) -> Callable[[Complement], Vector] | None:
    """The step in null vectors, (free,), that takes a complement to zero, by derivatives at z."""
    forms = differentiate(jacobian, z, at.left, at.null)
    normal = (forms.slopes.T @ forms.slopes).tocsc()
    largest = float(normal.diagonal().max(initial=0.0))
    if not 0.0 < largest < np.inf:
        return None
    factors = splu((normal + _REGULAR * largest * (at.null.T @ at.null)).tocsc(), **_symmetric())

    def flatten(left: Complement) -> Vector:
        missed = entries_at(left.between, forms.left, forms.null)
        x: Vector = factors.solve(forms.slopes.T @ missed)
        return x

    return flatten


def _symmetric() -> dict[str, Any]:
    """SuperLU's options for a positive definite matrix."""
    options = {"SymmetricMode": True}
    return {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": options}


def largest_lost_gap(left: Complement) -> float:
    """Largest |uᵀ Φ| of orthonormal left vectors u, by the Cholesky factor of their products."""
    factors = splu((left.left.T @ left.left).tocsc(), **_symmetric())
    lost = np.empty_like(left.lost)
    lost[factors.perm_r] = left.lost
    reduced = spsolve_triangular(factors.L.tocsr(), lost, lower=True)
    return float(np.abs(reduced / np.sqrt(factors.U.diagonal())).max(initial=0.0))
