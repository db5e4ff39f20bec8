"""Branches of motion at a branch point of a driven machine.

There the rank of Phi_q falls by k, with the null directions N. The velocity is v_p + N c, and the
missing equations are the solvability conditions of the accelerations: l gamma(v) = 0 with
l Phi_q = 0. They are k quadratic equations in c: with k = 1 two branches, one, or none.

Interpolation of a branch of a driven motion across a branch point.

Close to it velocities and accelerations are quotients 0/0. So states are computed on the branch at
some distance before and behind, where little is lost to rounding, and the motion in between is the
polynomial through them. The branch point itself, which is less accurate, is not one of them.
"""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from runtime.continuation.predictor_corrector import return_to_motion
from runtime.linalg.rank_policy import LOST, NO_PIVOT
from runtime.mechanism.dense_equations import Equations, FloatArray, row_lengths
from runtime.singularity.motion_polynomial import Motion, interpolate

SOLVED = 1e-6  # accuracy: |uᵀ ν|, in parts of the speed, below which velocities exist
_REAL = 1e-6  # accuracy: imaginary part of a root that is rounding
# accuracy: difference of equal velocities, or of equal distances, in parts of the speed
_ALIKE = 1e-6
_FLAT = 1e-9  # accuracy: coefficients of the quadratic equations below this are zero
_GRID = 3  # safety: largest rank deficiency for which the search for branches starts from a grid
_ITERATIONS = 60  # safety: Newton iterations from each start of that search


class Branch(NamedTuple):
    """One motion: velocity, acceleration without its part in N, distance from the preferred one."""

    v: FloatArray  # (n,), as a
    a: FloatArray
    far: float  # in scaled coordinates, 1/s


class RankDeficiency:
    """Phi_q at (t, q), unit rows, scaled columns, and its singular vectors; `k` values are lost.

    Rows that follow from others everywhere are left out; m is the number of the others, whose
    indices are `rows`. `left` has shape (m, k), `null` (n, k), `inverse` (n, m), `lengths` (m,). At
    least `least` of the smallest `values` count as lost. Rows shorter than `shortest`, shape (all
    rows,), are divided by that, since they may vanish.
    """

    def __init__(
        self, equations: Equations, t: float, q: FloatArray, scale: FloatArray,
        shortest: FloatArray, least: int = 0,
    ) -> None:  # fmt: skip
        self.equations, self.t, self.q, self.scale = equations, t, q, scale
        self.rows = equations.independent
        matrix = equations.jacobian(t, q)[self.rows] * scale
        self.lengths = np.maximum(row_lengths(matrix), shortest[self.rows])
        self.matrix = matrix / self.lengths[:, None]
        left, self.values, right = np.linalg.svd(self.matrix)
        self.k = max(int((self.values < LOST).sum()), least)
        kept = len(self.values) - self.k
        self.left, self.null = left[:, kept:], right[kept:].T
        self.inverse = right[:kept].T @ (left[:, :kept].T / self.values[:kept, None])

    @property
    def nu(self) -> FloatArray:
        """-Phi_t of the rows, (m,)."""
        return self.equations.velocity_rhs(self.t, self.q)[self.rows] / self.lengths

    def gamma(self, v: FloatArray) -> FloatArray:
        """gamma of the rows, (m,)."""
        return self.equations.acceleration_rhs(self.t, self.q, v)[self.rows] / self.lengths

    def drift(self, rate: float) -> float:
        """|uᵀ nu| / rate, the second-order test: rounding where motions cross, else a lock-up."""
        return float(np.linalg.norm(self.left.T @ self.nu)) / rate

    def branches(self, preferred: FloatArray) -> list[Branch]:
        """The branches, nearest to the `preferred` velocities first; none if no motion exists."""
        if self.k == 0 or self.left.shape[0] != self.null.shape[0]:
            return []
        scale, nu = self.scale, self.nu
        base = preferred / scale
        base = base - self.inverse @ (self.matrix @ base - nu)
        growth = self.left.T @ self.gamma(base * scale)  # from rest, too, branches lead
        speed = max(float(np.abs(base).max()), float(np.abs(growth).max()) ** 0.5)
        at_rest = speed**2 == 0.0  # where no motion is told from another
        if at_rest or float(np.abs(self.left.T @ nu).max()) > SOLVED * speed:
            return []

        def velocity(c: FloatArray) -> FloatArray:
            v: FloatArray = (base + speed * (self.null @ c)) * scale
            return v

        def residual(c: FloatArray) -> FloatArray:
            missing: FloatArray = self.left.T @ self.gamma(velocity(c)) / speed**2
            return missing

        found = []
        for c in _roots(*_quadratic(residual, self.k)):
            v = velocity(c)
            far = speed * float(np.linalg.norm(c))
            found.append(Branch(v, (self.inverse @ self.gamma(v)) * scale, far))
        return sorted(found, key=lambda branch: branch.far)


def is_ambiguous(found: list[Branch], scale: FloatArray) -> bool:
    """Whether the nearest two are equally near."""
    if len(found) < 2:
        return False
    speed = max(float(np.abs(branch.v / scale).max()) for branch in found[:2])
    return found[1].far - found[0].far <= _ALIKE * speed


