"""The expressions of constraints and effects, in which functions of some kind are looked for."""

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import sympy

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
