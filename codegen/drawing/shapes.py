"""The shapes of which the picture of a mechanism consists, one class each.

An element returns shapes whose places are its points and whose numbers are expressions; in a
`Picture` the same classes have a `Place` for every point, and for every number a float or, where it
varies, its values over time, (k,). Lengths are in m, in the frame of the body of the place;
directions are those of unit vectors there.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from codegen.drawing.plane_geometry import unit

PointOrPlace = Any  # a Point of a declaration; in a picture, a Place
Number = Any  # a number or expression; in a picture, a float or its values over time


class Place(NamedTuple):
    """A point of a body of a picture: the body's number, 0 for the ground, and x', y' in m."""

    body: int
    x: Number
    y: Number

    @property
    def point(self) -> Any:
        """x' + iy' in m."""
        return self.x + 1j * self.y


class SpacePlace(NamedTuple):
    """A point of a body in space: the body's number, 0 for the ground, and x', y', z' in m."""

    body: int
    x: Number
    y: Number
    z: Number


class Course(NamedTuple):
    """A curve of a body of a picture: the body's number, and points along it, x' + iy', (k,), m."""

    body: int
    points: Any


@dataclass(frozen=True)
class Shape:
    """The part that all shapes have in common: a word for their kind."""

    kind: ClassVar[str] = ""


Shapes = tuple[Shape, ...]
OneShape = TypeVar("OneShape", bound=Shape)


@dataclass(frozen=True)
class Pair(Shape):
    """Two places that an element connects."""

    i: PointOrPlace
    j: PointOrPlace


class Directed(Shape):
    """A shape with a direction (ux, uy)."""

    ux: Number
    uy: Number

    @property
    def along(self) -> Any:
        """The direction as a complex number of length 1; in a picture."""
        return unit(self.ux + 1j * self.uy)


@dataclass(frozen=True)
class Guided(Pair, Directed):
    """Place j moves along a straight line of body i through place i, along (ux, uy)."""

    ux: Number
    uy: Number


@dataclass(frozen=True)
class SpringLike(Pair):
    """A spring, damper or actuator, or several of them in parallel."""

    elastic: bool = True
    damper: bool = False
    actuator: bool = False
    pushes: bool = False  # i and j apart, or turns j, where positive; else pulls, or turns i
    exerts: Number | None = None  # in space, where no series has it, N


class Pin(Pair):
    """A pin joint: two bodies turn about one point."""

    kind = "pin"


class Slide(Guided):
    """A block at place j on a guide of body i."""

    kind = "slide"


class Slot(Guided):
    """A pin at place j in a slot of body i."""

    kind = "slot"


class Rod(Pair):
    """A massless rod between two pins."""

    kind = "rod"


class Fixing(Pair):
    """Two bodies that are rigidly connected where places i and j meet."""

    kind = "fixing"


class Spring(SpringLike):
    """A spring, damper or actuator between two places."""

    kind = "spring"


class SpiralSpring(SpringLike):
    """A torsion spring, damper or motor between two bodies, about a pin of the second."""

    kind = "spiral spring"


@dataclass(frozen=True)
class Wheel(Shape):
    """A circle about a place of a body, which turns with the body; an internal gear's is a ring."""

    kind = "wheel"
    center: PointOrPlace
    radius: Number
    toothed: bool = False
    internal: bool = False

    @property
    def is_ring(self) -> bool:
        """Whether the body lies around the circle; in a picture."""
        return bool(self.internal or self.radius < 0)


@dataclass(frozen=True)
class Rack(Directed):
    """A straight line of a body through a place, along (ux, uy), toothed or a track."""

    kind = "rack"
    i: PointOrPlace
    ux: Number
    uy: Number
    toothed: bool = False


@dataclass(frozen=True)
class Belt(Pair):
    """A belt round two wheels."""

    kind = "belt"
    radius_i: Number
    radius_j: Number
    crossed: bool = False


@dataclass(frozen=True)
class Profile(Shape):
    """A curve that is fixed in a body; in a picture, a `Course`."""

    kind = "profile"
    curve: Any


@dataclass(frozen=True)
class Bearing(Pair):
    """A journal with clearance: pin j moves in a hole about place i, with `clearance` to spare."""

    kind = "bearing"
    clearance: Number


