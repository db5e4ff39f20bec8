"""Drivers in space whose equations are not those of the plane."""

from typing import Literal

import sympy

from codegen.declare.element import ConjugateReaction, Statement, label
from codegen.declare.element_fields import quantity
from codegen.declare.space_body import SpacePoint
from codegen.declare.space_frame import J
from codegen.drawing.shapes import Mark, Shapes
from codegen.elements.drivers import Driver, pushed_along
from codegen.elements.registry import element


@element(driver=True, space=True)
class PointDriverInSpace(Driver):
    """A point follows a law of the time along a global axis.

    x_j^P - C(t) = 0, y_j^P - C(t) = 0 or z_j^P - C(t) = 0; the reaction is the force of the driver
    on the body, at the point and along the axis, N.
    """

    kind = "point driver in space"
    name: str
    point: SpacePoint
    letter: Literal["x", "y", "z"]
    law: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """One equation, m."""
        phi = (J.point["xyz".index(self.letter)] - self.law,)
        reaction = ConjugateReaction.along(self.letter)
        return Statement(phi, (self.letter,), reaction, J.bind(self.point))

    def shapes(self) -> Shapes:
        """The point, and the direction of the force."""
        return Mark(self.point), pushed_along(self.point, self.letter)

    def problems(self) -> list[str]:
        """The law is one of time, and the ground stays where it is."""
        text = f"{label(self)} moves a point of the ground; give one of a moving body."
        return [*super().problems(), *([text] if self.point.body.fixed else [])]
