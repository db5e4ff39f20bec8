"""Outputs in sliding modes: where the motion slides, friction sticks, or a contact is closed."""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import types

from runtime.core.array_types import integer_matrix, integers, matrix, vector
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    SLIDING_COUNT,
    base_multipliers_of,
    kernel_modes_of,
    limits_of,
    modified_accelerations_of,
    reaction_of,
    share_high_of,
    share_of,
    sliding_functions_of,
    stiction_place_of,
    unit_multipliers_of,
)
from runtime.core.jit import ADDRESSES, allocating
from runtime.core.kernel_abi import powers_of
from runtime.core.modes import SLIDING
from runtime.hybrid.mode_consistency import count_sliding
from runtime.hybrid.mode_reactions import mix_reactions
from runtime.hybrid.stiction_force import apply_unit, remove_unit
from runtime.integrate.wiring import wire
from runtime.mechanism.mechanism import Mechanism

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@allocating(types.none(
    ADDRESSES, ADDRESSES, integers, vector, vector, matrix, matrix, integer_matrix, matrix, matrix,
    matrix, matrix, matrix, vector, vector,
))  # fmt: skip
def _mix_rows(
    context: Any, kernels: Any, rows: Any, times: Any, p: Any, q: Any, v: Any, modes: Any, a: Any,
    lam: Any, reaction: Any, power: Any, shares: Any, base: Any, other: Any,
) -> None:  # fmt: skip
    field = modified_accelerations_of(context)
    powers = powers_of(kernels)
    m = context[CONSTRAINT_COUNT]
    plain = kernel_modes_of(context)
    sliding = sliding_functions_of(context)
    share, high = share_of(context), share_high_of(context)
    stiction_place, limits = stiction_place_of(context), limits_of(context)
    base_multipliers = base_multipliers_of(context)
    unit_multipliers = unit_multipliers_of(context)
    mixed_reaction = reaction_of(context)
    multipliers = np.zeros(m)
    for row in rows:
        t = times[row]
        count_sliding(context, modes[row])
        field(context, t, q[row], v[row], modes[row], a[row], lam[row])
        mix_reactions(context, t, q[row], v[row], lam[row])
        for i in range(len(mixed_reaction)):
            reaction[row, i] = mixed_reaction[i]
        for c in range(context[SLIDING_COUNT]):
            remove_unit(context, sliding[c])
        for i in range(m):
            multipliers[i] = base_multipliers[i]
        powers(t, q[row], v[row], p, plain, multipliers, base)
        for i in range(len(base)):
            power[row, i] = base[i]
        for c in range(context[SLIDING_COUNT]):
            k = sliding[c]
            shares[row, k] = share[k]
            if stiction_place[k] >= 0:
                # Between the friction forces of both directions, at the present normal force.
                force, limit = mixed_reaction[limits[2 * k]], mixed_reaction[limits[2 * k + 1]]
                shares[row, k] = 0.5 - 0.5 * high[k] * force / limit if limit > 0.0 else np.nan
            for i in range(m):
                multipliers[i] = base_multipliers[i] + unit_multipliers[c * m + i]
            apply_unit(context, k)
            powers(t, q[row], v[row], p, plain, multipliers, other)
            remove_unit(context, k)
            for i in range(len(base)):
                power[row, i] += share[k] * (other[i] - base[i])


def overwrite_sliding(
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
    """Overwrite accelerations, reactions and powers at the instants with a function in mode 2.

    Returns
    -------
    (k, s)
        Filippov's share α of each function in mode 2 (0: the force of its mode 0, 1: that of
        mode 1), NaN elsewhere.
    """
    shares = np.full(modes.shape, np.nan)
    rows = np.flatnonzero((modes == SLIDING).any(axis=1))
    if len(rows):
        wiring = wire(machine.system, "dopri5", p, 1)
        sources = power.shape[1]
        _mix_rows(
            wiring.table, machine.kernel_table, rows, t, p, q, v, modes, a, lam, reaction, power,
            shares, np.zeros(sources), np.zeros(sources),
        )  # fmt: skip
    return shares
