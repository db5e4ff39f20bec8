"""Relative constraints: x, y or φ of two bodies keeps its difference (Haug, section 3.3)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.symbols import Letter, given
from codegen.drawing import shapes
from codegen.elements.registry import element

VALUE = given("value")
SPAN = J.point - I.point
DIFFERENCE = {"x": SPAN[0], "y": SPAN[1], "phi": J.phi - I.phi}
GLOBAL_X = sympy.Matrix([1, 0])


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
    value: sympy.Expr

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.i) | J.bind(self.j) | {VALUE: self.value}
        reaction = JointReaction(GLOBAL_X)
        return Statement((DIFFERENCE[self.letter] - VALUE,), (self.letter,), reaction, bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Marks at both points."""
        return shapes.Mark(self.i), shapes.Mark(self.j)
