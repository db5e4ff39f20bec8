"""Reactions of joints from the forces that their constraints exert, by statics.

The force and the torque are those of the first body on the second, at a point and in axes that the
reference page of each joint names.
"""

from collections.abc import Mapping
from math import cos, sin
from typing import Any

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import Placement, curve, unit

Vector = tuple[float, float]


def reaction(
    joint: parts.Joint, at: Placement, force: Mapping[str, float], lam: Any
) -> dict[str, float]:
    """Components by name; `force` is the joint's generalized force -Φ_qᵀ λ by coordinate."""
    if isinstance(joint, parts.TranslationDriver | parts.DistanceDriver):
        return {"force": -float(lam[0])}
    if isinstance(joint, parts.PointDriver | parts.RelativeDriver):
        word = "torque" if joint.letter == "phi" else f"f{joint.letter}"
        return {word: -float(lam[0])}
    body, other, place, x_axis, sign = _stated(joint, at)
    if body == parts.GROUND:  # the opposite of what the other body feels
        body, sign = other, -sign
    fx, fy, couple = _on_body(at, body, force)
    rx, ry = at.origin(body)
    torque = couple - ((place[0] - rx) * fy - (place[1] - ry) * fx)
    ux, uy = x_axis
    return {
        "fx": sign * (ux * fx + uy * fy),
        "fy": sign * (ux * fy - uy * fx),
        "torque": sign * torque,
    }


def _on_body(at: Placement, body: int, force: Mapping[str, float]) -> tuple[float, float, float]:
    name = at.names[body]
    return force[f"{name}.x"], force[f"{name}.y"], force.get(f"{name}.phi", 0.0)


def _stated(joint: parts.Joint, at: Placement) -> tuple[int, int, Vector, Vector, int]:
    """Body on which it acts, the other one, the point, the x axis (global), and the sign."""
    match joint:
        case parts.Revolute(_, i, j) | parts.Weld(_, i, j, _):
            return j.body, i.body, at.point(j), at.turned(i.body, (1.0, 0.0)), 1
        case parts.Translational(_, i, j, axis, _) | parts.Slot(_, i, j, axis, _):
            return j.body, i.body, at.point(j), at.turned(i.body, unit(axis)), 1
        case parts.Link(_, i, j, _):
            dx, dy = at.span(i, j)
            return j.body, i.body, at.point(j), unit((dx, dy)), 1
        case parts.Gear(_, i, j, (ri, rj), line):
            turn = (ri * at.angle(i.body) + rj * at.angle(j.body)) / (ri + rj)
            return j.body, i.body, at.point(j), (cos(line + turn), sin(line + turn)), 1
        case parts.Rack(_, pinion, rack, _, axis, _):
            x_axis = at.turned(rack.body, unit(axis))
            return pinion.body, rack.body, at.point(pinion), x_axis, -1
        case parts.Absolute(_, on, _, _):
            return on.body, parts.GROUND, at.point(on), (1.0, 0.0), 1
        case parts.FlatFollower(_, cam, _, face, axis, _):
            x_axis = at.turned(face.body, unit(axis))
            return face.body, cam, at.point(face), x_axis, 1
        case parts.RollerFollower(name, cam, profile, follower, roller, _, _):
            tangent = _tangent(at, cam, profile, f"{name}.alpha")
            contact = curve(roller, at.places[f"{name}.beta"])[0]
            (x, y), (dx, dy) = at.origin(follower), at.turned(follower, contact)
            return follower, cam, (x + dx, y + dy), tangent, 1
        case parts.PointFollower(name, cam, profile, point, _):
            tangent = _tangent(at, cam, profile, f"{name}.alpha")
            return point.body, cam, at.point(point), tangent, 1
    raise NotImplementedError(type(joint))


def _tangent(at: Placement, cam: int, profile: parts.Profile, place: str) -> Vector:
    dx, dy = curve(profile, at.places[place])[1]
    tangent: Vector = at.turned(cam, unit((dx, dy)))
    return tangent
