"""A driver: a coordinate, or any expression of coordinates, follows a law of time (Haug 3.5)."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body
from codegen.declare.element import ConjugateReaction, Statement
from codegen.declare.symbols import Coordinate
from codegen.elements.drivers.time_law import component, law_problems
from codegen.elements.registry import element


@element(driver=True)
@dataclass(frozen=True, eq=False)
class Motion:
    """driven - law(t) = 0; its reaction is the force that the driver exerts along `driven`."""

    kind: ClassVar[str] = "driver"
    name: str
    driven: sympy.Expr
    law: sympy.Expr
    bodies: tuple[Body, ...]

    def statement(self) -> Statement:
        """One equation; for a single coordinate the reaction is a force or torque on its body."""
        row, reaction = "motion", ("force", "")
        if isinstance(self.driven, Coordinate):
            row = self.driven.letter
            reaction = component(row)
        return Statement((self.driven - self.law,), (row,), ConjugateReaction((reaction,)))

    def problems(self) -> list[str]:
        """The law must be one of time alone, twice differentiable, and something must be driven."""
        problems = []
        if not self.bodies:
            problems.append(f"driver '{self.name}': {self.driven} names no coordinate of a body.")
        return problems + law_problems(f"driver '{self.name}'", self.law)
