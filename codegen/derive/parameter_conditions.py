"""What a scene asks of its parameters: conditions of its elements, tables' ranges, cams' shapes."""

from collections.abc import Iterator
from dataclasses import dataclass, is_dataclass
from typing import cast

import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import Constraint, Effect, Element, label
from codegen.declare.element_fields import Condition, derivatives, hold_conditions
from codegen.declare.returned_values import closed_curves, conditions_of, statement_of
from codegen.declare.symbols import Parameter, ParameterDeclaration, alpha, kinds, t
from codegen.derive.effect_terms import effect_terms
from codegen.tables.table_function import Interpolant


@dataclass(frozen=True)
class ElementCondition:
    """A condition, and the element that has it, as messages name it."""

    element: str
    condition: Condition


@dataclass(frozen=True)
class Profile:
    """A closed curve whose shape depends on parameters."""

    element: str
    # x, y and their first and second derivatives by α, which t stands for
    derivatives: tuple[sympy.Expr, ...]
    convex: bool


def expressions_in(part: object) -> Iterator[sympy.Basic]:
    """The expressions in nested tuples, lists, mappings and dataclasses."""
    stack = [part]
    while stack:
        part = stack.pop()
        if isinstance(part, sympy.Basic):
            yield part
        elif isinstance(part, tuple | list):
            stack += part
        elif isinstance(part, dict):
            stack += part.values()
        elif is_dataclass(part):
            stack += vars(part).values()


def element_conditions(element: Element, bodies: Bodies) -> list[ElementCondition]:
    """All conditions of an element that acts, on numbers as on parameters."""
    conditions = list(conditions_of(element))
    parts: object
    if isinstance(element, Constraint):
        statement = statement_of(element)
        parts = [tuple(statement.phi), dict(statement.bindings)]
    else:
        terms = effect_terms(cast(Effect, element), bodies)
        conditions += hold_conditions(terms.hold)
        parts = terms
    lookups = {node for e in expressions_in(parts) for node in e.atoms(Interpolant)}
    conditions += _ranges(sorted(lookups, key=str))
    return [ElementCondition(label(element), c) for c in conditions if not c.varies]


def _ranges(lookups: list[Interpolant]) -> Iterator[Condition]:
    """Tables that are taken at parameters alone, within their ends."""
    for node in lookups:
        table, at = node.table, node.at
        if not table.periodic and kinds(at, Parameter):
            low, high = table.knots[0], table.knots[-1]
            text = (
                f"table '{table.name}' is taken at {at} = {{:g}}, outside of its points from "
                f"{low:g} to {high:g}."
            )
            yield Condition(text, (at,), low, False, high)


def profiles_of(element: Element) -> Iterator[Profile]:
    """The closed curves of a joint whose shape depends on parameters."""
    for where, curve, convex in closed_curves(element):
        shape = derivatives(curve.at(alpha))
        if any(kinds(e, Parameter) for e in shape):
            yield Profile(where, tuple(e.subs(alpha, t) for e in shape), convex)


def carried(
    conditions: list[ElementCondition], parameters: tuple[ParameterDeclaration, ...],
    defaults: dict[sympy.Symbol, float],
) -> tuple[ElementCondition, ...]:  # fmt: skip
    """Those that other parameters may break, in terms of the `parameters` that take part.

    What the rule of a parameter's own sign implies is left out.
    """
    declared = {p.name: p for p in parameters}
    fixed = {symbol: value for symbol, value in defaults.items() if symbol.name not in declared}
    kept = {}
    for one in conditions:
        condition = one.condition
        numbers = tuple(number.subs(fixed) for number in condition.numbers)
        bound = Condition(
            condition.sentence, numbers, condition.low, condition.open, condition.high
        )
        if not bound.known and not bound.follows_from(declared):
            kept[one.element, bound] = ElementCondition(one.element, bound)
    return tuple(kept.values())
