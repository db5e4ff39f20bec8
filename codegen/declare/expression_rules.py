"""What an expression may consist of, wherever it stands in a declaration."""

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.symbols import (
    Acceleration,
    Coordinate,
    Given,
    Multiplier,
    Parameter,
    Side,
    Speed,
    Time,
    Velocity,
    alpha,
)
from codegen.readers.calls import unreadable
from codegen.readers.expressions import UNFINISHED, distinct_nodes, unreal_part
from codegen.readers.values import one_line, shown
from codegen.tables.table_function import Interpolant, TableAtom

INTERNAL = (Given, Side, Speed, Multiplier, Acceleration)
"""Symbols of the equations of elements, which mean nothing in a declaration."""
FUNCTIONS = (
    *(Interpolant, sympy.Piecewise, sympy.Abs, sympy.Heaviside, sympy.Max, sympy.Min, sympy.sign),
    *(sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan, sympy.atan2),
    *(sympy.sinh, sympy.cosh, sympy.tanh, sympy.exp, sympy.log),
    *(sympy.floor, sympy.ceiling, sympy.Mod),
)
"""The functions that can be compiled."""
PLAIN = (
    *(sympy.Symbol, sympy.Number, sympy.NumberSymbol, sympy.Add, sympy.Mul, sympy.Pow, TableAtom),
    *(sympy.I.func, sympy.zoo.func, Relational, Boolean, sympy.Tuple, *UNFINISHED),
)
"""What needs no function, or is refused for a reason of its own."""
MEANINGFUL = (Coordinate, Velocity, Time, Parameter)
"""Symbols that mean something in a declaration."""


def expression_problem(expression: sympy.Expr, profile: bool = False) -> str | None:
    """Why an expression can stand nowhere in a declaration; a `profile` may contain `alpha`."""
    if isinstance(expression, MEANINGFUL):
        return None
    try:
        return _problem(expression, profile)
    except Exception as error:  # of SymPy, of an expression too deep
        return unreadable(error)


def _problem(expression: sympy.Expr, profile: bool) -> str | None:
    for symbol in sorted(expression.free_symbols, key=str):
        if symbol == alpha and not profile:
            return (
                f"{one_line(expression)} contains alpha, the parameter of a profile, which means "
                "nothing outside of body.curve(...) and body.polar(...); a cam's contact is at "
                "joint.alpha."
            )
        if isinstance(symbol, INTERNAL) and symbol != alpha:
            return (
                f"{one_line(expression)} contains '{one_line(symbol)}', a placeholder of an "
                "element's equations; use coordinates, velocities, parameters and t."
            )
    return compile_problem(expression)


def compile_problem(expression: sympy.Basic) -> str | None:
    """Why an expression has no value, or cannot be compiled; None: it can."""
    found = unreal_part(expression)
    unknown = [
        node
        for node in distinct_nodes(expression)
        if node.func not in FUNCTIONS and not isinstance(node, PLAIN) and not node.is_number
    ]
    if unknown:
        known = ", ".join(sorted(f.__name__ for f in FUNCTIONS[2:]))
        what = min(map(one_line, unknown))
        return f"{what} cannot be compiled; known are {known}, powers and Piecewise."
    pieces = expression.atoms(sympy.Piecewise)
    incomplete = [piece for piece in pieces if piece.args[-1].cond != sympy.true]
    if incomplete:
        return (
            f"{one_line(min(incomplete, key=str))} says nothing where none of its conditions "
            "holds; end it with (value, True)."
        )
    if found:
        part, why = found
        start = "the value" if part == expression else shown(expression)
        return f"{start} {one_line(why)}; give finite real numbers."
    return None
