"""Constraints in global axes: x, y or φ of a body, or of two, keeps a value (Haug 3.2 and 3.3)."""

from typing import Any

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_fields import ground_unless_given, quantity
from codegen.declare.symbols import KINDS, Letter, given
from codegen.drawing import shapes
from codegen.elements.joints.links import SPAN, X_AXIS
from codegen.elements.registry import element

VALUE = given("value")
LEFT_SIDE = {"x": J.point[0], "y": J.point[1], "phi": J.phi}
DIFFERENCE = {"x": SPAN[0], "y": SPAN[1], "phi": J.phi - I.phi}
GLOBAL_X = sympy.Matrix([1, 0])


def letter_unit(element: Any) -> str:
    """Unit of the coordinate whose letter an element has."""
    return KINDS[element.letter].unit


@element
class Absolute(Constraint):
    """x_j^P = c, y_j^P = c or φ_j = c; the reaction is that of the ground on the body."""

    kind = "absolute"
    example = 'model.absolute("level", Q, "y", 0.5)'
    name: str
    ground: Body = ground_unless_given()
    point: Point
    letter: Letter
    value: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.ground.at(0, 0)) | J.bind(self.point) | {VALUE: self.value}
        phi = (LEFT_SIDE[self.letter] - VALUE,)
        return Statement(phi, (self.letter,), JointReaction(X_AXIS), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A mark at the point."""
        return (shapes.Mark(self.point),)


@element
class Relative(Constraint):
    """x_j^P - x_i^P = c, y_j^P - y_i^P = c or φ_j - φ_i = c, in global axes.

    The reaction is that of the constraint on body j at its point, in global axes. Body i gets
    the opposite force at its own point. The moment of this pair, where the points are apart across
    the force, is borne by whatever keeps the global axes from turning; so a relative x or y
    between two free bodies keeps their linear momentum and their energy, not the angular momentum.
    """

    kind = "relative"
    example = 'model.relative("beside", P, Q, "x", 0.5)'
    name: str
    i: Point
    j: Point
    letter: Letter
    value: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.i) | J.bind(self.j) | {VALUE: self.value}
        reaction = JointReaction(GLOBAL_X)
        return Statement((DIFFERENCE[self.letter] - VALUE,), (self.letter,), reaction, bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Marks at both points."""
        return shapes.Mark(self.i), shapes.Mark(self.j)
