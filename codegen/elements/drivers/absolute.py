"""Absolute driver: a point's x or y, or a body's φ, follows a law of time (Haug, section 3.5)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import ConjugateReaction, J, Statement, label
from codegen.declare.symbols import Letter
from codegen.drawing import shapes
from codegen.elements.drivers.driver_base_class import Driver
from codegen.elements.joints.absolute import LEFT_SIDE
from codegen.elements.registry import element


@element(driver=True)
class PointDriver(Driver):
    """x_j^P - C(t) = 0, y_j^P - C(t) = 0 or φ_j - C(t) = 0.

    The reaction is the force at the point along the global axis, N, or the torque, N m, that the
    driver exerts on the body.
    """

    kind = "point driver"
    example = """
        points = [0, 1, 2, 3, 4], [0, 0.3, 0.8, 1, 0.8]
        lift = model.table("lift", *points, units=("s", "m"), kind="spline")
        model.point_driver("hand", Q, "y", lift(t))
    """
    name: str
    point: Point
    letter: Letter
    law: sympy.Expr

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction.along(self.letter)
        phi = (LEFT_SIDE[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, J.bind(self.point))

    def problems(self) -> list[str]:
        """The law is one of time, and the ground stays where it is."""
        problems = super().problems()
        if self.point.body.fixed:
            problems.append(
                f"{label(self)} moves a point of the ground; give one of a moving body."
            )
        return problems

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An arrow at the point, straight or round."""
        ux, uy = int(self.letter == "x"), int(self.letter == "y")
        return (shapes.Drive(None, self.point, self.letter == "phi", ux, uy),)
