"""The search for a singular position near a motion.

The position is the root of well-conditioned equations, although Φ_q is singular there: of the
constraints but for their lost combinations uᵀ Φ, and of uᵀ Φ_q restricted to the null directions,
all of it. (Lyapunov-Schmidt reduction: M. Golubitsky and D. G. Schaeffer, Singularities and Groups
in Bifurcation Theory I, 1985, chapter VII.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.constraints.frames import Frame, Frames
from runtime.constraints.motion import Motion
from runtime.constraints.scaled import ScaledConstraints

FloatArray = NDArray[np.float64]

_FLAT = 1e-6  # what is left of uᵀ Φ_q on the null directions at a singular position
_ITERATIONS = 40
_KEEP = 5  # iterations with the same second derivatives
_CONVERGED = 1e-12
_PASSES = 3
_DIFFERENCE = 6e-6  # eps ** (1/3), the relative size of a central difference


class Root(NamedTuple):
    """What an iteration found: z = (q / scale, t speed), the vectors there, and the form."""

    z: FloatArray
    left: FloatArray
    null: FloatArray
    form: FloatArray

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the positions around; one null direction is time's."""
        return int(self.null.shape[1] - self.left.shape[1] - 1)


class Search:
    """Finds singular positions near a motion; lengths scaled, time in units of 1 / speed."""

    def __init__(
        self, constraints: ScaledConstraints, frames: Frames, motion: Motion, speed: float
    ) -> None:
        self.constraints, self.frames = constraints, frames
        self.motion, self.speed = motion, speed
        matrix = constraints.dense(constraints.entries(motion.t, motion.q, 1.0 / speed))
        lengths = np.linalg.norm(matrix[:, :-1], axis=1)
        self.lengths = np.where(lengths > 0.0, lengths, 1.0)

    def at(self, s: float) -> FloatArray:
        """z after the time s."""
        return np.append(
            self.motion.at(s) / self.constraints.scale, (self.motion.t + s) * self.speed
        )

    def rate(self, s: float) -> FloatArray:
        """dz/ds."""
        return np.append(self.motion.rate(s) / self.constraints.scale, self.speed)

    def entries(self, z: FloatArray) -> FloatArray:
        """Entries of the Jacobian by z, before its rows are made unit length."""
        q = z[:-1] * self.constraints.scale
        return self.constraints.entries(z[-1] / self.speed, q, 1.0 / self.speed)

    def matrix(self, z: FloatArray) -> FloatArray:
        """The Jacobian of the unit rows by z."""
        return self.constraints.dense(self.entries(z)) / self.lengths[:, None]

    def gaps(self, z: FloatArray) -> FloatArray:
        """The unit rows' values."""
        q = z[:-1] * self.constraints.scale
        return self.constraints.gaps(z[-1] / self.speed, q) / self.lengths

    def nearest(self, z: FloatArray, s: float) -> float:
        """When the motion is nearest to z, in q."""
        for _ in range(4):
            away, rate = (self.at(s) - z)[:-1], self.rate(s)[:-1]
            s -= float(away @ rate) / float(rate @ rate)
        return s

    def weak(self, s: float) -> int:
        """How many constraints might be lost about where the motion is after the time s."""
        return self.frames.of(self.matrix(self.at(s))).weak

    def met(self, s: float, weak: int) -> tuple[Root, float] | None:
        """The position about there in which `weak` constraints are lost, and when it is passed.

        None where none is.
        """
        found = None
        for _ in range(_PASSES):
            z = self.at(s)
            found = self._root(z, self.frames.of(self.matrix(z)), weak)
            if found is None:
                return None
            before, s = s, self.nearest(found.z, s)
            # With one freedom the position is one point, wherever the search for it began.
            if found.freedom <= 1 or abs(s - before) * self.speed < 1e-6:
                break
        return (found, s) if found is not None else None

    def _root(self, z: FloatArray, frame: Frame, weak: int) -> Root | None:
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
        return Root(z, left, null, form)

    def _form(self, z: FloatArray, left: FloatArray, null: FloatArray) -> FloatArray:
        """uᵀ Φ_qq on the null directions, shape (k, c, c): [:, :, j] along direction j."""
        rows, columns = self.constraints.places
        padded = np.vstack([left / self.lengths[:, None], np.zeros(left.shape[1])])
        lefts, nulls = padded[rows].T.copy(), null[columns]
        parts = []
        for direction in null.T:
            delta = _DIFFERENCE * direction
            slope = (self.entries(z + delta) - self.entries(z - delta)) / (2.0 * _DIFFERENCE)
            parts.append((lefts * slope) @ nulls)
        return np.stack(parts, axis=2)
