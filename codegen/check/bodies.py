"""Checks of the bodies of a declaration."""

import math
from collections.abc import Iterator

import sympy

from codegen.declare.body import Body
from codegen.declare.expression_rules import expression_problem
from codegen.declare.returned_values import check_body
from codegen.errors import ModelError
from codegen.model import Model
from codegen.readers.expressions import constant_value
from codegen.readers.values import one_line


def body_problems(model: Model, body: Body, known: frozenset[sympy.Symbol]) -> Iterator[str]:
    """Problems of a body: of what an own class returns, of its mass and inertia."""
    if not type(body).__module__.startswith("codegen."):
        try:
            check_body(body, known)
        except ModelError as error:
            yield from error.problems
            return
    yield from _mass_problems(model, body)


def _mass_problems(model: Model, body: Body) -> Iterator[str]:
    for word, unit in (("mass", "kg"), ("inertia", "kg m^2")):
        value = getattr(body, word)
        if value is None:
            continue
        if problem := expression_problem(value):  # of a body that a modeller made by hand
            yield f"{word} of body '{body.name}': {problem}"
            continue
        symbols = value.free_symbols
        if unknown := sorted(s.name for s in symbols if s not in model.defaults):
            yield (
                f"{word} of body '{body.name}': unknown symbol {', '.join(map(repr, unknown))}; "
                "a mass is a number or an expression of parameters."
            )
            continue
        number = value.subs(model.defaults) if symbols else value
        try:
            size = constant_value(number)
        except (TypeError, ValueError, ArithmeticError):  # it is complex, or zoo
            size = math.nan
        if not 0.0 < size < math.inf:
            shown = one_line(number) if math.isnan(size) else f"{size:g}"
            yield (
                f"{word} of body '{body.name}' is {shown} {unit}; it must be positive and "
                "finite (leave it out where the scene is kinematic)."
            )
