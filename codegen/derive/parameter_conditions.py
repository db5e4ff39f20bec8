"""What a scene asks of its parameters: conditions of its elements, tables' ranges, cams' shapes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from typing import cast

import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import Constraint, Effect, Element, label
from codegen.declare.element_fields import Condition, derivatives, hold_conditions
from codegen.declare.returned_values import (
    closed_curves,
    conditions_of,
    own_coordinates,
    statement_of,
)
from codegen.declare.scene import Scene
from codegen.declare.symbols import Parameter, ParameterDeclaration, alpha, dotted, kinds, t
from codegen.derive.effect_terms import effect_terms
from codegen.elements.joints.cams import CamFollower
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
    touches: int = 0  # 1: it touches the next curve from outside, -1: from inside


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


def touching(element: Element, scene: Scene, parameters: Mapping[sympy.Symbol, float]) -> int:
    """Whether two profiles touch from outside, 1, or inside, -1; 0: none do in such an element.

    From outside, unless the scene gives both parameters of another contact.
    """
    if not isinstance(element, CamFollower):
        return 0
    given, own = dict((*scene.guess, *scene.start)), own_coordinates(element)
    if not all(dotted(q) in given for q in own):
        return 1
    coordinates = (*own, *(q for body in element.bodies for q in body.coordinates))
    places = {q: given.get(dotted(q), q.measure.neutral) for q in coordinates}
    return -1 if element.touches_inside({**parameters, **places}) else 1


def profiles_of(element: Element, touches: int) -> Iterator[Profile]:
    """The closed curves of a joint whose shape depends on parameters; both where they touch."""
    rows = [(where, derivatives(curve.at(alpha)), convex)
            for where, curve, convex in closed_curves(element)]  # fmt: skip
    depend = [any(kinds(e, Parameter) for e in shape) for _, shape, _ in rows]
    for k, (where, shape, convex) in enumerate(rows):
        if depend[k] or (touches and any(depend)):
            touched = touches if k == 0 else 0
            yield Profile(where, tuple(e.subs(alpha, t) for e in shape), convex, touched)


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
