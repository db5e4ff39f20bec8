"""Derivatives of the expressions of elements, by the rules of calculus alone.

SymPy differentiates a power as if its exponent might vary, with the logarithm of its base, and asks
a page of questions about the sign of that; half the time of a build went there. Sums, products and
powers with a number for exponent are differentiated here, to the same expressions, once for each
expression and symbol. All else is left to SymPy.
"""

from functools import cache

import sympy


@cache
def derivative(expression: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """∂ expression / ∂ symbol."""
    if expression == symbol:
        return sympy.S.One
    if symbol not in expression.free_symbols:
        return sympy.S.Zero
    args = list(expression.args)
    if expression.is_Add:
        return sympy.Add(*(derivative(a, symbol) for a in args))
    if expression.is_Mul:
        return sympy.Add(
            *(
                sympy.Mul(*args[:k], derivative(a, symbol), *args[k + 1 :])
                for k, a in enumerate(args)
            )
        )
    if expression.is_Pow and args[1].is_number:
        base, exponent = args
        return expression * (derivative(base, symbol) * exponent / base)
    if isinstance(expression, sympy.floor):
        return sympy.S.Zero  # between its jumps, at which steps end
    if isinstance(expression, sympy.sin | sympy.cos):
        return expression.fdiff(1) * derivative(args[0], symbol)
    return sympy.diff(expression, symbol)
