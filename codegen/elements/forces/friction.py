"""Coulomb friction: under a normal force that is given, and in a joint, from its reaction."""

from typing import Any

import sympy

from codegen.declare.body import Bodies, Loads
from codegen.declare.element import (
    Constraint,
    Effect,
    FrictionLaw,
    Measure,
    Measures,
    Reported,
    Sticking,
    label,
)
from codegen.declare.element_fields import quantity, static_condition
from codegen.declare.space_body import SpaceBody
from codegen.declare.symbols import Velocity, kinds, nonlinear_in, side
from codegen.drawing import shapes
from codegen.elements.joints.guides import Translational
from codegen.elements.registry import element
from codegen.elements.scalar_measures import RubbingJoint, angle_problems, is_constant, same_body
from codegen.readers.values import shown


class Coulomb(Effect):
    """A friction with the coefficients of Coulomb's law, and perhaps a speed of creep."""

    coefficient: sympy.Expr
    static: sympy.Expr | None
    creep: sympy.Expr | None

    @property
    def speed(self) -> sympy.Expr:
        """ṡ."""
        raise NotImplementedError

    def hold(self, bodies: Bodies) -> Sticking | None:
        """Where it sticks, if it does."""
        sticks = self.creep is None
        return Sticking(self.speed, self.coefficient, self.static) if sticks else None

    def problems(self) -> list[str]:
        """A static coefficient that contradicts the kinetic one, and two laws at once."""
        where, kinetic, static = label(self), self.coefficient, self.static
        if static is None:
            return []
        if self.creep is not None:
            return [
                (
                    f"{where} has both static= and creep=; a friction that creeps never sticks: "
                    "give creep= for the smooth law, or static= for the one that sticks, or both "
                    "with fidelity='sticking' or 'regularised' to let scenes choose."
                )
            ]
        if kinetic == 0:
            return [
                (
                    f"{where}: the coefficient of friction is 0 and the static one {static}; a "
                    "friction that sticks also acts when it slides: give a positive coefficient."
                )
            ]
        (condition,) = static_condition(kinetic, static)
        known = kinetic.is_number and static.is_number
        return [*condition.problems(where, {})] if known else []


