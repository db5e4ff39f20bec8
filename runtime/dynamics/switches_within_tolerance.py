"""Switches that turned and turned back by less than the tolerance: events that may be error alone.

A motion may touch a switching surface and not cross it, as a slider does whose dead centre is where
a force begins, or may stay beside it, as two bodies do that part from a stiff contact. A looser run
then has events that a tighter one has not. They do little, and are named.
"""

import numpy as np
import numpy.typing as npt

from runtime.core.modes_and_event_kinds import Direction
from runtime.integrate.problem import Options
from runtime.integrate.trajectory import Events
from runtime.mechanism.dense_equations import Equations, FloatArray

Indices = npt.NDArray[np.intp]

_SHOWN = 3  # layout: switches that the sentence names


def describe_unresolved_switches(
    equations: Equations, events: Events, sizes: FloatArray, options: Options
) -> tuple[int, str]:
    """The number of events within the tolerance, and a sentence that names them; 0 and empty.

    Between two events of a switch, each the other's reverse, its function is taken at the middle of
    Hermite's polynomial through both states. It may err by what it changes with each coordinate and
    velocity by their tolerances `atol + rtol |y|`.
    """
    alternating = {int(Direction.BEGAN), int(Direction.CEASED)}
    total, clauses = 0, []
    for k in np.unique(events.index):
        rows = np.flatnonzero(events.index == k)
        kinds = events.direction[rows]
        first = rows[:-1][(kinds[:-1] == -kinds[1:]) & np.isin(kinds[:-1], [*alternating])]
        after = rows[np.searchsorted(rows, first) + 1]
        span = events.t[after] - events.t[first]
        first, after = first[span > 0.0], after[span > 0.0]
        if not len(first):
            continue
        reached = _middle_values(equations, int(k), events, first, after)
        largest = np.concatenate([np.abs(y[rows]).max(axis=0) for y in (events.q, events.v)])
        begin = rows[0]
        at = float(events.t[begin]), events.q[begin], events.v[begin]
        permitted = tolerance_of_switch(equations, int(k), at, largest, sizes, options)
        within = reached <= permitted
        if within.any():
            count = len(np.union1d(first[within], after[within]))
            total += count
            clauses.append(
                f"{equations.description.switches[int(k)].title} ({count} from t = "
                f"{events.t[first[within][0]]:.6g} s on, past zero by {reached[within].max():.1g}, "
                f"permitted {permitted:.1g})"
            )
    if not clauses:
        return 0, ""
    shown = "; ".join(clauses[:_SHOWN]) + (" and others" if len(clauses) > _SHOWN else "")
    return total, (
        f" {total} of {len(events.t)} events lie within the tolerance, and a tighter rtol may not "
        f"have them: {shown}."
    )


def _middle_values(
    equations: Equations, k: int, events: Events, first: Indices, after: Indices
) -> FloatArray:
    """|g_k| midway between the states of events `first` and `after`."""
    # compiled: most runs have no such events
    from runtime.dynamics.switching_values import write_switching_values

    switches, span = len(equations.description.switches), events.t[after] - events.t[first]
    span = span[:, None]
    q0, q1, v0, v1 = events.q[first], events.q[after], events.v[first], events.v[after]
    q = 0.5 * (q0 + q1) + 0.125 * span * (v0 - v1)
    v = 1.5 * (q1 - q0) / span - 0.25 * (v0 + v1)
    t, g = 0.5 * (events.t[first] + events.t[after]), np.zeros((len(first), switches))
    write_switching_values(equations.table, t, q, v, equations.p, g)
    values: FloatArray = np.abs(g[:, k])
    return values


def tolerance_of_switch(
    equations: Equations, k: int, at: tuple[float, FloatArray, FloatArray], largest: FloatArray,
    sizes: FloatArray, options: Options,
) -> float:  # fmt: skip
    """What g_k may err by at the state `at` as each coordinate and velocity may.

    `largest` are their largest magnitudes, (2n,).
    """
    (t, q, v), n = at, len(sizes)
    state = np.concatenate([q, v])
    absolute = np.concatenate([
        np.broadcast_to(options.rtol * np.minimum(1.0, sizes) if a is None else np.asarray(a), n)
        for a in (options.atol_q, options.atol_v)
    ])  # fmt: skip
    change = absolute + options.rtol * largest
    here, total = float(equations.switching(t, q, v)[k]), 0.0
    for j in range(2 * n):
        moved = state.copy()
        moved[j] += change[j]
        total += abs(float(equations.switching(t, moved[:n], moved[n:])[k]) - here)
    return total
