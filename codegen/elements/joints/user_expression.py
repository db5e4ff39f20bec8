"""A constraint that the user writes as plain expressions Φ(q, t)."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import ConjugateReaction, Constraint, Statement, label
from codegen.declare.symbols import Coordinate
from codegen.elements.registry import element


@element
class ExpressionConstraint(Constraint):
    """Any equations of coordinates, parameters and t; each expression is kept at zero."""

    kind = "constraint"
    example = 'model.constraint("pulley", i.y + 2 * j.y - 1)'
    name: str
    phi: tuple[sympy.Expr, ...]
    on: tuple[Body, ...]

    def statement(self) -> Statement:
        """The expressions as they stand; the reactions are their multipliers' forces -λ."""
        rows = tuple(f"row{k}" if len(self.phi) > 1 else "row" for k in range(len(self.phi)))
        names = (row.replace("row", "force") for row in rows)
        reaction = ConjugateReaction(tuple(zip(names, map(_force_unit, self.phi), strict=True)))
        return Statement(self.phi, rows, reaction)

    def problems(self) -> list[str]:
        """An equation without coordinates constrains nothing."""
        if not self.bodies:
            return [f"{label(self)}: {self.phi} names no coordinate of a body."]
        return []


def _force_unit(phi: sympy.Expr) -> str:
    """N or N m of the multiplier, where numbers alone multiply coordinates of one unit; else ""."""
    coordinates = phi.atoms(Coordinate)
    plain = all(phi.diff(x).is_number for x in coordinates)
    units = {x.measure.force_unit for x in coordinates} if plain else set()
    return units.pop() if len(units) == 1 else ""
