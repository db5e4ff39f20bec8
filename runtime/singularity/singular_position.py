"""Singular positions: where independent constraints become dependent, found and measured.

At a singular position Φ_q has lost k rows: there are left vectors u with uᵀ Φ_q = 0, and k null
directions beyond those of the motion. Time counts as one more coordinate, so that what is found is
where motions cross, and not where a driver is at the end of its reach.

What is left of uᵀ Φ at the root that `search` finds is the gap by which the machine misses a
position in which motions cross. (Unfolding of a saddle: M. Golubitsky and D. G. Schaeffer,
Singularities and Groups in Bifurcation Theory I, 1985, chapter VII.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.singularity.local_motion import Motion, distance, nearest
from runtime.singularity.location import Root, Search
from runtime.singularity.pivot_orders import Frames
from runtime.singularity.scaled_constraints import ScaledConstraints

FloatArray = NDArray[np.float64]

# measured: of the way there; a motion that comes as near to a known position passes it
_SAME = 0.05
_ROUNDED = 1e-13  # accuracy: gap of unit rows that is rounding
# measured: part of a gap; a smaller one belongs to another position
_CLEARLY = 1e-3
_LOST = 1e-6  # accuracy: singular values of unit rows below this are lost, as at a start


class Singularity(NamedTuple):
    """A singular position close to a motion; lengths are in units of `ScaledConstraints.scale`.

    Attributes
    ----------
    t
        When the motion passes it, s.
    q
        The position, shape (n,).
    rows
        The share that each constraint has in the combinations lost, shape (m,): the length of its
        row in orthonormal ones.
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
    due
        The instant that drivers give the position; not a number where they leave freedom.
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
    due: float


class Positions:
    """The singular positions of a machine, looked for near its motion."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        self.constraints, self.frames = constraints, Frames(constraints)

    def near(self, motion: Motion, s: float) -> Singularity | None:
        """The singular position that the motion meets, or barely misses, about the time `s` hence.

        None where there is none.
        """
        speed = float(np.linalg.norm(motion.v / self.constraints.scale))
        if not 0.0 < speed < np.inf:
            return None
        search = Search(self.constraints, self.frames, motion, speed)
        best = None
        # Where more is weak than the motion loses, it misses the position in which all of it would
        # be lost, and may meet one close by in which less is.
        for weak in range(search.weak(s), 0, -1):
            met = search.met(s, weak)
            found = _described(search, *met) if met is not None else None
            if found is not None and (best is None or found.gap < _CLEARLY * best.gap):
                best = found
            if best is not None and best.gap <= _ROUNDED:
                break
        return best

    def again(self, motion: Motion, known: Singularity) -> Singularity | None:
        """A known singular position as a later look at the motion sees it."""
        speed = float(np.linalg.norm(motion.v / self.constraints.scale))
        if not 0.0 < speed < np.inf:
            return None
        z = np.append(known.q / self.constraints.scale, known.t * speed)
        series = motion.scaled(self.constraints.scale, speed)
        s = nearest(series, known.t - motion.t, z)
        miss = distance(series, s, z)
        if miss > _SAME * max(abs(s) * speed, 1e-3):
            return self.near(motion, s)
        growth = speed / known.speed
        return known._replace(t=motion.t + s, speed=speed, rate=known.rate * growth, miss=miss)

    def instant(self, motion: Motion, known: Singularity) -> float:
        """When this motion is nearest to a known singular position."""
        z = np.append(known.q / self.constraints.scale, known.t * known.speed)
        series = motion.scaled(self.constraints.scale, known.speed)
        return motion.t + nearest(series, known.t - motion.t, z)


def _described(search: Search, root: Root, s: float) -> Singularity | None:
    """The root as users of it see it; None where the motion is nowhere near."""
    constraints = search.constraints
    rate = search.at(s)[1]
    miss = distance(search.series, s, root.z)
    if miss > 0.1 * abs(s) * search.speed + 1e-3:
        return None
    passing, veer = _directions(search, root, rate)
    _, rates, right = np.linalg.svd(passing)
    weakest = float(rates[-1])
    direction = (root.null @ right[len(rates) - 1])[:-1]
    count = len(rates)
    if constraints.independent.size < constraints.m:
        found = _of_all(search, root, direction)
        if found is None:
            return None
        count, direction = found
    rows = np.zeros(constraints.m)
    # Of equal shares the first is to be the largest, whatever rounding says.
    rows[constraints.independent] = np.linalg.norm(root.left, axis=1).round(9)
    return Singularity(
        t=search.motion.t + s,
        q=root.z[:-1] * constraints.scale,
        rows=rows,
        lost=count,
        direction=direction / max(float(np.linalg.norm(direction)), 1e-300),
        gap=root.gap,
        rate=weakest,
        veer=veer * constraints.scale,
        astray=float(np.linalg.norm(veer)) / search.speed,
        speed=search.speed,
        miss=miss,
        due=float(root.z[-1]) / search.speed if root.freedom == 0 else np.nan,
    )


def _of_all(search: Search, root: Root, direction: FloatArray) -> tuple[int, FloatArray] | None:
    """How many constraints are lost, and the direction, where others repeat what some say.

    None where all together determine every coordinate. What is left out may hold where what was
    kept does not: rows that are independent elsewhere can lose more here than all rows together.
    """
    constraints = search.constraints
    matrix = constraints.all_rows(root.z[-1] / search.speed, root.z[:-1] * constraints.scale)
    _, values, right = np.linalg.svd(matrix)
    rank = int((values > _LOST).sum())
    null = right[rank:]
    if not len(null):
        return None
    allowed: FloatArray = null.T @ (null @ direction)
    size = float(np.linalg.norm(allowed))
    if size < _LOST:
        # Nothing of it is left: of the others, that which is least the motion's.
        along = null @ search.series[1, :-1]
        others = np.linalg.svd(along[None, :])[2][1:] if len(null) > 1 else np.eye(len(null))
        allowed, size = others[0] @ null, 1.0
    return max(constraints.independent.size - rank, 0), allowed / size


def _directions(search: Search, root: Root, rate: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The rate of what is lost along a motion, (k, c), and what its dz/ds lacks to a branch."""
    from runtime.singularity.complement_derivative import (
        branch,  # loaded where something is singular
    )

    (wide, free), weak = root.null.shape, root.left.shape[1]
    passing, x = np.empty((weak, free)), np.empty(free)
    branch(
        search.table,
        search.speed,
        root.z,
        rate,
        root.left,
        root.null,
        np.empty((wide, weak)),
        np.empty((weak, weak)),
        np.empty((weak, free)),
        passing,
        x,
    )
    veer: FloatArray = (root.null @ x)[:-1]
    return passing, veer
