"""Relative driver: x, y or φ of body j less that of body i follows a law (Haug, section 3.5)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import ConjugateReaction, I, J, Statement
from codegen.declare.symbols import Letter
from codegen.drawing import shapes
from codegen.elements.drivers.driver_base_class import Driver
from codegen.elements.joints.relative import DIFFERENCE
from codegen.elements.registry import element


@element(driver=True)
class RelativeDriver(Driver):
    """x_j^P - x_i^P - C(t) = 0, y_j^P - y_i^P - C(t) = 0 or φ_j - φ_i - C(t) = 0, in global axes.

    With φ it is the revolute-rotational driver: the motor in a revolute joint. The reaction is
    the force along the global axis on body j at its point, N, or the torque on body j, N m; body i
    gets the opposite.
    """

    kind = "relative driver"
    example = 'model.rotation_driver("motor", P, Q, 2 * t**2)'
    declared_by = ("relative_driver", "rotation_driver")
    name: str
    i: Point
    j: Point
    letter: Letter
    law: sympy.Expr

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction.along(self.letter)
        phi = (DIFFERENCE[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, I.bind(self.i) | J.bind(self.j))

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An arrow at the point of body j, straight or round."""
        ux, uy = int(self.letter == "x"), int(self.letter == "y")
        return (shapes.Drive(None, self.j, self.letter == "phi", ux, uy),)
