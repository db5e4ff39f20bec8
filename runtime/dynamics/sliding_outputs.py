"""Outputs in sliding modes: where the motion slides, friction sticks, or a contact is closed."""

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import powers_of
from runtime.core.modes_and_event_kinds import SLIDING
from runtime.dynamics.output_quantities import SAMPLES
from runtime.hybrid.filippov_shares import mix_reactions
from runtime.hybrid.mode_consistency import count_sliding
from runtime.hybrid.stiction_force import is_prescribed, set_unit
from runtime.integrate.wiring import wire
from runtime.mechanism.dense_equations import Equations, magnitudes
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.results.samples import Samples


@compiled(none(ADDRESSES, ADDRESSES, integers, SAMPLES, vector, matrix))
def _mix_rows(context: Any, kernels: Any, rows: Any, s: Any, p: Any, powers: Any) -> None:
    base, other, reaction = powers[0], powers[1], context.reaction
    modes, base_lam, lam = (
        context.kernel_modes,
        context.given_multipliers,
        context.mixed_multipliers,
    )
    evaluate_powers = powers_of(kernels)
    for row in rows:
        t, q, v = s.t[row], s.q[row], s.v[row]
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


def _sizes(
    mechanism: Mechanism, p: npt.NDArray[np.float64], samples: Samples, row: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Of coordinates, (n,), and of the rates of switching functions, (s,), at sample `row`.

    By these it is judged whether a response is more than rounding, as in a run.
    """
    t, q, n = float(samples.t[row]), samples.q[row], samples.q.shape[1]
    size, count = magnitudes(Equations(mechanism, p), t, q), samples.modes.shape[1]

    def rates(v: npt.NDArray[np.float64], a: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        out = np.zeros(count)
        mechanism.kernels.switching_rates(t, q, v, a, p, out)
        return out

    still = np.zeros(n)
    rest, spread = rates(still, still), np.zeros(count)
    for change in np.diag(size):
        for moved in rates(change, still), rates(still, change):
            spread += np.nan_to_num(np.abs(moved - rest), posinf=0.0)
    return size, spread


def overwrite_sliding(mechanism: Mechanism, p: npt.NDArray[np.float64], samples: Samples) -> None:
    """Overwrite accelerations, multipliers, reactions and powers where a function is in mode 2.

    `share` receives Filippov's share α of each function in mode 2 (0: the force of its mode 0, 1:
    that of mode 1).
    """
    rows = np.flatnonzero((samples.modes == SLIDING).any(axis=1))
    wiring = wire(mechanism.system, "dopri5", p, 1)
    size, spread = _sizes(mechanism, p, samples, int(rows[0]))
    workspace = wiring.arrays["workspace"].reshape(ws.ROWS, 2, len(size))
    workspace[ws.SIZE] = size
    masses = Equations(mechanism, p).masses(samples.q[rows[0]])
    np.divide(1.0, masses, workspace[ws.PROJECTION, 0], where=masses > 0.0)
    sizes = wiring.arrays["switching_rows"].reshape(ws.SWITCH_ROWS, len(spread))
    sizes[ws.LARGEST], sizes[ws.RESERVE] = spread, spread
    powers = np.zeros((2, samples.power.shape[1]))
    _mix_rows(wiring.table, mechanism.kernel_table, rows, samples, p, powers)
