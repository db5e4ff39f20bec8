"""The solids of a picture in space, from the places at which elements hold its bodies.

A solid is a unit form that a matrix carries into the frame of its body: a ball of radius 1, a
cylinder of radius 1 along z from -1 to 1, or a box from -1 to 1. The page draws them as they are,
figures their outlines; a plate is a box that hides nothing.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from codegen.drawing.meshes import Mesh, mesh_of
from codegen.drawing.picture import BAR, BLOCK, BOB, PIN, SAME, SpacePicture
from codegen.drawing.plane_geometry import FloatArray
from codegen.drawing.shapes import Mark, Pair, SpacePlace, Trace, places
from codegen.drawing.space_shapes import Bulk, Form, Push, SpaceJoint

ROUND = 32  # layout: corners of a cylinder and of a ball's rings
THIN = 0.6  # layout: radius of a bar, in half widths of a planar one
PLATE = (0.055, 0.007)  # layout: half width and half height of the plate of a ground mark
LINKS = 6.0  # layout: bodies in a typical length of a chain
STEM = 0.05  # layout: height of a ground mark
SLEEVE = 0.028  # layout: half length of the sleeve of a hinge
ROOM = 1.5  # layout: of the plate of a joint round the places that it holds, in half blocks
LARGEST, SMALLEST = 0.2, 0.012  # layout: half sizes of a body that follow from its inertia
BALL, DISC = (5 / 3) ** 0.5, (4 / 3) ** 0.5  # formula: radii, in half sides of a box of as much J
SPOKE = 0.035  # layout: half width of the spoke of a disc, in its radii
EQUAL = 0.02  # accuracy: of half sizes of a body that is drawn round


class Solid(NamedTuple):
    """A "ball", "cylinder", "box", "plate" or "mesh" of a body, and its matrix, (3, 4)."""

    form: str
    body: int
    matrix: FloatArray
    element: str = ""  # to which it belongs; of the body itself where there is none
    mesh: Mesh | None = None

    @property
    def center(self) -> FloatArray:
        """The place of its middle in its body, (3,), m."""
        return self.matrix[:, 3]

    @property
    def corners(self) -> FloatArray:
        """Points of its body, (k, 3), m, whose convex hull it is, or the corners of a mesh."""
        if self.mesh:
            return self.mesh.vertices
        return np.asarray(self.matrix[:, 3] + _CORNERS[self.form] @ self.matrix[:, :3].T)


_HOLDING = (Push, Mark, Trace)
"""Shapes of one place that belongs to its body."""
_ANGLES = 2.0 * np.pi * np.arange(ROUND) / ROUND
_RING = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(ROUND)])
_TILTS = np.pi * (np.arange(ROUND // 2 + 1) / (ROUND // 2) - 0.5)
_ABOVE = np.array([0.0, 0.0, 1.0])
_CORNERS = {
    "ball": np.concatenate([_RING * np.cos(a) + np.sin(a) * _ABOVE for a in _TILTS]),
    "cylinder": np.concatenate([_RING - _ABOVE, _RING + _ABOVE]),
    "box": np.stack(np.meshgrid([-1.0, 1], [-1.0, 1], [-1.0, 1]), axis=-1).reshape(-1, 3),
}
_CORNERS["plate"] = _CORNERS["box"]


def solids(picture: SpacePicture) -> list[Solid]:
    """The solids of all bodies and joints, which are fixed in bodies; of the first instant."""
    first = picture.first
    assert isinstance(first, SpacePicture)
    maker = _Maker(picture, first)
    found = [one for body in range(len(picture.bodies)) for one in maker.body(body)]
    found += [one for symbol in first.symbols for one in maker.joint(symbol.element, symbol.shape)]
    return [one for one in found if np.isfinite(one.matrix).all()]


def reach(picture: SpacePicture) -> float:
    """A typical length, m: the diagonal of the box about all bodies and the places that hold them.

    In a chain of short bodies it is `LINKS` of them; it is 1 m where everything is at one place.
    """
    held = [place for _, pair in picture.having(Pair) for place in (pair.i, pair.j)]
    own = [[picture.where(place) for place in held if place.body == k]
           for k in range(1, len(picture.bodies))]  # fmt: skip
    long = [_diagonal(points) for points in own if len(points) > 1]
    everything = [*map(picture.where, held), *picture.poses[1:, :3]]
    for _, form in picture.having(Form):
        everything += [*picture.in_world(mesh_of(form.mesh).vertices, form.at.body)]
    whole = min(_diagonal(everything), LINKS * float(np.median(long)) if any(long) else np.inf)
    bulks = [2.0 * half_sizes(bulk)[0].max() for _, bulk in picture.having(Bulk)]
    return whole or max(bulks, default=0.0) or 1.0


def _diagonal(points: list[FloatArray]) -> float:
    known = np.array(points).reshape(-1, 3)
    known = known[np.isfinite(known).all(axis=1)]
    return float(np.linalg.norm(np.ptp(known, axis=0))) if len(known) else 0.0


def half_sizes(bulk: Bulk) -> tuple[FloatArray, FloatArray]:
    """Half sizes, (3,), m, and axes as columns of a box with a mass and an inertia.

    a² = 3 (J_b + J_c - J_a) / 2m along each principal axis.
    """
    xx, yy, zz, xy, xz, yz = (
        _now(j) for j in (bulk.jxx, bulk.jyy, bulk.jzz, bulk.jxy, bulk.jxz, bulk.jyz)
    )
    moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    axes[:, 2] *= np.linalg.det(axes)
    square = 1.5 * (moments.sum() - 2.0 * moments) / _now(bulk.mass)
    return np.sqrt(np.maximum(square, 0.0)), axes


def _now(number: Any) -> float:
    return float(np.ravel(number)[0])


def axes_along(way: FloatArray) -> FloatArray:
    """Three axes as columns, (3, 3), of which the last one is a direction."""
    z = way / (np.linalg.norm(way) or 1.0)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def bar(body: int, start: Any, end: Any, radius: float, element: str = "") -> Solid:
    """A cylinder between two points."""
    way = np.asarray(end, dtype=float) - start
    axes = axes_along(way) * [radius, radius, np.linalg.norm(way) / 2.0]
    middle = start + way / 2.0
    return Solid("cylinder", body, np.column_stack([axes, middle]), element)


def ball(body: int, at: Any, radius: float, element: str = "") -> Solid:
    """A ball about a point."""
    return Solid("ball", body, np.column_stack([radius * np.eye(3), at]), element)


def box(body: int, at: Any, axes: FloatArray, halves: Any, element: str = "") -> Solid:
    """A box about a point, with axes as columns and half sizes along them."""
    return Solid("box", body, np.column_stack([axes * halves, at]), element)


def _point(place: SpacePlace) -> FloatArray:
    return np.array([_now(c) for c in place[1:]])


class _Maker:
    """What the solids of a picture follow from."""

    def __init__(self, picture: SpacePicture, first: SpacePicture) -> None:
        self.picture, self.first, self.size = picture, first, picture.size
        moving = first.poses[None] if picture.motion is None else picture.motion
        step = max(1, len(moving) // 500)  # layout: instants from which rails have their length
        self.motion = SpacePicture("", picture.bodies, moving[::step], first.symbols)
        self.meshes: dict[int, list[Mesh]] = {number: [] for number in range(len(picture.bodies))}
        for _, form in first.having(Form):
            self.meshes[form.at.body].append(mesh_of(form.mesh))

    def body(self, number: int) -> Iterator[Solid]:
        """What draws a body; else a bar or a star of bars, and what follows from the inertia."""
        size, first = self.size, self.first
        for mesh in self.meshes[number]:
            yield Solid("mesh", number, np.eye(3, 4), mesh=mesh)
        if first.is_ground(number) or self.meshes[number]:
            return
        radius = THIN * BAR * size
        held = self._held(number)
        bulk = next((b for _, b in first.having(Bulk) if b.at.body == number), None)
        if len(held) > 1 or (len(held) == 1 and np.linalg.norm(held[0]) > SAME * size):
            yield from self._bars(number, held, radius)
        blocks = (s.j.body for _, s in first.having(SpaceJoint) if s.form == "rail")
        if number in blocks:
            return
        if bulk is not None:
            yield from self._bulk(number, bulk)
        elif not held.any():
            yield ball(number, np.zeros(3), BOB * size)

    def _held(self, number: int) -> FloatArray:
        """The distinct places of a body that joints, rods and springs hold, (k, 3), m."""
        found: list[FloatArray] = []
        for symbol in self.first.symbols:
            pair = isinstance(symbol.shape, Pair)
            known = places(symbol.shape) if pair or isinstance(symbol.shape, _HOLDING) else []
            for place in known[: 2 if pair else 1]:
                at = _point(place)
                if place.body != number or not np.isfinite(at).all():
                    continue
                at_center = isinstance(symbol.shape, Push) and not at.any()
                is_new = all(np.linalg.norm(at - one) > SAME * self.size for one in found)
                if is_new and not at_center:
                    found.append(at)
        return np.array(found).reshape(-1, 3)

    def _bars(self, number: int, held: FloatArray, radius: float) -> Iterator[Solid]:
        """A bar through places on a line with the centre of mass, else bars to that centre."""
        points = np.concatenate([held, np.zeros((1, 3))])
        away = points - held[0]
        far = int(np.argmax(np.linalg.norm(away, axis=1)))
        along = away[far] / np.linalg.norm(away[far])
        shares = away @ along
        if np.linalg.norm(away - np.outer(shares, along), axis=1).max() < SAME * self.size:
            ends = held[0] + np.outer([shares.min(), shares.max()], along)
            yield bar(number, ends[0], ends[1], radius)
            if shares[-1] in (shares.min(), shares.max()) and np.linalg.norm(held, axis=1).all():
                yield ball(number, np.zeros(3), BOB * self.size)
            return
        for at in held:
            if at.any():
                yield bar(number, np.zeros(3), at, radius)
                yield ball(number, at, radius)

    def _bulk(self, number: int, bulk: Bulk) -> Iterator[Solid]:
        """A ball, a disc, a rod or a box with the inertia of a body, within a share of the size."""
        halves, axes = half_sizes(bulk)
        halves = halves * min(1.0, LARGEST * self.size / (halves.max() or 1.0))
        halves = np.maximum(halves, SMALLEST * self.size)
        if np.ptp(halves) < EQUAL * halves.max():
            yield ball(number, np.zeros(3), BALL * float(halves.max()))
            return
        for k in range(3):
            one, other = halves[k - 1], halves[k - 2]
            if abs(one - other) < EQUAL * halves.max():
                way, one = halves[k] * axes[:, k], DISC * float(one)
                yield bar(number, -way, way, one)
                if halves[k] < one:  # a spoke shows that it turns
                    spoke = np.full(3, SPOKE * one) + np.eye(3)[k] * halves[k]
                    spoke[k - 1] = 0.86 * one
                    yield box(number, np.zeros(3), axes, spoke)
                return
        yield box(number, np.zeros(3), axes, halves)

    def joint(self, element: str, shape: Any) -> Iterator[Solid]:
        """The solids of a joint, and what holds it to the ground."""
        pin = PIN * self.size
        if isinstance(shape, Mark):
            yield ball(shape.at.body, _point(shape.at), pin, element)
        if isinstance(shape, SpaceJoint):
            yield from self._form(element, shape, pin)
        if isinstance(shape, Pair) and getattr(shape, "form", "") != "rail":
            yield from self._ground(element, shape)

    def _form(self, element: str, joint: SpaceJoint, pin: float) -> Iterator[Solid]:
        i, j, at, block = joint.i, joint.j, _point(joint.i), BLOCK[0] * self.size
        h = np.zeros(3) if joint.axis is None else _point(joint.axis)
        axes = axes_along(h) if joint.axis else np.eye(3)
        low, high = self._travel(joint, axes)
        first, last = (low[2], high[2]) if joint.slides else (0.0, 0.0)
        if joint.form == "bead":  # its line begins at the body that has it
            first, last = min(first, 0.0), max(last, 0.0)
        inner = self.first.within(self.first.along(joint.axis), j.body) if joint.axis else h
        sleeve = SLEEVE * self.size
        match joint.form:
            case "hinge" | "shaft" | "bead":
                ends = at + (first - 1.6 * sleeve) * h, at + (last + 1.6 * sleeve) * h
                yield bar(i.body, *ends, 0.8 * pin, element)
                middle, half = _point(j), sleeve * inner
                sleeves = bar(j.body, middle - half, middle + half, 1.5 * pin, element)
                yield ball(j.body, middle, 1.7 * pin, element) if joint.form == "bead" else sleeves
            case "rail":
                ends = at + (first - 2 * block) * h, at + (last + 2 * block) * h
                yield bar(i.body, *ends, 0.7 * pin, element)
                halves = [BLOCK[1] * self.size, BLOCK[1] * self.size, block]
                if not self.meshes[j.body]:
                    yield box(j.body, _point(j), axes_along(inner), halves)
            case "plate":
                middle, half = (low + high) / 2.0, (high - low) / 2.0 + ROOM * block
                plate = box(i.body, at + axes @ [*middle[:2], 0.0], axes, [*half[:2], 0.4 * pin])
                yield plate._replace(form="plate", element=element)
                yield ball(j.body, _point(j), 1.7 * pin, element)
            case "cross":
                for end, axis in ((i, joint.axis), (j, joint.axis_j)):
                    middle, half = _point(end), 1.2 * sleeve * _point(axis)
                    yield bar(end.body, middle - half, middle + half, 0.8 * pin, element)
                yield ball(i.body, at, 1.2 * pin, element)
            case "clamp":
                yield box(i.body, at, np.eye(3), 1.3 * pin, element)
            case _:
                yield ball(i.body, at, 1.7 * pin, element)

    def _travel(self, joint: SpaceJoint, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and largest travel of place j from i along axes of body i, (3,), m."""
        away = self.motion.where(joint.j) - self.motion.where(joint.i)
        travel = self.motion.within(away, joint.i.body) @ axes
        travel = travel[np.isfinite(travel).all(axis=1)]
        if not len(travel):
            travel = np.zeros((1, 3))
        return travel.min(axis=0), travel.max(axis=0)

    def _ground(self, element: str, pair: Pair) -> Iterator[Solid]:
        """A plate on a stem below each place on the ground; a plane there needs none."""
        size, up = self.size, self.picture.up
        for place in (pair.i, pair.j)[getattr(pair, "form", "") == "plate" :]:
            if self.first.is_ground(place.body):
                at = _point(place)
                foot = at - STEM * size * up
                axis = getattr(pair, "axis", None)
                if axis is not None and abs(self.first.along(axis) @ up) > 0.9:
                    foot = at - (STEM + SLEEVE) * size * up
                yield bar(place.body, foot, at, 0.8 * PIN * size, element)
                half, high = (part * size for part in PLATE)
                yield box(place.body, foot, axes_along(up), [half, half, high], element)


def held_apart(picture: SpacePicture, joint: SpaceJoint) -> FloatArray:
    """From place i of a joint to place j, (3,), m, without the share along which it slides."""
    away = np.asarray(picture.where(joint.j) - picture.where(joint.i))
    if joint.axis is None or not (joint.slides or joint.form == "plate"):
        return away
    way = picture.along(joint.axis)
    along = (away @ way) * way
    return along if joint.form == "plate" else away - along
