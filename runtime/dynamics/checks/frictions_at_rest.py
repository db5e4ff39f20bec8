"""Frictions that joints and drivers hold at rest: what they exert is one valid choice of many."""

import numpy as np

from codegen.object_display import counted
from runtime.core.kinds import SLIDING
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.dense_equations import Equations
from runtime.results.result import Result

_RESPONDS = 1e-9  # accuracy: of the largest change of a multiplier; a smaller one is rounding


def name_held_frictions(result: Result, equations: Equations) -> None:
    """Add frictions to `not_unique` that are held at rest, with what follows from them.

    The message has their bounds. The share of such a friction is not a number.
    """
    description, samples = equations.description, result.samples
    limits = {k: rows for k, *rows in description.friction_limits}
    switches = description.switches
    low, high = np.zeros(len(switches)), np.ones(len(switches))
    equations.kernels.holds(equations.p, low, high)
    for k, switch in enumerate(switches):
        held = switch.sticks & (samples.modes[:, k] == SLIDING) & np.isnan(samples.share[:, k])
        if not held.any():
            continue
        rows, sides = samples.at(held), []
        for mode in (0, 1):
            rows.modes[:, k] = mode
            sides.append(evaluate(equations, rows.t, rows.q, rows.v, rows.modes))
        off, on = sides
        bounds, unit = np.full((len(rows.t), 2), np.nan), ""
        for column, row in enumerate(description.reactions):
            if row.element == switch.name and row.component in {"force", "torque"}:
                base, unit = off.reaction[:, column], row.unit
                bounds = base[:, None] + np.outer(on.reaction[:, column] - base, [low[k], high[k]])
        if k in limits:
            bounds = np.outer(rows.reaction[:, limits[k][1]], [-1.0, 1.0])
        if not bounds.any():
            continue
        change = np.nan_to_num(np.abs(on.lam - off.lam)).max(axis=0, initial=0.0)
        moved = np.flatnonzero(change > _RESPONDS * change.max(initial=0.0))
        others = dict.fromkeys(description.constraints[j].element for j in moved)
        result.not_unique = tuple(dict.fromkeys([*result.not_unique, switch.name, *others]))
        force = f"anything from {bounds.min():.6g} to {bounds.max():.6g} {unit}"
        result.message += (
            f" At {counted(len(rows.t), 'instant')} from t = {rows.t[0]:.6g} to {rows.t[-1]:.6g} s "
            f"joints and drivers hold the friction {switch.name} at rest, and it may exert "
            f"{'any force' if np.isnan(bounds).any() else force}: the least, 0, is given, and the "
            f"reactions of {', '.join(others)} with it."
        )
