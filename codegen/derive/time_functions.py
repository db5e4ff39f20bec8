"""Explicit functions of time in a scene: the largest parts of its equations without coordinates.

A run looks at them before its first step (`runtime.mechanism.explicit_time`): where they bend
sharply its steps are short, and where their pieces meet steps end.
"""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Literal, NamedTuple

import sympy
from sympy.core.relational import Relational

from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds
from codegen.derive.effect_terms import EffectTerms
from codegen.derive.piecewise_conditions import is_known_beforehand, switching_function
from codegen.readers.expressions import powers_with_number_outside

if TYPE_CHECKING:
    from codegen.derive.equations import ConstraintEquations, EffectEquations

Role = Literal["law", "effect", "place"]


class TimeFunction(NamedTuple):
    """A function of time and parameters alone, and the element that it belongs to."""

    element: str
    # a "law" chooses its pieces by the time itself, an "effect" by its modes; so does a "place",
    # which may not jump where its rate acts
    role: Role
    expression: sympy.Expr
    along: tuple[tuple[sympy.Expr, sympy.Expr], ...] = ()  # (s, f) of the forces, of a "place"


def time_functions(
    constraints: Iterable["ConstraintEquations"], effects: Iterable["EffectEquations"]
) -> tuple[TimeFunction, ...]:
    """The explicit functions of time of constraints and effects, each once."""
    found: dict[TimeFunction, None] = {}
    for constraint in constraints:
        for expression in (*constraint.terms.phi, *constraint.statement.bindings.values()):
            for part in _parts(expression):
                found[TimeFunction(constraint.name, "law", part)] = None
    for effect in effects:
        moving = [(s, f, {*_parts(s)}) for s, f in effect.terms.pulls if _takes_rate(f, s)]
        for expression in _expressions(effect.terms):
            for part in _parts(expression):
                along = tuple((s, f) for s, f, places in moving if part in places)
                role: Role = "place" if along else "effect"
                found[TimeFunction(effect.name, role, part, along)] = None
    return tuple(found)


def _takes_rate(force: sympy.Expr, scalar: sympy.Expr) -> bool:
    """Whether a force takes the rate of the scalar along which it acts, by name or written out."""
    rates = {q.rate for q in kinds(scalar, Coordinate)}
    return force.has(SPEED) or (bool(rates) and rates <= {*kinds(force, Velocity)})


def is_of_time(node: sympy.Basic) -> bool:
    """Whether nothing but the time and parameters is in an expression, the time among it."""
    return is_known_beforehand(node) and any(isinstance(s, Time) for s in node.free_symbols)


def _parts(expression: sympy.Basic) -> Iterator[sympy.Expr]:
    """The largest parts of an expression that are functions of time, in the order of the text."""
    stack: list[sympy.Basic] = [expression] if expression.has(Time) else []
    while stack:
        node = stack.pop()
        if isinstance(node, Relational) and is_of_time(node):
            g = switching_function(node)
            yield sympy.Piecewise((sympy.S.One, g > 0), (sympy.S.Zero, True))
        elif isinstance(node, sympy.Add | sympy.Mul):
            timely = [a for a in node.args if is_of_time(a)]
            if timely and powers_with_number_outside(node):
                timely.insert(0, node.args[0])
            if timely:
                yield node.func(*timely)
            stack += [a for a in node.args[::-1] if a not in timely]
        elif isinstance(node, sympy.Expr) and is_of_time(node):
            yield node
        else:
            stack += node.args[::-1]


def _expressions(terms: EffectTerms) -> Iterator[sympy.Basic]:
    yield from (part for pair in terms.pulls for part in pair)
    yield from (load for _, load in terms.loads)
    if terms.potential is not None:
        yield terms.potential
    if terms.hold is not None:
        yield from (part for part in vars(terms.hold).values() if isinstance(part, sympy.Basic))
