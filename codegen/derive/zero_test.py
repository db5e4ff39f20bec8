"""Is an expression zero, whatever its symbols are? Numbers tell sooner than expanding does."""

import math
from typing import NamedTuple

import sympy

# safety: golden and silver ratio; symbols get fractional parts of multiples of these
_POINTS = (0.6180339887498949, 0.4142135623730951)
_ROUNDING = 1e-12  # accuracy: a sum below this part of its terms' sizes is zero


class _Sized(NamedTuple):
    value: float
    size: float  # what the value would be if nothing cancelled


class _UnknownError(Exception):
    """The expression holds something that has no number here."""


def is_zero(expr: sympy.Expr) -> bool:
    """Whether sums, products, powers, sines and cosines cancel at points where nothing else would.

    False also where the expression holds other functions: then it is not known.
    """
    symbols = sorted(expr.free_symbols, key=str)
    try:
        for step in _POINTS:
            at = {symbol: 0.5 + math.modf((k + 1) * step)[0] for k, symbol in enumerate(symbols)}
            sized = _number(expr, at)
            if not abs(sized.value) <= _ROUNDING * sized.size:
                return False
    except (_UnknownError, ArithmeticError, ValueError):
        return False
    return True


def _number(expr: sympy.Expr, at: dict[sympy.Symbol, float]) -> _Sized:
    if expr.is_Symbol:
        return _Sized(at[expr], at[expr])
    if expr.is_number:
        number = float(expr)
        return _Sized(number, abs(number))
    parts = [_number(part, at) for part in expr.args]
    if expr.is_Add:
        return _Sized(math.fsum(x.value for x in parts), math.fsum(x.size for x in parts))
    if expr.is_Mul:
        return _Sized(math.prod(x.value for x in parts), math.prod(x.size for x in parts))
    if expr.is_Pow:
        base, power = parts
        number = math.pow(base.value, power.value)
        return _Sized(number, max(abs(number), math.pow(base.size, power.value)))
    if expr.func in (sympy.sin, sympy.cos):
        number = math.sin(parts[0].value) if expr.func is sympy.sin else math.cos(parts[0].value)
        return _Sized(number, 1.0)
    raise _UnknownError
