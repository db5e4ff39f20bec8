"""Interval arithmetic: bounds of an operation's value from those of what it takes.

R. E. Moore, Interval Analysis, 1966. Bounds are not rounded outwards; what they are compared with
is far from rounding.

Evaluation of an explicit function of time in an interval: bounds of all its values at once.

Interval arithmetic misses nothing between two samples: a pulse that lives in a hundredth of a
millionth of the run is inside the bounds of its interval.
"""

import math

from runtime.core.arrays import (
    IntegerMatrix,
    Matrix,
    Vector,
    f8,
    i8,
    integer_matrix,
    matrix,
    vector,
)
from runtime.core.jit import compiled, inner

OPERATIONS = (
    *("const", "p", "t", "+", "-", "*", "/", "neg", "sin", "cos", "tan", "asin", "acos", "atan"),
    *("atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "pow", "floor", "<", "not", "and"),
    *("or", "select", "table"),
)
(
    CONST, P, T, ADD, SUB, MUL, DIV, NEG, SIN, COS, TAN, ASIN, ACOS, ATAN, ATAN2, SINH, COSH, TANH,
    EXP, LOG, SQRT, POW, FLOOR, LESS, NOT, AND, OR, SELECT, TABLE,
) = range(len(OPERATIONS))  # fmt: skip
CHOICE, BREAK = 1, 2  # code: a condition is undecided; a function leaves its domain or jumps

_TURN = 2.0 * math.pi


@inner
def times(a: float, b: float) -> float:
    """a b, and 0 where one of them is: bounds at infinity are no values."""
    return 0.0 if a == 0.0 or b == 0.0 else a * b


@inner
def product(a0: float, a1: float, b0: float, b1: float) -> tuple[float, float]:
    """Bounds of a b."""
    w, x, y, z = times(a0, b0), times(a0, b1), times(a1, b0), times(a1, b1)
    return min(w, x, y, z), max(w, x, y, z)


@inner
def sine(a0: float, a1: float) -> tuple[float, float]:
    """Bounds of sin a."""
    if not a1 - a0 < _TURN:
        return -1.0, 1.0
    low, high = min(math.sin(a0), math.sin(a1)), max(math.sin(a0), math.sin(a1))
    if math.floor((a1 - 0.25 * _TURN) / _TURN) > math.floor((a0 - 0.25 * _TURN) / _TURN):
        high = 1.0
    if math.floor((a1 + 0.25 * _TURN) / _TURN) > math.floor((a0 + 0.25 * _TURN) / _TURN):
        low = -1.0
    return low, high


@inner
def quotient(a0: float, a1: float, b0: float, b1: float) -> tuple[float, float, int]:
    """Bounds of a / b, and BREAK where b may vanish."""
    if b0 > 0.0 or b1 < 0.0:
        low, high = product(a0, a1, 1.0 / b1, 1.0 / b0)
        return low, high, 0
    if b0 == b1:
        return math.nan, math.nan, BREAK
    if b0 == 0.0 or b1 == 0.0:
        low, high = (1.0 / b1, math.inf) if b0 == 0.0 else (-math.inf, 1.0 / b0)
        low, high = product(a0, a1, low, high)
        return low, high, BREAK
    return -math.inf, math.inf, BREAK


@inner
def angle(y0: float, y1: float, x0: float, x1: float) -> tuple[float, float, int]:
    """Bounds of atan2(y, x), and BREAK where it may jump."""
    origin = x0 <= 0.0 <= x1 and y0 <= 0.0 <= y1
    if origin or (x0 < 0.0 and y0 < 0.0 <= y1):
        return -math.pi, math.pi, BREAK
    w, x, y, z = math.atan2(y0, x0), math.atan2(y0, x1), math.atan2(y1, x0), math.atan2(y1, x1)
    return min(w, x, y, z), max(w, x, y, z), 0


@inner
def power(a0: float, a1: float, b0: float, b1: float) -> tuple[float, float, int]:
    """Bounds of a ** b, and BREAK where its base may vanish and its exponent is not whole."""
    if b0 == b1 and b0 == b0 // 1.0 and b0 > 0.0:
        w, x = a0**b0, a1**b0
        low = 0.0 if a0 <= 0.0 <= a1 and b0 % 2.0 == 0.0 else min(w, x)
        return low, max(w, x), 0
    if a1 < 0.0:
        return math.nan, math.nan, 0
    base = max(a0, 0.0)
    w, x, y, z = base**b0, base**b1, a1**b0, a1**b1
    code = BREAK if a0 <= 0.0 < a1 else 0
    return min(w, x, y, z), max(w, x, y, z), code


@inner
def cubic_bounds(pieces: Matrix, k: int, s0: float, s1: float) -> tuple[float, float]:
    """Bounds of a piece of a spline from s0 to s1 behind its knot, by its Bézier points."""
    c0, c1, c2, c3 = pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3]
    h = s1 - s0
    first = c0 + s0 * (c1 + s0 * (c2 + s0 * c3))
    last = c0 + s1 * (c1 + s1 * (c2 + s1 * c3))
    second = first + h * (c1 + s0 * (2.0 * c2 + s0 * 3.0 * c3)) / 3.0
    third = last - h * (c1 + s1 * (2.0 * c2 + s1 * 3.0 * c3)) / 3.0
    return min(first, last, second, third), max(first, last, second, third)


