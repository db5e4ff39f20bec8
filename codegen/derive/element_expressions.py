"""The expressions of constraints and effects, in which functions of some kind are looked for.

Messages of runs name the tables of a scene that end, and what they are taken at.

A switch ends a simulation where an effect's table does (`codegen.derive.piecewise_conditions`); all
other analyses, and tables of motion laws and constraints, have no number beyond.
"""

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import sympy

from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds
from codegen.derive.switching_functions import rate
from codegen.tables.table_function import Interpolant

if TYPE_CHECKING:
    from codegen.derive.equations import ConstraintEquations, EffectEquations


class ElementExpression(NamedTuple):
    """An expression by coordinates and velocities, the time and parameters."""

    element: str
    expression: sympy.Expr
    along: sympy.Expr | None = None  # the scalar along which it is a force, with SPEED its rate


def element_expressions(
    constraints: Iterable["ConstraintEquations"],
    effects: Iterable["EffectEquations"],
    functions: tuple[type[sympy.Basic], ...],
) -> Iterator[ElementExpression]:
    """Those that have any of `functions`: of constraints, with their bindings, and of effects."""
    for constraint in constraints:
        bindings = constraint.statement.bindings
        for expression in (*constraint.terms.phi, *bindings.values()):
            if expression.has(*functions):
                yield ElementExpression(constraint.name, expression.xreplace(bindings))
    for one in chain.from_iterable(map(_expressions_of, effects)):
        if one.expression.has(*functions) or (one.along is not None and one.along.has(*functions)):
            yield one


def _expressions_of(effect: "EffectEquations") -> Iterator[ElementExpression]:
    terms = effect.terms
    for scalar, force in terms.pulls:
        yield ElementExpression(effect.name, scalar)
        yield ElementExpression(effect.name, force, scalar)
    yield from (ElementExpression(effect.name, force) for _, force in terms.loads)
    if terms.potential is not None:
        yield ElementExpression(effect.name, terms.potential)


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
