"""The picture of a mechanism as numbers: bodies with outlines, shapes of elements, poses.

Its layout says which number of a kernel stands where in it. A generated module has the layout as
plain tuples, and the kernel `picture` writes the numbers, so that a picture of any instant and any
parameters needs neither the model nor SymPy.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from codegen.drawing import shapes, space_shapes
from codegen.drawing.plane_geometry import FloatArray, Points, in_frame, placed
from codegen.drawing.shapes import Course, OneShape, Place, Shape, SpacePlace, changed, places

# Sizes of signs, in typical lengths, so that machines of all sizes look alike.
BAR = 0.021  # layout: half width of a bar, in typical lengths
CHEEK = 0.034  # layout: half width of a bar with a slot
PIN = 0.0115  # layout: radius of a pin
SLOT = 0.016  # layout: half width of a slot
BOB = 0.036  # layout: radius of the disc at a centre of mass
PARTICLE = 0.026  # layout: radius of a body that nothing holds
BLOCK = (0.062, 0.038)  # layout: half length and half width of a block on a guide
SAME = 2e-3  # layout: places nearer than this are one
HATCH = 0.0155  # layout: distance of the strokes of a hatching
SPRING = 0.021  # layout: half width of a spring
ARROW = 0.15  # layout: length of an arrow that is not to scale
HEAD = 0.032  # layout: length of an arrow's head
ROUND_ARROW = 0.062  # layout: radius of a driver's round arrow


@dataclass(frozen=True)
class BodyPicture:
    """A body: its name, whether it is the ground, and its outlines, given or derived."""

    name: str
    fixed: bool = False
    outlines: tuple[Points, ...] = ()  # closed polygons in its frame, (k,), m
    is_derived: bool = True  # the outlines follow from the joints; the modeller gave none


@dataclass(frozen=True)
class Symbol:
    """A shape, and the element that it belongs to.

    `spans` are those of time, s, in which it acts, without their ends; none: it always acts.
    """

    element: str
    kind: str  # of the element, as "revolute"
    role: str  # "joint", "driver" or "force"
    shape: Shape
    spans: tuple[tuple[float, float], ...] = ()

    def acts(self, t: float) -> bool:
        """Whether it acts at an instant, s."""
        return not self.spans or any(first <= t < last for first, last in self.spans)


@dataclass(frozen=True)
class Picture:
    """A mechanism at one instant, or in motion, at k instants.

    In motion it has the symbols of all that acts at any time, whose numbers, if they vary, have a
    value for each instant, (k,).
    """

    title: str  # model and scene
    bodies: tuple[BodyPicture, ...]  # the ground first
    poses: FloatArray  # x, y in m and φ in rad of each body, (bodies, 3); in motion (k, bodies, 3)
    symbols: tuple[Symbol, ...]
    size: float = 1.0  # m, a typical length by which signs of no size of their own are scaled
    # poses of the whole run, (instants, bodies, 3): guides and surfaces are as long as it needs
    motion: FloatArray | None = None
    t: FloatArray | None = None  # in motion the instants, s, (k,)

    def at(self, place: Place) -> Any:
        """A place in the global frame, x + iy in m."""
        return self.placed(place.point, place.body)

    def placed(self, points: Any, body: int) -> Any:
        """Points of a body in the global frame."""
        return placed(points, self.poses[..., body, :])

    def in_body(self, points: Any, body: int) -> Any:
        """Points of the global frame in that of a body."""
        return in_frame(points, self.poses[..., body, :])

    def turned(self, direction: Any, body: int) -> Any:
        """A direction of a body in the global frame."""
        return direction * np.exp(1j * self.poses[..., body, 2])

    def path(self, place: Place) -> Points:
        """A place in the global frame during the motion, (instants,), m; without one as it is."""
        poses = self.poses[None] if self.motion is None else self.motion
        return np.asarray(placed(place.point, poses[:, place.body]))

    def is_ground(self, body: int) -> bool:
        """Whether a body is fixed."""
        return self.bodies[body].fixed

    def having(self, *kinds: type[OneShape]) -> list[tuple[Symbol, OneShape]]:
        """The symbols whose shapes are of one of these kinds, and the shapes."""
        return [(s, s.shape) for s in self.symbols if isinstance(s.shape, kinds)]

    def partners(self, shape: Shape, *kinds: type[Shape]) -> list[Any]:
        """The shapes of these kinds that the element of a shape has."""
        elements = {symbol.element for symbol in self.symbols if symbol.shape is shape}
        return [one for symbol, one in self.having(*kinds) if symbol.element in elements]

    def shifts(self, first: "Picture") -> dict[tuple[str, int], Any]:
        """Element and body → how far a place there lies from where an alike picture has it, m.

        Places that stay where they are in their bodies are left out.
        """
        here, there = self._held(), first._held()
        both = ((key, zip(there.get(key, ()), here[key], strict=False)) for key in here)
        return {key: now - was for key, pairs in both for was, now in pairs if np.any(now != was)}

    def _held(self) -> dict[tuple[str, int], list[Any]]:
        """Element and body → the points of its places there, in its frame, m."""
        found: dict[tuple[str, int], list[Any]] = {}
        for symbol in self.symbols:
            for place in places(symbol.shape):
                found.setdefault((symbol.element, place.body), []).append(place.point)
        return found

    @property
    def first(self) -> "Picture":
        """The first instant, with the shapes of all elements that act at any time."""
        return self if self.t is None else self.instant(0)

    def instant(self, k: int) -> "Picture":
        """An instant of a motion, with the shapes of all elements that act at any time."""

        def now(values: Any) -> float:
            return float(values[k]) if np.ndim(values) else values

        symbols = tuple(replace(one, shape=changed(now, one.shape)) for one in self.symbols)
        return replace(self, poses=self.poses[k], symbols=symbols, t=None)

    def frames(self) -> list["Picture"]:
        """The picture of each instant of a motion, with the shapes of what acts there."""
        frames = []
        for k, t in enumerate([] if self.t is None else self.t):
            frame = self.instant(k)
            acting = tuple(one for one in frame.symbols if one.acts(t))
            frames.append(replace(frame, symbols=acting))
        return frames


AZIMUTH, HEIGHT = 0.6, 0.42  # layout: rad by which the usual view is turned from the front one
FLAT = 1e-9  # accuracy: a smaller acceleration of gravity, m/s², is none


def turned(vectors: Any, p: FloatArray) -> FloatArray:
    """Vectors of a body, (..., 3), in global axes, by its Euler parameters, (..., 4)."""
    scalar, e = p[..., :1], p[..., 1:]
    return np.asarray(vectors + 2.0 * np.cross(e, np.cross(e, vectors) + scalar * vectors))


@dataclass(frozen=True)
class SpacePicture(Picture):
    """The same of a machine in space, with poses x, y, z, e0 … e3 of each body, (..., 7).

    As a planar picture it is the projection onto the plane of its view: places are points of that
    plane, and so are the points of its strokes, of whatever body.
    """

    seen: str = "usual"  # of `presentation.VIEWS`

    def where(self, place: SpacePlace) -> FloatArray:
        """A place in the global frame, (..., 3), m."""
        point = np.stack(np.broadcast_arrays(*place[1:]), axis=-1)
        return self.in_world(point, place.body)

    def in_world(self, points: Any, body: int) -> FloatArray:
        """Points of a body, (..., 3), in the global frame."""
        pose = self.poses[..., body, :]
        return np.asarray(pose[..., :3] + turned(points, pose[..., 3:]))

    def along(self, direction: SpacePlace) -> FloatArray:
        """A direction of a body, given as a place of it, in global axes, (..., 3)."""
        return np.asarray(self.where(direction) - self.poses[..., direction.body, :3])

    def within(self, vectors: Any, body: int) -> FloatArray:
        """Vectors of the global frame, (..., 3), in the axes of a body."""
        return turned(vectors, self.poses[..., body, 3:] * [1, -1, -1, -1])

    def at(self, place: Any) -> Any:
        """A place in the plane of the view, x + iy in m."""
        return self.flat(self.where(place))

    def placed(self, points: Any, body: int) -> Any:
        """Points of the plane of the view, as they are."""
        return points

    def path(self, place: Any) -> Points:
        """A place in the plane of the view during the motion, (instants,), m."""
        moving = self if self.motion is None else replace(self, poses=self.motion)
        return np.atleast_1d(moving.at(place))

    @cached_property
    def up(self) -> FloatArray:
        """The axis, (3,), that points upward: most nearly against gravity, else z."""
        for _, pull in self.having(space_shapes.Pull):
            g = np.array([np.ravel(c)[0] for c in (pull.gx, pull.gy, pull.gz)], dtype=float)
            if np.abs(g).max() > FLAT:
                k = int(np.argmax(np.abs(g)))
                return np.asarray(-np.sign(g[k]) * np.eye(3)[k])
        return np.array([0.0, 0.0, 1.0])

    @property
    def level(self) -> tuple[FloatArray, FloatArray]:
        """The axes to the right and upward of the view from the front."""
        return np.array([0.0, 1.0, 0.0] if self.up[0] else [1.0, 0.0, 0.0]), self.up

    @cached_property
    def view(self) -> FloatArray:
        """The view: the axes to the right, upward and toward the viewer, as rows, (3, 3)."""
        right, _ = self.level
        if self.seen != "usual":
            toward = np.eye(3)["xyz".index(self.seen[-1])] * (-1) ** self.seen.startswith("-")
            right = right if toward @ self.up else np.cross(self.up, toward)
            return np.array([right, np.cross(toward, right), toward])
        front = np.cross(right, self.up)
        (c, s), (ch, sh) = ((np.cos(a), np.sin(a)) for a in (AZIMUTH, HEIGHT))
        right, front = c * right - s * front, s * right + c * front
        return np.array([right, ch * self.up - sh * front, sh * self.up + ch * front])

    def flat(self, vectors: Any) -> Any:
        """Vectors of the global frame, (..., 3), in the plane of the view."""
        return vectors @ (self.view[0] + 1j * self.view[1])


SAMPLES = 181  # layout: of a closed curve, ends included
KINDS, SPACE_KINDS = (
    {
        cls.kind: cls for cls in vars(room).values()
        if isinstance(cls, type) and issubclass(cls, Shape) and cls.kind
    } for room in (shapes, space_shapes)
)  # fmt: skip
# Digests of the kinds and their fields: a module with another one was written by another version.
VERSION, SPACE_VERSION = (
    hashlib.sha256(
        repr([(kind, [f.name for f in fields(cls)]) for kind, cls in kinds.items()]).encode()
    ).hexdigest()[:16]
    for kinds in (KINDS, SPACE_KINDS)
)


SPACE_POSE = 7  # formula: numbers of a pose in space


class BodyLayout(NamedTuple):
    """A body: slots of x, y and φ, or of x, y, cos φ and sin φ; outlines as pairs of slots.

    In space the slots are those of x, y, z and e0 to e3.
    """

    name: str
    fixed: bool
    pose: tuple[int, ...]
    outlines: tuple[tuple[tuple[int, int], ...], ...]


class ShapeLayout(NamedTuple):
    """A shape: its fields in their order, each a pair (what it is, where to find it).

    ("at", (body, slot, slot)), in space with a third slot, is a place, ("number", slot) a number,
    ("body", number) a body, ("bodies", numbers) several, ("curve", (body, number)) a curve, and
    ("word", value) a plain value.
    """

    element: str
    kind: str
    role: str
    shape: str
    fields: tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Layout:
    """The layout of a scene's picture."""

    title: str
    bodies: tuple[BodyLayout, ...]
    shapes: tuple[ShapeLayout, ...]

    @property
    def curves(self) -> int:
        """How many curves there are."""
        return sum(what == "curve" for row in self.shapes for what, _ in row.fields)

    @property
    def size(self) -> int:
        """How many slots there are: each is written once."""
        of_bodies = sum(len(b.pose) + 2 * sum(map(len, b.outlines)) for b in self.bodies)
        values = [value for row in self.shapes for value in row.fields]
        of_places = sum(len(where) - 1 for what, where in values if what == "at")
        return of_bodies + of_places + sum(what == "number" for what, _ in values)

    def picture(
        self, t: FloatArray, numbers: FloatArray, curves: Callable[[float], FloatArray]
    ) -> Picture:
        """The picture in motion, without outlines that follow from joints, of size 1.

        At the instants t, s, (k,), the kernel `picture` writes the numbers, (k, slots). `curves`
        are x and y of the first, the second and so on, m, at a parameter of theirs, rad.
        """
        places = np.linspace(0.0, 2.0 * np.pi, SAMPLES if self.curves else 0)
        points = np.array([curves(float(at)) for at in places]).reshape(len(places), self.curves, 2)

        def value(what: str, where: Any) -> Any:
            match what:
                case "at":
                    found = (constant_or_all(numbers[:, slot]) for slot in where[1:])
                    return (Place if len(where) == 3 else SpacePlace)(where[0], *found)
                case "number":
                    return constant_or_all(numbers[:, where])
                case "curve":
                    return Course(where[0], points[:, where[1]] @ [1, 1j])
            return where

        known = KINDS | SPACE_KINDS
        symbols = tuple(
            Symbol(*row[:3], known[row.shape](*(value(*field) for field in row.fields)))
            for row in self.shapes
        )
        if len(self.bodies[0].pose) == SPACE_POSE:
            names = tuple(BodyPicture(body.name, body.fixed) for body in self.bodies)
            slots = np.array([body.pose for body in self.bodies])
            return SpacePicture(self.title, names, numbers[:, slots], symbols, t=t)
        bodies, poses = [], np.empty((len(t), len(self.bodies), 3))
        for number, (name, fixed, (x, y, *turn), outlines) in enumerate(self.bodies):
            polygons = [numbers[0, np.array(line)] @ [1, 1j] for line in outlines]
            bodies.append(BodyPicture(name, fixed, tuple(polygons), not outlines))
            angle = numbers[:, turn[0]]
            if len(turn) > 1:
                angle = np.unwrap(np.arctan2(numbers[:, turn[1]], angle))
            poses[:, number] = np.column_stack([numbers[:, x], numbers[:, y], angle])
        return Picture(self.title, tuple(bodies), poses, symbols, t=t)


def constant_or_all(values: FloatArray) -> float | FloatArray:
    """The value of a number over time, (k,), if it has one at all instants, else all."""
    known = values[np.isfinite(values)]
    varies = len(known) > 0 and (len(known) < len(values) or float(np.ptp(known)) > 0.0)
    return values if varies else float(values[0])
