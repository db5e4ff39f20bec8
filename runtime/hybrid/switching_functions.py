"""Switching functions along a run: g itself, or how far what holds g at zero is from letting go."""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    COORDINATES,
    HELD,
    HIGH,
    LIMITS,
    LOW,
    SETTINGS,
    SHARE,
    SWITCHES,
    bent_of,
    limited_of,
    margins_of,
    switching_of,
    switching_rates_of,
)
from runtime.core.jit import addressed, inlined, inner
from runtime.core.run_arrays import (
    mode_numbers,
    multipliers,
    parameters,
    surfaces,
    workspace,
)
from runtime.core.signatures import MARGINS, Integers, Vector
from runtime.core.workspace import DELTA, ROWS, SAMPLE, SWITCH_ROWS
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.sliding_rhs import STEP

_AHEAD = 1e-4  # accuracy: of a step; the distance over which the rate of a margin is differenced
UNBOUNDED = -1e300  # code: a lower bound below this is none


@inlined
def functions(
    machine: Integers,
    t: float,
    state: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
) -> None:
    """Write g at the state in row `state` of the workspace into row `slot` of `sw`.

    In the place of a function that is held stands its margin, which is positive as long as its
    share lies between its bounds.
    """
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, view(sw, slot * s, s))
    if machine[HELD] != 0:
        margins_of(machine)(machine, t, state, slot)


@inner
def margin(
    machine: Integers, t: float, q: Vector, v: Vector, p: Vector, lam: Vector, s: int, k: int
) -> float:
    """How far what holds function `k` is from letting go: zero where it does, negative beyond.

    That is the share's distance from its bounds, or what is left of the force that friction bears.
    """
    if integers_at(machine, LIMITS, 2 * s)[2 * k] >= 0:
        return float(limited_of(machine)(machine, t, q, v, p, lam, k))
    share = floats_at(machine, SHARE, s)[k]
    low, high = floats_at(machine, LOW, s)[k], floats_at(machine, HIGH, s)[k]
    room = high - share
    if low >= UNBOUNDED:
        room *= (share - low) / (high - low)
    return float(room) if np.isfinite(room) else -1.0


@addressed(MARGINS)
def margins(machine: Integers, t: float, state: int, slot: int) -> None:
    """Write the margins of what is held over its functions in row `slot` of `sw`."""
    n, s = machine[COORDINATES], machine[SWITCHES]
    w, sw, p = workspace(machine), surfaces(machine), parameters(machine)
    modes, lam = mode_numbers(machine), multipliers(machine)
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    bent_of(machine)(machine, t, q, v, p, modes, view(w, DELTA * 2 * n, n), lam)
    for k in range(s):
        if modes[k] == HELD_MODE:
            sw[slot * s + k] = margin(machine, t, q, v, p, lam, s, k)


@inner
def measure(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Write g into row `slot` of `sw` and dg/dt into the next, for two rows of the workspace.

    The rate of a margin is a difference along the motion.
    """
    length = w.size // ROWS
    n = length // 2
    s = sw.size // SWITCH_ROWS
    functions(machine, t, state, slot, w, sw, p)
    q, v = view(w, state * length, n), view(w, state * length + n, n)
    a = view(w, derivative * length + n, n)
    rates = view(sw, (slot + 1) * s, s)
    switching_rates_of(machine)(t, q, v, a, p, rates)
    if machine[HELD] == 0:
        return
    y = view(w, state * length, length)
    z = view(w, SAMPLE * length, length)
    ahead = _AHEAD * floats_at(machine, SETTINGS, 2)[STEP]
    for j in range(n):
        z[j] = y[j] + ahead * (y[n + j] + 0.5 * ahead * a[j])
        z[n + j] = y[n + j] + ahead * a[j]
    z_q, z_v = view(z, 0, n), view(z, n, n)
    bent_of(machine)(machine, t + ahead, z_q, z_v, p, modes, view(w, DELTA * length, n), lam)
    for k in range(s):
        if modes[k] == HELD_MODE:
            rates[k] = (
                margin(machine, t + ahead, z_q, z_v, p, lam, s, k) - sw[slot * s + k]
            ) / ahead
