"""Switches that turned and turned back by less than the tolerance: events that may be error alone.

A motion may touch a switching surface and not cross it, as a slider does whose dead centre is where
a force begins, or may stay beside it, as two bodies do that part from a stiff contact. A looser run
then has events that a tighter one has not. They do little, and are named.
"""

import numpy as np

from runtime.integrate.problem import Options
from runtime.integrate.trajectory import Events
from runtime.mechanism.dense_equations import Equations, FloatArray

_SHOWN = 3  # layout: switches that the sentence names


def describe_unresolved_switches(
    equations: Equations, events: Events, sizes: FloatArray, options: Options
) -> tuple[int, str]:
    """The number of events within the tolerance, and a sentence that names them; 0 and empty.

    Between two events of a switch, each the other's reverse, its function is taken at the middle of
    Hermite's polynomial through both states. It may err by what it changes with each coordinate and
    velocity by their tolerances `atol + rtol |y|`.
    """
    switches, e, n = equations.description.switches, len(events.t), len(sizes)
    if e < 2 or not switches:
        return 0, ""
    # compiled: most scenes have no switches
    from runtime.dynamics.switching_values import measure_reversals

    s, absolute = len(switches), options.absolute(sizes, options.rtol)
    reversed_event, reached, permitted = np.zeros(e, np.int64), np.zeros(e), np.zeros(s)
    if not measure_reversals(
        equations.table, events.t, events.q, events.v, events.index, events.direction, equations.p,
        options.rtol, absolute, np.zeros((3, max(s, 2 * n))), np.zeros((s, 2 * n)),
        np.zeros((2, s), np.int64), reversed_event, reached, permitted,
    ):  # fmt: skip
        return 0, ""
    after = np.flatnonzero(reversed_event >= 0)
    after = after[reached[after] <= permitted[events.index[after]]]
    first, index = reversed_event[after], events.index[after]
    clauses = []
    for k in np.unique(index):
        those = index == k
        count = len(np.union1d(first[those], after[those]))
        clauses.append(
            f"{switches[int(k)].title} ({count} from t = {events.t[first[those][0]]:.6g} s on, "
            f"past zero by {reached[after[those]].max():.1g}, permitted {permitted[k]:.1g})"
        )
    total = len(np.union1d(first, after))
    shown = "; ".join(clauses[:_SHOWN]) + (" and others" if len(clauses) > _SHOWN else "")
    return total, (
        f" {total} of {e} events lie within the tolerance, and a tighter rtol may not "
        f"have them: {shown}."
    )
