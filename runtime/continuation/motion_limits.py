"""Limits of a machine of one degree of freedom: how far a coordinate moves, where it turns back.

With its driver released the machine moves along a closed curve of positions, which is followed once
by its length. Where a coordinate turns back, it could not drive the machine on: a dead centre.
Where the constraints lose rank, two motions meet: a change point (K. H. Hunt, Kinematic Geometry of
Mechanisms, 1978).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize_scalar

from codegen.errors import AnalysisError
from codegen.object_display import listed
from runtime.continuation.arclength import Curve, Piece, Point
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import Equations, FloatArray, IntArray
from runtime.results.assembled_state import Assembly, State
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import SingularPositions

_LARGEST, _SMALLEST = 0.1, 1e-9  # measured: steps along the curve, scaled
_BENT = 0.98  # measured: cosine of two tangents below which a step is too long
_MOST = 20_000  # safety: steps along the curve
_SAME = 1e-8  # accuracy: scaled distance of two positions that are one
_AT_CHANGE = 1e-6  # accuracy: of a direction at a change point, and of a singular value
_FAR = 100.0  # safety: scaled distance at which a motion is open
_TURN = 2.0 * np.pi


@dataclass(frozen=True, repr=False)
class MotionLimits:
    """How far a coordinate of a machine of one degree of freedom moves, on one closed motion.

    `turns` are whole turns in a cycle of the motion. The coordinate turns back in `limits`. In
    `dead_centres`, by coordinate, angles of bodies do, or places of bodies that do not turn. In
    `change_points` motions meet; there the motion is followed smoothly on. All are states at rest.
    """

    title: str
    coordinate: str
    turns: int
    limits: tuple[State, ...]
    dead_centres: Mapping[str, tuple[State, ...]]
    change_points: tuple[State, ...]

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value, m or rad; infinite of an angle that gains whole turns."""
        values = [state[self.coordinate] for state in self.limits]
        return (-np.inf, np.inf) if self.turns else (min(values), max(values))

    def __repr__(self) -> str:
        """How far the coordinate moves, and a line for each position."""
        name, far = self.coordinate, f"turns all around, {self.turns:+d} turn(s) in a cycle"
        if not self.turns:
            unit = self.limits[0].coordinates[name].unit
            far = f"moves from {self.range[0]:.9g} to {self.range[1]:.9g} {unit}"
        rows = [("limit", [name], state) for state in self.limits]
        rows += [("dead centre", [k, name], one) for k, s in self.dead_centres.items() for one in s]
        rows += [("change point", [name], state) for state in self.change_points]
        return "\n  ".join([f"{self.title}: {name} {far}", *(
            f"{kind}: " + " at ".join(f"{n} = {round(state[n], 12) + 0.0:.9g}" for n in names)
            for kind, names, state in rows
        )])  # fmt: skip


class MotionCurve(Curve):
    """The positions of a machine at one instant: time and states of first order stay."""

    def __init__(self, equations: Equations, begin: Assembly, place: int) -> None:
        rows, self.place = _kept_rows(equations, begin, place), place
        self.scale = equations.scale(equations.size(begin.t, begin.q))
        super().__init__(equations.scaled(self.scale, rows), begin.t, begin.q, 1.0)
        still = [*(row.is_state for row in begin.coordinates), True]
        self.origin, self.still = self.z(begin.t, begin.q), np.eye(len(still))[still]
        self.title, self.coordinates = equations.description.title, begin.coordinates

    def matrix(self, z: FloatArray) -> FloatArray:
        """[Φ_q, Φ_t], and rows for what stays."""
        return np.vstack([super().matrix(z), self.still])

    def gaps(self, z: FloatArray) -> FloatArray:
        """Φ, and how far what stays has moved."""
        return np.append(super().gaps(z), self.still @ (z - self.origin))

    def crossing(self, piece: Piece) -> Point | None:
        """The place in a piece at which another curve meets this one, with sign 0; None if none."""
        t, q = self.position(piece.start.z)
        v = piece.start.tangent[:-1] * self.scale
        motion, positions = taylor(t, q, v, np.zeros_like(v)), SingularPositions(self.constraints)
        found = positions.find(motion, 0.5 * piece.h, branch=True)
        if found is None:
            return None
        z = self.z(t, found.q)
        null = null_space(self.matrix(z), rcond=LOST)
        self.require_two_motions(z, null.shape[1])
        along = null @ (null.T @ self.z(0.0, v + found.veer))
        s = float((z - piece.start.z) @ piece.start.tangent)
        near = 0.0 < s < piece.h and np.abs(self.gaps(z)).max() < _SAME
        return Point(z, along / np.linalg.norm(along), 0.0) if near else None

    def narrowness(self, point: Point) -> float:
        """The smallest singular value of the matrix."""
        return float(np.linalg.norm(self.matrix(point.z), -2))

    def require_signs(self, pieces: list[Piece]) -> None:
        """Raise where the constraints lose rank, and the determinant keeps its sign."""
        least = [self.narrowness(piece.start) for piece in pieces]
        for k in np.flatnonzero((least <= np.roll(least, 1)) & (least <= np.roll(least, -1))):
            for start, h, end in (pieces[k - 1], pieces[k]):
                if start.sign and end.sign:  # else a change point is known
                    found = minimize_scalar(
                        lambda s, start: self.narrowness(self.across(start, s) or start),
                        args=(start,), bounds=(0.0, h), options={"xatol": 1e-10},
                    )  # fmt: skip
                    lost = 2 * int(found.fun < _AT_CHANGE)
                    self.require_two_motions(start.z + found.x * start.tangent, lost + 1)

    def require_two_motions(self, z: FloatArray, freedom: int) -> None:
        """Raise where so many degrees of freedom say that more than two motions meet."""
        row, x = self.coordinates[self.place], self.position(z)[1][self.place]
        if freedom > 2:
            raise AnalysisError(
                f"{self.title}: several motions meet near {row.name} = {x:.6g} {row.unit}; limits "
                "follows machines in which two cross. Change a length by a little."
            )


