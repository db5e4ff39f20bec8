"""Conditions → switching functions: every smooth piece of a force gets a mode.

`Abs`, `Max`, `Min`, `sign` and `Heaviside` are written as pieces first, so that each step of an
integration sees a smooth function.
"""

from collections.abc import Iterable
from functools import partial

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.symbols import Parameter, Time
from codegen.errors import ModelError

KINKED = (sympy.Abs, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside)
STEPS = (sympy.Mod, sympy.ceiling, sympy.floor)
"""Functions with a jump at every whole number, in which only what is known beforehand may stand."""


def as_pieces(expression: sympy.Expr) -> sympy.Expr:
    """The same function with every kink spelled out as a Piecewise."""
    for function in KINKED:
        if expression.has(function):
            expression = expression.replace(function, partial(_pieces, function))
    if expression.has(sympy.Mod, sympy.ceiling):
        expression = expression.replace(sympy.Mod, lambda a, b: a - b * sympy.floor(a / b))
        expression = expression.replace(sympy.ceiling, lambda a: -sympy.floor(-a))
    return expression.replace(sympy.ITE, _alternatives)


def _alternatives(condition: Boolean, yes: Boolean, no: Boolean) -> Boolean:
    """SymPy's form of a kink inside a condition, in terms of And, Or and Not."""
    return sympy.Or(sympy.And(condition, yes), sympy.And(sympy.Not(condition), no))


def _pieces(function: type[sympy.Function], *arguments: sympy.Expr) -> sympy.Expr:
    first = arguments[0]
    halves = {sympy.Abs: (first, -first), sympy.sign: (1, -1), sympy.Heaviside: (1, 0)}
    if function in halves:
        above, below = halves[function]
        return sympy.Piecewise((above, first > 0), (below, True))
    *firsts, last = arguments
    pieces: list[tuple[sympy.Expr, Boolean | bool]] = []
    for k, one in enumerate(firsts):
        beats = sympy.Gt if function is sympy.Max else sympy.Lt
        pieces.append((one, sympy.And(*(beats(one, other) for other in arguments[k + 1 :]))))
    return sympy.Piecewise(*pieces, (last, True))


def switching_function(condition: Relational) -> sympy.Expr:
    """g with `condition` ⇔ g > 0; a condition and its negation give g and -g."""
    if isinstance(condition, sympy.Eq | sympy.Ne):
        raise ModelError(
            f"the condition {condition} is an equality, which no motion meets for a time; "
            "use an inequality."
        )
    return condition.gts - condition.lts


def is_known_beforehand(node: sympy.Basic) -> bool:
    """Whether nothing but the time and parameters is in an expression."""
    return all(isinstance(symbol, Time | Parameter) for symbol in node.free_symbols)


def conditions(expressions: Iterable[sympy.Expr]) -> tuple[Relational, ...]:
    """Every inequality in the expressions, each once, in the order of its first appearance."""
    relations: dict[Relational, None] = {}
    stack: list[sympy.Basic] = list(expressions)[::-1]
    while stack:
        piece = stack.pop()
        if isinstance(piece, Relational):
            relations[piece] = None
        stack += piece.args[::-1]  # SymPy's own traversal takes And and Or by their hashes
    return tuple(relations)
