"""Frictions that joints and drivers hold at rest: what they exert is one valid choice of many."""

import numpy as np

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
    limits, switches = {k: rows for k, *rows in description.friction_limits}, description.switches
    if not any(switch.sticks for switch in switches):
        return
    low, high = np.zeros(len(switches)), np.ones(len(switches))
    joints = [row.element for row in description.constraints]
    equations.kernels.holds(equations.p, low, high)
    result._held = ""
    for k, switch in enumerate(switches):
        held = switch.sticks & (samples.modes[:, k] == SLIDING) & np.isnan(samples.share[:, k])
        if not held.any():
            continue
        rows, sides = samples.at(held), []
        for mode in (0, 1):
            rows.modes[:, k] = mode
            sides.append(evaluate(equations, rows.t, rows.q, rows.v, rows.modes))
        off, on = sides
        change = np.nan_to_num(np.abs(on.lam - off.lam)).max(axis=0, initial=0.0)
        moved = np.flatnonzero(change > _RESPONDS * change.max(initial=0.0))
        others, bounds = dict.fromkeys(joints[j] for j in moved), dict[str, str]()
        for column, row in enumerate(description.reactions):
            name, base = row.element, off.reaction[:, column]
            spread = on.reaction[:, column] - base
            if name in joints or row.component not in {"force", "torque"} or not spread.any():
                continue
            ends = base[:, None] + np.outer(spread, [low[k], high[k]])
            if name == switch.name and k in limits:
                ends = np.outer(rows.reaction[:, limits[k][1]], [-1.0, 1.0])
            bounds[name] = f"anything from {ends.min():.6g} to {ends.max():.6g} {row.unit}"
        if not any(row.element == switch.name for row in description.reactions):
            bounds[switch.name] = "any force that it can bear"
        if not bounds:
            continue
        result.not_unique = tuple(dict.fromkeys([*result.not_unique, *bounds, *others]))
        forces = ", ".join(f"{name} may exert {ends}" for name, ends in bounds.items())
        when = f"At t = {rows.t[0]:.6g} s"
        if len(rows.t) > 1:
            when = f"At instants given from t = {rows.t[0]:.6g} to {rows.t[-1]:.6g} s"
        follow = f", and the reactions of {', '.join(others)} with it" if others else ""
        result._held += (
            f" {when} joints and drivers hold friction at rest: {forces}. "
            f"The least, 0, is given{follow}."
        )
    result.message += result._held
