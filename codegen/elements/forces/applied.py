"""Loads that are given: gravity, potentials, forces and torques (Haug 6.1)."""

from dataclasses import replace
from typing import Literal

import sympy

from codegen.declare.body import Bodies, Body, Loads, Point
from codegen.declare.element import Effect, Measure, Measures, Pulls, label
from codegen.declare.element_fields import quantity
from codegen.declare.space_body import SpacePoint
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.elements.scalar_measures import (
    SpanMeasures,
    along_scalar,
    distance_and_rate,
    line_problems,
    same_body,
)


@element
class Gravity(Effect):
    """Gravity pulls at all bodies with mass.

    V = -Σ m (g_x x + g_y y).
    """

    kind = "gravity"
    example = 'model.gravity("weight", (0, -9.81))'
    name: str
    g: tuple[sympy.Expr, sympy.Expr] = quantity(("m/s^2", "m/s^2"))

    def potential(self, bodies: Bodies) -> sympy.Expr | None:
        """Potential energy of the bodies, zero at the global origin."""
        axes = [(k, g) for k, g in enumerate(self.g) if g != 0]
        centres = ((b.mass, tuple(b.mass_centre)) for b in bodies if b.mass is not None)
        return sympy.Add(*(-m * sympy.Add(*(g * r[k] for k, g in axes)) for m, r in centres))

    def forces(self, bodies: Bodies) -> Loads:
        """∂V/∂m along masses m that vary: matter that comes has its potential energy already."""
        return {q: sympy.diff(self.potential(bodies), q) for b in bodies for q, _ in b.laws}

    def weights(self, bodies: Bodies) -> tuple[tuple[str, sympy.Expr, sympy.Expr], ...]:
        """(body, mass, acceleration) of the products m g in the potential."""
        return tuple((b.name, b.mass, g) for b in bodies if b.mass is not None for g in self.g)

    def shapes(self) -> shapes.Shapes:
        """Its direction."""
        return (shapes.Gravity(*self.g),)


@element
class Potential(Effect):
    """A potential energy of your own, whose forces follow from it.

    Potential energy V(q), in joule; its forces are -∂V/∂q.
    """

    kind = "potential"
    example = 'model.potential("pendulum", 20 * (1 - cos(i.phi)))'
    name: str
    energy: sympy.Expr = quantity("J")
    on: Bodies

    def potential(self, bodies: Bodies) -> sympy.Expr | None:
        """V itself."""
        return self.energy

    def problems(self) -> list[str]:
        """A potential depends on positions only."""
        return [
            f"{label(self)}: {self.energy} contains the velocity {s.name}; "
            "write a force that depends on velocity as a generalized force."
            for s in kinds(self.energy, Velocity)
        ]


@element
class GeneralizedForce(Effect):
    """Forces and torques of your own along coordinates.

    Forces Q along coordinates, N for lengths and N m for angles.
    """

    kind = "generalized force"
    example = 'model.generalized_force("friction", {j.phi: -0.1 * (j.omega - i.omega)})'
    name: str
    components: tuple[tuple[Coordinate, sympy.Expr], ...]
    on: Bodies

    def forces(self, bodies: Bodies) -> Loads:
        """Coordinate → force."""
        return dict(self.components)


@element
class AppliedForce(Effect):
    """A force acts on a point of a body, such as a load, drag, or the thrust of a jet.

    F at a point P: Q_r = F, Q_φ = (B s')ᵀ F (Haug 6.1), with F in global or in body axes.

    If another body, `from_`, exerts the force, the reaction -F acts on that body at the same place
    in space, so that the pair keeps its momentum and its moment of momentum.
    """

    kind = "force"
    example = 'model.force("brake", on=P, fx=-5 * i.vx, fy=3.0, frame="body")'
    name: str
    point: Point
    fx: sympy.Expr = quantity("N", gated=True)
    fy: sympy.Expr = quantity("N", gated=True)
    frame: Literal["ground", "body"] = "ground"
    from_: Body | None = None

    def forces(self, bodies: Bodies) -> Loads:
        """The generalized forces on x, y and φ."""
        body, fx, fy = self.point.body, self.fx, self.fy
        (x, y), (c, s) = body.position, body.rotation
        if self.frame == "body":
            torque = self.point.sx * fy - self.point.sy * fx
            fx, fy = c * fx - s * fy, s * fx + c * fy
        else:
            torque = (self.point.x - x) * fy - (self.point.y - y) * fx
        on = {} if body.fixed else {body.x: fx, body.y: fy}
        on |= {} if torque == 0 or body.fixed else body.torque(torque)
        return on | self._reaction(fx, fy)

    def _reaction(self, fx: sympy.Expr, fy: sympy.Expr) -> Loads:
        """-F on the body that exerts the force, at the place of the point."""
        other = self.from_
        if other is None or other.fixed:
            return {}
        x, y = other.position
        torque = (self.point.y - y) * fx - (self.point.x - x) * fy
        return {other.x: -fx, other.y: -fy, **other.torque(torque)}

    def exerting(self, value: sympy.Expr) -> "AppliedForce | None":
        """The force whose only component is that value; None where it has two."""
        if (self.fx == 0) == (self.fy == 0):
            return None
        return replace(self, fx=value) if self.fy == 0 else replace(self, fy=value)

    def measures(self, bodies: Bodies) -> Measures:
        """F, in the axes in which it is given."""
        return Measure("force", "fx", "N", self.fx), Measure("force", "fy", "N", self.fy)

    def problems(self) -> list[str]:
        """The ground cannot be pushed, and a particle bears no moment."""
        problems = exertion_problems(self, self.point.body, self.from_)
        if not problems and self.from_ is not None and not self.from_.turns:
            problems.append(
                f"{label(self)} reacts on '{self.from_.name}', which is a particle and bears no "
                "moment; use a body, or model.line_force between the two."
            )
        return problems

    def shapes(self) -> shapes.Shapes:
        """An arrow, and the opposite one on the body that exerts the force."""
        fx, fy = self.fx, self.fy
        if self.frame == "body":
            c, s = self.point.body.rotation
            fx, fy = c * fx - s * fy, s * fx + c * fy
        force, other = shapes.Force(self.point, fx, fy), self.from_
        if other is None or other.fixed:
            return (force,)
        (x, y), (c, s) = other.position, other.rotation
        dx, dy = self.point.x - x, self.point.y - y
        at = Point(other, c * dx + s * dy, c * dy - s * dx)
        return force, shapes.OppositeForce(at, -fx, -fy)


