"""How many constraints of a large machine are weak, from its sparse Schur complement.

Its singular values σ between orthonormal left and null vectors are counted, not computed: of the
matrix [[s UᵀU, G], [Gᵀ, s NᵀN]] as many eigenvalues are negative as there are σ > s, and of its
factors as many pivots. (Sylvester's law of inertia: B. N. Parlett, The Symmetric Eigenvalue
Problem, 1998, section 3.3.)
"""

import numpy as np
from scipy.sparse.linalg import splu

from runtime.core.array_types import Vector
from runtime.linalg.bordered_matrix import bordered_matrix
from runtime.singularity.pivot_order_reuse import STRONG, PivotOrder, PivotOrders, count_weak
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.sparse_complement import Complement, SparseJacobian

_RATIO = 1.1  # accuracy: to which singular values are known
_LEAST, _LARGEST = 1e-9, 1.0  # accuracy: singular values outside are as good as these


class SparsePivotOrders(PivotOrders):
    """Orders of pivots of the last few Jacobians of a large machine's constraints."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        super().__init__(constraints)
        self.jacobian = SparseJacobian(constraints)

    def _choose(self, entries: Vector) -> PivotOrder:
        """Pivots as far as they are large; singular values of the complement of these."""
        jacobian, rows = self.jacobian, self.jacobian.shape[0]
        kept = entries[jacobian.kept]
        order, values = jacobian.order(kept, STRONG), np.ones(rows)
        weak = rows - order.pivots
        if weak > 0:
            left = jacobian.reduce(kept, np.zeros(rows), order, weak)
            if left is not None:
                values[order.pivots :] = singular_values(left)[::-1]
            order = jacobian.order(kept, 0.0)
        return PivotOrder(entries, order.rows, order.columns, count_weak(values))


def count_above(left: Complement, level: float) -> int:
    """How many singular values of a complement, between orthonormal vectors, exceed a level."""
    u, n, between = left.left, left.null, left.between
    whole = bordered_matrix(level * (u.T @ u), between.T, level * (n.T @ n))
    options = {"SymmetricMode": True}
    factors = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    return int(np.sum(factors.U.diagonal() < 0.0))


def singular_values(left: Complement) -> Vector:
    """Singular values of a complement in rising order, (weak,), to a tenth, from 1e-9 to 1."""
    weak = left.between.shape[0]
    found = np.full(weak, _LARGEST)

    def search(low: float, high: float, below_low: int, below_high: int) -> None:
        if below_low == below_high:
            return
        middle = float(np.sqrt(low * high))
        if high < _RATIO * low:
            found[below_low:below_high] = middle
            return
        below = weak - count_above(left, middle)
        search(low, middle, below_low, below)
        search(middle, high, below, below_high)

    zeros = weak - count_above(left, _LEAST)
    found[:zeros] = _LEAST
    search(_LEAST, _LARGEST, zeros, weak - count_above(left, _LARGEST))
    return found
