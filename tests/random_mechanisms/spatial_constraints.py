"""Constraints between rotation matrices, with slopes by (ṙ, ω) and second derivatives by hand.

Three kinds of scalars make every joint: a·b of two vectors, a·(p_j - p_i) of a vector and two
points, and |p_j - p_i| of two points; the angle of a joint is made of two of the first kind, and a
screw, a gear or a rack is a sum of angles and scalars. Every vector and point is fixed in a body;
the ground is the last body. Nothing here takes an absolute value or a conjugate, so that a complex
step differentiates it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts


@dataclass(frozen=True)
class SpatialState:
    """Centres of mass r (n, 3), rotation matrices R (n, 3, 3), ṙ (n, 3), ω (n, 3) in global axes.

    `turned` holds for each joint with an angle (see `Layout.angles`) a value within half a turn of
    its angle: it says how many turns the angle has.
    """

    r: Any
    R: Any
    v: Any
    w: Any
    turned: Any

    @property
    def body_rates(self) -> Any:
        """ω′ (n, 3): angular velocities in the axes of their bodies."""
        return np.einsum("bji,bj->bi", self.R, self.w)

    @property
    def euler_parameters(self) -> Any:
        """e0 … e3 (n, 4), of which the first is not negative: p and -p are one attitude."""
        p = Rotation.from_matrix(self.R).as_quat()[:, [3, 0, 1, 2]]
        return np.where(p[:, :1] < 0, -p, p)


@dataclass(frozen=True)
class Scalars:
    """Scalars s (m,), slopes `by` (m, n + 1, 6) with ṡ = Σ by·(ṙ, ω), and s̈ - Σ by·(r̈, ω̇)."""

    value: Any
    by: Any
    second: Any


class Frames:
    """The bodies of a state with the ground behind them, and what is fixed in them."""

    def __init__(self, state: SpatialState) -> None:
        still = np.zeros((1, 3))
        self.r = np.vstack([state.r, still])
        self.R = np.concatenate([state.R, np.eye(3)[None]])
        self.v, self.w = np.vstack([state.v, still]), np.vstack([state.w, still])

    def vectors(self, body: Any, a: Any) -> tuple[Any, Any, Any]:
        """Vectors in global axes, their rates, and their second rates without ω̇."""
        turned = np.einsum("kij,kj->ki", self.R[body], a)
        w = self.w[body]
        rate = cross(w, turned)
        return turned, rate, cross(w, rate)

    def points(self, body: Any, s: Any) -> tuple[Any, Any, Any, Any]:
        """Arms from the centres of mass, points, velocities, accelerations without r̈ and ω̇."""
        arm, rate, second = self.vectors(body, s)
        return arm, self.r[body] + arm, self.v[body] + rate, second


def cross(a: Any, b: Any) -> Any:
    """a × b of vectors in the last axis; a fifth of the time of NumPy's."""
    after, before = [1, 2, 0], [2, 0, 1]
    return a[..., after] * b[..., before] - a[..., before] * b[..., after]


def products(at: Frames, i: Any, a: Any, j: Any, b: Any) -> Scalars:
    """a·b of vectors of bodies i and j."""
    (a, da, dda), (b, db, ddb) = at.vectors(i, a), at.vectors(j, b)
    by = _zeros(at, len(i), a)
    rows, across = np.arange(len(i)), cross(a, b)
    by[rows, i, 3:] += across
    by[rows, j, 3:] -= across
    second = np.sum(dda * b + 2.0 * da * db + a * ddb, axis=1)
    return Scalars(np.sum(a * b, axis=1), by, second)


def offsets(at: Frames, k: Any, a: Any, i: Any, s_i: Any, j: Any, s_j: Any) -> Scalars:
    """a·(p_j - p_i) of a vector of body k and points of bodies i and j."""
    a, da, dda = at.vectors(k, a)
    arm_i, p_i, v_i, c_i = at.points(i, s_i)
    arm_j, p_j, v_j, c_j = at.points(j, s_j)
    d, rate = p_j - p_i, v_j - v_i
    by, rows = _zeros(at, len(i), a), np.arange(len(i))
    by[rows, k, 3:] += cross(a, d)
    by[rows, i, :3] -= a
    by[rows, i, 3:] -= cross(arm_i, a)
    by[rows, j, :3] += a
    by[rows, j, 3:] += cross(arm_j, a)
    second = np.sum(dda * d + 2.0 * da * rate + a * (c_j - c_i), axis=1)
    return Scalars(np.sum(a * d, axis=1), by, second)