@element
class AppliedTorque(Effect):
    """A torque, such as a load or the friction in a bearing, acts on a body.

    A torque about the axis normal to the plane, counter-clockwise positive.

    If another body, `from_`, exerts the torque, the opposite torque acts on that body, as on
    the stator of a motor.
    """

    kind = "torque"
    example = 'model.torque("motor", on=j, value=10 - 2 * j.omega, when=j.omega > 0)'
    name: str
    body: Body
    value: sympy.Expr = quantity("N m", gated=True)
    from_: Body | None = None

    def forces(self, bodies: Bodies) -> Loads:
        """Q_φ of both bodies, or the generalized forces that do the same work."""
        on = {} if self.body.fixed else self.body.torque(self.value)
        if self.from_ is None or self.from_.fixed:
            return on
        return on | self.from_.torque(-self.value)

    def exerting(self, value: sympy.Expr) -> "AppliedTorque":
        """The torque of that value."""
        return replace(self, value=value)

    def measures(self, bodies: Bodies) -> Measures:
        """The torque."""
        return (Measure("torque", "", "N m", self.value),)

    def problems(self) -> list[str]:
        """The ground cannot be turned, and a particle has nothing to turn."""
        problems = exertion_problems(self, self.body, self.from_)
        given = (self.body,) if self.from_ is None else (self.body, self.from_)
        return problems + [
            f"{label(self)} turns '{body.name}', which is a particle; use a body."
            for body in given
            if not body.fixed and not body.turns
        ]

    def shapes(self) -> shapes.Shapes:
        """A round arrow, and the opposite one on the body that exerts the torque."""
        torque = shapes.Torque(self.body, self.value)
        if self.from_ is None or self.from_.fixed:
            return (torque,)
        return torque, shapes.Torque(self.from_, -self.value)


@element
class LineForce(SpanMeasures, Effect):
    """A force along the line of two points, such as a hydraulic or gas cylinder, or a rope.

    A force f along the line of two points, N, positive where it pulls them together.

    f may be any expression, also of the length ℓ and its rate ℓ̇. It has no potential, and its
    power is -f ℓ̇. At ℓ = 0 the line has no direction, and a run ends there as not finite.
    """

    kind = "line force"
    example = """
        p = model.table("p", [0, 1, 2, 3, 4], [9e3, 4e3, 2e3, 1e3, 5e2], units=("m", "N"))
        model.line_force("cylinder", P, Q, lambda length, rate: -p(length) + 30 * rate)
    """
    name: str
    i: Point
    j: Point
    value: sympy.Expr = quantity("N", gated=True, function_of=distance_and_rate)

    def pulls(self, bodies: Bodies) -> Pulls:
        """f along ℓ."""
        return ((self.length, self.value),)

    def exerting(self, value: sympy.Expr) -> "LineForce":
        """The force of that value."""
        return replace(self, value=value)

    def measures(self, bodies: Bodies) -> Measures:
        """ℓ, ℓ̇ and f."""
        return along_scalar(self.length, "m", self.value)

    def problems(self) -> list[str]:
        """Two points that keep their distance, and a force that is none."""
        problems = line_problems(self, self.i, self.j)
        if self.value == 0:
            problems.append(f"{label(self)} is 0 throughout; give a force in N.")
        return problems

    def shapes(self) -> shapes.Shapes:
        """An actuator."""
        exerts = self.value if isinstance(self.i, SpacePoint) else None
        return (shapes.Spring(self.i, self.j, elastic=False, actuator=True, exerts=exerts),)


def exertion_problems(effect: Effect, on: Body, from_: Body | None) -> list[str]:
    """A force that moves nothing, and one that a body exerts on itself."""
    if on.fixed and (from_ is None or from_.fixed):
        return [f"{label(effect)} acts on the ground; give a moving body."]
    return [] if from_ is None else same_body(label(effect), (on, from_))
