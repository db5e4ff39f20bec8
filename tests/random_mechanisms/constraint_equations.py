"""The constraint equations of all joints and drivers, written by hand over numbers or jets.

They owe nothing to the library but the form of each equation that its reference pages state, which
decides the scale and the sign of a multiplier.
"""

from collections.abc import Callable
from functools import cache, singledispatch
from math import hypot
from typing import Any

from tests.random_mechanisms import parts
from tests.random_mechanisms.jets import cos, sin, sqrt

Vector = tuple[Any, Any]


class Placement:
    """Where everything is: x, y, φ of each body, places of contacts, and the time."""

    def __init__(self, mechanism: parts.Mechanism, q: Any, t: Any) -> None:
        self.t = t
        self.places = dict(zip(mechanism.coordinates, q, strict=True))
        self.names = [body.name for body in mechanism.bodies]
        self._turned: dict[int, Vector] = {}

    def origin(self, body: int) -> Vector:
        """The body's x and y."""
        if body == parts.GROUND:
            return 0.0, 0.0
        name = self.names[body]
        return self.places[f"{name}.x"], self.places[f"{name}.y"]

    def angle(self, body: int) -> Any:
        """The body's φ; 0 for the ground and a particle."""
        return 0.0 if body == parts.GROUND else self.places.get(f"{self.names[body]}.phi", 0.0)

    def turned(self, body: int, s: tuple[Any, Any]) -> Vector:
        """A vector of the body's frame in global axes."""
        if body not in self._turned:
            phi = self.angle(body)
            self._turned[body] = (cos(phi), sin(phi))
        (c, d), (x, y) = self._turned[body], s
        return c * x - d * y, d * x + c * y

    def back(self, body: int, r: Vector) -> Vector:
        """A global vector in the body's axes."""
        self.turned(body, (0.0, 0.0))
        (c, d), (x, y) = self._turned[body], r
        return c * x + d * y, c * y - d * x

    def point(self, end: parts.End) -> Vector:
        """A body's point, global."""
        (x, y), (dx, dy) = self.origin(end.body), self.turned(end.body, end.s)
        return x + dx, y + dy

    def span(self, i: parts.End, j: parts.End) -> Vector:
        """The way from point i to point j, global."""
        (xi, yi), (xj, yj) = self.point(i), self.point(j)
        return xj - xi, yj - yi


def unit(axis: parts.Pair) -> parts.Pair:
    """A vector of length 1."""
    size = hypot(*axis)
    return axis[0] / size, axis[1] / size


def law(of: parts.Law, t: Any) -> Any:
    """The value of a law at a time, which may be a jet."""
    swing = sin(of.frequency * t + of.phase) - float(sin(of.phase))
    return of.offset + of.rate * t + of.amplitude * swing


def curve(profile: parts.Profile, a: Any) -> tuple[Vector, Vector]:
    """c(α) and c'(α) in the body's frame."""
    r, slope = profile.size + 0.0 * a, 0.0 * a
    for k, size, phase in profile.harmonics:
        r = r + profile.size * size * cos(k * a + phase)
        slope = slope - profile.size * size * k * sin(k * a + phase)
    c, s = cos(a), sin(a)
    x, y = profile.centre
    return (x + r * c, y + r * s), (slope * c - r * s, slope * s + r * c)


@cache
def pace(profile: parts.Profile) -> float:
    """|c'(0)| to three digits, by which the equations of contacts are divided."""
    return float(f"{hypot(*curve(profile, 0.0)[1]):.3g}")


def along_and_across(at: Placement, i: parts.End, j: parts.End, axis: parts.Pair) -> Vector:
    """Components of the way from i to j along an axis of body i, and to the left of it."""
    (ux, uy), (dx, dy) = at.turned(i.body, unit(axis)), at.span(i, j)
    return ux * dx + uy * dy, ux * dy - uy * dx


@singledispatch
def equations(joint: parts.Joint, at: Placement) -> tuple[Any, ...]:
    """Φ of a joint or driver, one a row."""
    raise NotImplementedError(type(joint))


def _equations(function: Callable[..., tuple[Any, ...]]) -> Callable[..., tuple[Any, ...]]:
    return equations.register(function)


@_equations
def _revolute(joint: parts.Revolute, at: Placement) -> tuple[Any, ...]:
    dx, dy = at.span(joint.j, joint.i)
    return dx, dy


@_equations
def _weld(joint: parts.Weld, at: Placement) -> tuple[Any, ...]:
    turn = at.angle(joint.j.body) - at.angle(joint.i.body) - joint.angle
    return (*at.span(joint.j, joint.i), turn)


@_equations
def _translational(joint: parts.Translational, at: Placement) -> tuple[Any, ...]:
    across = along_and_across(at, joint.i, joint.j, joint.axis)[1]
    return across, at.angle(joint.j.body) - at.angle(joint.i.body) - joint.angle


