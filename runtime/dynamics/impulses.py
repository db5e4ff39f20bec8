"""Impulses of joints and drivers where the rate of a law, and so the velocities, jump.

M Δv + Φ_qᵀ Λ = 0, Φ_q Δv = ν⁺ - ν⁻: straight lines as a law of motion ask for them at every knot.
"""

from collections.abc import Iterable
from itertools import compress

import numpy as np

from codegen.object_display import counted
from runtime.core.kinds import Direction
from runtime.mechanism.dense_equations import Equations
from runtime.results.run_records import Event

_APART = 128.0 * np.finfo(float).eps  # accuracy: of the time; the side before an event
_ROUNDING = 1e-12  # accuracy: of the largest impulse; a smaller one is 0
_MOST = 5  # layout: instants that a message tells


def with_impulses(
    equations: Equations, events: Iterable[Event], latest: float
) -> tuple[tuple[Event, ...], str]:
    """The events of a run up to `latest`, s, with the impulses at jumps of rates, and a sentence.

    The sentence is empty where no rate jumps.
    """
    description, found = equations.description, [*events]
    titles = {function.title for function in description.time_functions}
    if not titles:
        return tuple(found), ""
    jumped = [e.direction == Direction.IMPACT and e.name in titles for e in found]
    jumps = [*compress(found, jumped)]
    if not jumps:
        return tuple(found), ""
    for k in np.flatnonzero(jumped) if description.has_masses else ():
        found[k] = found[k]._replace(impulse=_impulses(equations, found[k], latest))
    times = ", ".join(f"{event.time:.6g}" for event in jumps[:_MOST])
    more = ", …" if len(jumps) > _MOST else ""
    names = " and ".join(f"'{name}'" for name in dict.fromkeys(event.element for event in jumps))
    what = "That takes impulses, which no force contains: each of these events has its `impulse`"
    if not description.has_masses:
        what = "Accelerations are without bound there"
    return tuple(found), (
        f" The rate of the law in {names} jumps at {counted(len(jumps), 'instant')} (t = {times}"
        f"{more} s), and velocities with it. {what}. A law with a continuous rate has none, such "
        "as a table of kind='spline'."
    )


def _impulses(equations: Equations, event: Event, latest: float) -> dict[str, float]:
    """Component of the reaction of a joint or driver → its impulse, N s or N m s, if not 0."""
    equations, t, q = equations.whole, event.time, event.q
    description = equations.description
    before = t - _APART * max(abs(t), abs(latest))
    jump = equations.velocity_rhs(t, q) - equations.velocity_rhs(before, q)
    none = np.zeros((equations.n, 1))
    _, multipliers = equations.responses(t, q, none, jump[:, None])
    reactions = np.zeros(len(description.reactions))
    kernel = equations.kernels.reactions
    if "reactions" in description.kernels:
        kernel(t, q, event.v, equations.p, multipliers[:, 0], reactions)
    parts = {row.element for row in description.constraints}  # effects and points have no impulse
    reactions *= [row.element in parts and "N" in row.unit for row in description.reactions]
    least = _ROUNDING * np.abs(reactions).max(initial=0.0)
    rows = zip(description.reactions, reactions.tolist(), strict=True)
    return {f"{row.element}.{row.component}": value for row, value in rows if abs(value) > least}
