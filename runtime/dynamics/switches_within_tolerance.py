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
    if len(events.t) < 2:
        return 0, ""
    order = np.argsort(events.index, kind="stable")
    index, kinds, t = events.index[order], events.direction[order], events.t[order]
    turned = (kinds[:-1] == -kinds[1:]) & (np.abs(kinds[:-1]) == Direction.BEGAN)
    same = index[:-1] == index[1:]
    turned &= same & (t[:-1] < t[1:])
    if not turned.any():
        return 0, ""
    first, after = order[:-1][turned], order[1:][turned]
    begins = np.flatnonzero(np.append(True, ~same))  # of the events of each switch
    pair = np.searchsorted(index[begins], index[:-1][turned])
    chosen = np.zeros(len(begins), dtype=np.bool_)
    chosen[pair] = True
    at, switches, permitted = order[begins[chosen]], index[begins], np.zeros(len(begins))
    states = np.abs(np.hstack([events.q, events.v]))[order]
    largest = np.maximum.reduceat(states, begins)[chosen]
    permitted[chosen] = tolerances_of_switches(
        equations, switches[chosen], events.t[at], events.q[at], events.v[at], largest, sizes,
        options,
    )  # fmt: skip
    reached = _middle_values(equations, switches[pair], events, first, after)
    within = reached <= permitted[pair]
    if not within.any():
        return 0, ""
    clauses = []
    for k in np.unique(pair[within]):
        those = within & (pair == k)
        count = len(np.union1d(first[those], after[those]))
        clauses.append(
            f"{equations.description.switches[int(switches[k])].title} ({count} from t = "
            f"{events.t[first[those][0]]:.6g} s on, past zero by {reached[those].max():.1g}, "
            f"permitted {permitted[k]:.1g})"
        )
    total = len(np.union1d(first[within], after[within]))
    shown = "; ".join(clauses[:_SHOWN]) + (" and others" if len(clauses) > _SHOWN else "")
    return total, (
        f" {total} of {len(events.t)} events lie within the tolerance, and a tighter rtol may not "
        f"have them: {shown}."
    )


def _middle_values(
    equations: Equations, switches: Indices, events: Events, first: Indices, after: Indices
) -> FloatArray:
    """|g| of one switch each, midway between the states of events `first` and `after`."""
    # compiled: most runs have no such events
    from runtime.dynamics.switching_values import write_switching_values

    count, span = len(equations.description.switches), events.t[after] - events.t[first]
    span = span[:, None]
    q0, q1, v0, v1 = events.q[first], events.q[after], events.v[first], events.v[after]
    q = 0.5 * (q0 + q1) + 0.125 * span * (v0 - v1)
    v = 1.5 * (q1 - q0) / span - 0.25 * (v0 + v1)
    t, g = 0.5 * (events.t[first] + events.t[after]), np.zeros((len(first), count))
    write_switching_values(equations.table, t, q, v, equations.p, g)
    values: FloatArray = np.abs(g[np.arange(len(first)), switches])
    return values


def tolerances_of_switches(
    equations: Equations, switches: Indices, t: FloatArray, q: FloatArray, v: FloatArray,
    largest: FloatArray, sizes: FloatArray, options: Options,
) -> FloatArray:  # fmt: skip
    """What each g_k may err by at its state (t, q, v) as each coordinate and velocity may, (k,).

    States are (k, n), and `largest` their largest magnitudes, (k, 2n).
    """
    from runtime.dynamics.switching_values import write_changes

    n, count = len(sizes), len(equations.description.switches)
    change = options.rtol * largest
    for atol, half in ((options.atol_q, slice(n)), (options.atol_v, slice(n, None))):
        absolute = options.rtol * np.minimum(1.0, sizes) if atol is None else np.asarray(atol)
        change[:, half] += absolute
    state, g, total = np.hstack([q, v]), np.zeros(count), np.zeros(len(switches))
    write_changes(equations.table, switches, t, state, change, equations.p, g, total)
    return total
