"""Joints in space, made of four kinds of equations.

Two points coincide, r_i + A_i s'_i - r_j - A_j s'_j = 0, or keep their distance; two vectors keep
their angle, aᵀ b = cos α; a vector is perpendicular to the line between two points, aᵀ d = 0 with
d = r_j^P - r_i^P (E. J. Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems, 1989,
9.4). Body i has the axis h of a joint and two vectors f, g perpendicular to it and to each other;
body j has f and h, too.

A joint counts an angle or a slide where a scene asks for it: an own coordinate with a row of its
own. The angle θ is that by which body j has turned against body i about h since the drawing, with

    2 (c Δ_h - s Δ_0) = 2 sin((ψ - θ) / 2) = 0,   c = cos(θ/2), s = sin(θ/2),

Δ the Euler parameters of the turn ψ from f_i to f_j. Its roots are ψ and all whole turns more, and
no angle of the mirrored closure; its slope by θ is -1 or 1 in each. The slide is h_iᵀ d.
"""

from copy import copy
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np
import sympy

from codegen.declare.drawn_pose import attitude_of_axes, symbolic
from codegen.declare.element import Constraint, Statement, WrenchReaction, label
from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.rotation_entries import conjugate, product
from codegen.declare.space_body import SpacePoint, Three
from codegen.declare.space_frame import I, J
from codegen.declare.symbols import coordinate, given
from codegen.drawing.shapes import Rod, Shapes
from codegen.drawing.space_shapes import SpaceDrive, SpaceJoint
from codegen.elements.joints.guides import Screw
from codegen.elements.registry import element
from codegen.errors import ModelError

SPAN = J.point - I.point
COINCIDENT = tuple(-SPAN)
F, G, H_I = I.vector("f"), I.vector("g"), I.vector("h")
F_J, H_J = J.vector("f"), J.vector("h")
PARALLEL = (F.dot(H_J), G.dot(H_J))
ON_LINE = (F.dot(SPAN), G.dot(SPAN))
IN_PLANE = (H_I.dot(SPAN),)
LENGTH, COSINE = given("length"), given("cosine")
LINK = (SPAN.dot(SPAN) - LENGTH**2,)
DRAWN = tuple(given(f"drawn{k}") for k in range(4))  # body i in body j, at the drawing
THETA, SLIDE = coordinate("joint", "angle"), coordinate("joint", "slide")


def _angle_row() -> sympy.Expr:
    turn, *axis = product(product(conjugate(I.p), J.p), DRAWN)
    along = sympy.Matrix(axis).dot(I.given("h"))
    return 2 * (sympy.cos(THETA / 2) * along - sympy.sin(THETA / 2) * turn)


COUNTED = {"angle": (THETA, _angle_row()), "slide": (SLIDE, H_I.dot(SPAN) - SLIDE)}
"""Letter of a coordinate that joints may count → its placeholder and its row."""


def counted(letter: str, text: str, *, of_rate: bool = False) -> Any:
    """A property of joints: a coordinate that they may count, or its rate; `text` describes it."""

    def symbol(joint: "JointInSpace") -> Any:
        if letter not in joint.countable:
            raise ModelError(
                f"{label(joint)} has no {letter}; joints that turn about an axis have an angle, "
                "joints that slide along one a slide."
            )
        q = coordinate(joint.name, letter)
        return q.rate if of_rate else q

    return property(symbol, doc=text)


@shared_fields
class JointInSpace(Constraint):
    """A joint at a point of each of two bodies, with the wrench on body j at its point."""

    phi: ClassVar[tuple[sympy.Expr, ...]]
    rows: ClassVar[tuple[str, ...]]
    form: ClassVar[str] = "ball"  # of `codegen.drawing.space_shapes.SpaceJoint`
    countable: ClassVar[tuple[str, ...]] = ()  # letters of the coordinates that it may count
    facing: ClassVar[tuple[str, ...]] = ()  # letters of the vectors that its bodies share
    numbers: ClassVar[tuple[str, ...]] = ()  # fields, and placeholders of the same names
    name: str
    i: SpacePoint
    j: SpacePoint

    angle = counted("angle", "How far body j has turned against body i, about h, rad.")
    rate = counted("angle", "The rate of the angle, rad/s.", of_rate=True)
    slide = counted("slide", "How far the point of body j is ahead of that of body i along h, m.")
    speed = counted("slide", "The rate of the slide, m/s.", of_rate=True)

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """Vectors of bodies i and j by letter, in their frames."""
        return {}, {}

    def bindings(self) -> dict[sympy.Symbol, sympy.Expr]:
        """The placeholders of its class, and their values."""
        of_i, of_j = self.vectors()
        numbers = {given(word): getattr(self, word) for word in self.numbers}
        return I.bind(self.i, **of_i) | J.bind(self.j, **of_j) | numbers

    def statement(self) -> Statement:
        """The equations of its class."""
        phi, bindings = self.phi, self.bindings()
        return Statement(phi, self.rows, WrenchReaction(J), bindings, facing=self.facing)

    def shapes(self) -> Shapes:
        """The form of its class, along an axis of each body if it has them."""
        pairs = zip((self.i, self.j), self.vectors(), strict=True)
        axes = (SpacePoint(end.body, *own["h"]) for end, own in pairs if "h" in own)
        return (SpaceJoint(self.i, self.j, self.form, *axes),)


