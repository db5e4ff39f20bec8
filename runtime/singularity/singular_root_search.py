"""The search for a singular position near a motion.

The position is the root of well-conditioned equations, although Φ_q is singular there: the values
of the strong constraints, and all entries of the Schur complement that their elimination leaves of
the weak ones, uᵀ Φ_q in the null directions with u the row combinations that are lost.
(Lyapunov-Schmidt reduction: M. Golubitsky and D. G. Schaeffer, Singularities and Groups in
Bifurcation Theory I, 1985, chapter VII.)

Derivative of the Schur complement, and the branch nearest to a motion, in compiled code.

In a direction d it is uᵀ J'(d) z between the left vectors u and the null vectors z (see
`schur_complement`); J'(d) is the central difference of two Jacobians.

Gauss-Newton iteration for a singular position, in compiled code.

The unknown is z. The equations are the values of the strong rows and all entries of the Schur
complement of the weak ones, which vanish together (see `singular_root_search`). (P. Deuflhard,
Newton Methods for Nonlinear Problems, section 4.3.)
"""

from typing import Any, NamedTuple

import numpy as np

from runtime.core.arrays import Integers, Matrix, Vector, f8, i8, integers, matrix, vector, view
from runtime.core.jit import allocating, inner
from runtime.linalg.leading_block import complete_solution
from runtime.linalg.orthogonal_factors import (
    factor_cholesky,
    multiply_gram,
    orthonormalise,
    solve_cholesky,
)
from runtime.linalg.vectors import copy_vector, dot, multiply
from runtime.singularity import schur_complement as schur
from runtime.singularity import search_function_table as st
from runtime.singularity.motion_polynomial import Motion, nearest_time
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import PivotOrder, PivotOrders
from runtime.singularity.search_function_table import set_units, unit_jacobian_entries

ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: a step over a direction's length, or 1 + |z|, that is the last
_DIFFERENCE = 6e-6  # accuracy: EPS ** (1/3), the relative size of a central difference
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing
_KEEP = 5  # measured: iterations with the same second derivatives, except after the first
_FAR = 0.5  # safety: of a coordinate's size: a root so far from where the search began is another
_FLAT = 1e-6  # accuracy: the largest entry of the complement at a singular position
_PASSES = 3  # safety: searches, each from the position of the last one


@inner
def differentiate_complement(
    search: Integers, z: Vector, left: Matrix, null: Matrix, row: int, out: Matrix
) -> None:
    """Differentiate the complement at z along the direction in `step`: uᵀ J'(step) N.

    Out is (k, free) of as many left vectors u as divide k: theirs are row `row`, and the rows at
    equal distances behind it.
    """
    (wide, free), (rows, weak) = null.shape, left.shape
    ahead, behind = st.ahead_of(search), st.behind_of(search)
    at_row, at_column = st.entry_rows_of(search), st.entry_columns_of(search)
    lengths, displaced, sums = st.lengths_of(search), st.displaced_of(search), st.sums_of(search)
    direction = st.step_of(search)
    delta = _DIFFERENCE / max(np.sqrt(dot(direction, direction)), 1e-300)
    for sign, entries in ((1.0, ahead), (-1.0, behind)):
        for j in range(wide):
            displaced[j] = z[j] + sign * delta * direction[j]
        st.jacobian_entries(search, displaced, entries)
    sums[:] = 0.0
    for e in range(ahead.size):
        i, j = at_row[e], at_column[e]
        if i < rows and ahead[e] != behind[e]:
            slope = (ahead[e] - behind[e]) / (2.0 * delta * lengths[i])
            for w in range(weak):
                sums[j * weak + w] += slope * left[i, w]
    apart = out.shape[0] // weak
    for w in range(weak):
        for f in range(free):
            out[row + w * apart, f] = 0.0
        for j in range(wide):
            if sums[j * weak + w] != 0.0:
                for f in range(free):
                    out[row + w * apart, f] += sums[j * weak + w] * null[j, f]


@inner
def factor_normal_equations(
    search: Integers, z: Vector, left: Matrix, null: Matrix, form: Matrix, normal: Matrix
) -> bool:
    """Fill `form`, (weak free, free), with the complement's derivatives, and factor formᵀ form.

    The factor is `normal`. Directions that the derivatives do not determine are kept short in z.
    Returns whether there are any derivatives.
    """
    wide, free = null.shape
    direction = st.step_of(search)
    for g in range(free):
        copy_vector(null[:, g], direction)
        differentiate_complement(search, z, left, null, g, form)
    multiply_gram(form, normal)
    largest = 0.0
    for f in range(free):
        largest = max(largest, normal[f, f])
    if not largest > 0.0:
        return False
    for j in range(wide):
        for i in range(free):
            if null[j, i] != 0.0:
                for k in range(i + 1):
                    normal[i, k] += _REGULAR * largest * null[j, i] * null[j, k]
    return factor_cholesky(normal)


@inner
def newton_step(slopes: Matrix, square: Matrix, missed: Vector, x: Vector) -> float:
    """Take Newton's step of least norm to a root of xᵀ form x; its length over that of x.

    `slopes` is form x, (weak, free), the forms being symmetric.
    """
    weak, free = slopes.shape
    multiply(slopes, x, missed)
    multiply_gram(slopes.T, square)
    largest = 0.0
    for w in range(weak):
        largest = max(largest, square[w, w])
    for w in range(weak):
        square[w, w] += _REGULAR * largest
    if not factor_cholesky(square):
        return 0.0
    solve_cholesky(square, missed)
    moved, size = 0.0, 0.0
    for f in range(free):
        step = 0.0
        for w in range(weak):
            step -= 0.5 * slopes[w, f] * missed[w]
        x[f] += step
        moved += step * step
        size += x[f] * x[f]
    return float(np.sqrt(moved / max(size, 1e-300)))