@dataclass(frozen=True)
class Mark(Shape):
    """A place that an element without a shape of its own takes hold of."""

    kind = "mark"
    at: PointOrPlace


@dataclass(frozen=True)
class Contact(Shape):
    """Bodies that may touch; `at` is where, if the element knows it.

    From `gap`, the distance g between them in m, follow the place and the ground's surface; `force`
    is the component of the element's force along it, and a stop has a plate for a surface.
    """

    kind = "contact"
    bodies: tuple[Any, ...]
    at: PointOrPlace | None = None
    gap: Number | None = None
    force: str = "force"
    is_stop: bool = False


@dataclass(frozen=True)
class Exertion(Shape):
    """An element's force, the component `force`, on a body, by its shares in Q_x, Q_y and Q_φ."""

    kind = "exertion"
    body: Any
    gx: Number
    gy: Number
    turn: Number
    force: str


@dataclass(frozen=True)
class ContactSide(Exertion):
    """A contact as a moving body has it: the gap, and its slopes by x, y and φ of the body.

    Elements return `Contact`, of which these follow. Whether the other side is the ground, and
    whether its surface keeps its direction and its place, are words.
    """

    kind = "contact side"
    gap: Number
    bend: Number  # ∂²g/∂φ²
    third: Number  # ∂³g/∂φ³
    is_grounded: bool
    is_level: bool
    is_fixed: bool
    is_stop: bool = False


@dataclass(frozen=True)
class Drive(Directed):
    """A driver's sign: it turns body j against body i, or pushes it along (ux, uy) of body i."""

    kind = "drive"
    i: PointOrPlace
    j: PointOrPlace
    turns: bool = True
    ux: Number = 0.0
    uy: Number = 0.0


@dataclass(frozen=True)
class Force(Shape):
    """A force (fx, fy) in global axes, N, on a body at a place."""

    kind = "force"
    at: PointOrPlace
    fx: Number
    fy: Number


class OppositeForce(Force):
    """The opposite of a force, on the body that exerts it; it does not hold that body together."""

    kind = "opposite force"


@dataclass(frozen=True)
class Torque(Shape):
    """A torque on a body, N m, drawn about its origin."""

    kind = "torque"
    at: PointOrPlace
    torque: Number


@dataclass(frozen=True)
class Reaction(Directed):
    """Axes in which a joint reports the force that the first body exerts on the second.

    (ux, uy) is the x axis in the global frame, and (x, y) the point of action there.
    """

    kind = "reaction"
    by: Any
    on: Any
    x: Number
    y: Number
    ux: Number
    uy: Number


@dataclass(frozen=True)
class Gravity(Shape):
    """The direction and size of gravity, m/s²."""

    kind = "gravity"
    gx: Number
    gy: Number


@dataclass(frozen=True)
class Trace(Shape):
    """A point whose path is an output."""

    kind = "trace"
    at: PointOrPlace


def places(shape: Shape) -> list[Any]:
    """The places of a shape's fields, in their order."""
    values = (getattr(shape, field.name) for field in fields(shape))
    return [value for value in values if isinstance(value, Place | SpacePlace)]


def is_finite(shape: Shape) -> bool:
    """Whether all places and numbers of a shape are finite."""
    values = [getattr(shape, field.name) for field in fields(shape)]
    numbers = [value for value in values if isinstance(value, float)]
    numbers += [number for place in places(shape) for number in place]
    curves = [value.points for value in values if isinstance(value, Course)]
    return bool(np.isfinite(np.concatenate([numbers, *curves])).all())


def changed(change: Callable[..., Any], first: OneShape, *others: OneShape) -> OneShape:
    """The first of several alike shapes, each of its numbers the result of those of all."""
    values: dict[str, Any] = {}
    for field in fields(first):
        own, *same = (getattr(shape, field.name) for shape in (first, *others))
        if isinstance(own, Place | SpacePlace):
            numbers = (change(*each) for each in list(zip(own, *same, strict=True))[1:])
            values[field.name] = type(own)(own.body, *numbers)
        elif isinstance(own, float | np.ndarray):
            values[field.name] = change(own, *same)
    return replace(first, **values)
