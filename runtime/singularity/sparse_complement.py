"""Sparse Schur complement of the Jacobian of a large machine, with left vectors and null vectors.

As `schur_complement`, but nothing is a dense matrix: strong rows are eliminated in an order of few
fill-ins, and bases of the left vectors and null vectors follow whose vectors are local where a
machine loses constraints here and there. They are of unit length, but not orthogonal: what depends
on that takes their Gram matrices. (T. A. Davis, Direct Methods for Sparse Linear Systems, 2006,
chapters 3 and 6.)

How many constraints of a large machine are weak, from its sparse Schur complement.

Its singular values σ between orthonormal left and null vectors are counted, not computed: of the
matrix [[s UᵀU, G], [Gᵀ, s NᵀN]] as many eigenvalues are negative as there are σ > s, and of its
factors as many pivots. (Sylvester's law of inertia: B. N. Parlett, The Symmetric Eigenvalue
Problem, 1998, section 3.3.)
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, diags_array, identity, vstack
from scipy.sparse.linalg import splu

from runtime.core import arrays
from runtime.core.arrays import Integers, Vector, i8, integers, none, tuple_type, vector
from runtime.core.jit import allocating, compiled
from runtime.linalg.least_norm import bordered_matrix
from runtime.linalg.rank_policy import NO_DIVISOR
from runtime.linalg.sparse_elimination import (
    SparseRows,
    by_rows,
    complete_sparsely,
    eliminate_in_order,
    order_sparsely,
)
from runtime.singularity import search_function_table as st
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import STRONG, PivotOrder, PivotOrders, count_weak

_ROWS = arrays.named_tuple_type((integers, integers, vector), SparseRows)


class Order(NamedTuple):
    """Rows, (m',), and columns, (n + 1,), in the order of pivots; how many pivots there are."""

    rows: Integers
    columns: Integers
    pivots: int


class Complement(NamedTuple):
    """What the elimination of the strong rows leaves at a position z."""

    left: Any  # (m', weak), sparse by rows, of unit columns; as `null`
    null: Any  # (n + 1, free)
    between: Any  # uᵀ Φ_z N, (weak, free), sparse by rows
    lost: Vector  # uᵀ Φ, (weak,)
    step: Vector  # a step that brings the strong rows to zero, (n + 1,)


@allocating(tuple_type((i8, integers, integers))(integers, integers, vector, i8, i8, arrays.f8))
def _order(
    rows: Integers, columns: Integers, values: Vector, m: int, n: int, least: float
) -> tuple[int, Integers, Integers]:
    """Count and order of the pivots above `least` of the matrix (m, n) with these entries."""
    row_order, column_order = np.empty(m, np.int64), np.empty(n, np.int64)
    matrix = by_rows(rows, columns, values, m)
    count = order_sparsely(matrix, n, least, row_order, column_order)
    return count, row_order, column_order


@allocating(
    tuple_type((i8, _ROWS, _ROWS, _ROWS))(
        integers, integers, vector, tuple_type((i8, i8)), i8, vector, vector
    )
)
def _eliminate(
    rows: Integers, columns: Integers, values: Vector, shape: tuple[int, int], strong: int,
    right: Vector, x: Vector,
) -> tuple[int, SparseRows, SparseRows, SparseRows]:  # fmt: skip
    """Eliminate the strong rows of a matrix whose rows and columns stand in the order of pivots.

    Returns whether no pivot vanishes, the first rows of the null and of the left vectors, and U
    with the complement. `right`, (m,), is eliminated, and `x`, (strong,), solves for it.
    """
    m, n = shape
    upper = eliminate_in_order(by_rows(rows, columns, values, m), n, strong, right, NO_DIVISOR)
    for s in range(strong):
        if not abs(upper.values[upper.starts[s]]) > NO_DIVISOR:
            return 0, upper, upper, upper
    for s in range(strong - 1, -1, -1):
        x[s] = right[s]
        for e in range(upper.starts[s] + 1, upper.starts[s + 1]):
            if upper.columns[e] < strong:
                x[s] -= upper.values[e] * x[upper.columns[e]]
        x[s] /= upper.values[upper.starts[s]]
    across = by_rows(columns, rows, values, n)
    lower = eliminate_in_order(across, m, strong, np.zeros(n), NO_DIVISOR)
    return 1, complete_sparsely(upper, n, strong), complete_sparsely(lower, m, strong), upper


@compiled(none(integers, vector, vector))
def unit_values(search: Integers, z: Vector, residuals: Vector) -> None:
    """Fill `residuals`, (rows,), with Φ at z over the rows' lengths."""
    st.unit_residuals(search, z, residuals)


class SparseJacobian:
    """The Jacobian by scaled coordinates and time of a machine, its rows of unit length."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        # The table holds addresses of arrays that live as long as the constraints.
        self.constraints, self.table = constraints, constraints.layout.table
        rows, columns = constraints.places
        self.shape = constraints.independent.size, constraints.scale.size + 1
        self.kept = np.flatnonzero(rows < self.shape[0])  # the other rows follow from these
        self.rows, self.columns = (np.ascontiguousarray(a[self.kept]) for a in (rows, columns))
        self.count = rows.size

    def entries(self, z: Vector) -> Vector:
        """Its entries at z, at `rows` and `columns`."""
        out = np.empty(self.count)
        st.unit_jacobian_entries(self.table, z, out)
        kept: Vector = out[self.kept]
        return kept

    def gaps(self, z: Vector) -> Vector:
        """The unit rows' values at z, (m',)."""
        out = np.empty(self.shape[0])
        unit_values(self.table, z, out)
        return out

    def matrix(self, values: Vector) -> Any:
        """The sparse matrix, (m', n + 1), with these values at `rows` and `columns`."""
        filled = np.flatnonzero(values)
        where = self.rows[filled], self.columns[filled]
        return csr_array((values[filled], where), shape=self.shape)

    def order(self, values: Vector, least: float) -> Order:
        """The order of its pivots above `least`, by size to a factor, and so few fill-ins."""
        filled = np.flatnonzero(values)
        places = self.rows[filled], self.columns[filled]
        count, rows, columns = _order(*places, values[filled], *self.shape, least)
        return Order(rows, columns, count)

    def eliminate(self, z: Vector, order: Order, weak: int) -> Complement | None:
        """What is left at z of the last `weak` rows of an order; None where a pivot vanishes."""
        return self.reduce(self.entries(z), self.gaps(z), order, weak)

    def reduce(self, values: Vector, gaps: Vector, order: Order, weak: int) -> Complement | None:
        """As `eliminate`, of these entries of the Jacobian and values of its rows, (m',)."""
        m, n = self.shape
        filled, strong = np.flatnonzero(values), m - weak
        row_place, column_place = np.empty(m, np.int64), np.empty(n, np.int64)
        row_place[order.rows], column_place[order.columns] = np.arange(m), np.arange(n)
        right, x = gaps[order.rows], np.zeros(strong)
        places = row_place[self.rows[filled]], column_place[self.columns[filled]]
        found = _eliminate(*places, values[filled], (m, n), strong, right, x)
        if not found[0]:
            return None
        null, null_lengths = _basis(found[1], n - strong, column_place)
        left, left_lengths = _basis(found[2], weak, row_place)
        behind, first = found[3], found[3].starts[strong]
        parts = behind.values[first:], behind.columns[first:] - strong
        between = csr_array((*parts, behind.starts[strong:] - first), shape=(weak, n - strong))
        between = diags_array(1.0 / left_lengths) @ between @ diags_array(1.0 / null_lengths)
        step = np.zeros(n)
        step[order.columns[:strong]] = x
        return Complement(left, null, between.tocsr(), right[strong:] / left_lengths, step)


def _basis(first: SparseRows, count: int, place: Integers) -> tuple[Any, Vector]:
    """The vectors [W; I] with these first rows, in units of their lengths, and the lengths."""
    parts = first.values, first.columns, first.starts
    block = csr_array(parts, shape=(len(first.starts) - 1, count))
    lengths: Vector = np.sqrt(1.0 + block.multiply(block).sum(axis=0))
    whole = vstack([block, identity(count, format="csr")], format="csr")[place]
    return (whole @ diags_array(1.0 / lengths)).tocsr(), lengths


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
