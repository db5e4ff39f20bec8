"""Event location: the first instant in a step at which a switching function contradicts its mode.

Only where a function may have crossed zero (see `event_step_limit`) is the dense output evaluated:
at equal distances, and between them at the lowest points, so that no pair of crossings is missed.
"""

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.dense_output import interpolate
from runtime.core.jit import addressed, inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.modes_and_event_kinds import RANGE, SLIDING
from runtime.core.unit_roundoff import EPS
from runtime.hybrid.switching_values_and_margins import evaluate_switching
from runtime.linalg.vectors import copy_vector

INSTANT = 4.0 * EPS  # accuracy: of the time; difference of instants that the clock cannot resolve
NOT_FOUND = 2.0  # code: a fraction of the step: there is no such point
_ROUNDED = 64.0 * EPS  # accuracy: of a run; rounding of its states, as a time
_NOISE = 1e-14  # accuracy: of the largest |g|; a dip of this depth is rounding
_GOLDEN = 0.3819660112501051  # formula: golden section


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
