"""The period of a table that repeats: the row that closes it, and whether it fits an angle."""

import math

import sympy

from codegen.declare.symbols import Coordinate, alpha

# accuracy: of the last step; a last abscissa that is nearer to the period's end is this end
_SAME = 0.01
_ROUNDED = 1e-5  # accuracy: of a number of turns; a π of five digits makes no larger difference
# safety: turns; a longer period of an angle is in degrees: 710 of them are nearly 113 turns
_MOST = 50
# safety: a longer period that is a multiple or unit fraction of 360 is in degrees
_DEGREES = 90.0
_HALF = sympy.Rational(1, 2)


def with_closing_row(
    x: list[float], y: list[float], period: float
) -> tuple[list[float], list[float]]:
    """Points that end with the first one a period later, whether they had this row or not.

    Raises ValueError, with the reason, where they do not lie within one period.
    """
    end, step = x[0] + period, x[-1] - x[-2] if len(x) > 1 else period
    if period <= 0.0 or x[-1] > end + _SAME * abs(step):
        raise ValueError(
            f"its points reach from {x[0]:g} to {x[-1]:g}, and the period is {period:g}; give "
            "the points of one period, and its length in their unit."
        )
    if end - x[-1] < _SAME * abs(step):
        return [*x[:-1], end], y
    return [*x, end], [*y, y[0]]


def misfit(x: list[float], is_given: bool) -> str:
    """Why a table with abscissae x, the last a period behind the first, is none over an angle.

    Empty where it may be one. A period that is given may be any but one in degrees.
    """
    period, step = x[-1] - x[0], x[-1] - x[-2]
    degrees = period >= _DEGREES and _is_whole(period / 360.0)
    turns = period / (2.0 * math.pi)
    if (_is_whole(turns) and turns < _MOST) or (is_given and not degrees):
        return ""
    missing = _is_whole(turns + step / (2.0 * math.pi))
    whole = f"period={2 * round(turns) or 2}*pi" if missing else "period= in rad"
    return (
        f"it repeats after {period:.9g} rad, or {turns:.6g} turns; over an angle that is to be a "
        f"whole number of turns, up to {_MOST}, or a unit fraction of one: give {whole}, which "
        'adds the row that closes the period, or units=("deg", ...) for abscissae in degrees.'
    )


def _is_whole(count: float) -> bool:
    """Whether it is a whole number, or one through a whole number, but for rounding."""
    count = max(count, 1.0 / count)
    return abs(count - round(count)) <= _ROUNDED * count


def is_angle(expression: sympy.Expr) -> bool:
    """Whether an angle, or its double or half, is a term of an expression."""
    for term in sympy.Add.make_args(expression):
        factor, symbol = term.as_coeff_Mul()
        turns = symbol == alpha or (isinstance(symbol, Coordinate) and symbol.unit == "rad")
        if turns and abs(factor) in (1, 2, _HALF):
            return True
    return False
