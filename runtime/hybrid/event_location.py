"""Where inside a step a switching function first contradicts its mode.

Cubic interpolation of g from its values and rates at both ends, with its values at three points
between, decides cheaply whether anything may have crossed, also twice. Only then is the dense
output evaluated: at equal distances, and between them at the lowest points, so that a pair of
crossings is not stepped over.
"""

from runtime.core.array_types import Integers
from runtime.core.dense_output import interpolate
from runtime.core.function_table import LOCATE, SAMPLED, SWITCHES, crossed_of, modes_of, sampled_of
from runtime.core.jit import addressed, inner
from runtime.core.rounding import EPS
from runtime.core.workspace import (
    BAND,
    BETWEEN,
    G0,
    G1,
    LARGEST,
    MISMATCH,
    R0,
    R1,
    SAMPLE,
    SCAN,
    SUBDIVISIONS,
    SUSPECT,
    TRIAL,
    switch_row,
)
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.switching_functions import functions

# accuracy: of the time; difference of two instants that the clock cannot resolve
INSTANT = 4.0 * EPS
NOWHERE = 2.0  # code: a fraction of the step that says that there is no such place
# measured: of the variation of g over the step; closer to zero than this g is scanned
_MARGIN = 0.15
_NOISE = 1e-14  # accuracy: of the largest |g|; a dip of this depth is rounding
_GOLDEN = 0.3819660112501051  # formula: golden section


@inner
def suspects(context: Integers, h: float) -> int:
    """Mark in SUSPECT the functions that may cross in the step, and count them."""
    modes = modes_of(context)
    band_row = switch_row(context, BAND)
    g0_row = switch_row(context, G0)
    g1_row = switch_row(context, G1)
    r0 = switch_row(context, R0)
    r1 = switch_row(context, R1)
    between = switch_row(context, BETWEEN)
    mismatch = switch_row(context, MISMATCH)
    suspect = switch_row(context, SUSPECT)
    s = context[SWITCHES]
    count = 0
    for k in range(s):
        side = 1.0 if modes[k] != 0 else -1.0
        band = band_row[k]
        g0 = side * g0_row[k]
        g1 = side * g1_row[k]
        c1 = g0 + h * side * r0[k] / 3.0
        c2 = g1 - h * side * r1[k] / 3.0
        a1 = side * between[k]
        a2 = side * switch_row(context, BETWEEN + 1)[k]
        a3 = side * switch_row(context, BETWEEN + 2)[k]
        low = min(c1, c2, g1, a1, a2, a3)
        high = max(g0, c1, c2, g1, a1, a2, a3)
        if band == 0.0:
            low = min(low, g0)
        else:
            # On its surface and hardly moving: what counts is whether it leaves the band.
            low = low + band if high - low > 2.0 * band or g1 < -band else 1.0
            high = high + band
        marked = g1 < -band or not low > max(_MARGIN * (high - low), 2.0 * mismatch[k])
        suspect[k] = 1.0 if marked else 0.0
        count += 1 if marked else 0
    return count


@addressed(SAMPLED)
def sampled(context: Integers, t: float, h: float, x: float, k: int, dense_rows: int) -> float:
    """Function `k` on the dense output at fraction `x` of the step; all of them in row TRIAL."""
    trial = switch_row(context, TRIAL)
    interpolate(context, dense_rows, x, SAMPLE)
    functions(context, t + x * h, SAMPLE, TRIAL)
    return float(trial[k])


@inner
def dip(
    context: Integers,
    t: float,
    h: float,
    low: float,
    high: float,
    side: float,
    band: float,
    k: int,
    dense_rows: int,
) -> float:
    """A fraction between `low` and `high` at which side * g_k < -band, or `NOWHERE`.

    Golden section, which ends as soon as such a point is found.
    """
    sample = sampled_of(context)
    x1 = low + _GOLDEN * (high - low)
    x2 = high - _GOLDEN * (high - low)
    g1 = side * sample(context, t, h, x1, k, dense_rows)
    g2 = side * sample(context, t, h, x2, k, dense_rows)
    for _ in range(40):
        if g1 < -band:
            return x1
        if g2 < -band:
            return x2
        if g1 < g2:
            high, x2, g2 = x2, x1, g1
            x1 = low + _GOLDEN * (high - low)
            g1 = side * sample(context, t, h, x1, k, dense_rows)
        else:
            low, x1, g1 = x1, x2, g2
            x2 = high - _GOLDEN * (high - low)
            g2 = side * sample(context, t, h, x2, k, dense_rows)
    return NOWHERE


