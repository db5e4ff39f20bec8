"""Outputs where something is held: where the motion slides, sticks, or a contact is closed."""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import types

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    HELD,
    HIGH,
    LIMITS,
    PLAIN,
    REACTION,
    REACTION_ROWS,
    RIGID_COUNT,
    SHARE,
    SOUGHT,
    SWITCHES,
    WORK,
    bent_of,
)
from runtime.core.jit import ADDRESSES, allocating
from runtime.core.kernels import FETCH, MATRIX, MODE_ROWS, MODES, VECTOR
from runtime.hybrid.mode_consistency import hold
from runtime.hybrid.mode_reactions import mix
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.stiction_force import engage, release
from runtime.integrate.wiring import wire
from runtime.mechanism.mechanism import Mechanism

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
powers_of = FETCH["powers"]


@allocating(
    types.none(
        ADDRESSES,
        ADDRESSES,
        MODES,
        VECTOR,
        VECTOR,
        MATRIX,
        MATRIX,
        MODE_ROWS,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        VECTOR,
        VECTOR,
    )
)
def _mix_rows(
    machine: Any,
    kernels: Any,
    rows: Any,
    times: Any,
    p: Any,
    q: Any,
    v: Any,
    modes: Any,
    a: Any,
    lam: Any,
    reaction: Any,
    power: Any,
    shares: Any,
    base: Any,
    other: Any,
) -> None:
    bent = bent_of(machine)
    powers = powers_of(kernels)
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    plain = integers_at(machine, PLAIN, 2 * s)
    held = view(plain, s, s)
    share, high = floats_at(machine, SHARE, s), floats_at(machine, HIGH, s)
    sought, limits = integers_at(machine, SOUGHT, s), integers_at(machine, LIMITS, 2 * s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    mixed = floats_at(machine, REACTION, machine[REACTION_ROWS])
    own = np.zeros(m)
    for row in rows:
        t = times[row]
        hold(machine, modes[row])
        bent(machine, t, q[row], v[row], p, modes[row], a[row], lam[row])
        mix(machine, t, q[row], v[row], p, lam[row])
        for i in range(len(mixed)):
            reaction[row, i] = mixed[i]
        for c in range(machine[HELD]):
            release(machine, p, held[c])
        for i in range(m):
            own[i] = work[n + i]
        powers(t, q[row], v[row], p, plain, own, base)
        for i in range(len(base)):
            power[row, i] = base[i]
        for c in range(machine[HELD]):
            k = held[c]
            shares[row, k] = share[k]
            if sought[k] >= 0:
                # Between the forces that the friction would have, sliding with what presses now.
                force, limit = mixed[limits[2 * k]], mixed[limits[2 * k + 1]]
                shares[row, k] = 0.5 - 0.5 * high[k] * force / limit if limit > 0.0 else np.nan
            for i in range(m):
                own[i] = work[n + i] + work[(c + 1) * size + n + i]
            engage(machine, p, k)
            powers(t, q[row], v[row], p, plain, own, other)
            release(machine, p, k)
            for i in range(len(base)):
                power[row, i] += share[k] * (other[i] - base[i])


def mix_held(
    machine: Mechanism,
    p: FloatArray,
    t: FloatArray,
    q: FloatArray,
    v: FloatArray,
    modes: IntArray,
    a: FloatArray,
    lam: FloatArray,
    reaction: FloatArray,
    power: FloatArray,
) -> FloatArray:
    """Overwrite accelerations and what follows from them at the instants at which something holds.

    Returns
    -------
    (k, s)
        The share of each function that is held (0: the force of its mode 0, 1: that of mode 1),
        NaN where it is not.
    """
    shares = np.full(modes.shape, np.nan)
    rows = np.flatnonzero((modes == HELD_MODE).any(axis=1))
    if len(rows):
        wiring = wire(machine.system, "dopri5", p, 1)
        sources = power.shape[1]
        _mix_rows(
            wiring.table, machine.kernel_table, rows, t, p, q, v, modes, a, lam, reaction, power,
            shares, np.zeros(sources), np.zeros(sources),
        )  # fmt: skip
    return shares
