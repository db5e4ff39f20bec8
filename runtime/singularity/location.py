"""The search for a singular position near a motion.

The position is the root of well-conditioned equations, although Φ_q is singular there: of the
constraints that keep their strength, and of what elimination of these leaves of the others, all of
it: uᵀ Φ_q restricted to the null directions, u the row combinations that are lost.
(Lyapunov-Schmidt reduction: M. Golubitsky and D. G. Schaeffer, Singularities and Groups in
Bifurcation Theory I, 1985, chapter VII.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.singularity.local_motion import Motion, moved, nearest
from runtime.singularity.pivot_orders import Frame, Frames
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.search_table import (
    COLUMN_ORDER,
    COLUMN_PLACE,
    ROW_ORDER,
    ROW_PLACE,
    measure_rows,
    unit_entries,
)

FloatArray = NDArray[np.float64]

_PASSES = 3  # safety: searches, each from the position of the last one


class Root(NamedTuple):
    """What an iteration found: z = (q / scale, t speed), the vectors there, and the gap.

    `left`, (m', weak), and `null`, (n + 1, free), are orthonormal; `gap` is the largest |uᵀ Φ|.
    """

    z: FloatArray
    left: FloatArray
    null: FloatArray
    gap: float

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
        self.series = motion.scaled(constraints.scale, speed)
        self.table, self.arrays = constraints.layout
        measure_rows(self.table, speed, self.series[0])

    def at(self, s: float) -> tuple[FloatArray, FloatArray]:
        """z and dz/ds after the time s."""
        z, rate = np.empty((2, self.series.shape[1]))
        moved(self.series, s, z, rate)
        return z, rate

    def weak(self, s: float) -> int:
        """How many constraints might be lost about where the motion is after the time s."""
        return self._frame(self.at(s)[0]).weak

    def met(self, s: float, weak: int) -> tuple[Root, float] | None:
        """The position about there in which `weak` constraints are lost, and when it is passed.

        None where none is.
        """
        found = None
        for _ in range(_PASSES):
            z = self.at(s)[0]
            found = self._root(z, self._frame(z), weak)
            if found is None:
                return None
            before, s = s, nearest(self.series, s, found.z)
            # With one freedom the position is one point, wherever the search for it began.
            if found.freedom <= 1 or abs(s - before) * self.speed < 1e-6:
                break
        return (found, s) if found is not None else None

    def _frame(self, z: FloatArray) -> Frame:
        entries = np.empty(self.constraints.places[0].size)
        unit_entries(self.table, self.speed, z, entries)
        return self.frames.of(entries)

    def _root(self, z: FloatArray, frame: Frame, weak: int) -> Root | None:
        """A position where `weak` constraints are lost; None where none is near z."""
        from runtime.singularity.gauss_newton import root  # loaded where something is singular

        arrays = self.arrays
        rows, wide = frame.row_order.size, frame.column_order.size
        arrays[ROW_ORDER][:], arrays[COLUMN_ORDER][:] = frame.row_order, frame.column_order
        arrays[ROW_PLACE][frame.row_order] = np.arange(rows)
        arrays[COLUMN_PLACE][frame.column_order] = np.arange(wide)
        free = wide - rows + weak
        left, null = np.empty((rows, weak)), np.empty((wide, free))
        gap = root(
            self.table,
            self.speed,
            z,
            np.empty((rows, wide)),
            left,
            null,
            np.empty((wide, weak)),
            np.empty((weak * free, free)),
            np.empty((free, free)),
            np.empty((weak, weak)),
            np.empty(free),
        )
        return Root(z, left, null, float(gap)) if gap >= 0.0 else None