def distances(at: Frames, i: Any, s_i: Any, j: Any, s_j: Any) -> Scalars:
    """|p_j - p_i| of points of bodies i and j."""
    arm_i, p_i, v_i, c_i = at.points(i, s_i)
    arm_j, p_j, v_j, c_j = at.points(j, s_j)
    d, rate = p_j - p_i, v_j - v_i
    length = np.sqrt(np.sum(d * d, axis=1))
    u = d / length[:, None]
    by, rows = _zeros(at, len(i), u), np.arange(len(i))
    by[rows, i, :3] -= u
    by[rows, i, 3:] -= cross(arm_i, u)
    by[rows, j, :3] += u
    by[rows, j, 3:] += cross(arm_j, u)
    along = np.sum(u * rate, axis=1)
    second = np.sum(u * (c_j - c_i), axis=1) + (np.sum(rate * rate, axis=1) - along**2) / length
    return Scalars(length, by, second)


def angles(at: Frames, cosine: Scalars, sine: Scalars, near: Any) -> Scalars:
    """The angles of (cosine, sine), in the turn that is nearest to `near`."""
    c, s = cosine.value, sine.value
    square = c * c + s * s
    velocity = np.concatenate([at.v, at.w], axis=1)

    def rate(of: Scalars) -> Any:
        return np.einsum("kbx,bx->k", of.by, velocity)

    by = (c[:, None, None] * sine.by - s[:, None, None] * cosine.by) / square[:, None, None]
    turning = (c * rate(sine) - s * rate(cosine)) / square
    growing = 2.0 * (c * rate(cosine) + s * rate(sine)) / square
    second = (c * sine.second - s * cosine.second) / square - turning * growing
    principal = np.arctan2(s.real, c.real)
    small = np.arctan(  # exact, and differentiable by a complex step: about 0 after turning back
        (s * np.cos(principal) - c * np.sin(principal))
        / (c * np.cos(principal) + s * np.sin(principal))
    )
    turns = np.round((near - principal) / (2.0 * np.pi))
    return Scalars(principal + 2.0 * np.pi * turns + small, by, second)


def _zeros(at: Frames, rows: int, like: Any) -> Any:
    return np.zeros((rows, len(at.r), 6), dtype=like.dtype)


KINDS = ("product", "offset", "distance")


