"""Switches that turned and turned back by less than the tolerance: events that may be error alone.

A motion may touch a switching surface and not cross it, as a slider does whose dead centre is where
a force begins, or may stay beside it, as two bodies do that part from a stiff contact. A looser run
then has events that a tighter one has not. They do little, and are named.
"""

import numpy as np

from runtime.core.modes_and_event_kinds import KNOTS
from runtime.dynamics.end_check_screening import Suspicions
from runtime.integrate.trajectory import Events
from runtime.mechanism.dense_equations import Equations

_SHOWN = 3  # layout: switches that the sentence names


def describe_unresolved_switches(
    equations: Equations, events: Events, suspicions: Suspicions
) -> tuple[int, str]:
    """The number of events within the tolerance, and a sentence that names them; 0 and empty.

    Between two events of a switch, each the other's reverse, its function is taken at the middle of
    Hermite's polynomial through both states. It may err by what it changes with each coordinate and
    velocity by their tolerances `atol + rtol |y|`.
    """
    if not suspicions.reversals:
        return 0, ""
    switches, e = equations.description.switches, len(events.t)
    reversed_event, reached, permitted = suspicions[-3:]
    after = np.flatnonzero(reversed_event >= 0)
    after = after[reached[after] <= permitted[events.index[after]]]
    parts = equations.description.table_parts
    after = after[[parts[k] != KNOTS for k in events.index[after]]]
    if not len(after):
        return 0, ""
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