@_equations
def _link(joint: parts.Link, at: Placement) -> tuple[Any, ...]:
    dx, dy = at.span(joint.i, joint.j)
    return (dx * dx + dy * dy - joint.length**2,)


@_equations
def _slot(joint: parts.Slot, at: Placement) -> tuple[Any, ...]:
    return (along_and_across(at, joint.i, joint.j, joint.axis)[1] - joint.distance,)


@_equations
def _gear(joint: parts.Gear, at: Placement) -> tuple[Any, ...]:
    (ri, rj), (dx, dy) = joint.radii, at.span(joint.i, joint.j)
    turned = ri * at.angle(joint.i.body) + rj * at.angle(joint.j.body)
    theta = joint.line + turned / (ri + rj)
    return (dx * sin(theta) - dy * cos(theta),)


@_equations
def _rack(joint: parts.Rack, at: Placement) -> tuple[Any, ...]:
    along, across = along_and_across(at, joint.rack, joint.pinion, joint.axis)
    turn = at.angle(joint.pinion.body) - at.angle(joint.rack.body)
    return across - joint.radius, along + joint.radius * turn - joint.offset


def _coordinate(at: Placement, end: parts.End, letter: str) -> Any:
    return at.angle(end.body) if letter == "phi" else at.point(end)["xy".index(letter)]


@_equations
def _absolute(joint: parts.Absolute, at: Placement) -> tuple[Any, ...]:
    return (_coordinate(at, joint.on, joint.letter) - joint.value,)


@_equations
def _flat_follower(joint: parts.FlatFollower, at: Placement) -> tuple[Any, ...]:
    (cx, cy), (tx, ty) = curve(joint.profile, at.places[f"{joint.name}.alpha"])
    contact, slope = at.turned(joint.cam, (cx, cy)), at.turned(joint.cam, (tx, ty))
    (x, y), (fx, fy) = at.origin(joint.cam), at.point(joint.face)
    ux, uy = unit(joint.axis)
    nx, ny = at.turned(joint.face.body, (-uy, ux))
    gap = nx * (x + contact[0] - fx) + ny * (y + contact[1] - fy)
    return gap, (nx * slope[0] + ny * slope[1]) / pace(joint.profile)


@_equations
def _roller_follower(joint: parts.RollerFollower, at: Placement) -> tuple[Any, ...]:
    c, tangent = curve(joint.profile, at.places[f"{joint.name}.alpha"])
    d, other = curve(joint.roller, at.places[f"{joint.name}.beta"])
    size, other_size = pace(joint.profile), pace(joint.roller)
    (x, y), (u, w) = at.origin(joint.cam), at.origin(joint.follower)
    arm = at.turned(joint.follower, d)
    apart = at.back(joint.cam, (u + arm[0] - x, w + arm[1] - y))
    gx, gy = apart[0] - c[0], apart[1] - c[1]
    sx, sy = at.back(joint.cam, at.turned(joint.follower, other))
    tx, ty = tangent[0] / size, tangent[1] / size
    return tx * gx + ty * gy, tx * gy - ty * gx, (tx * sy - ty * sx) / other_size


@_equations
def _point_follower(joint: parts.PointFollower, at: Placement) -> tuple[Any, ...]:
    c, tangent = curve(joint.profile, at.places[f"{joint.name}.alpha"])
    (x, y), (px, py) = at.origin(joint.cam), at.point(joint.point)
    apart = at.back(joint.cam, (px - x, py - y))
    gx, gy = apart[0] - c[0], apart[1] - c[1]
    tx, ty = (k / pace(joint.profile) for k in tangent)
    return tx * gx + ty * gy, tx * gy - ty * gx


@_equations
def _point_driver(joint: parts.PointDriver, at: Placement) -> tuple[Any, ...]:
    return (_coordinate(at, joint.on, joint.letter) - law(joint.law, at.t),)


@_equations
def _relative_driver(joint: parts.RelativeDriver, at: Placement) -> tuple[Any, ...]:
    difference = _coordinate(at, joint.j, joint.letter) - _coordinate(at, joint.i, joint.letter)
    return (difference - law(joint.law, at.t),)


@_equations
def _translation_driver(joint: parts.TranslationDriver, at: Placement) -> tuple[Any, ...]:
    along = along_and_across(at, joint.i, joint.j, joint.axis)[0]
    return (along - law(joint.law, at.t),)


@_equations
def _distance_driver(joint: parts.DistanceDriver, at: Placement) -> tuple[Any, ...]:
    dx, dy = at.span(joint.i, joint.j)
    return (sqrt(dx * dx + dy * dy) - law(joint.law, at.t),)
