"""Coulomb friction in a joint, from the joint's own reaction."""

from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import rate
from codegen.elements.forces.given_load_friction import coefficient_problems
from codegen.elements.forces.scalar_measures import angle_problems, relative_angle, span
from codegen.elements.joints.revolute import Revolute
from codegen.elements.joints.sliding_joints import RevoluteTranslational, Translational
from codegen.elements.registry import element
from codegen.readers.values import shown

JOINTS = (Revolute, Translational, RevoluteTranslational)


def joint_coordinate(joint: el.Constraint) -> tuple[sympy.Expr, str]:
    """φ_j - φ_i of a revolute joint, else u_iᵀ d along the line of body i, and its unit."""
    assert isinstance(joint, JOINTS)
    if isinstance(joint, Revolute):
        return relative_angle(joint.i.body, joint.j.body), "rad"
    ux, uy = joint.axis
    c, s = joint.i.body.rotation
    dx, dy = span(joint.i, joint.j)
    size = sympy.sqrt(ux**2 + uy**2)
    return ((ux * c - uy * s) * dx + (ux * s + uy * c) * dy) / size, "m"


@element
class JointFriction(el.Effect):
    """f = -μ N sign(ṡ) along the slip s, N being the size of the joint's reaction (Coulomb).

    In a revolute joint of radius R the slip is the angle between the bodies, and f the torque
    -μ R |F| sign(ω). In a translational joint the force across the guide presses; where the
    bearing's length b is given, it presses at both ends, with |F/2 ± T/b| each. In a
    revolute-translational joint the force across the line presses.

    At ṡ = 0 the friction is the force that keeps the joint at rest, up to μ_s N. A change of sign
    of ṡ is an event of a run. There the run finds the stiction force, compares it with the limit of
    the reaction that goes with it, and goes on sticking where the force is small enough. Whether
    the joint could slide does not matter: one that would jam on one side can stick. Only where a
    condition or another friction changes with the same slip, the force is found between those of
    sliding to either side.

    A joint that sticks reports its `force` (a revolute joint its `torque`), N as `normal`, and the
    `limit`, μ_s N or μ_s R N.

    With a creep speed v_c the law is smooth instead, f = -μ N tanh(ṡ/v_c): below v_c the joint
    creeps instead of sticking, at ṡ = v_c f/(μ N) nearly, and above three times v_c the force is
    within half a percent of Coulomb's.

    The reaction depends on the friction in turn, and both are solved together. Of two solutions the
    smaller one is taken. Where no reaction agrees with the friction that it causes, a joint that
    slides jams: accelerations and reactions are not a number there, and a run ends.
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
        "", "nonnegative", binds="nonnegative", word="coefficient of friction"
    )
    creep: sympy.Expr | None = quantity(
        lambda of: "rad/s" if isinstance(of.joint, Revolute) else "m/s",
        "positive", binds="positive", default=None, word="creep speed",
    )  # fmt: skip
    radius: sympy.Expr | None = quantity("m", "positive", binds="positive", default=None)
    length: sympy.Expr | None = quantity("m", "positive", binds="positive", default=None)
    static: sympy.Expr | None = quantity("", binds="positive", default=None)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies of the joint."""
        pair: tuple[Body, ...] = self.joint.bodies if isinstance(self.joint, JOINTS) else ()
        return pair

    def friction(self) -> el.FrictionLaw:
        """The slip along which it acts, and the normal force."""
        joint, mu = self.joint, self.coefficient
        along, _ = joint_coordinate(joint)
        if isinstance(joint, Revolute):
            pressing: tuple[Any, ...] = ((("fx", sympy.S.One),), (("fy", sympy.S.One),))
            return el.FrictionLaw(
                joint.name, mu * self.radius, self.creep, along, (pressing,), "N m"
            )
        ends: tuple[Any, ...] = (((("fy", sympy.S.One),),),)
        if self.length is not None:
            half = sympy.Rational(1, 2)
            ends = tuple(((("fy", half), ("torque", sign / self.length)),) for sign in (1, -1))
        return el.FrictionLaw(joint.name, mu, self.creep, along, ends, "N")

    def hold(self, bodies: tuple[Body, ...]) -> el.Sticking | None:
        """Where it sticks, if it does."""
        if self.creep is not None:
            return None
        return el.Sticking(rate(self.friction().along), self.coefficient, self.static)

    def problems(self) -> list[str]:
        """Joints that do not rub, and two laws at once."""
        where, joint = el.label(self), self.joint
        if not isinstance(joint, JOINTS):
            name = f"'{joint.name}'" if isinstance(joint, el.Constraint) else shown(joint)
            advice = "give a revolute, a translational or a revolute-translational joint"
            advice += " itself, not its name." if isinstance(joint, str) else "."
            return [f"{where}: {name} is no joint that rubs; {advice}"]
        pin = isinstance(joint, Revolute)
        problems = angle_problems(self, *joint.bodies) if pin else []
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
        return problems + coefficient_problems(self, self.coefficient, self.static, self.creep)
