"""Joints in space, made of three kinds of equations.

Two points coincide, r_i + A_i s'_i - r_j - A_j s'_j = 0; two vectors are perpendicular, aᵀ b = 0;
a vector is perpendicular to the line between two points, aᵀ d = 0 with d = r_j^P - r_i^P (E. J.
Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems, 1989, 9.4). Body i has the axis
h of a joint and two vectors f, g perpendicular to it and to each other; body j has f and h, too.

A joint counts an angle or a slide where a scene asks for it: an own coordinate with a row of its
own. The angle θ is that by which body j has turned against body i about h since the drawing, with

    2 (c Δ_h - s Δ_0) = 2 sin((ψ - θ) / 2) = 0,   c = cos(θ/2), s = sin(θ/2),

Δ the Euler parameters of the turn ψ from f_i to f_j. Its roots are ψ and all whole turns more, and
no angle of the mirrored closure; its slope by θ is -1 or 1 in each. The slide is h_iᵀ d.
"""

from copy import copy
from typing import Any, ClassVar, Self

import numpy as np
import sympy

from codegen.declare.drawn_pose import attitude_of_axes, symbolic
from codegen.declare.element import Constraint, Statement, WrenchReaction, label
from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.space_body import SpacePoint, Three
from codegen.declare.space_frame import I, J
from codegen.declare.symbols import coordinate, given
from codegen.drawing.shapes import Rod, Shapes
from codegen.drawing.space_shapes import SpaceJoint
from codegen.elements.registry import element
from codegen.errors import ModelError

SPAN = J.point - I.point
COINCIDENT = tuple(-SPAN)
F, G, H_I = I.vector("f"), I.vector("g"), I.vector("h")
F_J, H_J = J.vector("f"), J.vector("h")
PARALLEL = (F.dot(H_J), G.dot(H_J))
ON_LINE = (F.dot(SPAN), G.dot(SPAN))
LENGTH = given("length")
DRAWN = tuple(given(f"drawn{k}") for k in range(4))  # body i in body j, at the drawing
THETA, SLIDE = coordinate("joint", "angle"), coordinate("joint", "slide")


def product(a: Any, b: Any) -> tuple[Any, ...]:
    """The product of two quaternions, Euler parameters of one turn after another."""
    u, v = sympy.Matrix(a[1:]), sympy.Matrix(b[1:])
    return (a[0] * b[0] - u.dot(v), *(a[0] * v + b[0] * u + u.cross(v)))


def conjugate(p: Any) -> tuple[Any, ...]:
    """The Euler parameters of the opposite turn."""
    return (p[0], *(-e for e in p[1:]))


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
                f"{label(joint)} has no {letter}; revolute and cylindrical joints have an angle, "
                "cylindrical and translational joints a slide."
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

    def statement(self) -> Statement:
        """The equations of its class."""
        of_i, of_j = self.vectors()
        bindings = I.bind(self.i, **of_i) | J.bind(self.j, **of_j)
        return Statement(self.phi, self.rows, WrenchReaction(J), bindings, facing=self.facing)

    def shapes(self) -> Shapes:
        """The form of its class, along an axis of each body if it has them."""
        pairs = zip((self.i, self.j), self.vectors(), strict=True)
        axes = (SpacePoint(end.body, *own["h"]) for end, own in pairs if "h" in own)
        return (SpaceJoint(self.i, self.j, self.form, *axes),)


@shared_fields
class JointWithAxis(JointInSpace):
    """A joint with an axis: f, g and h of body i, f and h of body j."""

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

    def statement(self) -> Statement:
        """The equations of its class, and those of what it counts."""
        stated = super().statement()
        if not self.counted:
            return stated
        own = tuple((letter, coordinate(self.name, letter)) for letter in self.counted)
        bindings = stated.bindings | self._drawn | {COUNTED[letter][0]: q for letter, q in own}
        phi = (*self.phi, *(COUNTED[letter][1] for letter in self.counted))
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
    form = "hinge"
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
    """A Cardan joint: two points coincide, and an axis of each body stays perpendicular.

    r_i^P - r_j^P = 0 and h_iᵀ h_j = 0.
    """

    kind = "universal"
    form = "cross"
    phi, rows = (*COINCIDENT, H_I.dot(H_J)), ("x", "y", "z", "cross")
    axis_i: Three
    axis_j: Three

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """h of both bodies."""
        return {"h": self.axis_i}, {"h": self.axis_j}


@element(space=True)
class DistanceInSpace(JointInSpace):
    """Two points keep their distance, as a massless rod with two ball joints makes them.

    dᵀ d - L² = 0.
    """

    kind = "distance in space"
    phi, rows = (SPAN.dot(SPAN) - LENGTH**2,), ("length",)
    length: sympy.Expr = quantity("m", "positive", advice=", or use a spherical joint")

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j) | {LENGTH: self.length}
        return Statement(self.phi, self.rows, WrenchReaction(J), bindings)

    def shapes(self) -> Shapes:
        """A rod."""
        return (Rod(self.i, self.j),)
