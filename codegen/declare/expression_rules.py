"""What an expression may consist of, wherever it stands in a declaration."""

import math

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
from codegen.errors import FAILURES
from codegen.plain_values import TINY, one_line, shown
from codegen.public_callables import unreadable
from codegen.real_range import (
    UNFINISHED,
    constant_value,
    distinct_nodes,
    evaluated,
    unreal_part,
)
from codegen.tables.table_function import Interpolant, TableAtom
from codegen.values_of_long_numbers import maximal_numbers

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
    except FAILURES as error:  # of SymPy, of a number of thousands of digits
        return unreadable(error)


def is_costly(part: sympy.Basic) -> bool:
    """Whether SymPy would evaluate a part that is refused to write what contains it."""
    plain = part.is_Rational or part.is_Pow or (part.is_Function and part.func not in FUNCTIONS)
    return bool(part.is_number and plain)


def number_problem(expression: sympy.Basic) -> str | None:
    """Why a part without symbols is no finite real number that SymPy can tell."""
    for number in maximal_numbers(expression):
        try:
            value = constant_value(number)
            finite, lost = math.isfinite(value), value == 0.0 and evaluated(number) != 0
        except FAILURES:  # it is complex, or not to be told from another number
            finite, lost = False, False
        if not finite:
            return f"{shown(number)} is no real number; give finite real numbers."
        if lost:
            return f"{shown(number)} is {TINY}; give finite real numbers."
    return None


def _problem(expression: sympy.Expr, profile: bool) -> str | None:
    found = unreal_part(expression)
    if found and is_costly(found[0]):
        return f"the value {one_line(found[1])}; give finite real numbers."
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
    if found is None and (problem := number_problem(expression)):
        return problem
    nodes = distinct_nodes(expression)
    unknown = [n for n in nodes if n.func not in FUNCTIONS and not isinstance(n, PLAIN)]
    for node in unknown:  # written, to be sorted, where there is a fault
        if node.is_number is not True:
            known = ", ".join(sorted(f.__name__ for f in FUNCTIONS[2:]))
            what = one_line(min((n for n in unknown if n.is_number is not True), key=one_line))
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
        start = "the value" if part == expression else one_line(expression)
        return f"{start} {one_line(why)}; give finite real numbers."
    return None
