"""Gauss-Newton iteration for a singular position, in compiled code.

The unknown is z. The equations are the values of the strong rows and all entries of the Schur
complement of the weak ones, which vanish together (see `singular_root_search`). (P. Deuflhard,
Newton Methods for Nonlinear Problems, section 4.3.)
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, f8, integers, matrix, vector
from runtime.core.jit import allocating
from runtime.linalg.cholesky import orthonormalise, solve_cholesky
from runtime.linalg.leading_block import complete_solution
from runtime.linalg.vectors import copy_vector
from runtime.singularity import schur_complement as schur
from runtime.singularity import search_function_table as st
from runtime.singularity.nearest_branch import factor_normal_equations

_ITERATIONS = 40  # safety: Newton iterations
_KEEP = 5  # measured: iterations with the same second derivatives, but for the first one's
_CONVERGED = 1e-12  # accuracy: a step over 1 + |z| that is the last
_FAR = 0.5  # safety: of a coordinate's size: a root so far from where the search began is another
_FLAT = 1e-6  # accuracy: the largest entry of the complement at a singular position


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
    for iteration in range(_ITERATIONS):
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
