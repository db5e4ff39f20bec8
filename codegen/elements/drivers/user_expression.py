"""A driver: a coordinate, or any expression of coordinates, follows a law of time (Haug 3.5)."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import ConjugateReaction, Statement, label
from codegen.declare.symbols import Coordinate
from codegen.drawing import shapes
from codegen.elements.drivers.driver_base_class import Driver
from codegen.elements.registry import element


@element(driver=True)
class Motion(Driver):
    """driven - law(t) = 0; its reaction is the force that the driver exerts along `driven`."""

    kind = "driver"
    example = """
        omega = model.parameter("omega", 2.0, unit="rad/s")
        model.driver("motor", i.phi, pi / 4 + omega * t)
    """
    name: str
    driven: sympy.Expr
    law: sympy.Expr
    on: tuple[Body, ...]

    def statement(self) -> Statement:
        """One equation; for a single coordinate the reaction is a force or torque on its body."""
        row, reaction = "motion", ConjugateReaction((("force", ""),))
        if isinstance(self.driven, Coordinate):
            row = self.driven.letter
            reaction = ConjugateReaction.along(row)
        return Statement((self.driven - self.law,), (row,), reaction)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An arrow on the body whose coordinate is driven, straight or round."""
        body = next((b for b in self.on if self.driven in (b.x, b.y, b.phi)), None)
        if body is None:
            return ()
        ux, uy = int(self.driven == body.x), int(self.driven == body.y)
        return (shapes.Drive(None, body, self.driven == body.phi, ux, uy),)

    def problems(self) -> list[str]:
        """The law must be one of time alone, twice differentiable, and something must be driven."""
        missing = f"{label(self)}: {self.driven} names no coordinate of a body."
        return [*([] if self.bodies else [missing]), *super().problems()]
