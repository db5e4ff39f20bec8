"""A spatial mechanism's parts as a declaration in Linkwright, and its states by coordinates."""

import re
from functools import singledispatch
from typing import Any

import numpy as np
import sympy

from codegen import Model
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.declaration import law
from tests.random_mechanisms.spatial_constraints import Layout, SpatialState

FRAMES = {"global": "ground", "body": "body"}


class SpatialDeclaration:
    """A model in space under construction."""

    def __init__(self, mechanism: parts.SpatialMechanism, name: str) -> None:
        self.model: Any = Model(name, space=True)
        self.mechanism, self._layout = mechanism, Layout(mechanism)
        self.bodies = [
            self.model.body(
                b.name, b.mass, b.inertia, at=b.r, axes=tuple(zip(*b.A, strict=True))[:2]
            )
            for b in mechanism.bodies
        ]

    def body(self, index: int) -> Any:
        """A body, or the ground."""
        return self.model.ground if index == parts.GROUND else self.bodies[index]

    def at(self, index: int, place: parts.Vector) -> Any:
        """The point of a body at a place of the drawing."""
        return self.body(index).at(*self._layout.fixed_point(index, place).tolist())


def declare(mechanism: parts.SpatialMechanism, name: str) -> Model:
    """The model, with a scene ``"run"`` of all its effects and drivers."""
    to = SpatialDeclaration(mechanism, name)
    for part in (*mechanism.joints, *mechanism.effects):
        add(part, to)
    drivers = list(to.model.drivers)
    to.model.scene("run", effects=[e.name for e in mechanism.effects], drivers=drivers)
    model: Model = to.model
    return model


def coordinates(state: SpatialState) -> tuple[Any, Any]:
    """q and q̇ of a state: of each body r and the Euler parameters, with ṗ = ½ Gᵀ ω′."""
    p, w = state.euler_parameters, state.body_rates
    e0, e = p[:, :1], p[:, 1:]
    rates = np.hstack([-np.sum(e * w, axis=1, keepdims=True), e0 * w + np.cross(e, w)]) / 2
    return np.hstack([state.r, p]).ravel(), np.hstack([state.v, rates]).ravel()


@singledispatch
def add(part: Any, to: SpatialDeclaration) -> None:
    """Declare one part."""
    raise NotImplementedError(type(part))


@add.register(parts.Spherical)
@add.register(parts.Weld)
def _(part: Any, to: SpatialDeclaration) -> None:
    word = "spherical" if isinstance(part, parts.Spherical) else "weld"
    getattr(to.model, word)(part.name, to.body(part.i), to.body(part.j), at=part.at)


def word(part: Any) -> str:
    """The method that declares a part: ``point_in_plane``."""
    return re.sub("(?<!^)(?=[A-Z])", "_", type(part).__name__).lower()


@add.register(parts.Revolute)
@add.register(parts.Translational)
@add.register(parts.Cylindrical)
@add.register(parts.Planar)
@add.register(parts.PointInPlane)
@add.register(parts.PointOnLine)
@add.register(parts.RevoluteTranslational)
def _(part: Any, to: SpatialDeclaration) -> None:
    ends, more = (to.body(part.i), to.body(part.j)), {}
    if isinstance(part, parts.RevoluteTranslational):
        more = {"hinge": part.hinge}
    getattr(to.model, word(part))(part.name, *ends, at=part.at, axis=part.axis, **more)


@add.register
def _(part: parts.ParallelAxes, to: SpatialDeclaration) -> None:
    ends = to.at(part.i, part.at), to.at(part.j, part.at)
    to.model.parallel_axes(part.name, *ends, axis=part.axis)


@add.register
def _(part: parts.Screw, to: SpatialDeclaration) -> None:
    ends = to.body(part.i), to.body(part.j)
    to.model.screw(part.name, *ends, part.lead, at=part.at, axis=part.axis)


@add.register
def _(part: parts.RevoluteSpherical, to: SpatialDeclaration) -> None:
    ends = to.at(part.i, part.at_i), to.at(part.j, part.at_j)
    getattr(to.model, word(part))(part.name, *ends, axis=part.axis)


