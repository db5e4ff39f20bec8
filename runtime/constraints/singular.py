"""Singular positions: where independent constraints become dependent, found and measured.

At a singular position Φ_q has lost k rows: there are left vectors u with uᵀ Φ_q = 0, and k null
directions beyond those of the motion. Time counts as one more coordinate, so that what is found is
where motions cross, and not where a driver is at the end of its reach.

The position is the root of well-conditioned equations, although Φ_q is singular there: of the
constraints but for their lost combinations uᵀ Φ, and of uᵀ Φ_q restricted to the null directions,
all of it. What is left of uᵀ Φ at the root is the gap by which the machine misses a position in
which motions cross. (Lyapunov-Schmidt reduction and unfolding of a saddle: M. Golubitsky and
D. G. Schaeffer, Singularities and Groups in Bifurcation Theory I, 1985, chapter VII.)
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Kernel = Callable[..., Any]

_WEAK = 0.3  # a singular value above this, columns scaled and rows made unit length, is not weak
_APART = 3.0  # factor by which the weak singular values lie below the others
_NONE = 1e-9  # singular values below this are not told apart
_FLAT = 1e-6  # what is left of uᵀ Φ_q on the null directions at a singular position
_ITERATIONS = 40
_KEEP = 5  # iterations with the same second derivatives
_CONVERGED = 1e-12
_KNOWN = 0.02  # Jacobians that differ by no more than this share their singular vectors
_PASSES = 3
_SAME = 0.05  # of the way there: a motion that comes as near to a known position passes it
_ROUNDED = 1e-13  # a gap of unit rows that is none
_CLEARLY = 1e-3  # of a gap: a gap that is another's
_DIFFERENCE = 6e-6  # eps ** (1/3), the relative size of a central difference


class Motion(NamedTuple):
    """A motion near an instant: q(t + s) = Σ s^i series_i; `series` has shape (k + 1, n)."""

    t: float
    series: FloatArray

    @property
    def q(self) -> FloatArray:
        """The position now."""
        q: FloatArray = self.series[0]
        return q

    @property
    def v(self) -> FloatArray:
        """The velocity now."""
        v: FloatArray = self.series[1]
        return v

    def at(self, s: float) -> FloatArray:
        """q after the time s."""
        q: FloatArray = s ** np.arange(len(self.series)) @ self.series
        return q

    def rate(self, s: float) -> FloatArray:
        """Its derivative."""
        powers = np.arange(1, len(self.series))
        v: FloatArray = (powers * s ** (powers - 1)) @ self.series[1:]
        return v


def taylor(t: float, q: FloatArray, v: FloatArray, a: FloatArray) -> Motion:
    """The motion with these derivatives."""
    return Motion(t, np.stack([q, v, 0.5 * a]))


def hermite(
    t: float, h: float, start: tuple[FloatArray, ...], end: tuple[FloatArray, ...]
) -> Motion:
    """The quintic with these q, v and a at both ends of a step."""
    q0, v0, a0 = start
    left = np.stack([end[0] - q0 - h * v0 - 0.5 * h * h * a0, end[1] - v0 - h * a0, end[2] - a0])
    right = np.array(
        [[h**3, h**4, h**5], [3 * h**2, 4 * h**3, 5 * h**4], [6 * h, 12 * h**2, 20 * h**3]]
    )
    units = h ** np.arange(3.0)
    rest = np.linalg.solve(units[:, None] * right, units[:, None] * left)
    return Motion(t, np.vstack([q0, v0, 0.5 * a0, rest]))


class Singularity(NamedTuple):
    """A singular position close to a motion; lengths are in units of `Positions.scale`.

    Attributes
    ----------
    t
        When the motion passes it, s.
    q
        The position, shape (n,).
    rows
        The largest share that each constraint has in the combinations lost, shape (m,).
    lost
        Their number k.
    direction
        The null direction that is not the motion's, of unit length, shape (n,).
    gap
        The largest |uᵀ Φ|, in units of the rows' lengths.
    rate
        How fast the smallest singular value passes through zero, 1/s.
    veer
        What the velocity lacks to one along the nearest branch, shape (n,).
    astray
        Its length as a part of the speed.
    speed
        Length of the velocity, 1/s.
    miss
        Distance of the motion from the position.
    """

    t: float
    q: FloatArray
    rows: FloatArray
    lost: int
    direction: FloatArray
    gap: float
    rate: float
    veer: FloatArray
    astray: float
    speed: float
    miss: float


class _Frame(NamedTuple):
    """Singular vectors of a Jacobian; of its singular values the last `weak` are."""

    matrix: FloatArray
    left: FloatArray
    values: FloatArray
    right: FloatArray
    weak: int


@dataclass
class Positions:
    """The constraints of a machine, scaled.

    Parameters
    ----------
    constraints, jacobian, velocity_rhs
        Kernels.
    rows, columns
        (nnz,): where the values of `jacobian` belong.
    p
        Parameters.
    scale
        (n,): typical size of a change of each coordinate.
    independent
        Constraints of which none follows from others everywhere.
    m
        Number of constraints.
    """

    constraints: Kernel
    jacobian: Kernel
    velocity_rhs: Kernel
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    p: FloatArray
    scale: FloatArray
    independent: NDArray[np.int64]
    m: int
    _frames: list[_Frame] = field(default_factory=list)

    def entries(self, t: float, q: FloatArray, unit: float) -> FloatArray:
        """Non-zeros of Φ_q, columns scaled, then Φ_t times `unit`; at `places`, (nnz + m,)."""
        values = np.zeros(self.rows.size + self.m)
        rate = values[self.rows.size :]
        self.jacobian(t, q, self.p, values[: self.rows.size])
        values[: self.rows.size] *= self.scale[self.columns]
        self.velocity_rhs(t, q, self.p, rate)
        rate *= -unit
        return values

    @cached_property
    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of `entries`; dependent rows are set aside behind the others."""
        order = np.full(self.m, self.independent.size)
        order[self.independent] = np.arange(self.independent.size)
        rows = np.append(self.rows, np.arange(self.m))
        columns = np.append(self.columns, np.full(self.m, self.scale.size))
        return order[rows], columns

    def dense(self, entries: FloatArray) -> FloatArray:
        """The matrix of `entries`, independent rows only, shape (m', n + 1)."""
        matrix = np.zeros((self.independent.size + 1, self.scale.size + 1))
        matrix[self.places] = entries
        return matrix[:-1]

    def gaps(self, t: float, q: FloatArray) -> FloatArray:
        """Φ, shape (m',)."""
        phi = np.zeros(self.m)
        self.constraints(t, q, self.p, phi)
        return phi[self.independent]

    def near(self, motion: Motion, s: float) -> Singularity | None:
        """The singular position that the motion meets, or barely misses, about the time `s` hence.

        None where there is none.
        """
        speed = float(np.linalg.norm(motion.v / self.scale))
        if not 0.0 < speed < np.inf:
            return None
        search = _Search(self, motion, speed)
        best = None
        # Where more is weak than the motion loses, it misses the position in which all of it would
        # be lost, and may meet one close by in which less is.
        for weak in range(search.weak(s), 0, -1):
            found = search.met(s, weak)
            if found is not None and (best is None or found.gap < _CLEARLY * best.gap):
                best = found
            if best is not None and best.gap <= _ROUNDED:
                break
        return best

    def again(self, motion: Motion, known: Singularity) -> Singularity | None:
        """A known singular position as a later look at the motion sees it."""
        speed = float(np.linalg.norm(motion.v / self.scale))
        if not 0.0 < speed < np.inf:
            return None
        search = _Search(self, motion, speed)
        z = np.append(known.q / self.scale, known.t * speed)
        s = search.nearest(z, known.t - motion.t)
        miss = float(np.linalg.norm((search.at(s) - z)[:-1]))
        if miss > _SAME * max(abs(s) * speed, 1e-3):
            return self.near(motion, s)
        growth = speed / known.speed
        return known._replace(t=motion.t + s, speed=speed, rate=known.rate * growth, miss=miss)

    def frame(self, matrix: FloatArray) -> _Frame:
        """Singular vectors of this Jacobian, or of a known one that hardly differs."""
        for known in self._frames:
            if np.abs(known.matrix - matrix).max() < _KNOWN:
                return known
        left, values, right = np.linalg.svd(matrix)
        made = _Frame(matrix, left, values, right, weak_values(values))
        self._frames = [made, *self._frames[:3]]
        return made


