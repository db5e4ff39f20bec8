"""Switches that turned and turned back by less than the tolerance: events that may be error alone.

A motion may touch a switching surface and not cross it, as a slider does whose dead centre is where
a force begins, or may stay beside it, as two bodies do that part from a stiff contact. A looser run
then has events that a tighter one has not. They do little, and are named.
"""

import numpy as np

from runtime.dynamics.end_check_screening import Suspicions, find_unresolved
from runtime.integrate.trajectory import Events
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.module_tables import Description

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
    description = equations.description
    parts, found = np.array(description.table_parts), np.zeros((len(description.switches), 4))
    find_unresolved(events.t, events.index, *suspicions[-3:], parts, found)
    return int(found[:, 0].sum()), sentence_of_unresolved(description, found, len(events.t))


def sentence_of_unresolved(description: Description, found: FloatArray, count: int) -> str:
    """A sentence on switches with events within the tolerance, of `count` in all; or empty.

    `found`, (s, 4), is what `find_unresolved` writes.
    """
    within = np.flatnonzero(found[:, 0])
    if not len(within):
        return ""
    clauses = [
        f"{description.switches[int(k)].title} ({found[k, 0]:.0f} from t = {found[k, 1]:.6g} s on, "
        f"past zero by {found[k, 2]:.1g}, permitted {found[k, 3]:.1g})"
        for k in within
    ]
    shown = "; ".join(clauses[:_SHOWN]) + (" and others" if len(clauses) > _SHOWN else "")
    return (
        f" {found[:, 0].sum():.0f} of {count} events lie within the tolerance, and a tighter rtol "
        f"may not have them: {shown}."
    )
