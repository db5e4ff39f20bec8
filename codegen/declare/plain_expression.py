"""A number or an expression that a modeller gives → an expression of SymPy, by type alone."""

from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy

from codegen.plain_values import KindError, plain_number
from codegen.real_range import BITS


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
        if max(abs(number.numerator), number.denominator).bit_length() > BITS:
            raise KindError("it is a number of thousands of digits")
        return sympy.Rational(number.numerator, number.denominator)
    return sympy.Float(number)
