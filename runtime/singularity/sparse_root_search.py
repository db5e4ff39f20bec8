"""The search for a singular position near a motion of a large machine, without dense matrices.

The equations are those of `singular_root_search`: values of the strong rows, and all entries of the
Schur complement of the weak ones. But the complement, its derivatives and the equations of a step
are sparse, so that a search takes time and memory in proportion to the number of coordinates where
constraints are lost here and there. (P. Deuflhard, Newton Methods for Nonlinear Problems, 4.3.)

Derivative of the sparse Schur complement along null vectors, from few differences.

Null vectors that meet in no constraint share one difference of Jacobians: of each constraint it is
that of the vector which enters the constraint. So it takes as many differences as vectors meet in a
constraint, however many there are. (A. R. Curtis, M. J. D. Powell and J. K. Reid, On the Estimation
of Sparse Jacobian Matrices, Journal of the Institute of Mathematics and its Applications 13, 1974.)

The branch nearest to a motion at a singular position of a large machine, and how it is passed.

As `singular_root_search`, in null vectors N that are sparse and not orthogonal:
the least step δ with S δ = r, least in |N δ|, solves (NᵀN, Sᵀ; S, 0) (δ; μ) = (0; r), which is
sparse too. (Å. Björck, Numerical Methods for Least Squares Problems, 1996, section 2.7.)
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array, vstack
from scipy.sparse.linalg import splu, spsolve_triangular

from runtime.core.arrays import Integers, Vector
from runtime.linalg.least_norm import bordered_matrix
from runtime.singularity.motion_polynomial import Motion
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import PivotOrder, PivotOrders
from runtime.singularity.singular_root_search import Passage, Root, Search
from runtime.singularity.sparse_complement import Complement, Order, SparseJacobian

_DIFFERENCE = 6e-6  # accuracy: EPS ** (1/3), the relative size of a central difference
_ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: a step over a direction's length, or 1 + |z|, that is the last
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing
_INVERSE = 300  # safety: steps of inverse iteration
_SETTLED = 1e-8  # accuracy: relative change of the squared singular value at the last one
_COLUMNS = 64  # layout: right sides that are solved for at once
_KEEP = 5  # measured: iterations with the same second derivatives, except after the first
_FAR = 0.5  # safety: of a coordinate's size: a root so far from where the search began is another
_FLAT = 1e-6  # accuracy: the largest entry of the complement at a singular position


class Forms(NamedTuple):
    """Derivatives of entries of uᵀ Φ_z N along the null vectors: those that are not all zero."""

    left: Integers  # (k,): which left vector u and null vector N the entry belongs to
    null: Integers
    slopes: Any  # (k, free), sparse by rows


def difference(jacobian: SparseJacobian, z: Vector, direction: Vector) -> Vector:
    """The derivative along a direction, (n + 1,), of the entries of the Jacobian at z."""
    delta = _DIFFERENCE / max(float(np.abs(direction).max()), 1e-300)
    ahead = jacobian.entries(z + delta * direction)
    slopes: Vector = (ahead - jacobian.entries(z - delta * direction)) / (2.0 * delta)
    return slopes


def group(touched: Any) -> Integers:
    """Groups, (free,), of the columns of a sparse pattern; no row has two columns of a group."""
    by_column, by_row = touched.tocsc(), touched.tocsr()
    found = np.full(by_column.shape[1], -1)
    for f in range(found.size):
        rows = by_column.indices[by_column.indptr[f] : by_column.indptr[f + 1]]
        near = [by_row.indices[by_row.indptr[i] : by_row.indptr[i + 1]] for i in rows]
        taken = set(found[np.concatenate(near)].tolist()) if near else set()
        found[f] = next(k for k in range(found.size + 1) if k not in taken)
    return found


def _touched(jacobian: SparseJacobian, left: Any, null: Any) -> Any:
    """Which null vectors enter which of the constraints that the left vectors have; a pattern."""
    ones = np.ones(jacobian.rows.size)
    structure = csr_array((ones, (jacobian.rows, jacobian.columns)), shape=jacobian.shape)
    in_left = np.diff(left.indptr) > 0
    structure = structure.multiply(in_left[:, None]).tocsr()
    structure.eliminate_zeros()
    return (structure @ abs(null)).tocsr()


def differentiate(jacobian: SparseJacobian, z: Vector, left: Any, null: Any) -> Forms:
    """The forms at z between left vectors, (m', weak), and null vectors, (n + 1, free)."""
    m, free = jacobian.shape[0], null.shape[1]
    touched = _touched(jacobian, left, null)
    groups, of_null = group(touched), null.tocsc()
    entry = touched.tocoo()
    by_left, blocks = left.tocoo(), []
    keys, places, shares = [], [], []
    for k in range(int(groups.max(initial=-1)) + 1):
        members = groups == k
        slopes = difference(jacobian, z, of_null @ members.astype(float))
        blocks.append(jacobian.matrix(slopes) @ null)
        owner, mine = np.full(m, -1), members[entry.col]
        owner[entry.row[mine]] = entry.col[mine]
        owned = owner[by_left.row] >= 0
        rows, columns = by_left.row[owned], by_left.col[owned].astype(np.int64)
        keys.append(columns * free + owner[rows])
        places.append(rows.astype(np.int64) + k * m)
        shares.append(by_left.data[owned])
    if not blocks:
        nothing = np.zeros(0, np.int64)
        return Forms(nothing, nothing, csr_array((0, free)))
    pairs, number = np.unique(np.concatenate(keys), return_inverse=True)
    where = number, np.concatenate(places)
    sums = coo_array((np.concatenate(shares), where), shape=(pairs.size, m * len(blocks)))
    slopes = (sums.tocsr() @ vstack(blocks, format="csr")).tocsr()
    return Forms(pairs // free, pairs % free, slopes)


def entries_at(matrix: Any, rows: Integers, columns: Integers) -> Vector:
    """Entries of a sparse matrix by rows at the places in rising order, (k,)."""
    found = matrix.tocoo()
    width = matrix.shape[1]
    keys, wanted = found.row.astype(np.int64) * width + found.col, rows * width + columns
    at = np.searchsorted(wanted, keys)
    out = np.zeros(wanted.size)
    inside = at < wanted.size
    inside[inside] = wanted[at[inside]] == keys[inside]
    out[at[inside]] = found.data[inside]
    return out


def nearest_passage(jacobian: SparseJacobian, root: Root, rate: Vector, most: int) -> Passage:
    """How a motion at the rate dz/ds, (n + 1,), passes a root, and the branch nearest to it."""
    left: Any = root.left
    null: Any = root.null
    weak, free = left.shape[1], null.shape[1]
    of_left, of_null = (left.T @ left).tocsc(), (null.T @ null).tocsc()
    start = splu(of_null, permc_spec="MMD_AT_PLUS_A").solve(null.T @ rate)
    x, weakest, direction = start, 0.0, np.zeros(free)
    for iteration in range(most):
        slopes = left.T @ jacobian.matrix(difference(jacobian, root.z, null @ x)) @ null
        largest = float(slopes.multiply(slopes).sum(axis=1).max()) or 1.0
        whole = bordered_matrix(of_null, slopes, -_REGULAR * largest * of_left)
        factors = splu(whole, permc_spec="MMD_AT_PLUS_A")
        if iteration == 0:
            weakest, direction = _least_singular_value(factors, of_left, of_null)
        step = factors.solve(np.concatenate([np.zeros(free), -0.5 * (slopes @ x)]))[:free]
        x = x + step
        if not step @ (of_null @ step) >= _CONVERGED**2 * (x @ (of_null @ x)):
            break
    along = null @ direction
    veer: Vector = (null @ (x - start))[:-1]
    return Passage(veer, weakest, along[:-1], weak, shares(left, of_left))


def _least_singular_value(factors: Any, of_left: Any, of_null: Any) -> tuple[float, Vector]:
    """The least singular value between orthonormal vectors, and its right vector, (free,)."""
    weak, free = of_left.shape[0], of_null.shape[0]
    u = np.random.default_rng(0).normal(size=weak)
    square, x = np.inf, np.zeros(free)
    for _ in range(_INVERSE):
        right = of_left @ u
        both = factors.solve(np.concatenate([np.zeros(free), right / np.sqrt(u @ right)]))
        x, u = both[:free], both[free:]
        before, square = square, float(x @ (of_null @ x)) / float(u @ (of_left @ u))
        if abs(square - before) <= _SETTLED * square:
            break
    return float(np.sqrt(square)), x


def shares(left: Any, of_left: Any) -> Vector:
    """Lengths of the rows, (m',), of the left vectors made orthonormal; `of_left` their products.

    Raises RuntimeError where they depend on each other.
    """
    found, factors = np.zeros(left.shape[0]), splu(of_left, permc_spec="MMD_AT_PLUS_A")
    filled = np.flatnonzero(np.diff(left.indptr))
    for k in range(0, filled.size, _COLUMNS):
        rows = left[filled[k : k + _COLUMNS]]
        solved = factors.solve(rows.T.toarray())
        found[filled[k : k + _COLUMNS]] = np.sqrt(np.asarray(rows.multiply(solved.T).sum(axis=1)))
    return found


class SparseSearch(Search):
    """A search for singular positions near a motion of a large machine; roots are sparse."""

    def __init__(
        self, constraints: ScaledConstraints, orders: PivotOrders, motion: Motion, speed: float
    ) -> None:
        super().__init__(constraints, orders, motion, speed)
        self.jacobian = SparseJacobian(constraints)

    def passage(self, root: Root, rate: Vector, most: int) -> Passage:
        """How a motion at the rate dz/ds, (n + 1,), passes a root; `most`: as of `find_branch`."""
        return nearest_passage(self.jacobian, root, rate, most)

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
