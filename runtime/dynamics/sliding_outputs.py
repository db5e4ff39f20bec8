"""Outputs in sliding modes: where the motion slides, friction sticks, or a contact is closed."""

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import mass_of, powers_of, switching_rates_of
from runtime.core.kinds import SLIDING
from runtime.dynamics.output_quantities import SAMPLES
from runtime.hybrid.filippov_shares import mix_reactions
from runtime.hybrid.mode_consistency import count_sliding
from runtime.hybrid.stiction_force import is_prescribed, set_unit
from runtime.integrate.wiring import Wiring, wire
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.start_table import start_table
from runtime.mechanism.typical_sizes import measure_length, write_scale
from runtime.results.samples import Samples


@inner
def prepare_mixing(
    context: Any, start: Any, diagonal: Any, t: float, q: Any, p: Any, masses: Any
) -> None:  # fmt: skip
    """Write the sizes of coordinates and of the rates of switching functions, and the masses at q.

    By these it is judged whether a response is more than rounding, as in a run. `diagonal` has the
    coordinate of each non-zero of M, -1 beside the diagonal, and `masses` is room for these;
    `start` is a table of `start_table`.
    """
    size, projection = ws.row_of(context, ws.SIZE), ws.row_of(context, ws.PROJECTION)
    n, rates = q.size, switching_rates_of(start)
    write_scale(start, measure_length(start, t, q, p), start.change_scale)
    for j in range(n):
        size[j], size[n + j], projection[j] = start.change_scale[j], start.change_scale[j], 0.0
    mass_of(start)(q, p, masses)
    for e in range(masses.size):
        if diagonal[e] >= 0 and masses[e] > 0.0:
            projection[diagonal[e]] = 1.0 / masses[e]
    still, change = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    rest, moved = ws.switch_row(context, ws.SCAN), ws.switch_row(context, ws.SCAN + 1)
    spread = context.largest
    still.fill(0.0)
    change.fill(0.0)
    spread.fill(0.0)
    rates(t, q, still, still, p, rest)
    for j in range(n):
        change[j] = start.change_scale[j]
        for of_velocity in range(2):
            if of_velocity == 0:
                rates(t, q, change, still, p, moved)
            else:
                rates(t, q, still, change, p, moved)
            for k in range(spread.size):
                away = abs(moved[k] - rest[k])
                spread[k] += away if np.isfinite(away) else 0.0
        change[j] = 0.0
    for k in range(spread.size):
        context.reserve[k] = spread[k]


@inner
def mix_rows(
    context: Any, start: Any, diagonal: Any, s: Any, p: Any, masses: Any, powers: Any
) -> None:  # fmt: skip
    """Overwrite the outputs of the samples in which a function is in mode 2."""
    base, other, reaction = powers[0], powers[1], context.reaction
    modes, base_lam, lam = (
        context.kernel_modes,
        context.given_multipliers,
        context.mixed_multipliers,
    )
    evaluate_powers = powers_of(start)
    prepared = False
    for row in range(s.t.size):
        t, q, v, sliding = s.t[row], s.q[row], s.v[row], False
        for k in range(s.modes.shape[1]):
            sliding = sliding or s.modes[row, k] == SLIDING
        if not sliding:
            continue
        if not prepared:
            prepare_mixing(context, start, diagonal, t, q, p, masses)
            prepared = True
        count_sliding(context, s.modes[row])
        ft.modified_accelerations_of(context)(context, t, q, v, s.modes[row], s.a[row], s.lam[row])
        mix_reactions(context, t, q, v, s.lam[row])
        for i in range(len(reaction)):
            s.reaction[row, i] = reaction[i]
        evaluate_powers(t, q, v, p, modes, base_lam, base)
        for i in range(len(base)):
            s.power[row, i] = base[i]
        for c in range(context[ft.SLIDING_COUNT]):
            k = context.sliding_functions[c]
            s.share[row, k] = context.share[k]
            if context.stiction_place[k] >= 0:
                # Between the friction forces of both directions, at the present normal force.
                force, limit = reaction[context.limits[2 * k]], reaction[context.limits[2 * k + 1]]
                part = 0.5 * context.share_high[k] * force / limit
                s.share[row, k] = 0.5 - part if limit > 0.0 else np.nan
            if is_prescribed(context, k):
                continue
            for i in range(len(lam)):
                lam[i] = base_lam[i] + context.unit_multipliers[c, i]
            set_unit(context, k, 1)
            evaluate_powers(t, q, v, p, modes, lam, other)
            set_unit(context, k, 0)
            for i in range(len(base)):
                s.power[row, i] += context.share[k] * (other[i] - base[i])


@compiled(none(ADDRESSES, ADDRESSES, integers, SAMPLES, vector, vector, matrix))
def _mix(
    context: Any, start: Any, diagonal: Any, s: Any, p: Any, masses: Any, powers: Any
) -> None:  # fmt: skip
    mix_rows(context, start, diagonal, s, p, masses, powers)


def wire_mixing(mechanism: Mechanism, p: npt.NDArray[np.float64]) -> Wiring:
    """A table for `mix_rows`."""
    return wire(mechanism.system, "dopri5", p, 1)


def overwrite_sliding(mechanism: Mechanism, p: npt.NDArray[np.float64], samples: Samples) -> None:
    """Overwrite accelerations, multipliers, reactions and powers where a function is in mode 2.

    `share` receives Filippov's share α of each function in mode 2 (0: the force of its mode 0, 1:
    that of mode 1).
    """
    wiring, start = wire_mixing(mechanism, p), start_table(mechanism)
    diagonal = mechanism.description.mass_diagonal
    masses, powers = np.zeros(len(diagonal)), np.zeros((2, samples.power.shape[1]))
    _mix(wiring.table, start.table, diagonal, samples, p, masses, powers)
