"""The tables of a scene that end, and what they are taken at: for messages of runs that leave one.

A switch ends a simulation where an effect's table does (`codegen.derive.piecewise_conditions`); all
other analyses, and tables of motion laws and constraints, have no number beyond.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import sympy

from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds
from codegen.derive.element_expressions import element_expressions
from codegen.derive.switching_functions import rate
from codegen.tables.table_function import Interpolant

if TYPE_CHECKING:
    from codegen.derive.equations import ConstraintEquations, EffectEquations


class TableRange(NamedTuple):
    """A table that is undefined beyond its ends, and the expression that it is taken at."""

    element: str
    table: str
    at: sympy.Expr
    low: float
    high: float


def table_ranges(
    constraints: Iterable["ConstraintEquations"], effects: Iterable["EffectEquations"]
) -> tuple[TableRange, ...]:
    """The tables of constraints and effects that a motion may leave, each use once."""
    found: dict[TableRange, None] = {}
    for element, expression, along in element_expressions(constraints, effects, (Interpolant,)):
        moved = along is not None and expression.has(SPEED)
        taken = expression.xreplace({SPEED: rate(along)}) if moved else expression
        for node in sorted(taken.atoms(Interpolant), key=str):
            table = node.table
            moves = kinds(node.at, Coordinate, Velocity, Time)
            if table.stops and table.role in ("values", "end") and moves:
                found[TableRange(element, table.name, node.at, table.first, table.last)] = None
    return tuple(found)
