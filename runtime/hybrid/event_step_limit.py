"""Event resolution: a step is short enough to see all crossings of switching functions.

The length of a step follows the error of the motion. Where the motion is simple, an accepted step
may span many periods of a switching function, and its ends say nothing of the crossings between.
Therefore g is evaluated at three points inside, on the cubic of the motion through both ends, which
takes no accelerations, and compared there with its own cubic. Where the two disagree and zero is
near, the step is too long. Cubic and values also decide cheaply whether g may have crossed zero,
once or twice.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.jit import addressed, inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.modes_and_event_kinds import BALANCED, SLIDING
from runtime.hybrid.event_location import mode_sign
from runtime.hybrid.switching_values_and_margins import (
    evaluate_switching,
    evaluate_switching_and_rates,
)

UNRESOLVED = -1  # the step is too long to see all crossings

# measured: of the variation of g over the step; largest accepted difference of the two cubics
_RESOLVED = 0.2
_NEAR = 3.0  # measured: differences, at most variations, from zero within which it matters
_MARGIN = 0.15  # measured: of the variation of g over the step; nearer to zero g is scanned
_ROUNDING = 1e-11  # accuracy: of the largest |g|; a difference of this size is rounding
_FINEST = 1e-10  # safety: of the run; shorter steps are never rejected here
_COARSER = 4.0  # measured: growth of that length at an unresolved step
_FINER = 0.8  # measured: its change at other steps

# Formula: fractions of a step at which g is sampled. They are no ratios of small numbers, so that a
# period which divides the step is not sampled at one phase.
X1, X2, X3 = 0.1732050807568877, 0.4142135623730951, 0.7307704011542153


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