@add.register
def _(part: parts.RevoluteCylindrical, to: SpatialDeclaration) -> None:
    ends, axes = (to.body(part.i), to.body(part.j)), (part.axis, part.hinge)
    words = dict(zip(("axis", "hinge"), axes, strict=True))
    to.model.revolute_cylindrical(part.name, *ends, at=part.at, angle=between(*axes), **words)


@add.register
def _(part: parts.Gear, to: SpatialDeclaration) -> None:
    ends = to.model.joints[part.joint], to.model.joints[part.driven]
    declared = to.model.rack_and_pinion if isinstance(part, parts.Rack) else to.model.gear
    declared(part.name, *ends, part.ratio)


@add.register
def _(part: parts.Universal, to: SpatialDeclaration) -> None:
    ends, axes = (to.body(part.i), to.body(part.j)), (part.axis_i, part.axis_j)
    to.model.universal(part.name, *ends, at=part.at, axes=axes, angle=between(*axes))


def between(a: Any, b: Any) -> Any:
    """The angle of two axes, rad, a right one exactly."""
    cosine = np.dot(a, b) / (np.linalg.norm(a) * np.linalg.norm(b))
    return sympy.pi / 2 if abs(cosine) < 1e-15 else np.arccos(cosine)


@add.register
def _(part: parts.SphericalSpherical, to: SpatialDeclaration) -> None:
    to.model.distance(part.name, to.at(part.i, part.at_i), to.at(part.j, part.at_j))


@add.register
def _(part: parts.PointDriver, to: SpatialDeclaration) -> None:
    to.model.point_driver(part.name, to.at(part.body, part.at), part.letter, law(part.law))


@add.register
def _(part: parts.DistanceDriver, to: SpatialDeclaration) -> None:
    ends = to.at(part.i, part.at_i), to.at(part.j, part.at_j)
    to.model.distance_driver(part.name, *ends, law(part.law))


@add.register(parts.AngleDriver)
@add.register(parts.SlideDriver)
def _(part: Any, to: SpatialDeclaration) -> None:
    word = "rotation" if isinstance(part, parts.AngleDriver) else "translation"
    joint = to.model.joints[part.joint]
    getattr(to.model, f"{word}_driver")(part.name, joint, law(part.law))


@add.register
def _(part: parts.TorsionSpring, to: SpatialDeclaration) -> None:
    to.model.torsion_spring(
        part.name, to.model.joints[part.joint], stiffness=part.stiffness,
        free_angle=part.free_angle, damping=part.damping,
    )  # fmt: skip


@add.register
def _(part: parts.Bushing, to: SpatialDeclaration) -> None:
    ends, axes = (to.body(part.i), to.body(part.j)), tuple(zip(*part.axes, strict=True))[:2]
    laws = part.stiffness, part.damping, part.preload
    to.model.bushing(part.name, *ends, *laws, at=part.at, axes=axes)


@add.register
def _(part: parts.Friction, to: SpatialDeclaration) -> None:
    joint, words = to.model.joints[part.joint], ("creep", "radius", "length", "collar")
    given = {word: getattr(part, word) for word in words}
    to.model.friction(part.name, joint, part.coefficient, **given)


@add.register
def _(part: parts.Gravity, to: SpatialDeclaration) -> None:
    to.model.gravity(part.name, part.g)


@add.register
def _(part: parts.Force, to: SpatialDeclaration) -> None:
    value = tuple(map(law, part.laws))
    to.model.force(part.name, to.at(part.body, part.at), value, frame=FRAMES[part.frame])


@add.register
def _(part: parts.Torque, to: SpatialDeclaration) -> None:
    value = tuple(map(law, part.laws))
    to.model.torque(part.name, to.body(part.body), value, frame=FRAMES[part.frame])


@add.register
def _(part: parts.Spring, to: SpatialDeclaration) -> None:
    ends = to.at(part.i, part.at_i), to.at(part.j, part.at_j)
    actuator = {} if part.actuator == parts.REST else {"actuator": law(part.actuator)}
    to.model.spring(
        part.name, *ends, stiffness=part.stiffness, free_length=part.free_length,
        damping=part.damping, **actuator,
    )  # fmt: skip