@inner
def table(
    knots: Vector, pieces: Matrix, first: int, count: int, period: float, x0: float, x1: float
) -> tuple[float, float, int]:
    """Bounds of a function of `count` cubic pieces; beyond its ends not a number.

    One whose `period` is negative goes on there.
    """
    begin, end = knots[first], knots[first + count]
    if period > 0.0:
        if x1 - x0 >= period:
            x0, x1 = begin, end
        else:
            turns = period * math.floor((x0 - begin) / period)
            x0, x1 = x0 - turns, x1 - turns
    margin = 1e-9 * (end - begin)
    if period == 0.0 and (x1 < begin - margin or x0 > end + margin):
        return math.nan, math.nan, 0
    code = BREAK if period == 0.0 and (x0 < begin - margin or x1 > end + margin) else 0
    low, high = math.inf, -math.inf
    for turn in range(2 if period > 0.0 else 1):
        shift = turn * period
        if (period >= 0.0 and x1 < begin + shift) or (turn > 0 and x1 == end):
            continue
        for k in range(count):
            left, right = knots[first + k] + shift, knots[first + k + 1] + shift
            left = x0 if k == 0 and turn == 0 else left
            right = x1 if k == count - 1 and period <= 0.0 else right
            if right < x0 or left > x1:
                continue
            s = knots[first + k] + shift
            bounds = cubic_bounds(pieces, first + k, max(left, x0) - s, min(right, x1) - s)
            low, high = min(low, bounds[0]), max(high, bounds[1])
    return low, high, code


@inner
def logic(op: int, a0: float, a1: float, b0: float, b1: float) -> tuple[float, float]:
    """Whether a condition holds: (1, 1), does not: (0, 0), or may: (0, 1)."""
    if op == NOT:
        return 1.0 - a1, 1.0 - a0
    if op == AND:
        return min(a0, b0), min(a1, b1)
    return max(a0, b0), max(a1, b1)


@inner
def monotone(op: int, a: float) -> float:
    """A function that rises everywhere."""
    if op == EXP:
        return math.exp(a)
    if op == TANH:
        return math.tanh(a)
    if op == ATAN:
        return math.atan(a)
    return math.sinh(a)


@inner
def limited(op: int, a0: float, a1: float) -> tuple[float, float, int]:
    """Bounds of a function that is not defined everywhere, and BREAK where that may matter."""
    if op == TAN:
        shift = 0.25 * _TURN
        if math.floor((a0 + shift) / math.pi) != math.floor((a1 + shift) / math.pi):
            return -math.inf, math.inf, BREAK
        return math.tan(a0), math.tan(a1), 0
    if op == SQRT:
        if a1 < 0.0:
            return math.nan, math.nan, 0
        return math.sqrt(max(a0, 0.0)), math.sqrt(a1), BREAK if a0 <= 0.0 < a1 else 0
    if op == LOG:
        if a1 <= 0.0:
            return math.nan, math.nan, 0
        low = math.log(a0) if a0 > 0.0 else -math.inf
        return low, math.log(a1), BREAK if a0 <= 0.0 else 0
    if op == FLOOR:
        low, high = a0 // 1.0, a1 // 1.0
        return low, high, BREAK if low != high else 0
    if a1 < -1.0 or a0 > 1.0:
        return math.nan, math.nan, 0
    code = BREAK if (a0 <= -1.0 or a1 >= 1.0) and a0 < a1 else 0
    low, high = max(a0, -1.0), min(a1, 1.0)
    if op == ASIN:
        return math.asin(low), math.asin(high), code
    return math.acos(high), math.acos(low), code


@inner
def compare(a0: float, a1: float, b0: float, b1: float) -> tuple[float, float, int]:
    """Whether a < b, as in `logic`, and CHOICE where that is undecided."""
    if a1 < b0:
        return 1.0, 1.0, 0
    if a0 < b1:
        return 0.0, 1.0, CHOICE
    return 0.0, 0.0, 0