@element
class DryFriction(Coulomb):
    """Two surfaces rub under a given normal force; they slide, and stick.

    f = -μ N sign(ṡ) along the slip ṡ; at ṡ = 0 the force that keeps ṡ = 0, up to μ_s N (Coulomb).

    The slip is a velocity, linear in the velocities of the bodies, ṡ = J q̇ + b; f acts as Q = Jᵀ f.
    b is, for example, the speed of a belt. A change of sign of ṡ is an event of a run. Where the
    force that keeps ṡ at 0 lies within ±μ_s N, the surfaces stick. The reported power is that on
    the bodies, Q·q̇: a belt that carries a block along does work.

    With a creep speed v_c the law is smooth instead, f = -μ N tanh(ṡ/v_c): surfaces that would
    stick creep at about ṡ = v_c f/(μ N). Where a variable normal force is negative, the friction is
    0.
    """

    kind = "dry friction"
    example = """
        mu, mu_s = model.parameter("mu", 0.2), model.parameter("mu_s", 0.3)
        model.dry_friction("rub", P, Q, axis=(1, 0), normal=50.0, coefficient=mu, static=mu_s)
    """
    name: str
    slip: sympy.Expr
    normal: sympy.Expr = quantity(
        "N", "nonnegative", binds="nonnegative", word="normal force", advice=", as it presses"
    )
    coefficient: sympy.Expr = quantity(
        "", "nonnegative", binds="nonnegative", word="coefficient of friction"
    )
    on: Bodies
    static: sympy.Expr | None = quantity("", binds="positive", default=None)
    creep: sympy.Expr | None = quantity(
        "m/s", "positive", binds="positive", default=None, word="creep speed"
    )

    @property
    def force(self) -> sympy.Expr:
        """f, N."""
        direction = side(self.name) if self.creep is None else sympy.tanh(self.slip / self.creep)
        return -self.coefficient * self.pressing * direction

    @property
    def pressing(self) -> sympy.Expr:
        """N, where something presses; else 0."""
        return self.normal if is_constant(self.normal) else sympy.Max(self.normal, 0)

    def forces(self, bodies: Bodies) -> Loads:
        """Q = Jᵀ f."""
        force = self.force
        return {v.coordinate: force * sympy.diff(self.slip, v) for v in kinds(self.slip, Velocity)}

    @property
    def speed(self) -> sympy.Expr:
        """The slip."""
        return self.slip

    def shapes(self) -> shapes.Shapes:
        """The force on each body, along the slopes of the slip."""
        slopes = {v: sympy.diff(self.slip, v) for v in kinds(self.slip, Velocity)}
        found = []
        for body in (b for b in dict.fromkeys(self.on) if not isinstance(b, SpaceBody)):
            gx, gy, turn = (slopes.get(v, 0) for v in (*body.velocity, body.angular_velocity))
            found.append(shapes.Exertion(body, gx, gy, turn, "force"))
        return tuple(found)

    def reported(self, bodies: Bodies) -> Reported:
        """f itself."""
        return (("force", "N", self.force),)

    def measures(self, bodies: Bodies) -> Measures:
        """The slip and N, beside f."""
        return (
            Measure("rate", "", "m/s", self.slip),
            Measure("force", "normal", "N", self.pressing),
        )

    def problems(self) -> list[str]:
        """A slip that is no velocity, and two laws at once."""
        where = label(self)
        if problems := same_body(where, self.bodies):
            return problems
        speeds = kinds(self.slip, Velocity)
        if not speeds:
            problems.append(
                f"{where}: the slip {self.slip} is no velocity, for it contains none; write one, "
                "such as block.vx - speed, or give two points."
            )
        if curved := nonlinear_in(self.slip):
            problems.append(
                f"{where}: the slip {self.slip} is not linear in {curved[0].name}; write the "
                "velocity itself, such as block.vx - speed."
            )
        return problems + super().problems()


def coefficient_unit(law: Any) -> str:
    """Of a coefficient, m where it is the arm of a torque."""
    return "m" if getattr(law.joint, "friction_arm", "") == "arm" else ""


def not_rubbing(law: "JointFriction", advice: str) -> str:
    """The problem of a joint that does not rub."""
    joint = law.joint
    name = f"'{joint.name}'" if isinstance(joint, Constraint) else shown(joint)
    advice += " itself, not its name." if isinstance(joint, str) else "."
    return f"{label(law)}: {name} is no joint that rubs; {advice}"


