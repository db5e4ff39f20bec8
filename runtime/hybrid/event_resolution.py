"""Whether a step sees the switching functions well enough to tell what crossed in it.

The length of a step follows the error of the motion. Where the motion is simple, an accepted step
may span many periods of a switching function, and its ends say nothing of what lies between. So
the functions are evaluated at three points between, on the motion's cubic through both ends, which
takes no accelerations, and compared there with their own cubics. Where the two disagree and zero is
near, the step is too long.
"""

import numpy as np

from runtime.core.array_types import Integers
from runtime.core.function_table import COORDINATES, SWITCHES, WATCH, modes_of
from runtime.core.jit import addressed, inner
from runtime.core.run_record import run_record
from runtime.core.workspace import (
    BETWEEN,
    G0,
    G1,
    LARGEST,
    MISMATCH,
    PREDICTED,
    R0,
    R1,
    SAMPLE,
    STAGE,
    Y0,
    Y1,
    K,
    row_of,
    switch_row,
)
from runtime.hybrid.event_location import suspects
from runtime.hybrid.switching_functions import functions, measure

UNRESOLVED = -1  # the step is too long to tell

# measured: of the variation of g over the step; difference of the two cubics that is let pass
_RESOLVED = 0.2
_NEAR = 3.0  # measured: differences, at most variations, from zero within which that matters
_ROUNDING = 1e-11  # accuracy: of the largest |g|; a difference of this size is rounding
_FINEST = 1e-10  # safety: of the run; steps of this length are never too long
_COARSER = 4.0  # measured: growth of that length at a step that stays unresolved
_FINER = 0.8  # measured: its change at other steps

# Formula: weights of the cubic through y0, y1 with slopes k0, k1 at the fraction x of a step:
# y0 + RISE (y1 - y0) + h (LEAVE k0 + ARRIVE k1). The fractions are no ratios of small numbers, so
# that a period which divides the step is not met at the same phase.
X1, X2, X3 = 0.1732050807568877, 0.4142135623730951, 0.7307704011542153
RISE1, LEAVE1, ARRIVE1 = X1 * X1 * (3 - 2 * X1), X1 * (1 - X1) ** 2, X1 * X1 * (X1 - 1)
RISE2, LEAVE2, ARRIVE2 = X2 * X2 * (3 - 2 * X2), X2 * (1 - X2) ** 2, X2 * X2 * (X2 - 1)
RISE3, LEAVE3, ARRIVE3 = X3 * X3 * (3 - 2 * X3), X3 * (1 - X3) ** 2, X3 * X3 * (X3 - 1)


@inner
def between(context: Integers, t: float, h: float, last: int) -> None:
    """Fill the three rows at BETWEEN with the functions at points between the ends of the step.

    The states there lie on the cubics through both ends.
    """
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    k0 = row_of(context, K)
    k1 = row_of(context, last)
    z1 = row_of(context, STAGE)
    z2 = row_of(context, SAMPLE)
    z3 = row_of(context, PREDICTED)
    for j in range(length):
        start, change = y0[j], y1[j] - y0[j]
        leave, arrive = h * k0[j], h * k1[j]
        z1[j] = start + RISE1 * change + LEAVE1 * leave + ARRIVE1 * arrive
        z2[j] = start + RISE2 * change + LEAVE2 * leave + ARRIVE2 * arrive
        z3[j] = start + RISE3 * change + LEAVE3 * leave + ARRIVE3 * arrive
    functions(context, t + X1 * h, STAGE, BETWEEN)
    functions(context, t + X2 * h, SAMPLE, BETWEEN + 1)
    functions(context, t + X3 * h, PREDICTED, BETWEEN + 2)


@inner
def bearable(context: Integers, h: float) -> float:
    """Ratio to this step's length of the longest step that the functions allow; infinite if any.

    Row MISMATCH receives the differences found.
    """
    modes = modes_of(context)
    g0_row = switch_row(context, G0)
    g1_row = switch_row(context, G1)
    between = switch_row(context, BETWEEN)
    r0 = switch_row(context, R0)
    r1 = switch_row(context, R1)
    mismatch = switch_row(context, MISMATCH)
    largest = switch_row(context, LARGEST)
    s = context[SWITCHES]
    allowed = np.inf
    for k in range(s):
        side = 1.0 if modes[k] != 0 else -1.0
        g0, g1 = side * g0_row[k], side * g1_row[k]
        a1 = side * between[k]
        a2 = side * switch_row(context, BETWEEN + 1)[k]
        a3 = side * switch_row(context, BETWEEN + 2)[k]
        change = g1 - g0
        leave, arrive = h * side * r0[k], h * side * r1[k]
        b1 = g0 + RISE1 * change + LEAVE1 * leave + ARRIVE1 * arrive
        b2 = g0 + RISE2 * change + LEAVE2 * leave + ARRIVE2 * arrive
        b3 = g0 + RISE3 * change + LEAVE3 * leave + ARRIVE3 * arrive
        difference = max(abs(a1 - b1), abs(a2 - b2), abs(a3 - b3))
        mismatch[k] = difference
        low = min(g0, g1, a1, a2, a3)
        high = max(g0, g1, a1, a2, a3)
        if not difference > _ROUNDING * max(largest[k], abs(low), abs(high)):
            continue
        # The difference grows with the fourth power of the length, the variation with the first.
        varied = max(high, b1, b2, b3) - min(low, b1, b2, b3)
        if low > 1e4 * difference or varied > 1e4 * difference:
            continue
        resolved = (_RESOLVED * varied / difference) ** (1.0 / 3.0)
        # Where periods are skipped, the cubic of g swings more widely than g itself.
        swing = max(min(difference, high - low), 1e-300)
        far = (max(low, 0.0) / (_NEAR * swing)) ** 0.25
        allowed = min(allowed, max(resolved, far))
    return allowed


@addressed(WATCH)
def watch(context: Integers, t: float, h: float, t1: float) -> int:
    """Evaluate the functions over the step and count those that may cross in it.

    Returns `UNRESOLVED` where the step is too long to tell. `run.stretch` is the ratio of the next
    step's length to this one's that the functions allow.
    """
    r = run_record(context)
    measure(context, t1, Y1, K + r.last, G1)
    between(context, t, h, K + r.last)
    allowed = bearable(context, h)
    r.stretch = np.inf if r.fixed != 0 else 0.9 * allowed
    if r.fixed == 0:
        finest = _FINEST * r.duration
        if allowed >= 1.0:
            r.finest = max(finest, _FINER * r.finest)
        elif h > max(finest, r.finest):
            again = r.rejected_before != 0 and r.reason == UNRESOLVED
            r.stretch = 0.25 if again else max(0.1, min(0.5, r.stretch))
            return UNRESOLVED
        else:
            # A jump, a kink or rounding: shorter steps would tell no more.
            r.finest = _COARSER * max(finest, r.finest)
            r.stretch = _COARSER
    return int(suspects(context, h))
