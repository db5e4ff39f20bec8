"""Absolute driver: a point's x or y, or a body's φ, follows a law of time (Haug, section 3.5)."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import ConjugateReaction, J, Statement
from codegen.elements.drivers.time_law import component, law_problems
from codegen.elements.registry import element

DRIVEN = {"x": J.point[0], "y": J.point[1], "phi": J.phi}


@element(driver=True)
@dataclass(frozen=True, eq=False)
class PointDriver:
    """x_j^P - C(t) = 0, y_j^P - C(t) = 0 or φ_j - C(t) = 0.

    The reaction is the force at the point along the global axis, N, or the torque, N m, that the
    driver exerts on the body.
    """

    kind: ClassVar[str] = "point driver"
    name: str
    point: Point
    letter: Literal["x", "y", "phi"]
    law: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The body moved."""
        return (self.point.body,)

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction((component(self.letter),))
        phi = (DRIVEN[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, J.bind(self.point))

    def problems(self) -> list[str]:
        """The law is one of time, and the ground stays where it is."""
        where = f"{self.kind} '{self.name}'"
        problems = law_problems(where, self.law)
        if self.point.body.fixed:
            problems.append(f"{where} moves a point of the ground; give one of a moving body.")
        return problems