@shared_fields
class JointWithAxis(JointInSpace):
    """A joint with an axis: f, g and h of body i, f and h of body j."""

    counts: ClassVar[dict[str, tuple[sympy.Symbol, sympy.Expr]]] = COUNTED
    counted: ClassVar[tuple[str, ...]] = ()  # letters of the coordinates that a scene asks for
    facing: ClassVar[tuple[str, ...]] = ("h",)
    axes: tuple[Three, Three, Three, Three, Three]

    def counting(self, letters: tuple[str, ...]) -> Self:
        """The joint with coordinates of these letters."""
        found = copy(self)
        vars(found)["counted"] = letters
        return found

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """f, g and h of body i; f and h of body j."""
        f, g, h, f_j, h_j = self.axes
        return {"f": f, "g": g, "h": h}, {"f": f_j, "h": h_j}

    def drive(self, letter: str) -> SpaceDrive:
        """The direction of what a driver of its angle or its slide exerts on body j."""
        x, y, z = self.i.body.A * sympy.Matrix(self.axes[2])
        return SpaceDrive(self.j, x, y, z, letter == "angle")

    def statement(self) -> Statement:
        """The equations of its class, and those of what it counts."""
        stated = super().statement()
        if not self.counted:
            return stated
        own = tuple((letter, coordinate(self.name, letter)) for letter in self.counted)
        bindings = stated.bindings | self._drawn | {self.counts[letter][0]: q for letter, q in own}
        phi = (*self.phi, *(self.counts[letter][1] for letter in self.counted))
        reaction = WrenchReaction(J, rows=len(self.phi))
        return Statement(phi, (*self.rows, *self.counted), reaction, bindings, own, self.facing)

    @property
    def _drawn(self) -> dict[sympy.Symbol, sympy.Expr]:
        """The Euler parameters of body i in body j, where f of both is one direction."""
        f, _, h, f_j, h_j = (np.array(axis, float) for axis in self.axes)
        of_i, of_j = (attitude_of_axes(x, np.cross(z, x)) for x, z in ((f, h), (f_j, h_j)))
        return dict(zip(DRAWN, symbolic(product(of_j, conjugate(of_i))), strict=True))


@element(space=True)
class Spherical(JointInSpace):
    """A ball joint: a point of body i and a point of body j coincide."""

    kind = "spherical"
    phi, rows = COINCIDENT, ("x", "y", "z")


@element(space=True)
class RevoluteInSpace(JointWithAxis):
    """A hinge: two points coincide and both bodies share an axis.

    r_i^P - r_j^P = 0, f_iᵀ h_j = 0 and g_iᵀ h_j = 0.
    """

    kind = "revolute in space"
    form, friction_arm = "hinge", "radius"
    countable = ("angle",)
    phi, rows = (*COINCIDENT, *PARALLEL), ("x", "y", "z", "f", "g")


@element(space=True)
class Cylindrical(JointWithAxis):
    """Body j turns about an axis of body i and slides along it.

    f_iᵀ d = 0, g_iᵀ d = 0, f_iᵀ h_j = 0 and g_iᵀ h_j = 0.
    """

    kind = "cylindrical"
    form = "shaft"
    countable = ("angle", "slide")
    phi, rows = (*ON_LINE, *PARALLEL), ("line_f", "line_g", "f", "g")


@element(space=True)
class TranslationalInSpace(JointWithAxis):
    """Body j slides along an axis of body i and does not turn against it.

    The equations of a cylindrical joint, and g_iᵀ f_j = 0.
    """

    kind = "translational in space"
    form = "rail"
    countable, facing = ("slide",), ("h", "f")
    phi = (*ON_LINE, *PARALLEL, G.dot(F_J))
    rows = ("line_f", "line_g", "f", "g", "turn")


@element(space=True)
class WeldInSpace(JointWithAxis):
    """Two bodies are fixed to each other.

    r_i^P - r_j^P = 0, f_iᵀ h_j = 0, g_iᵀ h_j = 0 and g_iᵀ f_j = 0.
    """

    kind = "weld in space"
    form = "clamp"
    facing = ("h", "f")
    phi = (*COINCIDENT, *PARALLEL, G.dot(F_J))
    rows = ("x", "y", "z", "f", "g", "turn")


