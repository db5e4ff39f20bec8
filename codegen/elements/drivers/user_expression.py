"""A driver: a coordinate, or any expression of coordinates, follows a law of time (Haug 3.5)."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import ConjugateReaction, Constraint, Statement, label
from codegen.declare.symbols import Coordinate, kinds, t
from codegen.elements.registry import element


@element(driver=True)
class Motion(Constraint):
    """driven - law(t) = 0; its reaction is the force that the driver exerts along `driven`."""

    kind = "driver"
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

    def problems(self) -> list[str]:
        """The law must be one of time alone, twice differentiable, and something must be driven."""
        problems = law_problems(self, self.law)
        if not self.bodies:
            problems.insert(0, f"{label(self)}: {self.driven} names no coordinate of a body.")
        return problems


def law_problems(driver: Constraint, law: sympy.Expr) -> list[str]:
    """A law that contains coordinates is no law of time."""
    return [
        f"{label(driver)}: the law {law} contains the coordinate {s.name}; "
        f"a motion law depends on {t} and parameters only."
        for s in kinds(law, Coordinate)
    ]
