"""Coulomb friction in joints in space, from their reactions."""

from dataclasses import dataclass
from typing import Any

import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import FrictionLaw, Measure, Measures, Pressing, label
from codegen.declare.element_fields import quantity
from codegen.drawing.shapes import Shapes
from codegen.elements.forces.friction import Coulomb, JointFriction, not_rubbing
from codegen.elements.registry import element
from codegen.elements.space.joints import (
    Cylindrical,
    JointWithAxis,
    RevoluteInSpace,
    TranslationalInSpace,
)

FORCE, TORQUE = ("fx", "fy", "fz"), ("tx", "ty", "tz")
RUBBING = RevoluteInSpace, Cylindrical, TranslationalInSpace
Entry = tuple[tuple[str, sympy.Expr], ...]


@element(space=True)
@dataclass(frozen=True, eq=False)
class JointFrictionInSpace(JointFriction):
    """A joint rubs under its own reaction; it slides, and sticks.

    f = -μ N sign(ṡ) along the slip s. In a revolute joint with a pin of the radius R the slip is
    the angle, and f the torque -μ R N sign(ω); in a translational joint it is the slide. The law at
    rest, with static friction and with a creep speed is that of the plane.

    N is the size of the force F_t across the axis. If the bearing's length b is given, with the
    joint's point of body j in its middle, its ends are pressed with |F_t / 2 + T × h / b| and
    |F_t / 2 - T × h / b|. The force F_h along a hinge presses a thrust face of the mean radius R_h,
    if that is given as `collar`: R_h |F_h| / R is added to N. The torque T_h about the axis of a
    guide presses it at the radius R, if that is given: |T_h| / R is added to N.

    A cylindrical joint slips by v = (ṡ, R ω), and the friction is opposite to v: with the creep
    speed v_c the force along the slide is -μ N ṡ / √(vᵀv + v_c²), and the torque about the axis
    -μ N R² ω / √(vᵀv + v_c²). It creeps, and does not stick. Its reported force is -μ N at all
    speeds; what acts is the part |v| / √(vᵀv + v_c²) of it.
    """

    kind = "friction in space"
    collar: sympy.Expr | None = quantity("m", "positive", binds="positive", default=None)

    @property
    def bodies(self) -> Bodies:
        """The bodies of the joint."""
        pair: Bodies = self.joint.bodies if isinstance(self.joint, RUBBING) else ()
        return pair

    @property
    def spins_and_slides(self) -> bool:
        """Whether the slip has two components, so that friction does not stick."""
        return isinstance(self.joint, Cylindrical)

    def friction(self) -> FrictionLaw:
        """The slip along which it acts, and the loads that press."""
        joint, strength, unit = self.joint, self.coefficient, "N"
        along: Any = joint.slide if "slide" in joint.countable else joint.angle
        if isinstance(joint, RevoluteInSpace):
            strength, unit = strength * self.radius, "N m"
        if self.spins_and_slides:
            along = (joint.slide, self.radius * joint.angle)
        return FrictionLaw(joint.name, strength, self.creep, along, self._loads(joint), unit)

    def _loads(self, joint: JointWithAxis) -> tuple[Pressing, ...]:
        turn = joint.i.body.A
        f, g, h = (turn * sympy.Matrix(axis) for axis in joint.axes[:3])

        def along(words: tuple[str, ...], axis: sympy.Matrix, factor: sympy.Expr) -> Entry:
            pairs = zip(words, axis, strict=True)
            return tuple((word, factor * part) for word, part in pairs if part != 0)

        loads: tuple[Pressing, ...] = (
            (along(FORCE, f, sympy.S.One), along(FORCE, g, sympy.S.One)),
        )
        if self.length is not None:
            half = sympy.Rational(1, 2)
            loads = tuple(
                (
                    along(FORCE, f, half) + along(TORQUE, g, sign / self.length),
                    along(FORCE, g, half) + along(TORQUE, f, -sign / self.length),
                )
                for sign in (1, -1)
            )
        if self.collar is not None:
            loads += ((along(FORCE, h, self.collar / self.radius),),)
        if isinstance(joint, TranslationalInSpace) and self.radius is not None:
            loads += ((along(TORQUE, h, 1 / self.radius),),)
        return loads

    def measures(self, bodies: Bodies) -> Measures:
        """The rates of the slip."""
        joint, both = self.joint, self.spins_and_slides
        known = {"angle": ("rad/s", "rate"), "slide": ("m/s", "speed")}
        return tuple(
            Measure(
                "rate", letter if both else "", known[letter][0], getattr(joint, known[letter][1])
            )
            for letter in joint.countable
        )

    def shapes(self) -> Shapes:
        """Nothing: the joint stands for it."""
        return ()

    def problems(self) -> list[str]:
        """Joints that do not rub, radii missing or out of place, and two laws at once."""
        where, joint = label(self), self.joint
        if not isinstance(joint, RUBBING):
            return [not_rubbing(self, "give a revolute, a translational or a cylindrical joint")]
        problems, what = [], f"{where}: {joint.kind.removesuffix(' in space')} joint '{joint.name}'"
        if self.radius is None and not isinstance(joint, TranslationalInSpace):
            problems.append(f"{what} needs radius=, its pin's, in m.")
        if self.collar is not None and not isinstance(joint, RevoluteInSpace):
            problems.append(f"{what} slides and has no thrust face; leave out collar=.")
        if self.spins_and_slides and self.creep is None:
            problems.append(f"{what} turns and slides, and does not stick; give creep=, in m/s.")
        return problems + Coulomb.problems(self)