@element(space=True)
class Universal(JointInSpace):
    """A Cardan joint: two points coincide, and an axis of each body keeps its angle to the other.

    r_i^P - r_j^P = 0 and h_iᵀ h_j - cos α = 0. With α other than 90° it is the revolute-revolute
    joint of intersecting axes: a cross without mass whose arms are not perpendicular.
    """

    kind = "universal"
    form = "cross"
    phi, rows = (*COINCIDENT, H_I.dot(H_J) - COSINE), ("x", "y", "z", "cross")
    numbers = ("cosine",)
    axis_i: Three
    axis_j: Three
    cosine: sympy.Expr = quantity()

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """h of both bodies."""
        return {"h": self.axis_i}, {"h": self.axis_j}


@element(space=True)
class DistanceInSpace(JointInSpace):
    """Two points keep their distance, as a massless rod with two ball joints makes them.

    dᵀ d - L² = 0. The component "axial" of the reaction is the force 2 λ L with which the rod pulls
    the points together, negative where it pushes them apart.
    """

    kind = "distance in space"
    phi, rows, numbers = LINK, ("length",), ("length",)
    length: sympy.Expr = quantity("m", "positive", advice=", or use a spherical joint")

    def statement(self) -> Statement:
        """One equation, and the tension of the rod."""
        stated = super().statement()
        return replace(stated, reaction=WrenchReaction(J, tension=2 * LENGTH))

    def shapes(self) -> Shapes:
        """A rod."""
        return (Rod(self.i, self.j),)


@element(space=True)
class Planar(JointWithAxis):
    """A plane of body j lies on a plane of body i, slides and turns on it.

    f_iᵀ h_j = 0, g_iᵀ h_j = 0 and h_iᵀ d = 0, with the normals h of the planes.
    """

    kind = "planar"
    form = "plate"
    countable = ("angle",)
    phi, rows = (*PARALLEL, *IN_PLANE), ("f", "g", "normal")


@element(space=True)
class PointInPlane(JointWithAxis):
    """A point of body j stays in a plane of body i.

    h_iᵀ d = 0 with the normal h; the reaction is a force along it.
    """

    kind = "point in plane"
    form = "plate"
    facing = ()
    phi, rows = IN_PLANE, ("normal",)


@element(space=True)
class PointOnLine(JointWithAxis):
    """A point of body j stays on a line of body i.

    f_iᵀ d = 0 and g_iᵀ d = 0; the reaction is a force across the line.
    """

    kind = "point on line"
    form = "bead"
    countable, facing = ("slide",), ()
    phi, rows = ON_LINE, ("line_f", "line_g")


@element(space=True)
class Strut(PointOnLine):
    """A rod without mass slides along a line of body i; a ball joint holds it to body j.

    The equations are those of a point on a line.
    """

    kind = "strut"


@element(space=True)
class ParallelAxes(JointWithAxis):
    """An axis of body i and one of body j stay parallel, wherever the bodies are.

    f_iᵀ h_j = 0 and g_iᵀ h_j = 0; the reaction is a torque.
    """

    kind = "parallel axes"
    countable = ("angle",)
    phi, rows = PARALLEL, ("f", "g")

    def shapes(self) -> Shapes:
        """Nothing: no places belong together."""
        return ()


LEAD, OFFSET = given("lead"), given("offset")
TURN = THETA + sympy.cos(THETA) * G.dot(F_J) - sympy.sin(THETA) * F.dot(F_J)


@element(space=True)
class ScrewInSpace(JointWithAxis):
    """Body j turns about an axis of body i and moves along it by one lead in each turn.

    The equations of a cylindrical joint, and h_iᵀ d - L/2π (θ + sin(ψ - θ)) - s0 = 0. The joint
    always counts its angle θ, which is ψ, the turn from f_i to f_j, and whole turns; sin(ψ - θ) =
    cos θ g_iᵀ f_j - sin θ f_iᵀ f_j, so that the thread's torque acts on the bodies and not on θ.
    """

    kind = "screw in space"
    form = "shaft"
    countable = ("angle", "slide")
    phi = (*ON_LINE, *PARALLEL, H_I.dot(SPAN) - LEAD / (2 * sympy.pi) * TURN - OFFSET)
    rows = ("line_f", "line_g", "f", "g", "travel")
    numbers = ("lead", "offset")
    lead: sympy.Expr = quantity("m")
    offset: sympy.Expr = quantity("m")

    conditions = Screw.conditions

    def bindings(self) -> dict[sympy.Symbol, sympy.Expr]:
        """The placeholders of other joints, and the angle."""
        return super().bindings() | {THETA: coordinate(self.name, "angle")}
