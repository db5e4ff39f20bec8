"""Events: a step is short enough to see every crossing, and the first of them is located.

The length of a step follows the error of the motion. Where the motion is simple, an accepted step
may span many periods of a switching function, and its ends say nothing of the crossings between.
Therefore g is evaluated at three points inside, on the cubic of the motion through both ends, which
takes no accelerations, and compared there with its own cubic. Where the two disagree and zero is
near, the step is too long. Cubic and values also decide cheaply whether g may have crossed zero,
once or twice.

Only where a function may have crossed zero is the dense output evaluated, for the first instant at
which it contradicts its mode: at equal distances, and between them at the lowest points, so that no
pair of crossings is missed.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import EPS, Context
from runtime.core.dense_output import interpolate
from runtime.core.jit import addressed, inlined, inner
from runtime.core.kinds import BALANCED, RANGE, SLIDING
from runtime.core.loop_record import run_record
from runtime.hybrid.rest_forces import is_resting
from runtime.hybrid.sliding_motion import evaluate_switching, evaluate_switching_and_rates
from runtime.linalg.vectors import copy_vector

INSTANT = 4.0 * EPS  # accuracy: of the time; difference of instants that the clock cannot resolve
NOT_FOUND = 2.0  # code: a fraction of the step: there is no such point
_ROUNDED = 64.0 * EPS  # accuracy: of a run; rounding of its states, as a time
_NOISE = 1e-14  # accuracy: of the largest |g|; a dip of this depth is rounding
_GOLDEN = 0.3819660112501051  # formula: golden section

UNRESOLVED = -1  # the step is too long to see all crossings

# measured: of the variation of g over the step; largest accepted difference of both cubics
_RESOLVED = 0.2
_NEAR = 3.0  # measured: differences, or variations if less, within which a zero of g matters
_MARGIN = 0.15  # measured: of the variation of g over the step; a g nearer to zero is scanned
_ROUNDING = 1e-11  # accuracy: of the largest |g|; a difference of this size is rounding
_FINEST = 1e-10  # safety: of the run; shorter steps are never rejected here
_COARSER = 4.0  # measured: growth of this length after an unresolved step
_FINER = 0.8  # measured: its decrease after other steps

# Formula: fractions of a step at which g is sampled. They are no ratios of small numbers, so that a
# period which divides the step is not sampled at one phase.
X1, X2, X3 = 0.1732050807568877, 0.4142135623730951, 0.7307704011542153


@inlined
def mode_sign(context: Context, k: int) -> float:
    """1 where g ought to be positive in the mode of function `k`, else -1."""
    return 1.0 if context.modes[k] != 0 else -1.0


@addressed(ft.SAMPLE_FUNCTION)
def sample_function(context: Context, x: float, k: int) -> float:
    """Function `k` at fraction `x` of the step, by the sign of its mode; all go into row TRIAL."""
    r = run_record(context)
    interpolate(context, r.dense_rows, x, ws.SAMPLE)
    evaluate_switching(context, r.t + x * r.length, ws.SAMPLE, ws.TRIAL)
    return float(mode_sign(context, k) * context.trial[k])


@inner
def find_dip(context: Context, low: float, high: float, band: float, k: int) -> float:
    """A point between `low` and `high` where function `k` is below -band; golden section."""
    sample = ft.sample_function_of(context)
    x1, x2 = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    g1, g2 = sample(context, x1, k), sample(context, x2, k)
    for _ in range(40):
        if g1 < -band:
            return x1
        if g2 < -band:
            return x2
        if g1 < g2:
            high, x2, g2 = x2, x1, g1
            x1 = low + _GOLDEN * (high - low)
            g1 = sample(context, x1, k)
        else:
            low, x1, g1 = x1, x2, g2
            x2 = high - _GOLDEN * (high - low)
            g2 = sample(context, x2, k)
    return NOT_FOUND


@inner
def find_root(context: Context, low: float, high: float, band: float, k: int) -> float:
    """Fraction at which function `k` plus the band falls through zero, between `low` and `high`.

    Regula falsi with halved weights (Illinois), every third point a bisection; to 1e-13 of the
    step.
    """
    sample = ft.sample_function_of(context)
    g_low, g_high = sample(context, low, k) + band, sample(context, high, k) + band
    side = 0
    for i in range(120):
        if high - low <= 1e-13:
            break
        x = high - g_high * (high - low) / (g_high - g_low)
        if g_low <= 0.0 or i % 3 == 2 or not (low < x < high):
            x = 0.5 * (low + high)
        g = sample(context, x, k) + band
        if g < 0.0:
            high, g_high = x, g
            g_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, g_low = x, g
            g_high *= 0.5 if side == -1 else 1.0
            side = -1
    return high


@inner
def find_crossing_at_end(context: Context, t: float) -> int:
    """A function that is zero within the clock's resolution after the end of a run, or -1.

    The instant is known as well as the state: methods with large weights round a step's result by
    some tens of units, which the clock resolves. A table has its value at its end, and is not left
    there.
    """
    duration = run_record(context).duration
    for k in range(context[ft.SWITCHES]):
        if context.table_part[k] == RANGE:
            continue
        side = mode_sign(context, k)
        closing = -side * context.r1[k]
        rounding = min(_NOISE * context.largest[k], closing * _ROUNDED * duration)
        off = context.modes[k] != SLIDING and context.band[k] == 0.0
        if off and closing > 0.0 and side * context.g1[k] <= closing * INSTANT * abs(t) + rounding:
            return k
    return -1


@inner
def find_sign_change(context: Context, k: int, first: float) -> tuple[float, float, float]:
    """An interval (low, high) before `first` in which function `k` crosses, or `NOT_FOUND`.

    The third number is the last fraction before it at which g was off its surface.
    """
    r0, r1 = context.r0[k], context.r1[k]
    side, band = mode_sign(context, k), context.band[k]
    # Rounding of the dense output is no crossing; that of the end point counts.
    noise = max(band, _NOISE * context.largest[k])
    away = NOT_FOUND
    for i in range(1, ws.SUBDIVISIONS + 1):
        left, right = (i - 1) / ws.SUBDIVISIONS, i / ws.SUBDIVISIONS
        if left >= first:
            break
        here = side * ws.switch_row(context, ws.SCAN + i)[k]
        before = side * ws.switch_row(context, ws.SCAN + i - 1)[k]
        if before > noise:
            away = left
        if here < -(band if i == ws.SUBDIVISIONS else noise):
            return left, right, away
        # A lowest point may lie beside a sample that is lower than its neighbours.
        if i == 1:
            falls = side * r0 < 0.0 and band == 0.0
        else:
            falls = side * ws.switch_row(context, ws.SCAN + i - 2)[k] >= before
        if i == ws.SUBDIVISIONS:
            rises = side * r1 > 0.0
        else:
            rises = side * ws.switch_row(context, ws.SCAN + i + 1)[k] >= here
        if (falls and before <= here) or (rises and here <= before):
            x = find_dip(context, left, right, noise, k)
            if x < 1.0:
                return left, x, away
    return NOT_FOUND, NOT_FOUND, away


@addressed(ft.LOCATE)
def locate_event(context: Context) -> float:
    """Fraction of the step at which a marked function first crosses, or `NOT_FOUND`.

    The dense output must have been computed. `context.crossed[0]` receives its function.
    """
    for i in range(1, ws.SUBDIVISIONS):
        ft.sample_function_of(context)(context, i / ws.SUBDIVISIONS, 0)
        copy_vector(context.trial, ws.switch_row(context, ws.SCAN + i))
    copy_vector(context.g0, ws.switch_row(context, ws.SCAN))
    copy_vector(context.g1, ws.switch_row(context, ws.SCAN + ws.SUBDIVISIONS))
    first = NOT_FOUND
    for k in range(context[ft.SWITCHES]):
        if context.suspect[k] == 0.0:
            continue
        low, high, away = find_sign_change(context, k, first)
        if high > 1.0:
            continue
        # Where it has left the surface on which it began, it returns to g = 0.
        returns = away <= 1.0
        low, band = (away, 0.0) if returns else (low, context.band[k])
        x = find_root(context, low, high, band, k)
        if x < first:
            first = x
            context.crossed[0] = k
    return first


@inlined
def cubic(x: float, y0: float, change: float, leave: float, arrive: float) -> float:
    """The cubic from y0 to y0 + change at the fraction x; its slopes at the ends are times h."""
    return y0 + x * x * (3 - 2 * x) * change + x * (1 - x) ** 2 * leave + x * x * (x - 1) * arrive


@inner
def write_motion_between(context: Context, x: float, h: float) -> None:
    """Fill row SAMPLE with the cubic of the motion at the fraction x of the step."""
    last = run_record(context).last
    y0, y1, z = ws.row_of(context, ws.Y0), ws.row_of(context, ws.Y1), ws.row_of(context, ws.SAMPLE)
    k0, k1 = ws.row_of(context, ws.K), ws.row_of(context, ws.K + last)
    for j in range(2 * context[ft.COORDINATES]):
        z[j] = cubic(x, y0[j], y1[j] - y0[j], h * k0[j], h * k1[j])


@inner
def sample_at(context: Context, x: float, t: float, h: float, slot: int, joined: bool) -> None:
    """Fill row `slot` of `sw` with g on the cubic of the motion at the fraction x.

    Where it is `joined`, that is returned onto the constraints.
    """
    write_motion_between(context, x, h)
    if joined:
        ft.correct_of(context)(context, t + x * h, ws.SAMPLE, ws.PROJECTION)
    evaluate_switching(context, t + x * h, ws.SAMPLE, slot)


@inner
def rests_off_joints(context: Context, h: float) -> bool:
    """Whether a function rests at both ends of the step, and between them only with joints closed.

    The cubic of the motion leaves the constraints, and there what these keep at zero is not zero.
    """
    if context[ft.CONSTRAINT_COUNT] == 0:
        return False
    for k in range(context[ft.SWITCHES]):
        largest, least = context.largest[k], context.band[k]
        g0, g1, r0, r1 = context.g0[k], context.g1[k], h * context.r0[k], h * context.r1[k]
        if context.modes[k] == SLIDING:
            if context.boundary[k] < BALANCED:
                continue
            g0, g1, r0, r1, least = 1.0 - g0, 1.0 - g1, 0.0, 0.0, 1.0
        if not (least > 0.0 and max(abs(g0), abs(g1)) <= least):
            continue
        if max(abs(r0), abs(r1)) > _ROUNDING * largest:
            continue
        for slot in range(ws.BETWEEN, ws.BETWEEN + 3):
            g = ws.switch_row(context, slot)[k]
            if context.modes[k] == SLIDING:
                g = 1.0 - g
            if abs(g) > least:
                return True
    return False


@inner
def compare_with_cubics(context: Context, h: float) -> tuple[float, int]:
    """Longest step that resolves all functions, as a ratio to this one, and how many may cross.

    The ratio is infinite where all are resolved; SUSPECT marks the functions that may cross.
    """
    s1, s2 = ws.switch_row(context, ws.BETWEEN), ws.switch_row(context, ws.BETWEEN + 1)
    s3 = ws.switch_row(context, ws.BETWEEN + 2)
    allowed, suspects = np.inf, 0
    for k in range(context[ft.SWITCHES]):
        side, band = mode_sign(context, k), context.band[k]
        g0, g1 = side * context.g0[k], side * context.g1[k]
        a1, a2, a3 = side * s1[k], side * s2[k], side * s3[k]
        change, leave, arrive = g1 - g0, h * side * context.r0[k], h * side * context.r1[k]
        b1 = cubic(X1, g0, change, leave, arrive)
        b2 = cubic(X2, g0, change, leave, arrive)
        b3 = cubic(X3, g0, change, leave, arrive)
        difference = max(abs(a1 - b1), abs(a2 - b2), abs(a3 - b3))
        for c in range(context[ft.SLIDING_COUNT]):
            resting = context.sliding_functions[c] == k and is_resting(context, c)
            if resting and difference <= 1.0:
                difference = 0.0  # such a margin is a part of the rounding that it is kept within
        # The cubic lies between its control points.
        c1, c2 = g0 + leave / 3.0, g1 - arrive / 3.0
        low, high = min(c1, c2, g1, a1, a2, a3), max(g0, c1, c2, g1, a1, a2, a3)
        if band == 0.0:
            low = min(low, g0)
        else:
            # On its surface and hardly moving: what counts is whether it leaves the band.
            low = low + band if high - low > 2.0 * band or g1 < -band else 1.0
            high = high + band
        marked = g1 < -band or not low > max(_MARGIN * (high - low), 2.0 * difference)
        context.suspect[k] = 1.0 if marked else 0.0
        suspects += 1 if marked else 0
        low, high = min(g0, g1, a1, a2, a3), max(g0, g1, a1, a2, a3)
        if not difference > _ROUNDING * max(context.largest[k], abs(low), abs(high)):
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
    return allowed, suspects


@addressed(ft.SCREEN_STEP)
def screen_step(context: Context, t: float, h: float, t1: float) -> int:
    """Count the functions that may cross in the step; `UNRESOLVED` where it is too long to see.

    `run.stretch` receives the ratio of the next step's length to this one's that they allow.
    """
    r = run_record(context)
    evaluate_switching_and_rates(context, t1, ws.Y1, ws.K + r.last, ws.G1)
    for index, x in enumerate((X1, X2, X3)):
        sample_at(context, x, t, h, ws.BETWEEN + index, False)
    if rests_off_joints(context, h):
        for index, x in enumerate((X1, X2, X3)):
            sample_at(context, x, t, h, ws.BETWEEN + index, True)
    allowed, suspects = compare_with_cubics(context, h)
    if r.fixed != 0:
        r.stretch = np.inf
        return suspects
    r.stretch, finest = 0.9 * allowed, _FINEST * r.duration
    if allowed >= 1.0:
        r.finest = max(finest, _FINER * r.finest)
    elif h > max(finest, r.finest):
        again = r.rejected_before != 0 and r.reason == UNRESOLVED
        r.stretch = 0.25 if again else max(0.1, min(0.5, r.stretch))
        return UNRESOLVED
    else:
        # A jump, a kink or rounding: shorter steps would show no more.
        r.finest = _COARSER * max(finest, r.finest)
        r.stretch = _COARSER
    return suspects
