"""Singular positions near a motion: how many constraints are lost, and how the motion passes.

At a singular position Φ_q has lost k rows: there are left vectors u with uᵀ Φ_q = 0, and k null
directions beyond those of the motion. Time counts as one more coordinate: a position is found where
motions cross (a branch point), not where a driver comes to the end of its reach (a fold).

|uᵀ Φ| at the root that `singular_root_search` finds is the gap by which the machine misses a branch
point. (Unfolding of a saddle: M. Golubitsky and D. G. Schaeffer, Singularities and Groups in
Bifurcation Theory I, 1985, chapter VII.)
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from runtime.core.arrays import EPS, Vector
from runtime.singularity.motion_polynomial import Motion, distance, nearest_time
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import PivotOrders
from runtime.singularity.search_function_table import is_root
from runtime.singularity.singular_root_search import ITERATIONS, Root, Search

_SAME = 0.05  # measured: of the way there; a motion that comes as near to a known position passes
_ROUNDED = 1e-13  # accuracy: gap of unit rows that is rounding
_NEAR = 0.01  # safety: of sizes; the way to a known position, to which none of its kind is nearer
_ALONG = 0.999  # safety: cosine of the angle between two motions along one line
_KEPT = 3  # layout: positions that are remembered, besides the last one
_TURN = 2.0 * np.pi
_CLEARLY = 1e-3  # measured: part of a gap; a smaller one belongs to another position


class Singularity(NamedTuple):
    """A singular position close to a motion; lengths are in units of `ScaledConstraints.scale`."""

    t: float  # when the motion passes it, s
    q: Vector  # the position, (n,)
    # share of each constraint in the row combinations that are lost, (m,): the length of its row in
    # the orthonormal left vectors
    rows: Vector
    lost: int  # number k of these combinations
    direction: Vector  # the null direction that is not the motion's, of unit length, (n,)
    gap: float  # the largest |uᵀ Φ|, in units of the rows' lengths
    rate: float  # how fast the smallest singular value passes through zero, 1/s
    veer: Vector  # velocity along the nearest branch less that of the motion, (n,)
    astray: float  # length of `veer` as a part of the speed
    speed: float  # length of the velocity, 1/s
    miss: float  # distance of the motion from the position
    due: float  # when drivers reach the position, s; not a number where they leave freedom


class SingularPositions:
    """The singular positions of a machine near its motion."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        self.constraints = constraints
        # Positions, their weak rows, how motions passed them, and entries of the Jacobian.
        self.passed: tuple[tuple[Singularity, int, Vector, Vector], ...] = ()
        self.orders, self.search = _searches(constraints)

    def find(self, motion: Motion, s: float, branch: bool = False) -> Singularity | None:
        """The singular position that the motion passes, or barely misses, about the time s hence.

        The motion is in the machine's own units, s negative where the position lies behind. None
        where there is none near, or where the machine rests. Unless the nearest `branch` is asked
        for, `veer` is a first guess.
        """
        speed = self._speed(motion)
        if not 0.0 < speed < np.inf:
            return None
        search = self.search(self.constraints, self.orders, motion, speed)
        count, most = search.count_weak(s), ITERATIONS if branch else 1
        best = None if branch else self._find_passed(search, s, count)
        # With more weak rows than the motion loses, it misses the position that loses all of them,
        # and may pass one close by that loses fewer.
        for weak in range(count if best is None else 0, 0, -1):
            root = search.find(s, weak)
            found = _characterise(search, *root, most) if root is not None else None
            if found is not None and (best is None or found.gap < _CLEARLY * best.gap):
                best = found
            if best is not None and best.gap <= _ROUNDED:
                if root is not None and root[0].freedom == 1 and weak == count:
                    values, line = search.arrays["values"], search.path.at(root[1])[1]
                    is_root(search.table, root[0].z, values, _ROUNDED)  # writes them
                    self.passed = ((best, weak, line[:-1], values.copy()), *self.passed[:_KEPT])
                break
        return best

    def _find_passed(self, search: Search, s: float, weak: int) -> Singularity | None:
        """The position, of those that are points, that the motion passes again in the same line.

        It is the same but for whole turns, and a root of the constraints as they are now. Another
        that loses as many rows is not as near: the weak singular values would lie apart.
        """
        scale, (z, rate), t = self.constraints.scale, search.path.at(s), search.motion.t + s
        q, v = z[:-1] * scale, rate[:-1]
        for known, count, line, entries in self.passed:
            turned = known.q + _TURN * np.round((q - known.q) / _TURN)
            near = count == weak and np.abs((turned - q) / scale).max() < _NEAR
            along = abs(v @ line) > _ALONG * sqrt(v @ v * (line @ line))
            z[:-1] = turned / scale
            rounded = _ROUNDED + EPS * np.abs(turned).max()  # of large angles
            if near and along and is_root(search.table, z, entries, rounded):
                return self._pass_again(search.motion, known._replace(t=t, q=turned))
        return None

    def find_again(self, motion: Motion, known: Singularity) -> Singularity | None:
        """A known singular position, with the instant at which a later motion passes it."""
        again = self._pass_again(motion, known)
        return again or self.find(motion, self.passing_time(motion, known) - motion.t)

    def _pass_again(self, motion: Motion, known: Singularity) -> Singularity | None:
        """As `find_again`; None where the motion does not come near, or where the machine rests."""
        speed, (s, miss) = self._speed(motion), self._nearest(motion, known)
        if not (0.0 < speed < np.inf and miss <= _SAME * max(abs(s) * speed, 1e-3)):
            return None
        growth = speed / known.speed
        return known._replace(t=motion.t + s, speed=speed, rate=known.rate * growth, miss=miss)

    def passing_time(self, motion: Motion, known: Singularity) -> float:
        """The instant at which this motion is nearest to a known singular position, s."""
        return motion.t + self._nearest(motion, known)[0]

    def _speed(self, motion: Motion) -> float:
        scaled = motion.velocity / self.constraints.scale
        return sqrt(scaled @ scaled)

    def _nearest(self, motion: Motion, known: Singularity) -> tuple[float, float]:
        """Time from the motion's own instant to where it is nearest to a position, and how near."""
        scale = self.constraints.scale
        series, z = motion.series / scale, known.q / scale
        s = nearest_time(series, known.t - motion.t, z)
        return s, distance(series, s, z)


