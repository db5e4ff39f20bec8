"""Evaluation of an explicit function of time in an interval: bounds of all its values at once.

Interval arithmetic misses nothing between two samples: a pulse that lives in a hundredth of a
millionth of the run is inside the bounds of its interval.
"""

import math

from runtime.core.array_types import (
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
from runtime.explicit_time.interval_arithmetic import (
    CONST,
    LESS,
    MUL,
    SELECT,
    TABLE,
    P,
    T,
    bound,
    table,
)


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
