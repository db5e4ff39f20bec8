"""Expressions of SymPy: search for parts that are not finite and real; numbers as expressions."""

import math
from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy
from sympy.concrete.expr_with_limits import ExprWithLimits

from codegen.readers.values import KindError, plain_number

UNFINISHED = (sympy.Limit, sympy.Derivative, sympy.Subs, ExprWithLimits)
"""What stands for an expression that is still to be found."""
NUMBERLESS = (sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)

_SMALLEST = 1e-300  # safety: of the factor of a power; a smaller factor stays inside the power
_DIGITS = 4000  # safety: of a whole number; Python refuses to write one of more than 4300


@lru_cache(maxsize=4096)
def _unit_of_sympy(expression: sympy.Expr) -> sympy.Basic | None:
    units = (a for a in expression.atoms(sympy.AtomicExpr) if hasattr(a, "scale_factor"))
    return next(units, None)


def plain_expression(value: Any) -> sympy.Expr:
    """A number or an expression as an expression; KindError for text, a condition, a matrix."""
    if isinstance(value, sympy.Symbol) and value.is_commutative:
        return value
    if isinstance(value, sympy.Number):  # of which SymPy would derive all that it can assume
        return value if value or not value.is_Float else sympy.S.Zero
    if isinstance(value, sympy.Expr):
        if value.is_Matrix or (not value.is_commutative and value.is_commutative is not None):
            raise KindError
        if unit := _unit_of_sympy(value):
            raise KindError(f"{unit} is a unit of SymPy; give a quantity of pint")
        return value
    number = plain_number(value)
    if number == 0:
        return sympy.S.Zero  # also 0.0, which SymPy tells from 0
    if isinstance(number, int):
        return sympy.Integer(number)
    if isinstance(number, Fraction):
        return sympy.Rational(number.numerator, number.denominator)
    return sympy.Float(number)


def distinct_nodes(expression: sympy.Basic) -> list[sympy.Basic]:
    """The parts of an expression, each once, those inside first."""
    found: dict[sympy.Basic, None] = {}
    waiting: list[tuple[sympy.Basic, bool]] = [(expression, False)]
    while waiting:
        node, is_inside_done = waiting.pop()
        if is_inside_done:
            found[node] = None
        elif node not in found:
            waiting.append((node, True))
            waiting += [(a, False) for a in reversed(node.args) if isinstance(a, sympy.Basic)]
    return list(found)


def maximal_numbers(expression: sympy.Basic) -> list[sympy.Expr]:
    """The largest parts of an expression that are numbers, but for plain ones."""
    found: dict[sympy.Expr, None] = {}
    waiting, seen = [expression], {expression}
    while waiting:
        node = waiting.pop()
        if isinstance(node, sympy.Expr) and node.is_number:
            if not (node.is_Number or node.is_NumberSymbol):
                found[node] = None
            continue
        inner = [a for a in node.args if isinstance(a, sympy.Basic) and a not in seen]
        seen.update(inner)
        waiting += inner
    return list(found)


def powers_with_number_outside(node: sympy.Basic) -> list[sympy.Expr]:
    """The powers b^x, b > 0, of a product whose number no float holds.

    SymPy takes e^990 out of exp(990 - 150 t), which is a fair function.
    """
    if not (isinstance(node, sympy.Mul) and node.args[0].is_Float):
        return []
    if _SMALLEST < abs(node.args[0]) < 1.0 / _SMALLEST:
        return []
    pairs = ((factor, *factor.as_base_exp()) for factor in node.args[1:])
    return [f for f, base, x in pairs if base.is_number and base.is_positive and not x.is_number]


def unreal_part(expression: sympy.Basic) -> tuple[sympy.Basic, str] | None:
    """A part of an expression that is no finite real number, and why; None: there is none."""
    nodes = distinct_nodes(expression)
    outside = {node.args[0] for node in nodes if powers_with_number_outside(node)}
    formulas = {*maximal_numbers(expression)}
    for node in nodes:
        if not isinstance(node, sympy.Expr) or node in outside:
            continue
        why = None
        if isinstance(node, UNFINISHED):
            why = f"{node}, which is to be written out as by doit()"
        elif node in NUMBERLESS:
            why = str(node)
        elif node.is_Number or node in formulas:
            why = _number_fault(node)
        if why:
            return node, f"{'is' if node == expression else 'contains'} {why}"
    return None


def _number_fault(number: sympy.Expr) -> str | None:
    """Why an expression without symbols is no number that a float holds and a text shows."""
    try:
        value = number.p / number.q if number.is_Rational else constant_value(number)
    except OverflowError:
        value = math.inf
    except (TypeError, ValueError, ArithmeticError):  # it is complex, or not to be told
        value = math.nan
    if math.isnan(value):
        return f"{number}, which is never a real number"
    if math.isinf(value):
        return "a number beyond 1e308"
    if number.is_Rational and max(abs(number.p), number.q).bit_length() > _DIGITS * math.log2(10):
        return "a number of thousands of digits"
    return None


def evaluated(number: sympy.Expr, digits: int = 25, most: int = 100) -> sympy.Expr:
    """A number in floating point; a sum of which SymPy finds no digit within `most` is 0."""
    value = number.evalf(digits, maxn=most)
    return sympy.S.Zero if value.is_Float and value._prec == 1 else value


def sympy_float(value: sympy.Basic) -> float:
    """The number that an expression of SymPy is; it may be infinite or nan."""
    if not isinstance(value, sympy.Expr) or value.is_Matrix:
        raise KindError
    if not value.is_number:
        raise KindError("it is an expression, and a number is needed")
    if value in (sympy.nan, sympy.oo, -sympy.oo):
        return float(value)
    if found := unreal_part(value):
        raise KindError(f"it {found[1]}")
    return float(evaluated(value, 17, 400))


@lru_cache(maxsize=4096)
def constant_value(number: sympy.Expr) -> float:
    """The float that an expression without symbols is; an error of SymPy's where it is none."""
    return float(evaluated(number))
