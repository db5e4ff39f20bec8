"""Where the values of an expression can lie, to find what is no finite real number anywhere.

Every symbol may have any value, and each operation answers an interval that holds its results,
rounded outwards: whatever is refused here has no value for any motion and any parameters.
"""

import math
import sys
from functools import lru_cache, reduce
from typing import Any

import sympy
from sympy.concrete.expr_with_limits import ExprWithLimits
from sympy.functions.special.bessel import BesselBase

from codegen.errors import FAILURES
from codegen.plain_values import TINY, KindError

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

BITS = 14_000  # safety: of a whole number; one of more digits Python does not write
_ARGUMENT = 1e3  # safety: of Γ, ζ, Bessel's and other functions, which may be summed term by term
_ORDER = 100  # measured: of Bessel's functions of any number; they take milliseconds
_SPECIAL = ("sympy.functions.special", "sympy.functions.combinatorial", "sympy.ntheory")
_SMALLEST = 1e-300  # safety: of a number that multiplies a power; one that is smaller is inside


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
    sizes: dict[sympy.Basic, float] = {}
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
        inner = [known.get(a, ALL) for a in node.args]
        if all(a in sizes for a in node.args):  # a number: symbols have no size
            sizes[node] = _exact_bits(node, sizes, inner)
        if why := _oversize(node, sizes.get(node, 0.0), inner):
            return node, f"{verb} {why}"
        interval = _range(node, inner)
        if interval is None:
            return node, f"{verb} {node}, which is never a real number"
        if node.is_Number and interval == (0.0, 0.0) and not node.is_zero:
            return node, f"{verb} a number {TINY}"
        if node.is_number and not (interval[0] < HUGE and interval[1] > -HUGE):
            return node, f"{verb} a number beyond 1e308"
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
    if found := unreal_part(value):  # also what is too large to be evaluated
        raise KindError(f"it {found[1]}")
    try:
        exact = evaluated(value, 17, 400)
        both = complex(exact)
    except FAILURES as error:  # of a number that is not to be told from another one
        raise KindError(f"SymPy cannot evaluate it: {type(error).__name__}") from error
    if both.imag:
        raise KindError("it is not real")
    if both == 0 and not exact.is_zero:
        raise KindError(f"it is {TINY}")
    return both.real


@lru_cache(maxsize=4096)
def constant_value(number: sympy.Expr) -> float:
    """The float that an expression without symbols is; an error of SymPy's where it is none."""
    return float(evaluated(number))


def _exact_bits(node: sympy.Expr, sizes: dict[sympy.Basic, float], args: list[Interval]) -> float:
    """Bits of the whole numbers in a number, with its powers multiplied out; π has none.

    SymPy multiplies no power of a sum out, so long as this is no fraction when it is written anew.
    """
    if node.is_Rational:
        return float(max(abs(node.p).bit_length(), node.q.bit_length()))
    if node.is_Pow and node.exp.is_rational:  # SymPy takes 3 out of 3^(7/5)
        times = max(map(abs, args[1]))
        if times == math.inf:
            return math.inf
        bits = sizes[node.base] * (1.0 + times // 1.0)
        is_sum = bits > BITS and node.base.is_Add and node.base.doit().is_Add
        return sizes[node.base] if is_sum else bits
    return sum(sizes[a] for a in node.args) if node.is_Add or node.is_Mul else 0.0


def _oversize(node: sympy.Expr, bits: float, args: list[Interval]) -> str | None:
    """Why a number would take SymPy too long to evaluate; None: it would not."""
    if node.is_Rational:
        p, q = abs(node.p).bit_length(), node.q.bit_length()
        return "a number of thousands of digits" if max(p, q) > BITS and p - q < 1000 else None
    if not (node.args and node.is_number):
        return None
    if node.is_Pow and bits > BITS:
        low, high = _range(node, args) or ALL
        if low >= HUGE or high <= -HUGE:
            return "a number beyond 1e308"
        if bits == math.inf:
            return "a power whose exponent has no known size"
        return f"an exact power of {math.log10(2) * bits:.1e} digits"
    if type(node).__module__.startswith(_SPECIAL):
        sizes = [max(map(abs, interval)) for interval in args]
        if isinstance(node, BesselBase) and sizes[0] <= _ORDER and sizes[1] < HUGE:
            return None  # of a low order it is as cheap far out
        if max(sizes, default=0.0) > _ARGUMENT:
            beyond = "of unknown size" if math.inf in sizes else "beyond 1000"
            return f"{type(node).__name__} of a number {beyond}"
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
        return (math.inf, math.inf) if node > 0 else (-math.inf, -math.inf)
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
