"""Where inside a step a switching function first contradicts its mode.

Cubic interpolation of g from its values and rates at both ends, with its values at three points
between, decides cheaply whether anything may have crossed, also twice. Only then is the dense
output evaluated: at equal distances, and between them at the lowest points, so that a pair of
crossings is not stepped over.
"""

from runtime.core.dense_output import interpolate
from runtime.core.function_table import SWITCHES, sampled_of
from runtime.core.jit import addressed, inner
from runtime.core.rounding import EPS
from runtime.core.run_arrays import mode_numbers, parameters, surfaces, workspace
from runtime.core.signatures import LOCATE, SAMPLED, Integers, Vector
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
def suspects(h: float, sw: Vector, modes: Integers) -> int:
    """Mark in SUSPECT the functions that may cross in the step, and count them."""
    s = modes.size
    count = 0
    for k in range(s):
        side = 1.0 if modes[k] != 0 else -1.0
        band = sw[BAND * s + k]
        g0 = side * sw[G0 * s + k]
        g1 = side * sw[G1 * s + k]
        c1 = g0 + h * side * sw[R0 * s + k] / 3.0
        c2 = g1 - h * side * sw[R1 * s + k] / 3.0
        a1 = side * sw[BETWEEN * s + k]
        a2 = side * sw[(BETWEEN + 1) * s + k]
        a3 = side * sw[(BETWEEN + 2) * s + k]
        low = min(c1, c2, g1, a1, a2, a3)
        high = max(g0, c1, c2, g1, a1, a2, a3)
        if band == 0.0:
            low = min(low, g0)
        else:
            # On its surface and hardly moving: what counts is whether it leaves the band.
            low = low + band if high - low > 2.0 * band or g1 < -band else 1.0
            high = high + band
        marked = g1 < -band or not low > max(_MARGIN * (high - low), 2.0 * sw[MISMATCH * s + k])
        sw[SUSPECT * s + k] = 1.0 if marked else 0.0
        count += 1 if marked else 0
    return count


@addressed(SAMPLED)
def sampled(machine: Integers, t: float, h: float, x: float, k: int, dense_rows: int) -> float:
    """Function `k` on the dense output at fraction `x` of the step; all of them in row TRIAL."""
    w, sw = workspace(machine), surfaces(machine)
    interpolate(w, dense_rows, x, SAMPLE)
    functions(machine, t + x * h, SAMPLE, TRIAL, w, sw, parameters(machine))
    return float(sw[TRIAL * machine[SWITCHES] + k])


@inner
def dip(
    machine: Integers,
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
    sample = sampled_of(machine)
    x1 = low + _GOLDEN * (high - low)
    x2 = high - _GOLDEN * (high - low)
    g1 = side * sample(machine, t, h, x1, k, dense_rows)
    g2 = side * sample(machine, t, h, x2, k, dense_rows)
    for _ in range(40):
        if g1 < -band:
            return x1
        if g2 < -band:
            return x2
        if g1 < g2:
            high, x2, g2 = x2, x1, g1
            x1 = low + _GOLDEN * (high - low)
            g1 = side * sample(machine, t, h, x1, k, dense_rows)
        else:
            low, x1, g1 = x1, x2, g2
            x2 = high - _GOLDEN * (high - low)
            g2 = side * sample(machine, t, h, x2, k, dense_rows)
    return NOWHERE


@inner
def root(
    machine: Integers,
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
    sample = sampled_of(machine)
    g_low = side * sample(machine, t, h, low, k, dense_rows) + band
    g_high = side * sample(machine, t, h, high, k, dense_rows) + band
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
        g = side * sample(machine, t, h, x, k, dense_rows) + band
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
def last_due(t: float, sw: Vector, modes: Integers) -> int:
    """A function that reaches zero at the step's end but for what the clock cannot tell, or -1.

    For the end of a run, after which no step sees it.
    """
    s = modes.size
    for k in range(s):
        side = 1.0 if modes[k] != 0 else -1.0
        change = side * sw[R1 * s + k] * INSTANT * abs(t)
        off = modes[k] != HELD_MODE and sw[BAND * s + k] == 0.0
        if off and change < 0.0 and side * sw[G1 * s + k] + change <= 0.0:
            return k
    return -1


@addressed(LOCATE)
def locate(machine: Integers, t: float, h: float, dense_rows: int, found: Integers) -> float:
    """Fraction of the step at which a marked function first crosses, or `NOWHERE`.

    The dense output must be there. `found[0]` receives the function's index.
    """
    s = machine[SWITCHES]
    sw, modes = surfaces(machine), mode_numbers(machine)
    sample = sampled_of(machine)
    for i in range(1, SUBDIVISIONS):
        sample(machine, t, h, i / SUBDIVISIONS, 0, dense_rows)
        for k in range(s):
            sw[(SCAN + i) * s + k] = sw[TRIAL * s + k]
    for k in range(s):
        sw[SCAN * s + k] = sw[G0 * s + k]
        sw[(SCAN + SUBDIVISIONS) * s + k] = sw[G1 * s + k]
    first = NOWHERE
    for k in range(s):
        if sw[SUSPECT * s + k] == 0.0:
            continue
        side = 1.0 if modes[k] != 0 else -1.0
        band = sw[BAND * s + k]
        # Rounding of the dense output is no crossing; that of the end point is looked at as it is.
        noise = max(band, _NOISE * sw[LARGEST * s + k])
        low, high, away = NOWHERE, NOWHERE, NOWHERE
        for i in range(1, SUBDIVISIONS + 1):
            left, right = (i - 1) / SUBDIVISIONS, i / SUBDIVISIONS
            if left >= first:
                break
            here = side * sw[(SCAN + i) * s + k]
            before = side * sw[(SCAN + i - 1) * s + k]
            if before > noise:
                away = left
            if here < -(band if i == SUBDIVISIONS else noise):
                low, high = left, right
                break
            # A lowest point may lie beside a sample that is lower than its neighbours.
            if i == 1:
                falls = side * sw[R0 * s + k] < 0.0 and band == 0.0
            else:
                falls = side * sw[(SCAN + i - 2) * s + k] >= before
            if i == SUBDIVISIONS:
                rises = side * sw[R1 * s + k] > 0.0
            else:
                rises = side * sw[(SCAN + i + 1) * s + k] >= here
            if (falls and before <= here) or (rises and here <= before):
                x = dip(machine, t, h, left, right, side, noise, k, dense_rows)
                if x < 1.0:
                    low, high = left, x
                    break
        if high <= 1.0 and away <= 1.0:
            # It has left the surface on which it began, and comes back to zero itself.
            low, band = away, 0.0
        if high <= 1.0:
            x = root(machine, t, h, low, high, side, band, k, dense_rows)
            if x < first:
                first = x
                found[0] = k
    return first