@inner
def bound(
    op: int, squared: bool, a0: float, a1: float, b0: float, b1: float
) -> tuple[float, float, int]:
    """Bounds of an operation on one or two values, and a code as `enclose` answers it."""
    if op == ADD:
        return a0 + b0, a1 + b1, 0
    if op == SUB:
        return a0 - b1, a1 - b0, 0
    if op == MUL:
        low, high = product(a0, a1, b0, b1)
        if squared:
            low = 0.0 if a0 <= 0.0 <= a1 else min(a0 * a0, a1 * a1)
        return low, high, 0
    if op == NEG:
        return -a1, -a0, 0
    if op in (SIN, COS):
        shift = 0.25 * _TURN if op == COS else 0.0
        low, high = sine(a0 + shift, a1 + shift)
        return low, high, 0
    if op == DIV:
        return quotient(a0, a1, b0, b1)
    if op == ATAN2:
        return angle(a0, a1, b0, b1)
    if op == POW:
        return power(a0, a1, b0, b1)
    if op == COSH:
        low, high = math.cosh(a0), math.cosh(a1)
        return 1.0 if a0 <= 0.0 <= a1 else min(low, high), max(low, high), 0
    if op == LESS:
        return compare(a0, a1, b0, b1)
    if op in (NOT, AND, OR):
        low, high = logic(op, a0, a1, b0, b1)
        return low, high, 0
    if op in (EXP, TANH, ATAN, SINH):
        return monotone(op, a0), monotone(op, a1), 0
    return limited(op, a0, a1)


@inner
def leave_out_untaken(code: IntegerMatrix, low: Vector, high: Vector, steps: Vector) -> int:
    """Give no value to what only untaken branches take; the codes of all else.

    `steps`, (values,), has -1 less the code of each value; of those that the last one takes, with
    what these take in turn, the code itself is left there.
    """
    undecided = 0
    steps[-1] = -1.0 - steps[-1]
    for k in range(low.size - 1, -1, -1):
        if steps[k] < 0.0:
            low[k] = high[k] = math.nan
            continue
        undecided |= int(steps[k])
        op = code[k, 0]
        for place in range(1, 1 if op in (CONST, P, T) else 2 if op == TABLE else 4):
            if op == SELECT and (
                (place == 2 and high[code[k, 1]] < 1.0) or (place == 3 and low[code[k, 1]] > 0.0)
            ):
                continue
            row = code[k, place]
            if steps[row] < 0.0:
                steps[row] = -1.0 - steps[row]
    return undecided


@compiled(i8(integer_matrix, vector, vector, vector, matrix, f8, f8, vector, vector, vector))
def enclose(
    code: IntegerMatrix, numbers: Vector, p: Vector, knots: Vector, pieces: Matrix, t0: float,
    t1: float, low: Vector, high: Vector, steps: Vector,
) -> int:  # fmt: skip
    """Bounds of all values of a function for t from t0 to t1, in `low` and `high`.

    `code` has a row (operation, a, b, c) a value: the rows that it takes, or of a parameter its
    slot in p, of a table the row, its first piece and how many these are; `numbers` the constants,
    of a table its period or 0. Values without any, and those of a branch that is certainly not
    taken, are not a number. `steps` is scratch, (values,). Returns 0, or the sum of CHOICE and
    BREAK for what is undecided.
    """
    for k in range(low.size):
        op, a, b, c = code[k, 0], code[k, 1], code[k, 2], code[k, 3]
        step = 0
        if op == CONST:
            low[k] = high[k] = numbers[k]
        elif op == P:
            low[k] = high[k] = p[a]
        elif op == T:
            low[k], high[k] = t0, t1
        elif op == SELECT:
            if low[a] > 0.0:
                low[k], high[k] = low[b], high[b]
            elif high[a] < 1.0:
                low[k], high[k] = low[c], high[c]
            else:
                low[k] = low[c] if math.isnan(low[b]) else min(low[b], low[c])
                high[k] = high[c] if math.isnan(low[b]) else max(high[b], high[c])
        elif math.isnan(low[a]) or (op != TABLE and math.isnan(low[b])):
            low[k] = high[k] = math.nan
            if op == LESS:
                low[k] = high[k] = 0.0
        elif op == TABLE:
            low[k], high[k], step = table(knots, pieces, b, c, numbers[k], low[a], high[a])
        else:
            low[k], high[k], step = bound(
                op, op == MUL and a == b, low[a], high[a], low[b], high[b]
            )
        steps[k] = -1.0 - step
    return leave_out_untaken(code, low, high, steps)