def motion_limits(equations: Equations, begin: Assembly, coordinate: str) -> MotionLimits:
    """How far a coordinate moves on the curve of an assembled start, its driver released."""
    table, title = begin.coordinates, equations.description.title
    place = table.index(coordinate)
    curve = MotionCurve(equations, begin, place)
    pieces, turns = _follow(curve)
    curve.require_signs(pieces)
    moving = np.flatnonzero(np.ptp([piece.start.z for piece in pieces], axis=0) > _SAME).tolist()
    if place not in moving:
        raise AnalysisError(f"{title}: {coordinate} rests while the machine moves.")

    def states(places: list[FloatArray]) -> tuple[State, ...]:
        return tuple(State(*curve.position(z), np.zeros(len(table)), table) for z in places)

    bodies = [row.name.rpartition(".")[0] for row in table]
    turning = {bodies[k] for k in moving if table[k].is_angle}
    back = {
        table[k].name: states(places)
        for k in moving
        if (k == place or table[k].is_angle or bodies[k] not in turning)
        and (places := _turning_places(curve, pieces, k))
    }
    limits, changes = back.pop(coordinate, ()), [p.end.z for p in pieces if p.end.sign == 0.0]
    return MotionLimits(title, coordinate, turns, limits, back, states(changes))


def _kept_rows(equations: Equations, begin: Assembly, place: int) -> IntArray:
    """The constraints along the curve: released are drivers of the coordinate, if none, all."""
    description = equations.description
    if begin.redundant:
        advice = "The others may lose rank elsewhere: for limits leave one of these joints out."
        raise AnalysisError([f"{description.title}: {one} {advice}" for one in begin.redundant])
    elements, drivers = [row.element for row in description.constraints], description.drivers
    acting = description.jacobian_rows[description.jacobian_columns == place]
    released = {elements[k] for k in acting}.intersection(drivers) or {*drivers}
    kept = [k for k, element in enumerate(elements) if element not in released]
    freedom = sum(not row.is_state for row in begin.coordinates) - len(kept)
    if freedom == 1:
        return np.array(kept, np.int64)
    raise AnalysisError(
        f"{description.title}: limits are those of a machine of one degree of freedom, and with "
        f"{listed(sorted(released), 'no driver')} released this one has {freedom}. Load a scene "
        "with other drivers, or name a coordinate with a driver: the others hold."
    )


def _follow(curve: MotionCurve) -> tuple[list[Piece], int]:
    """The pieces of the closed curve through the start, and the turns of the coordinate in it."""
    row, place = curve.coordinates[curve.place], curve.place
    start = curve.point(curve.origin, np.eye(len(curve.origin))[place])
    if start is None or curve.narrowness(start) < LOST:
        raise AnalysisError(
            f"{curve.title}: motions meet at the start, and it is not clear which one is meant. "
            "Start elsewhere, with start= of coordinates."
        )
    # A start is often a limit itself, which is clearer from a position beside it.
    beside = (curve.across(start, s) for s in 0.3 * _LARGEST * 0.5 ** np.arange(25))
    first = point = next((p for p in beside if p and p.tangent @ start.tangent > _BENT), None)
    is_angle = np.array([*(row.is_angle for row in curve.coordinates), False])
    pieces, h = list[Piece](), 0.5 * _LARGEST
    while point and first and h > _SMALLEST and len(pieces) < _MOST:
        there, change = curve.across(point, h), None
        fits = there is not None and float(there.tangent @ point.tangent) > _BENT
        if there and fits and there.sign * point.sign < 0.0:
            change = curve.crossing(Piece(point, h, there))
            fits = change is not None  # else it has landed on another curve
        if not there or not fits:
            h *= 0.5
            continue
        if change:
            s = float((change.z - point.z) @ point.tangent)
            pieces.append(Piece(point, s, change))
            point, h = change, h - s
        turns = np.where(is_angle, np.round((there.z - first.z) / _TURN), 0.0)
        goal = first.z + _TURN * turns
        s = float((goal - point.z) @ point.tangent)
        back = curve.across(point, s) if len(pieces) > 2 and 0.0 < s <= h else None
        if back and np.abs(back.z - goal).max() < _SAME:
            return [*pieces, Piece(point, s, back)], int(turns[place])
        pieces.append(Piece(point, h, there))
        point, h = there, min(1.5 * h, _LARGEST)
        if np.abs(there.z - first.z)[~is_angle].max() > _FAR:
            break
    reached = curve.position(point.z if point else curve.origin)[1][place]
    why = "moves on without end" if pieces and h > _SMALLEST else "cannot be followed on"
    raise AnalysisError(
        f"{curve.title}: the motion does not return to its start, but {why}. After {len(pieces)} "
        f"steps along it {row.name} is {reached:.6g} {row.unit}."
    )


def _turning_places(curve: MotionCurve, pieces: list[Piece], k: int) -> list[FloatArray]:
    """The places at which a coordinate turns back, in the order of the motion."""
    found, last = [], pieces[0].start
    for piece in pieces:
        start, there = piece.start, piece.end
        if abs(there.tangent[k]) <= (_AT_CHANGE if there.sign == 0.0 else 0.0):
            continue  # it may turn back just there
        if there.tangent[k] * last.tangent[k] < 0.0:
            if last is start:
                s = curve.locate(start, piece.h, lambda there: float(there.tangent[k]))
                start = curve.across(start, s) or there
            found.append(start.z)
        last = there
    return found