def _searches(constraints: ScaledConstraints) -> tuple[PivotOrders, type[Search]]:
    """Orders of pivots of a machine, and the search that takes them."""
    if not constraints.is_large:
        return PivotOrders(constraints), Search
    # Small machines load none of it.
    from runtime.singularity.sparse_complement import SparsePivotOrders
    from runtime.singularity.sparse_root_search import SparseSearch

    return SparsePivotOrders(constraints), SparseSearch


def _characterise(search: Search, root: Root, s: float, most: int) -> Singularity | None:
    """The singular position at a root; None where the motion does not come near."""
    constraints = search.constraints
    rate = search.path.at(s)[1]
    miss = distance(search.path.series, s, root.z[:-1])
    if miss > 0.1 * abs(s) * search.speed + 1e-3:
        return None
    passage = search.passage(root, rate, most)
    direction = passage.direction
    rows = np.zeros(constraints.m)
    # Of shares that differ by rounding alone the first is to be the largest.
    rows[constraints.independent] = passage.shares.round(9)
    return Singularity(
        t=search.motion.t + s,
        q=root.z[:-1] * constraints.scale,
        rows=rows,
        lost=passage.lost,
        direction=direction / max(float(np.linalg.norm(direction)), 1e-300),
        gap=root.gap,
        rate=passage.weakest,
        veer=passage.veer * constraints.scale,
        astray=float(np.linalg.norm(passage.veer)) / search.speed,
        speed=search.speed,
        miss=miss,
        due=float(root.z[-1]) / search.speed if root.freedom == 0 else np.nan,
    )