def weak_values(values: FloatArray) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0


class _Root(NamedTuple):
    """What an iteration found: z = (q / scale, t speed), the vectors there, and the form."""

    z: FloatArray
    left: FloatArray
    null: FloatArray
    form: FloatArray

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the positions around; one null direction is time's."""
        return int(self.null.shape[1] - self.left.shape[1] - 1)


class _Search:
    """Finds singular positions near a motion; lengths scaled, time in units of 1 / speed."""

    def __init__(self, positions: Positions, motion: Motion, speed: float) -> None:
        self.positions, self.motion, self.speed = positions, motion, speed
        matrix = positions.dense(positions.entries(motion.t, motion.q, 1.0 / speed))
        lengths = np.linalg.norm(matrix[:, :-1], axis=1)
        self.lengths = np.where(lengths > 0.0, lengths, 1.0)

    def at(self, s: float) -> FloatArray:
        """z after the time s."""
        return np.append(self.motion.at(s) / self.positions.scale, (self.motion.t + s) * self.speed)

    def rate(self, s: float) -> FloatArray:
        """dz/ds."""
        return np.append(self.motion.rate(s) / self.positions.scale, self.speed)

    def entries(self, z: FloatArray) -> FloatArray:
        """Entries of the Jacobian by z, before its rows are made unit length."""
        q = z[:-1] * self.positions.scale
        return self.positions.entries(z[-1] / self.speed, q, 1.0 / self.speed)

    def matrix(self, z: FloatArray) -> FloatArray:
        """The Jacobian of the unit rows by z."""
        return self.positions.dense(self.entries(z)) / self.lengths[:, None]

    def gaps(self, z: FloatArray) -> FloatArray:
        """The unit rows' values."""
        q = z[:-1] * self.positions.scale
        return self.positions.gaps(z[-1] / self.speed, q) / self.lengths

    def nearest(self, z: FloatArray, s: float) -> float:
        """When the motion is nearest to z, in q."""
        for _ in range(4):
            away, rate = (self.at(s) - z)[:-1], self.rate(s)[:-1]
            s -= float(away @ rate) / float(rate @ rate)
        return s

    def weak(self, s: float) -> int:
        """How many constraints might be lost about where the motion is after the time s."""
        return self.positions.frame(self.matrix(self.at(s))).weak

    def met(self, s: float, weak: int) -> Singularity | None:
        """The position about there in which `weak` constraints are lost; None where none is."""
        found = None
        for _ in range(_PASSES):
            z = self.at(s)
            found = self._root(z, self.positions.frame(self.matrix(z)), weak)
            if found is None:
                return None
            before, s = s, self.nearest(found.z, s)
            # With one freedom the position is one point, wherever the search for it began.
            if found.freedom <= 1 or abs(s - before) * self.speed < 1e-6:
                break
        return self.described(found, s) if found is not None else None

    def _root(self, z: FloatArray, frame: _Frame, weak: int) -> _Root | None:
        """Gauss-Newton for a position where `weak` constraints are lost; None where it fails."""
        strong = len(frame.values) - weak
        before, apart = frame.left[:, :strong], frame.left[:, strong:]
        across, along = frame.right[:strong].T, frame.right[strong:].T
        inverse = 1.0 / frame.values[:strong]
        left, null, origin = apart, along, z
        form = np.zeros(0)
        for iteration in range(_ITERATIONS):
            matrix = self.matrix(z)
            for _ in range(2):
                null = null - across @ (inverse[:, None] * (before.T @ (matrix @ null)))
                left = left - before @ (inverse[:, None] * (across.T @ (matrix.T @ left)))
            flat = left.T @ matrix @ null
            if iteration % _KEEP == 0:
                form = self._form(z, left, null)
            x = np.linalg.lstsq(form.reshape(-1, null.shape[1]), -flat.ravel(), rcond=1e-8)[0]
            step = null @ x - across @ (inverse * (before.T @ self.gaps(z)))
            z = z + step
            if np.linalg.norm(z - origin) > 1.0:
                return None
            if np.linalg.norm(step) < _CONVERGED * (1.0 + np.linalg.norm(z)):
                break
        if np.abs(left.T @ self.matrix(z) @ null).max() > _FLAT:
            return None
        return _Root(z, left, null, form)

    def _form(self, z: FloatArray, left: FloatArray, null: FloatArray) -> FloatArray:
        """uᵀ Φ_qq on the null directions, shape (k, c, c): [:, :, j] along direction j."""
        rows, columns = self.positions.places
        padded = np.vstack([left / self.lengths[:, None], np.zeros(left.shape[1])])
        lefts, nulls = padded[rows].T.copy(), null[columns]
        parts = []
        for direction in null.T:
            delta = _DIFFERENCE * direction
            slope = (self.entries(z + delta) - self.entries(z - delta)) / (2.0 * _DIFFERENCE)
            parts.append((lefts * slope) @ nulls)
        return np.stack(parts, axis=2)

    def described(self, root: _Root, s: float) -> Singularity | None:
        """The root as users of it see it; None where the motion is nowhere near."""
        positions = self.positions
        rate = self.rate(s)
        miss = float(np.linalg.norm((self.at(s) - root.z)[:-1]))
        if miss > 0.1 * abs(s) * self.speed + 1e-3:
            return None
        along = np.asarray(np.linalg.lstsq(root.null, rate, rcond=None)[0], dtype=np.float64)
        passing = root.form @ along
        _, rates, right = np.linalg.svd(passing)
        veer = (root.null @ (_on_branch(root.form, along) - along))[:-1]
        weakest = float(rates[-1])
        direction = (root.null @ right[len(rates) - 1])[:-1]
        rows = np.zeros(positions.m)
        rows[positions.independent] = np.abs(root.left).max(axis=1)
        return Singularity(
            t=self.motion.t + s,
            q=root.z[:-1] * positions.scale,
            rows=rows,
            lost=len(rates),
            direction=direction / max(float(np.linalg.norm(direction)), 1e-300),
            gap=float(np.abs(root.left.T @ self.gaps(root.z)).max()),
            rate=weakest,
            veer=veer * positions.scale,
            astray=float(np.linalg.norm(veer)) / self.speed,
            speed=self.speed,
            miss=miss,
        )


def _on_branch(form: FloatArray, along: FloatArray) -> FloatArray:
    """The nearest x with xᵀ form x = 0, all forms: the directions of branches, by Newton."""
    x = along
    for _ in range(_ITERATIONS):
        slopes = (form + form.transpose(0, 2, 1)) @ x
        step = np.linalg.lstsq(slopes, -(form @ x) @ x, rcond=1e-10)[0]
        x = x + step
        if np.linalg.norm(step) < _CONVERGED * np.linalg.norm(x):
            break
    return x
