"""Translational-distance driver: a slider's way along a line follows a law (Haug, section 3.5)."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import ConjugateReaction, I, J, Statement
from codegen.elements.drivers.time_law import law_problems
from codegen.elements.joints.body_line import ALONG, Axis, axis_problems, bind_axis
from codegen.elements.registry import element


@element(driver=True)
@dataclass(frozen=True, eq=False)
class TranslationDriver:
    """u_iᵀ d_ij - C(t) = 0: how far point j is ahead of point i along an axis of body i.

    The driver of a translational joint between the two points; it may pass through 0, and holds
    beside any other joint as well. The reaction is the force on body j along the axis, N; body i
    gets the opposite on the same line of action.
    """

    kind: ClassVar[str] = "translation driver"
    name: str
    i: Point
    j: Point
    axis: Axis
    law: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The guide and the slider."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation, m."""
        reaction = ConjugateReaction((("force", "N"),))
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        return Statement((ALONG - self.law,), ("along",), reaction, bindings)

    def problems(self) -> list[str]:
        """The law is one of time, and the axis has a direction."""
        where = f"{self.kind} '{self.name}'"
        return law_problems(where, self.law) + axis_problems(where, self.axis)
