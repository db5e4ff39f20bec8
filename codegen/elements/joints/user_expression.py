"""A constraint that the user writes as plain expressions Φ(q, t)."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import ConjugateReaction, Constraint, Statement, label
from codegen.elements.registry import element


@element
class ExpressionConstraint(Constraint):
    """Any equations of coordinates, parameters and t; each expression is kept at zero."""

    kind = "constraint"
    name: str
    phi: tuple[sympy.Expr, ...]
    on: tuple[Body, ...]

    def statement(self) -> Statement:
        """The expressions as they stand; the reactions are their multipliers' forces -λ."""
        rows = tuple(f"row{k}" if len(self.phi) > 1 else "row" for k in range(len(self.phi)))
        reaction = ConjugateReaction(tuple((row.replace("row", "force"), "") for row in rows))
        return Statement(self.phi, rows, reaction)

    def problems(self) -> list[str]:
        """An equation without coordinates constrains nothing."""
        if not self.bodies:
            return [f"{label(self)}: {self.phi} names no coordinate of a body."]
        return []
