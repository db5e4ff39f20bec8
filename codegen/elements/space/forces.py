"""Forces in space: gravity, given forces and torques, springs and dampers of a joint's angle."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, TypeVar

import sympy

from codegen.declare.body import Bodies, Loads
from codegen.declare.element import Constraint, Effect, Measure, Measures, label
from codegen.declare.element_fields import quantity
from codegen.declare.space_body import SpaceBody, SpacePoint
from codegen.declare.symbols import rate
from codegen.drawing.shapes import Shapes
from codegen.drawing.space_shapes import Pull, Push
from codegen.elements.forces.applied import Gravity
from codegen.elements.forces.springs import OTHER, SpringDamper
from codegen.elements.registry import element
from codegen.elements.space.joints import JointWithAxis

NEWTONS, TORQUES = ("N",) * 3, ("N m",) * 3
Three = tuple[sympy.Expr, ...]
_Given = TypeVar("_Given", "ForceInSpace", "TorqueInSpace")


@element(space=True)
class GravityInSpace(Effect):
    """Gravity pulls at all bodies with mass.

    V = -Σ m gᵀ r.
    """

    kind = "gravity in space"
    name: str
    g: Three = quantity(("m/s^2",) * 3)

    potential = Gravity.potential
    weights = Gravity.weights

    def shapes(self) -> Shapes:
        """Its direction."""
        return (Pull(*self.g),)


@element(space=True)
class ForceInSpace(Effect):
    """A force acts on a point of a body.

    Q_r = F and n' = s' × Aᵀ F, with F in global or in body axes.
    """

    kind = "force in space"
    name: str
    point: SpacePoint
    value: Three = quantity(NEWTONS, gated=True)
    frame: Literal["ground", "body"] = "ground"

    def forces(self, bodies: Bodies) -> Loads:
        """The generalized forces on x, y, z and the torque about the body's axes."""
        body, force = self.point.body, sympy.Matrix(self.value)
        inner = force if self.frame == "body" else body.A.T * force
        outer = body.A * force if self.frame == "body" else force
        torque = sympy.Matrix(self.point.place).cross(inner)
        pairs = zip(body.coordinates[:3], outer, strict=True)
        return {q: f for q, f in pairs if f != 0} | body.torque(torque)

    def exerting(self, value: sympy.Expr) -> "ForceInSpace | None":
        """The force whose only component is that value; None where it has others."""
        return _exerting(self, value)

    def measures(self, bodies: Bodies) -> Measures:
        """F, in the axes in which it is given."""
        return _components("force", "f", "N", self.value)

    def shapes(self) -> Shapes:
        """An arrow."""
        return (_push(self.point, self.value, self.frame, False),)

    def problems(self) -> list[str]:
        """The ground cannot be pushed."""
        return _of_ground(self, self.point.body)


@element(space=True)
class TorqueInSpace(Effect):
    """A torque acts on a body, in global or in body axes."""

    kind = "torque in space"
    name: str
    body: SpaceBody
    value: Three = quantity(TORQUES, gated=True)
    frame: Literal["ground", "body"] = "ground"

    def forces(self, bodies: Bodies) -> Loads:
        """The torque about the body's axes."""
        value = sympy.Matrix(self.value)
        return self.body.torque(value if self.frame == "body" else self.body.A.T * value)

    def exerting(self, value: sympy.Expr) -> "TorqueInSpace | None":
        """The torque whose only component is that value; None where it has others."""
        return _exerting(self, value)

    def measures(self, bodies: Bodies) -> Measures:
        """The torque, in the axes in which it is given."""
        return _components("torque", "t", "N m", self.value)

    def shapes(self) -> Shapes:
        """An arrow."""
        return (_push(self.body.at(0, 0, 0), self.value, self.frame, True),)

    def problems(self) -> list[str]:
        """The ground cannot be turned."""
        return _of_ground(self, self.body)


@element(space=True)
class TorsionSpringInSpace(SpringDamper):
    """A torsion spring, a rotary damper or both about the axis of a joint.

    n = k (θ - θ0) + N0 + c θ̇ + N with the angle θ of the joint, counted through turns; n acts on
    the first body of the joint, -n on the second. The rest is as in the plane.
    """

    kind = "torsion spring in space"
    unit = "rad"
    name: str
    joints: Mapping[str, Constraint]
    angle: sympy.Expr = quantity("rad")
    stiffness: sympy.Expr = quantity("N m/rad", "nonnegative", advice=OTHER.format("torque"))
    free_angle: sympy.Expr = quantity("rad")
    damping: sympy.Expr = quantity("N m s/rad", "nonnegative", advice=OTHER.format("torque"))
    actuator: sympy.Expr = quantity("N m")
    law: sympy.Expr | None = quantity(
        "N m", default=None, function_of=lambda of: (of.angle, rate(of.angle)), is_law=True
    )
    preload: sympy.Expr = quantity("N m", default=sympy.S.Zero)
    on: Bodies = ()

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """θ and θ0."""
        return self.angle, self.free_angle

    def shapes(self) -> Shapes:
        """Its torque on the second body of the joint: -n about the axis."""
        joint = self.joints.get(getattr(self.angle, "owner", ""))
        if not isinstance(joint, JointWithAxis):
            return ()
        drive = joint.drive("angle")
        return (replace(drive, x=-drive.x, y=-drive.y, z=-drive.z, exerts=self.exerts),)

    def exerting(self, value: sympy.Expr) -> "TorsionSpringInSpace | None":
        """The same with that actuator, beside the spring and the damper; None without one."""
        return None if self.actuator == 0 else replace(self, actuator=value)


def _exerting(effect: _Given, value: sympy.Expr) -> _Given | None:
    if sum(component != 0 for component in effect.value) != 1:
        return None
    return replace(effect, value=tuple(value if c != 0 else c for c in effect.value))


def _components(quantity: str, letter: str, unit: str, value: Three) -> Measures:
    pairs = zip("xyz", value, strict=True)
    return tuple(Measure(quantity, f"{letter}{c}", unit, sympy.sympify(v)) for c, v in pairs)


def _push(at: SpacePoint, value: Three, frame: str, turns: bool) -> Push:
    """A force or a torque in global axes."""
    turned = at.body.A * sympy.Matrix(value) if frame == "body" else value
    x, y, z = turned
    return Push(at, x, y, z, turns)


def _of_ground(effect: Effect, body: SpaceBody) -> list[str]:
    return [f"{label(effect)} acts on the ground; give a moving body."] if body.fixed else []
