"""Relative driver: x, y or φ of body j less that of body i follows a law (Haug, section 3.5)."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import ConjugateReaction, I, J, Statement
from codegen.elements.drivers.time_law import component, law_problems
from codegen.elements.joints.relative import DIFFERENCE
from codegen.elements.registry import element


@element(driver=True)
@dataclass(frozen=True, eq=False)
class RelativeDriver:
    """x_j^P - x_i^P - C(t) = 0, y_j^P - y_i^P - C(t) = 0 or φ_j - φ_i - C(t) = 0, in global axes.

    With φ it is the revolute-rotational driver: the motor in a revolute joint. The reaction is
    the force along the global axis on body j at its point, N, or the torque on body j, N m; body i
    gets the opposite.
    """

    kind: ClassVar[str] = "relative driver"
    name: str
    i: Point
    j: Point
    letter: Literal["x", "y", "phi"]
    law: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two bodies compared."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction((component(self.letter),))
        phi = (DIFFERENCE[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, I.bind(self.i) | J.bind(self.j))

    def problems(self) -> list[str]:
        """The law is one of time."""
        return law_problems(f"{self.kind} '{self.name}'", self.law)
