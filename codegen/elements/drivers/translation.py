"""Translational-distance driver: a slider's way along a line follows a law (Haug, section 3.5)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import ConjugateReaction, I, J, Statement
from codegen.declare.element_conditions import Condition, number_problems
from codegen.drawing import shapes
from codegen.elements.drivers.driver_base_class import Driver
from codegen.elements.joints.body_line import ALONG, Axis, axis_conditions, bind_axis
from codegen.elements.registry import element


@element(driver=True)
class TranslationDriver(Driver):
    """u_iᵀ d_ij - C(t) = 0: how far point j is ahead of point i along an axis of body i.

    The driver of a translational joint between the two points; it may pass through 0, and holds
    beside any other joint as well. The reaction is the force on body j along the axis, N; body i
    gets the opposite on the same line of action.
    """

    kind = "translation driver"
    example = 'model.translation_driver("slide", P, Q, sin(3 * t), axis=(2, 1))'
    name: str
    i: Point
    j: Point
    axis: Axis
    law: sympy.Expr

    def statement(self) -> Statement:
        """One equation, m."""
        reaction = ConjugateReaction((("force", "N"),))
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        return Statement((ALONG - self.law,), ("along",), reaction, bindings)

    def problems(self) -> list[str]:
        """The law is one of time, and the axis has a direction."""
        return super().problems() + number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """An axis with a direction."""
        return axis_conditions(self.axis)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An arrow along the axis."""
        return (shapes.Drive(self.i, self.j, False, *self.axis),)