class Layout:
    """The scalars of a mechanism's joints, in arrays by kind.

    Attributes
    ----------
    angles : names of joints whose angle a driver or a spring asks for
    rows : joint or driver → its rows of the constraint Jacobian
    """

    def __init__(self, mechanism: parts.SpatialMechanism) -> None:
        self.mechanism = mechanism
        self.angles = tuple(dict.fromkeys(_asked(mechanism)))
        self.at_drawing = _drawing(mechanism, len(self.angles))
        self._frames = Frames(self.at_drawing)
        self._lists: dict[str, list[tuple[Any, ...]]] = {kind: [] for kind in KINDS}
        pairs = np.array([self._angle(mechanism.joint(name)) for name in self.angles], int)
        self._cosines, self._sines = pairs.reshape(-1, 2).T
        order: list[tuple[str, int]] = []  # kind and place of each row
        self._order = order
        self._terms: list[list[tuple[float, str, int]]] = []  # of sums: factor, kind and place
        self.rows: dict[str, slice] = {}
        self._laws: list[tuple[int, parts.Law | float]] = []  # row and what it is equal to
        for joint in mechanism.joints:
            begin = len(order)
            self._add(joint)
            self.rows[joint.name] = slice(begin, len(order))
        sizes = np.cumsum([0, *(len(rows) for rows in self._lists.values()), len(self.angles)])
        first = dict(zip((*KINDS, "angle", "sum"), sizes.tolist(), strict=True))
        self._sums = np.zeros((len(self._terms), sizes[-1]))
        for k, terms in enumerate(self._terms):
            for factor, kind, place in terms:
                self._sums[k, first[kind] + place] += factor
        self._places = np.array([first[kind] + place for kind, place in order], int)
        self._arrays = [_columns(rows, width) for rows, width in
                        zip(self._lists.values(), (4, 6, 4), strict=True)]  # fmt: skip

    def fixed_point(self, body: int, at: Any) -> Any:
        """A point at the drawing, in the frame of its body."""
        return self._frames.R[body].T @ (np.asarray(at, float) - self._frames.r[body])

    def fixed_vector(self, body: int, axis: Any) -> Any:
        """A unit vector at the drawing, in the axes of its body."""
        axis = np.asarray(axis, float)
        return self._frames.R[body].T @ (axis / np.linalg.norm(axis))

    def scalars(self, state: SpatialState) -> tuple[Scalars, Scalars]:
        """The rows without their laws, and the angles of `angles`."""
        at = Frames(state)
        functions = products, offsets, distances
        kinds = [f(at, *columns) for f, columns in zip(functions, self._arrays, strict=True)]
        pair = (_taken(kinds[0], places) for places in (self._cosines, self._sines))
        turns = angles(at, *pair, state.turned)
        kinds.append(turns)
        together = Scalars(*(np.concatenate([getattr(kind, name) for kind in kinds])
                             for name in ("value", "by", "second")))  # fmt: skip
        both = (getattr(together, name) for name in ("value", "by", "second"))
        whole = Scalars(*(np.concatenate([x, np.tensordot(self._sums, x, axes=1)]) for x in both))
        return _taken(whole, self._places), turns

    def laws(self, t: float) -> Any:
        """What the rows are equal to, and its first and second rates: (3, rows)."""
        found = np.zeros((3, len(self._order)))
        for row, law in self._laws:
            found[:, row] = law_rates(law, t) if isinstance(law, parts.Law) else (law, 0.0, 0.0)
        return found

    def _append(self, kind: str, *numbers: Any) -> int:
        self._lists[kind].append(numbers)
        return len(self._lists[kind]) - 1

    def _row(self, kind: str, *numbers: Any) -> None:
        self._order.append((kind, self._append(kind, *numbers)))

    def _angle(self, joint: Any) -> tuple[int, int]:
        f, g, _ = triad(getattr(joint, "hinge", joint.axis))
        i, j = joint.i, joint.j
        end = self.fixed_vector(j, f)
        return (self._append("product", i, self.fixed_vector(i, f), j, end),
                self._append("product", i, self.fixed_vector(i, g), j, end))  # fmt: skip

    def _sum(self, *terms: tuple[float, str, int]) -> None:
        self._order.append(("sum", len(self._terms)))
        self._terms.append([*terms])

    def _turn(self, name: str) -> tuple[str, int]:
        return "angle", self.angles.index(name)

    def _slide(self, of: Any) -> tuple[str, int]:
        ends = of.i, self.fixed_point(of.i, of.at), of.j, self.fixed_point(of.j, of.at)
        return "offset", self._append("offset", of.i, self.fixed_vector(of.i, of.axis), *ends)

    def _length(self, i: int, at_i: Any, j: int, at_j: Any) -> None:
        self._laws.append((len(self._order), float(np.linalg.norm(np.subtract(at_j, at_i)))))
        self._row("distance", i, self.fixed_point(i, at_i), j, self.fixed_point(j, at_j))

    def _right_angles(self, i: int, j: int, pairs: Any) -> None:
        for a, b in pairs:
            self._row("product", i, self.fixed_vector(i, a), j, self.fixed_vector(j, b))

    def _offset(self, k: int, axis: Any, i: int, at_i: Any, j: int, at_j: Any) -> None:
        points = i, self.fixed_point(i, at_i), j, self.fixed_point(j, at_j)
        self._row("offset", k, self.fixed_vector(k, axis), *points)

    def _add(self, joint: Any) -> None:
        match joint:
            case parts.PointDriver(_, body, at, letter, law):
                axis = np.eye(3)["xyz".index(letter)]
                self._laws.append((len(self._order), law))
                self._offset(parts.GROUND, axis, parts.GROUND, np.zeros(3), body, at)
            case parts.DistanceDriver(_, i, j, at_i, at_j, law):
                self._laws.append((len(self._order), law))
                self._row("distance", i, self.fixed_point(i, at_i), j, self.fixed_point(j, at_j))
            case parts.SphericalSpherical(_, i, j, at_i, at_j):
                self._length(i, at_i, j, at_j)
            case parts.RevoluteSpherical(_, i, j, at_i, at_j, axis):
                f, g, h = triad(axis)
                if isinstance(joint, parts.RevoluteRevolute):
                    self._right_angles(i, j, [(f, h), (g, h)])
                self._offset(i, h, i, at_i, j, at_j)
                self._length(i, at_i, j, at_j)
            case parts.Rack(_, name, driven, ratio):
                slide = self._slide(self.mechanism.joint(driven))
                self._sum((1.0, *slide), (-ratio, *self._turn(name)))
            case parts.Gear(_, name, driven, ratio):
                self._sum((1.0, *self._turn(driven)), (-ratio, *self._turn(name)))
            case parts.AngleDriver(_, name, law):
                self._laws.append((len(self._order), law))
                self._order.append(("angle", self.angles.index(name)))
            case parts.SlideDriver(_, name, law):
                of: Any = self.mechanism.joint(name)
                self._laws.append((len(self._order), law))
                self._offset(of.i, of.axis, of.i, of.at, of.j, of.at)
            case _:
                self._add_joint(joint)

    def _add_joint(self, joint: Any) -> None:
        i, j, at = joint.i, joint.j, joint.at
        f, g, h = triad(getattr(joint, "axis", (0.0, 0.0, 1.0)))
        match joint:
            case parts.Spherical() | parts.Revolute() | parts.Universal() | parts.Weld():
                for axis in np.eye(3):
                    self._offset(parts.GROUND, axis, i, at, j, at)
            case (parts.Translational() | parts.Cylindrical() | parts.PointOnLine()
                  | parts.Screw() | parts.RevoluteCylindrical()):  # fmt: skip
                for axis in (f, g):
                    self._offset(i, axis, i, at, j, at)
            case parts.Planar() | parts.PointInPlane():
                self._offset(i, h, i, at, j, at)
        match joint:
            case (parts.Revolute() | parts.Cylindrical() | parts.Planar() | parts.ParallelAxes()
                  | parts.Screw()):  # fmt: skip
                self._right_angles(i, j, [(f, h), (g, h)])
            case parts.RevoluteTranslational():
                a, b, hinge = triad(joint.hinge)
                self._right_angles(i, j, [(a, hinge), (b, hinge)])
            case parts.RevoluteCylindrical():
                self._angle_of(i, h, j, joint.hinge)
            case parts.Translational() | parts.Weld():
                self._right_angles(i, j, [(f, h), (g, h), (f, g)])
            case parts.Universal(_, _, _, _, axis_i, axis_j):
                self._angle_of(i, axis_i, j, axis_j)
        if isinstance(joint, parts.Screw):
            per_turn = joint.lead / (2.0 * np.pi)
            self._sum((1.0, *self._slide(joint)), (-per_turn, *self._turn(joint.name)))

    def _angle_of(self, i: int, a: Any, j: int, b: Any) -> None:
        """Two vectors keep their angle."""
        cosine = np.dot(a, b) / (np.linalg.norm(a) * np.linalg.norm(b))
        self._laws.append((len(self._order), float(cosine)))
        self._right_angles(i, j, [(a, b)])