@allocating(i8(integers, vector, vector, matrix, matrix, matrix, vector, i8))
def find_branch(
    search: Integers, z: Vector, rate: Vector, left: Matrix, null: Matrix, passing: Matrix,
    x: Vector, most: int,
) -> int:  # fmt: skip
    """Direction of the branch nearest to a motion, in a singular position; returns the iterations.

    Branches have directions N x with uᵀ J'(N x) N x = 0 for all left vectors u. Newton's method
    with steps of least norm starts from the direction of the motion. `z` is the position and `rate`
    dz/ds of the motion, (n + 1,); `left` (rows, weak) are orthonormal left vectors, `null` (n + 1,
    free) null vectors N. `passing` (weak, free) becomes the rate of the complement along the
    motion; `x` (free,) the branch's direction less that of the motion, in terms of null vectors.
    After `most` iterations, one at least, the direction is what they have come to.
    """
    wide, free = null.shape
    weak = left.shape[1]
    direction, missed = st.step_of(search), view(st.residuals_of(search), 0, weak)
    slopes, square = np.empty((weak, free)), np.empty((weak, weak))
    multiply(null.T, rate, x)
    for iteration in range(most):
        multiply(null, x, direction)
        differentiate_complement(search, z, left, null, 0, slopes)
        if iteration == 0:
            passing[:, :] = slopes
        if newton_step(slopes, square, missed, x) < _CONVERGED:
            break
    for f in range(free):
        for j in range(wide):
            x[f] -= null[j, f] * rate[j]
    return int(iteration + 1)


@allocating(f8(integers, vector, matrix, matrix))
def find_root(search: Integers, z: Vector, left: Matrix, null: Matrix) -> float:
    """Bring z, (n + 1,), to a position in which as many rows are lost as `left` has columns.

    Returns the largest |uᵀ Φ|, or -1 where there is no such position. `left` (rows, weak) and
    `null` (n + 1, free) become the orthonormal left vectors and null vectors there.
    """
    (rows, weak), (wide, free) = left.shape, null.shape
    strong = rows - weak
    order, origin = st.column_order_of(search), st.origin_of(search)
    step, gaps = st.step_of(search), st.residuals_of(search)
    a, x, form = np.empty((rows, wide)), np.empty(free), np.empty((weak * free, free))
    square, normal = np.empty((weak, weak)), np.empty((free, free))
    copy_vector(z, origin)
    for iteration in range(ITERATIONS):
        if not schur.eliminate_strong_rows(search, z, strong, a, gaps):
            return -1.0
        if iteration % _KEEP == 0 or iteration == 1:
            schur.find_vectors(search, a, strong, left, null)
            if not factor_normal_equations(search, z, left, null, form, normal):
                return -1.0
        x[:] = 0.0
        for w in range(weak):
            for g in range(free):
                for f in range(free):
                    x[f] += form[w * free + g, f] * a[strong + w, strong + g]
        solve_cholesky(normal, x)
        for f in range(free):
            step[strong + f] = x[f]
        complete_solution(a, strong, gaps, step)
        moved, size, away = 0.0, 0.0, 0.0
        for s in range(wide):
            j = order[s]
            z[j] -= step[s]
            moved += step[s] ** 2
            size += z[j] ** 2
            away = max(away, abs(z[j] - origin[j]))
        if not (away < _FAR and moved < np.inf):
            return -1.0
        if moved < (_CONVERGED * (1.0 + np.sqrt(size))) ** 2:
            break
    if not schur.eliminate_strong_rows(search, z, strong, a, gaps):
        return -1.0
    schur.find_vectors(search, a, strong, left, null)
    if not schur.normalise_complement(a, strong, left, null, square, normal):
        return -1.0
    for i in range(strong, rows):
        for j in range(strong, wide):
            if not abs(a[i, j]) <= _FLAT:
                return -1.0
    orthonormalise(normal, null)
    orthonormalise(square, left)
    return schur.largest_lost_gap(gaps, strong, square)


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
            before, s = s, nearest_time(self.path.series, s, found.z[:-1])
            # With one freedom the position is one point, wherever the search for it began.
            if found.freedom <= 1 or abs(s - before) * self.speed < 1e-6:
                break
        return (found, s) if found is not None else None

    def passage(self, root: Root, rate: Vector, most: int) -> Passage:
        """How a motion at the rate dz/ds, (n + 1,), passes a root; `most`: as of `find_branch`."""
        weak, free = root.left.shape[1], root.null.shape[1]
        passing, x = np.empty((weak, free)), np.empty(free)  # of the complement; towards the branch
        find_branch(self.table, root.z, rate, root.left, root.null, passing, x, most)
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
        arrays = self.arrays
        rows, wide = order.row_order.size, order.column_order.size
        arrays["row_order"][:], arrays["column_order"][:] = order.row_order, order.column_order
        arrays["row_place"][order.row_order] = np.arange(rows)
        arrays["column_place"][order.column_order] = np.arange(wide)
        free = wide - rows + weak
        left, null = np.empty((rows, weak)), np.empty((wide, free))
        gap = find_root(self.table, z, left, null)
        return Root(z, left, null, float(gap)) if gap >= 0.0 else None