def _quadratic(
    residual: Callable[[FloatArray], FloatArray], k: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """`residual` as constant + slope c + c square c; shapes (k,), (k, k), (k, k, k)."""
    unit = np.eye(k)
    constant = residual(np.zeros(k))
    slope, square = np.zeros((k, k)), np.zeros((k, k, k))
    for i in range(k):
        ahead, behind = residual(unit[i]), residual(-unit[i])
        slope[:, i] = 0.5 * (ahead - behind)
        square[:, i, i] = 0.5 * (ahead + behind) - constant
    for i in range(k):
        for j in range(i):
            both = residual(unit[i] + unit[j]) - constant - slope[:, i] - slope[:, j]
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
    axes = [2.0 * sign * axis for axis in np.eye(k) for sign in (1.0, -1.0)]
    starts = product((0.0, 2.0, -2.0), repeat=k) if k <= _GRID else [np.zeros(k), *axes]
    found: list[FloatArray] = []
    for start in starts:
        c = np.array(start, dtype=np.float64)
        for _ in range(_ITERATIONS):
            left = constant + slope @ c + (square @ c) @ c
            step = np.linalg.lstsq(slope + 2.0 * (square @ c), -left, rcond=NO_PIVOT)[0]
            c = c + step
            if not np.linalg.norm(step) > 1e-14 * (1.0 + np.linalg.norm(c)):
                break
        left = constant + slope @ c + (square @ c) @ c
        new = all(np.linalg.norm(c - other) > _ALIKE * (1.0 + np.linalg.norm(c)) for other in found)
        if new and np.abs(left).max() <= _FLAT * size:
            found.append(c)
    return found


# measured: of the time scale; states at this and twice this distance are interpolated
DISTANCE = 2e-2
# measured: multiples of `DISTANCE`, in the order in which they are tried
_FACTORS = (1.0, 0.5, 2.0, 0.25, 4.0, 0.125)
# accuracy: distance of a state from its branch, over that from the next branch
_NEAR = 0.2
_NODES = (-1.0, 1.0, -2.0, 2.0)  # formula: nodes of the interpolation, in units of the distance


class Zone(NamedTuple):
    """A branch about a singular instant t; within `reach` of it, s, q is a polynomial."""

    t: float
    reach: float
    motion: Motion

    def holds(self, t: float) -> bool:
        """Whether an instant lies within the zone."""
        return bool(abs(t - self.t) <= self.reach)

    def at(self, t: float) -> tuple[FloatArray, FloatArray]:
        """q and dq/dt at an instant within, each (n,)."""
        return self.motion.at(t - self.t)


def distance_between(choices: list[Branch], scale: FloatArray) -> float:
    """Distance of the next branch's velocity from that of the first, scaled, 1/s."""
    first = choices[0].v
    distances = (float(np.linalg.norm((other.v - first) / scale)) for other in choices[1:])
    return min(distances, default=np.inf)


def interpolate_branch(
    equations: Equations, t: float, q: FloatArray, choices: list[Branch], scale: FloatArray,
    rate: float,
) -> Zone | None:  # fmt: skip
    """The first branch about (t, q); None where it does not go on smoothly on both sides.

    `rate` tells how fast its singular value moves, 1/s.
    """
    rate = max(rate, float(np.linalg.norm(choices[0].v / scale)), 1e-3)
    apart = _NEAR * distance_between(choices, scale)
    for factor in _FACTORS:
        unit = factor * DISTANCE / rate
        states = _compute_nodes(equations, t, q, choices[0], scale, apart, unit)
        if states is not None:
            orders = [0] * len(_NODES) + [1] * len(_NODES)
            return Zone(t, 2.0 * unit, interpolate(t, unit, 2 * _NODES, orders, states))
    return None


def _compute_nodes(
    equations: Equations, t: float, q: FloatArray, branch: Branch, scale: FloatArray,
    apart: float, unit: float,
) -> FloatArray | None:  # fmt: skip
    """q, then dq/dt, at the nodes, shape (2 nodes, n); None where one misses the branch."""
    nodes, n = len(_NODES), len(q)
    states = np.zeros((2 * nodes, n))
    a, p = branch.a, equations.p
    for i, x in enumerate(_NODES):
        h = x * unit
        there, v = q + h * (branch.v + 0.5 * h * a), branch.v + h * a
        guess, guessed_v = there.copy(), v.copy()
        correction, work = equations.kernels.correction, np.zeros((2, n))
        code, *_ = return_to_motion(correction, t + h, there, v, p, scale * scale, scale, *work)
        off = float(np.linalg.norm((there - guess) / scale))
        veered = float(np.linalg.norm((v - guessed_v) / scale))
        if code != 0 or off > apart * abs(h) or veered > apart:
            return None
        states[i], states[nodes + i] = there, v
        if i == 1:
            # What the equations leave open of the acceleration follows from the nearer two.
            a = (states[nodes + 1] - states[nodes]) / (2.0 * unit)
    return states