def _asked(mechanism: parts.SpatialMechanism) -> Iterator[str]:
    """The joints whose angle something contains."""
    for part in (*mechanism.joints, *mechanism.effects):
        match part:
            case parts.AngleDriver(_, joint) | parts.TorsionSpring(_, joint):
                yield joint
            case parts.Screw(name):
                yield name
            case parts.Rack(_, joint):
                yield joint
            case parts.Gear(_, joint, driven):
                yield from (joint, driven)
            case parts.Friction(_, joint):
                if not isinstance(mechanism.joint(joint), parts.Translational):
                    yield joint


def _drawing(mechanism: parts.SpatialMechanism, turning: int) -> SpatialState:
    n = len(mechanism.bodies)
    r = np.array([body.r for body in mechanism.bodies], float).reshape(n, 3)
    R = np.array([body.A for body in mechanism.bodies], float).reshape(n, 3, 3)
    return SpatialState(r, R, np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(turning))


def triad(axis: Any) -> tuple[Any, Any, Any]:
    """Two unit vectors at right angles to an axis, and its own, right-handed."""
    h = np.asarray(axis, float)
    h = h / np.linalg.norm(h)
    f = cross(h, np.eye(3)[np.argmin(np.abs(h))])
    f = f / np.linalg.norm(f)
    return f, cross(h, f), h


def law_rates(law: parts.Law, t: float) -> tuple[float, float, float]:
    """A law's value, rate and second rate."""
    angle, w = law.frequency * t + law.phase, law.frequency
    rate = law.rate + law.amplitude * w * np.cos(angle)
    return law(t), float(rate), float(-law.amplitude * w * w * np.sin(angle))


def _columns(rows: list[tuple[Any, ...]], width: int) -> list[Any]:
    if not rows:  # a body, or a vector, in turn
        return [np.zeros((0, 3)) if k % 2 else np.zeros(0, int) for k in range(width)]
    return [np.array(column) for column in zip(*rows, strict=True)]


def _taken(of: Scalars, places: Any) -> Scalars:
    return Scalars(of.value[places], of.by[places], of.second[places])
