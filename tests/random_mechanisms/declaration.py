"""A mechanism's parts as a declaration in Linkwright."""

from functools import singledispatch
from typing import Any

import sympy

from codegen import Curve, Model, Point, alpha, t
from tests.random_mechanisms import parts

RATES = {"x": "vx", "y": "vy", "phi": "omega"}


class Declaration:
    """A model under construction."""

    def __init__(self, mechanism: parts.Mechanism, name: str) -> None:
        self.model = Model(name)
        self.bodies = [
            self.model.particle(b.name, b.mass)
            if b.inertia is None
            else self.model.body(b.name, b.mass, b.inertia)
            for b in mechanism.bodies
        ]
        self.joints: dict[str, Any] = {}

    def body(self, index: int) -> Any:
        """A body, or the ground."""
        return self.model.ground if index == parts.GROUND else self.bodies[index]

    def at(self, end: parts.End) -> Point:
        """A point."""
        s = (0, 0) if end.s == (0.0, 0.0) else end.s
        point: Point = self.body(end.body).at(*s)
        return point

    def curve(self, body: int, profile: parts.Profile) -> Curve:
        """A profile on a body."""
        series = sum(a * sympy.cos(k * alpha + p) for k, a, p in profile.harmonics)
        curve: Curve = self.body(body).circle(profile.size * (1 + series), profile.centre)
        return curve


def law(of: parts.Law) -> sympy.Expr:
    """A law as an expression of t."""
    swing = sympy.sin(of.frequency * t + of.phase) - float(sympy.sin(of.phase))
    return of.offset + of.rate * t + of.amplitude * swing


def declare(mechanism: parts.Mechanism, name: str, scene: dict[str, Any]) -> Model:
    """The model, with a scene ``"run"`` of all its effects and drivers."""
    to = Declaration(mechanism, name)
    for part in (*mechanism.joints, *mechanism.effects):
        to.joints[part.name] = add(part, to)
    drivers = [j.name for j in mechanism.joints if isinstance(j, parts.DRIVERS)]
    effects = [effect.name for effect in mechanism.effects]
    to.model.scene("run", effects=effects, drivers=drivers, **scene)
    return to.model


@singledispatch
def add(part: Any, to: Declaration) -> Any:
    """Declare one part."""
    raise NotImplementedError(type(part))


@add.register
def _(part: parts.Revolute, to: Declaration) -> Any:
    return to.model.revolute(part.name, to.at(part.i), to.at(part.j))


@add.register
def _(part: parts.Weld, to: Declaration) -> Any:
    return to.model.weld(part.name, to.at(part.i), to.at(part.j), part.angle)


@add.register
def _(part: parts.Translational, to: Declaration) -> Any:
    ends = to.at(part.i), to.at(part.j)
    return to.model.translational(part.name, *ends, part.axis, part.angle)


@add.register
def _(part: parts.Link, to: Declaration) -> Any:
    return to.model.revolute_revolute(part.name, to.at(part.i), to.at(part.j), part.length)


@add.register
def _(part: parts.Slot, to: Declaration) -> Any:
    ends = to.at(part.i), to.at(part.j)
    return to.model.revolute_translational(part.name, *ends, part.axis, part.distance)


@add.register
def _(part: parts.Gear, to: Declaration) -> Any:
    return to.model.gear(part.name, to.at(part.i), to.at(part.j), *part.radii, part.line)


@add.register
def _(part: parts.Rack, to: Declaration) -> Any:
    ends = to.at(part.pinion), to.at(part.rack)
    return to.model.rack_and_pinion(part.name, *ends, part.radius, part.axis, part.offset)


@add.register
def _(part: parts.Absolute, to: Declaration) -> Any:
    return to.model.absolute(part.name, to.at(part.on), part.letter, part.value)


@add.register
def _(part: parts.FlatFollower, to: Declaration) -> Any:
    cam = to.curve(part.cam, part.profile)
    return to.model.cam_flat_follower(part.name, cam, to.at(part.face), part.axis)


@add.register
def _(part: parts.RollerFollower, to: Declaration) -> Any:
    curves = to.curve(part.cam, part.profile), to.curve(part.follower, part.roller)
    return to.model.cam_follower(part.name, *curves)


@add.register
def _(part: parts.PointFollower, to: Declaration) -> Any:
    return to.model.point_follower(part.name, to.curve(part.cam, part.profile), to.at(part.point))


@add.register
def _(part: parts.PointDriver, to: Declaration) -> Any:
    return to.model.point_driver(part.name, to.at(part.on), part.letter, law(part.law))


@add.register
def _(part: parts.RelativeDriver, to: Declaration) -> Any:
    ends = to.at(part.i), to.at(part.j)
    return to.model.relative_driver(part.name, *ends, part.letter, law(part.law))


@add.register
def _(part: parts.TranslationDriver, to: Declaration) -> Any:
    ends = to.at(part.i), to.at(part.j)
    return to.model.translation_driver(part.name, *ends, law(part.law), part.axis)


@add.register
def _(part: parts.DistanceDriver, to: Declaration) -> Any:
    return to.model.distance_driver(part.name, to.at(part.i), to.at(part.j), law(part.law))


@add.register
def _(part: parts.Gravity, to: Declaration) -> Any:
    return to.model.gravity(part.name, part.g)


@add.register
def _(part: parts.Spring, to: Declaration) -> Any:
    return to.model.spring(
        part.name, to.at(part.i), to.at(part.j), part.stiffness, part.free_length,
        part.damping, law(part.actuator),
    )  # fmt: skip


@add.register
def _(part: parts.TorsionSpring, to: Declaration) -> Any:
    ends = to.body(part.i), to.body(part.j)
    return to.model.torsion_spring(part.name, *ends, part.stiffness, part.free_angle, part.damping)


@add.register
def _(part: parts.Bushing, to: Declaration) -> Any:
    ends = to.at(part.i), to.at(part.j)
    return to.model.bushing(part.name, *ends, part.stiffness, part.damping, part.free_angle)


@add.register
def _(part: parts.Force, to: Declaration) -> Any:
    frame: Any = part.frame
    laws = law(part.fx), law(part.fy)
    return to.model.force(part.name, to.at(part.on), *laws, frame=frame)


@add.register
def _(part: parts.Torque, to: Declaration) -> Any:
    body = to.body(part.on)
    return to.model.torque(part.name, body, law(part.law) - part.drag * body.omega)


@add.register
def _(part: parts.JointFriction, to: Declaration) -> Any:
    numbers = part.coefficient, part.creep, part.radius, part.length, part.static
    return to.model.friction(part.name, to.joints[part.joint], *numbers)


@add.register
def _(part: parts.DryFriction, to: Declaration) -> Any:
    return to.model.dry_friction(
        part.name, to.at(part.i), to.at(part.j), axis=part.axis, normal=part.normal,
        coefficient=part.coefficient, creep=part.creep, static=part.static,
    )  # fmt: skip


@add.register
def _(part: parts.RigidContact, to: Declaration) -> Any:
    return to.model.contact(
        part.name, to.at(part.i), to.at(part.j), direction=part.direction,
        free_length=part.free_length, restitution=part.restitution,
    )  # fmt: skip


@add.register
def _(part: parts.Contact, to: Declaration) -> Any:
    return to.model.contact(
        part.name, to.at(part.i), to.at(part.j), direction=part.direction,
        free_length=part.free_length, stiffness=part.stiffness, damping=part.damping,
    )  # fmt: skip