@inner
def root(
    context: Integers,
    t: float,
    h: float,
    low: float,
    high: float,
    side: float,
    band: float,
    k: int,
    dense_rows: int,
) -> float:
    """Fraction at which side * g_k + band falls through zero, between `low` and `high`.

    Regula falsi with halved weights (Illinois), every third point a bisection; to 1e-13 of the
    step.
    """
    sample = sampled_of(context)
    g_low = side * sample(context, t, h, low, k, dense_rows) + band
    g_high = side * sample(context, t, h, high, k, dense_rows) + band
    kept = 0
    for i in range(120):
        if high - low <= 1e-13:
            break
        if g_low <= 0.0 or i % 3 == 2:
            x = 0.5 * (low + high)
        else:
            x = high - g_high * (high - low) / (g_high - g_low)
            if not (low < x < high):
                x = 0.5 * (low + high)
        g = side * sample(context, t, h, x, k, dense_rows) + band
        if g < 0.0:
            high, g_high = x, g
            if kept == 1:
                g_low *= 0.5
            kept = 1
        else:
            low, g_low = x, g
            if kept == -1:
                g_high *= 0.5
            kept = -1
    return high


@inner
def last_due(context: Integers, t: float) -> int:
    """A function that reaches zero at the step's end but for what the clock cannot tell, or -1.

    For the end of a run, after which no step sees it.
    """
    modes = modes_of(context)
    r1 = switch_row(context, R1)
    band = switch_row(context, BAND)
    g1 = switch_row(context, G1)
    s = context[SWITCHES]
    for k in range(s):
        side = 1.0 if modes[k] != 0 else -1.0
        change = side * r1[k] * INSTANT * abs(t)
        off = modes[k] != HELD_MODE and band[k] == 0.0
        if off and change < 0.0 and side * g1[k] + change <= 0.0:
            return k
    return -1


@addressed(LOCATE)
def locate(context: Integers, t: float, h: float, dense_rows: int) -> float:
    """Fraction of the step at which a marked function first crosses, or `NOWHERE`.

    The dense output must be there. The first of `crossed_of` receives the function's index.
    """
    trial = switch_row(context, TRIAL)
    scan = switch_row(context, SCAN)
    g0 = switch_row(context, G0)
    g1 = switch_row(context, G1)
    suspect = switch_row(context, SUSPECT)
    band_row = switch_row(context, BAND)
    largest = switch_row(context, LARGEST)
    r0 = switch_row(context, R0)
    r1 = switch_row(context, R1)
    s = context[SWITCHES]
    modes = modes_of(context)
    sample = sampled_of(context)
    for i in range(1, SUBDIVISIONS):
        sample(context, t, h, i / SUBDIVISIONS, 0, dense_rows)
        for k in range(s):
            switch_row(context, SCAN + i)[k] = trial[k]
    for k in range(s):
        scan[k] = g0[k]
        switch_row(context, SCAN + SUBDIVISIONS)[k] = g1[k]
    first = NOWHERE
    for k in range(s):
        if suspect[k] == 0.0:
            continue
        side = 1.0 if modes[k] != 0 else -1.0
        band = band_row[k]
        # Rounding of the dense output is no crossing; that of the end point is looked at as it is.
        noise = max(band, _NOISE * largest[k])
        low, high, away = NOWHERE, NOWHERE, NOWHERE
        for i in range(1, SUBDIVISIONS + 1):
            left, right = (i - 1) / SUBDIVISIONS, i / SUBDIVISIONS
            if left >= first:
                break
            here = side * switch_row(context, SCAN + i)[k]
            before = side * switch_row(context, SCAN + i - 1)[k]
            if before > noise:
                away = left
            if here < -(band if i == SUBDIVISIONS else noise):
                low, high = left, right
                break
            # A lowest point may lie beside a sample that is lower than its neighbours.
            if i == 1:
                falls = side * r0[k] < 0.0 and band == 0.0
            else:
                falls = side * switch_row(context, SCAN + i - 2)[k] >= before
            if i == SUBDIVISIONS:
                rises = side * r1[k] > 0.0
            else:
                rises = side * switch_row(context, SCAN + i + 1)[k] >= here
            if (falls and before <= here) or (rises and here <= before):
                x = dip(context, t, h, left, right, side, noise, k, dense_rows)
                if x < 1.0:
                    low, high = left, x
                    break
        if high <= 1.0 and away <= 1.0:
            # It has left the surface on which it began, and comes back to zero itself.
            low, band = away, 0.0
        if high <= 1.0:
            x = root(context, t, h, low, high, side, band, k, dense_rows)
            if x < first:
                first = x
                crossed_of(context)[0] = k
    return first
