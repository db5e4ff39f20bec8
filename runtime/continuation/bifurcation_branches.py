"""Branches of motion at a branch point of a driven machine.

There the rank of Phi_q falls by k, with the null directions N. The velocity is v_p + N c, and the
missing equations are the solvability conditions of the accelerations: l gamma(v) = 0 with
l Phi_q = 0. They are k quadratic equations in c: with k = 1 two branches, one, or none.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.linalg.rank_policy import LOST, NO_PIVOT
from runtime.mechanism.dense_equations import Equations, FloatArray

SOLVED = 1e-6  # accuracy: |uᵀ ν|, in parts of the speed, below which velocities exist
_REAL = 1e-6  # accuracy: imaginary part of a root that is rounding
# accuracy: difference of equal velocities, or of equal distances, in parts of the speed
_ALIKE = 1e-6
_FLAT = 1e-9  # accuracy: coefficients of the quadratic equations below this are zero
_GRID = 3  # safety: lost rows up to which the search for branches starts from a grid
_ITERATIONS = 60  # safety: Newton iterations from each start of that search


class Branch(NamedTuple):
    """One motion: velocity, acceleration without its part in N, distance from the preferred one.

    `v` and `a` have shape (n,); `far` is in scaled coordinates, 1/s.
    """

    v: FloatArray
    a: FloatArray
    far: float


class RankDeficiency(NamedTuple):
    """Phi_q with unit rows, scaled columns, and its singular vectors; `k` values are lost.

    Rows that follow from others everywhere are left out; m is the number of the others, whose
    indices are `rows`. `left` has shape (m, k), `null` (n, k), `inverse` (n, m), `lengths` (m,).
    """

    rows: npt.NDArray[np.int64]
    matrix: FloatArray
    lengths: FloatArray
    values: FloatArray
    left: FloatArray
    null: FloatArray
    inverse: FloatArray

    @property
    def k(self) -> int:
        """Rank deficiency."""
        return int(self.left.shape[1])


def rank_deficiency(
    equations: Equations, t: float, q: FloatArray, scale: FloatArray, least: int = 0
) -> RankDeficiency:
    """Singular vectors of Phi_q at q; at least `least` of the smallest values count as lost."""
    rows = equations.independent
    matrix = equations.jacobian(t, q)[rows] * scale
    lengths = np.linalg.norm(matrix, axis=1)
    lengths[lengths == 0.0] = 1.0
    matrix = matrix / lengths[:, None]
    left, values, right = np.linalg.svd(matrix)
    k = max(int((values < LOST).sum()), least)
    kept = len(values) - k
    inverse = right[:kept].T @ (left[:, :kept].T / values[:kept, None])
    return RankDeficiency(rows, matrix, lengths, values, left[:, kept:], right[kept:].T, inverse)


def branches(
    equations: Equations, t: float, q: FloatArray, preferred: FloatArray, scale: FloatArray
) -> list[Branch]:
    """The branches at q, nearest to the preferred velocities first; none where no motion exists."""
    at = rank_deficiency(equations, t, q, scale)
    if at.k == 0 or at.left.shape[0] != at.null.shape[0]:
        return []
    nu = equations.velocity_rhs(t, q)[at.rows] / at.lengths
    base = preferred / scale
    base = base - at.inverse @ (at.matrix @ base - nu)
    speed = max(float(np.abs(base).max()), 1e-300)
    if float(np.abs(at.left.T @ nu).max()) > SOLVED * speed:
        return []

    def velocity(c: FloatArray) -> FloatArray:
        v: FloatArray = (base + speed * (at.null @ c)) * scale
        return v

    def lack(c: FloatArray) -> FloatArray:
        gamma = equations.acceleration_rhs(t, q, velocity(c))[at.rows] / at.lengths
        missing: FloatArray = at.left.T @ gamma / speed**2
        return missing

    found = []
    for c in _roots(*_quadratic(lack, at.k)):
        v = velocity(c)
        gamma = equations.acceleration_rhs(t, q, v)[at.rows] / at.lengths
        far = speed * float(np.linalg.norm(c))
        found.append(Branch(v, (at.inverse @ gamma) * scale, far))
    return sorted(found, key=lambda branch: branch.far)


def ambiguous(found: list[Branch], scale: FloatArray) -> bool:
    """Whether the nearest two are equally near."""
    if len(found) < 2:
        return False
    speed = max(float(np.abs(branch.v / scale).max()) for branch in found[:2])
    return found[1].far - found[0].far <= _ALIKE * speed


def _quadratic(lack, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:  # type: ignore[no-untyped-def]
    """`lack` as constant + slope c + c square c; shapes (k,), (k, k), (k, k, k)."""
    unit = np.eye(k)
    constant = lack(np.zeros(k))
    slope, square = np.zeros((k, k)), np.zeros((k, k, k))
    for i in range(k):
        ahead, behind = lack(unit[i]), lack(-unit[i])
        slope[:, i] = 0.5 * (ahead - behind)
        square[:, i, i] = 0.5 * (ahead + behind) - constant
    for i in range(k):
        for j in range(i):
            both = lack(unit[i] + unit[j]) - constant - slope[:, i] - slope[:, j]
            square[:, i, j] = square[:, j, i] = 0.5 * (both - square[:, i, i] - square[:, j, j])
    return constant, slope, square


def _roots(constant: FloatArray, slope: FloatArray, square: FloatArray) -> list[FloatArray]:
    """The real solutions c, shape (k,); with k > 1, those to which Newton's method leads."""
    k = len(constant)
    size = max(float(np.abs(part).max()) for part in (constant, slope, square))
    if size <= _FLAT:
        return []
    if k == 1:
        b, a = float(slope[0, 0]), float(square[0, 0, 0])
        terms = [a, b, constant[0]] if abs(a) > _FLAT * size else [b, constant[0]]
        return [np.array([c.real]) for c in np.roots(terms) if abs(c.imag) <= _REAL]
    grid = product((0.0, 2.0, -2.0), repeat=k) if k <= _GRID else [np.zeros(k), *_axes(k)]
    found: list[FloatArray] = []
    for start in grid:
        c = np.array(start, dtype=np.float64)
        for _ in range(_ITERATIONS):
            left = constant + slope @ c + (square @ c) @ c
            step = np.linalg.lstsq(slope + 2.0 * (square @ c), -left, rcond=NO_PIVOT)[0]
            c = c + step
            if not np.linalg.norm(step) > 1e-14 * (1.0 + np.linalg.norm(c)):
                break
        left = constant + slope @ c + (square @ c) @ c
        if np.abs(left).max() <= _FLAT * size and all(
            np.linalg.norm(c - other) > _ALIKE * (1.0 + np.linalg.norm(c)) for other in found
        ):
            found.append(c)
    return found


def _axes(k: int) -> list[FloatArray]:
    return [2.0 * sign * axis for axis in np.eye(k) for sign in (1.0, -1.0)]
