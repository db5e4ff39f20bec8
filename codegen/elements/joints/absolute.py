"""Absolute constraints: a point's x or y, or a body's angle, keeps a value (Haug 3.2.1-3.2.3)."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import I, J, JointReaction, Statement
from codegen.declare.symbols import given
from codegen.elements.registry import element

VALUE = given("value")
LEFT_SIDE = {"x": J.point[0], "y": J.point[1], "phi": J.phi}
X_AXIS = I.A * sympy.Matrix([1, 0])


@element
@dataclass(frozen=True, eq=False)
class Absolute:
    """x_j^P = c, y_j^P = c or φ_j = c; the reaction is that of the ground on the body."""

    kind: ClassVar[str] = "absolute"
    name: str
    ground: Body
    point: Point
    letter: Literal["x", "y", "phi"]
    value: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The ground and the body."""
        return (self.ground, self.point.body)

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.ground.at(0, 0)) | J.bind(self.point) | {VALUE: self.value}
        return Statement(
            (LEFT_SIDE[self.letter] - VALUE,), (self.letter,), JointReaction(X_AXIS), bindings
        )

    def problems(self) -> list[str]:
        """Nothing can be wrong with a number."""
        return []
