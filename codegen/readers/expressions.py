"""Expressions of SymPy: what of them can be a finite real number, and numbers made into them.

Every symbol may have any value, and each operation returns an interval that holds its results,
rounded outwards: whatever is refused here has no value for any motion and any parameters.
"""

import math
import sys
from fractions import Fraction
from functools import lru_cache, reduce
from typing import Any

import sympy
from sympy.concrete.expr_with_limits import ExprWithLimits

from codegen.readers.values import KindError, plain_number

Interval = tuple[float, float]
ALL: Interval = (-math.inf, math.inf)
HUGE = sys.float_info.max
RANGES: dict[Any, Interval] = {
    sympy.sin: (-1.0, 1.0),
    sympy.cos: (-1.0, 1.0),
    sympy.tanh: (-1.0, 1.0),
    sympy.sign: (-1.0, 1.0),
    sympy.Heaviside: (0.0, 1.0),
    sympy.cosh: (1.0, math.inf),
    sympy.atan: (-1.6, 1.6),
    sympy.asin: (-1.6, 1.6),
    sympy.acos: (0.0, 3.2),
    sympy.atan2: (-3.2, 3.2),
}
"""Function → an interval that holds its values."""
UNFINISHED = (sympy.Limit, sympy.Derivative, sympy.Subs, ExprWithLimits)
"""What stands for an expression that is still to be found."""
NUMBERLESS = (sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)

_SMALLEST = 1e-300  # safety: of a number that multiplies a power; one that is smaller is inside
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
    """A part of an expression that never is a finite real number, and why; None: there is none."""
    nodes = distinct_nodes(expression)
    products = [node for node in nodes if powers_with_number_outside(node)]
    known: dict[sympy.Basic, Interval] = {product.args[0]: ALL for product in products}
    for node in nodes:
        if not isinstance(node, sympy.Expr) or node in known:
            continue
        verb = "is" if node == expression else "contains"
        if isinstance(node, UNFINISHED):
            return node, f"{verb} {node}, which is to be written out as by doit()"
        if node in NUMBERLESS:
            return node, f"{verb} {node}"
        if node.is_Symbol or (node.is_Atom and not node.is_number):
            known[node] = ALL
            continue
        interval = _range(node, [known.get(a, ALL) for a in node.args])
        if interval is None:
            return node, f"{verb} {node}, which is never a real number"
        if node.is_number and not (interval[0] < HUGE and interval[1] > -HUGE):
            return node, f"{verb} a number beyond 1e308"
        if node.is_Rational and max(abs(node.p), node.q).bit_length() > _DIGITS * math.log2(10):
            return node, f"{verb} a number of thousands of digits"
        known[node] = interval
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
    both = complex(evaluated(value, 17, 400))
    if both.imag:
        raise KindError("it is not real")
    return both.real


@lru_cache(maxsize=4096)
def constant_value(number: sympy.Expr) -> float:
    """The float that an expression without symbols is; an error of SymPy's where it is none."""
    return float(evaluated(number))


def number_problem(expression: sympy.Basic) -> str | None:
    """Why a part without symbols is no finite real number that SymPy can tell."""
    for number in maximal_numbers(expression):
        try:
            finite = math.isfinite(constant_value(number))
        except (TypeError, ValueError, ArithmeticError):  # it is complex, or not to be told
            finite = False
        if not finite:
            return f"{number} is no real number; give finite real numbers."
    return None


def _range(node: sympy.Expr, args: list[Interval]) -> Interval | None:
    """An interval that holds the values of a node; None where it has none."""
    if node.is_Number or node.is_NumberSymbol:
        return _number(node)
    if node.is_Add:
        return reduce(lambda a, b: _outwards(a[0] + b[0], a[1] + b[1]), args)
    if node.is_Mul:
        return reduce(_product, args)
    if isinstance(node, sympy.exp):
        low, high = (_pow(math.e, end) for end in args[0])
        return max(0.0, _outwards(low, low)[0]), _outwards(high, high)[1]
    if node.is_Pow:
        return _power(args[0], node.exp, args[1])
    if isinstance(node, sympy.Abs):
        low, high = args[0]
        return (0.0 if low <= 0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
    if isinstance(node, sympy.log) and args[0][1] <= 0:
        return None
    if isinstance(node, sympy.asin | sympy.acos) and (args[0][0] > 1 or args[0][1] < -1):
        return None
    return RANGES.get(node.func, ALL)


def _number(node: sympy.Expr) -> Interval:
    try:
        value = node.p / node.q if node.is_Rational else float(node)
    except OverflowError:
        value = math.inf if node > 0 else -math.inf
    return value, value


def _outwards(low: float, high: float) -> Interval:
    """The interval with its ends rounded outwards; an end that is undefined is open."""
    low, high = (math.nextafter(low, -math.inf), math.nextafter(high, math.inf))
    return (-math.inf if math.isnan(low) else low), (math.inf if math.isnan(high) else high)


def _product(a: Interval, b: Interval) -> Interval:
    ends = [0.0 if 0.0 in (x, y) else x * y for x in a for y in b]
    low, high = min(ends), max(ends)
    return (low and _outwards(low, low)[0]), (high and _outwards(high, high)[1])


def _pow(x: float, exponent: float) -> float:
    try:
        return float(abs(x) ** exponent)
    except (OverflowError, ZeroDivisionError):
        return math.inf


def _power(base: Interval, exponent: sympy.Expr, exponents: Interval) -> Interval | None:
    """base ** exponent; of a negative base only whole powers are real."""
    low, high = base
    if exponent.is_Float and float(exponent).is_integer():
        exponent = sympy.Integer(int(exponent))  # 2.0 counts as whole
    if not exponent.is_number or exponent.is_real is not True:
        return (0.0, math.inf) if low >= 0 else ALL
    if not exponent.is_integer and high < 0:
        return None
    e = exponents[0]
    ends = sorted(_pow(x, e) for x in base)
    if exponent.is_integer and exponent.is_odd and low < 0:
        return (
            ALL if low < 0 < high or e < 0 else (-_pow(low, e), math.copysign(_pow(high, e), high))
        )
    low = 0.0 if base[0] <= 0 <= base[1] and e > 0 else ends[0]
    high = math.inf if base[0] <= 0 <= base[1] and e < 0 else ends[1]
    return max(0.0, math.nextafter(low, -math.inf)), math.nextafter(high, math.inf)