@element
class JointFriction(Coulomb):
    """A joint rubs under its own reaction; it slides, rolls, and sticks.

    f = -μ N sign(ṡ) along the slip s, N being the size of the joint's reaction (Coulomb).

    In a revolute joint of radius R the slip is the angle between the bodies, and f the torque
    -μ R |F| sign(ω). In a translational joint N is the force across the guide; if the bearing's
    length b is given, its ends are pressed with |F/2 + T/b| and |F/2 - T/b|. In a
    revolute-translational joint N is the force across the line.

    In a cam with a flat-faced, curved or point follower the slip is the velocity of the follower's
    material at the contact against the cam's, along the common tangent. f acts at the contact, on
    both bodies, and N is the force along the common normal. A rolling disc resists with the torque
    -f_R N sign(ω) at the rate ω of the angle between disc and line, N being the normal force and
    f_R, in m, the coefficient of rolling friction: the arm by which N runs ahead of the contact.

    At ṡ = 0 the friction is the force that keeps the joint at rest, up to μ_s N. A change of sign
    of ṡ is an event of a run. At the event the run finds the stiction force and the reaction that
    belongs to it. The joint sticks if the force is within the limit that this reaction allows, even
    if the joint would jam in sliding to one side. If another friction or a condition depends on the
    same slip, the stiction force is sought between the forces of sliding to either side.

    A joint that sticks reports its `force` (a revolute joint or a rolling disc its `torque`), N as
    `normal`, and the `limit`, μ_s N or μ_s R N.

    With a creep speed v_c the law is smooth instead, f = -μ N tanh(ṡ/v_c): a joint that would stick
    creeps at about ṡ = v_c f/(μ N), and above three times v_c the force is within half a percent of
    Coulomb's.

    The reaction depends on the friction in turn; the run solves for both and takes the smaller of
    two solutions. Where no reaction agrees with the friction that it causes, a sliding joint jams:
    accelerations and reactions are not a number there, and the run ends.
    """

    kind = "friction"
    example = """
        mu = model.parameter("mu", 0.2)
        pin = model.revolute("pin", P, Q)
        model.friction("rub", pin, mu, creep=1e-3, radius=0.02)
    """
    name: str
    joint: Any
    coefficient: sympy.Expr = quantity(
        coefficient_unit, "nonnegative", binds="nonnegative", word="coefficient of friction"
    )
    creep: sympy.Expr | None = quantity(
        lambda of: "rad/s" if getattr(of.joint, "friction_arm", "") else "m/s",
        "positive", binds="positive", default=None, word="creep speed",
    )  # fmt: skip
    radius: sympy.Expr | None = quantity("m", "positive", binds="positive", default=None)
    length: sympy.Expr | None = quantity("m", "positive", binds="positive", default=None)
    static: sympy.Expr | None = quantity(coefficient_unit, binds="positive", default=None)

    @property
    def bodies(self) -> Bodies:
        """The bodies of the joint."""
        pair: Bodies = self.joint.bodies if isinstance(self.joint, RubbingJoint) else ()
        return pair

    def friction(self) -> FrictionLaw:
        """The slip along which it acts, and the normal force."""
        rubbing, strength = self.joint.rubbing(), self.coefficient
        if self.radius is not None:
            strength *= self.radius
        ends: tuple[Any, ...] = (tuple(((part, sympy.S.One),) for part in rubbing.pressing),)
        if self.length is not None:
            half = sympy.Rational(1, 2)
            ends = tuple(((("fy", half), ("torque", sign / self.length)),) for sign in (1, -1))
        unit = "N m" if self.joint.friction_arm else "N"
        return FrictionLaw(self.joint.name, strength, self.creep, rubbing.slip, ends, unit)

    @property
    def speed(self) -> sympy.Expr:
        """The rate of the slip."""
        return self.friction().slip

    def shapes(self) -> shapes.Shapes:
        """How it acts on the second body, where the joint's reaction does."""
        rubbing = self.joint.rubbing()
        return (shapes.Reaction(*rubbing.bodies, *rubbing.place, *rubbing.way),)

    def problems(self) -> list[str]:
        """Joints that do not rub, and two laws at once."""
        where, joint = label(self), self.joint
        if not isinstance(joint, RubbingJoint):
            advice = "give a revolute, a translational or a revolute-translational joint, "
            return [not_rubbing(self, advice + "a follower of a cam, or a rolling disc")]
        pin = joint.friction_arm == "radius"
        problems = angle_problems(self, *joint.bodies) if joint.friction_arm else []
        if pin and self.radius is None:
            problems.append(
                f"{where}: revolute joint '{joint.name}' needs radius=, its pin's, in m."
            )
        if not pin and self.radius is not None:
            problems.append(f"{where}: joint '{joint.name}' has no pin; leave out radius=.")
        if not isinstance(joint, Translational) and self.length is not None:
            problems.append(
                f"{where}: joint '{joint.name}' has no long bearing; leave out length=."
            )
        return problems + super().problems()
