"""The instant at which a joint is released or engages.

Positions and velocities stay, but for velocities that a joint which engages does not permit: these
end in an impact of all constraints, M Δv + Φ_qᵀ Λ = Gᵀ P, Φ_q (v + Δv) = ν, in which contacts that
are closed and freewheels take part by their impulses P ≥ 0.
"""

import numpy as np

from runtime.dynamics.prepared_simulation import Handover
from runtime.dynamics.start_of_clocks import numbered
from runtime.integrate.problem import Discrete
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.one_sided_impact import Contradiction, impact
from runtime.results.assembled_state import State
from runtime.results.reconnection import Ending, Reconnection
from runtime.validation.parameters import parameter_values

# accuracy: of the machine's lengths; a contact with a gap below it is closed
_TOUCHING = 1e-9
_CLOSED = 1e-6  # safety: of the size of its equation; a joint further open does not engage


class Gap(Exception):  # noqa: N818 (it is caught where runs follow one another)
    """A joint that does not close where it is to engage."""


def cross(
    before: Mechanism, after: Mechanism, end: Ending, parameters: Values
) -> tuple[State, Handover, Reconnection]:
    """The state behind the instant at which a joint comes or goes; raises Gap."""
    watched, (t, q, v) = before.description.watched[end.row], _state_by_names(before, after, end)
    impulse, units, lost = dict[str, float](), dict[str, str](), 0.0
    if watched.action == "engage":
        equations = Equations(after, parameter_values(after, known_parameters(after, parameters)))
        _require_closed(equations, watched.target, t, q, end.length)
        rest = v
        try:
            v, multipliers = impact(equations, t, q, rest, _TOUCHING * end.length)
        except Contradiction as found:
            where = f"Joint '{watched.target}' is to engage at t = {t:.9g} s"
            raise Gap(f"{where}, and {found}. Choose another instant, or release it.") from None
        mass = equations.mass(q)
        states = [row.column for row in after.description.states]
        v[states] = rest[states]  # to the last bit
        mass[states, states] = 0.0
        lost = float(rest @ mass @ rest - v @ mass @ v) / 2
        impulse = _impulses(after, equations, watched.target, t, q, v, multipliers)
        rows = [row for row in after.description.reactions if row.element == watched.target]
        units = {row.component: f"{row.unit} s" if row.unit else "" for row in rows}
    start = State(t, q, v, after.description.coordinates)
    discrete = _discrete_by_names(before, after, end.discrete)
    change = Reconnection(t, watched.target, watched.action, impulse, lost, units)
    return start, Handover(discrete, end.length), change


def _discrete_by_names(
    before: Mechanism, after: Mechanism, discrete: Discrete | None
) -> Discrete | None:
    """Clocks and conditions by the tables of another mechanism; None where it has none."""
    old, new = before.description, after.description
    if discrete is None or not (new.sampled or new.watched):
        return None
    known = numbered([row[:3] for row in old.watched])
    held = dict(zip(known, discrete.held.tolist(), strict=True))
    places = {key: k for k, key in enumerate(numbered(old.sampled))}
    rows = np.array([places[key] for key in numbered(new.sampled)], np.int64)
    ticks = discrete.ticks.reshape(-1, 2)[rows]
    return Discrete(
        ticks.ravel(), discrete.waiting[rows],
        np.array([held.get(key, 0.0) for key in numbered([row[:3] for row in new.watched])]),
    )  # fmt: skip


def _state_by_names(
    before: Mechanism, after: Mechanism, end: Ending
) -> tuple[float, FloatArray, FloatArray]:
    """The instant, s, positions and velocities, (n,) each, by the other mechanism's coordinates."""
    q, v = (_by_names(before, after, x) for x in (end.state.q, end.state.v))
    return end.state.t, q, v


def known_parameters(mechanism: Mechanism, parameters: Values) -> Values:
    """Those of the values whose parameters the mechanism has."""
    names = mechanism.description.parameters.names
    return {name: value for name, value in parameters.items() if name in names}


def _by_names(before: Mechanism, after: Mechanism, x: FloatArray) -> FloatArray:
    """A vector (n,) by the coordinates of another mechanism; 0 where there is none of the name."""
    known = {name: k for k, name in enumerate(before.description.coordinates.names)}
    names = after.description.coordinates.names
    return np.array([x[known[name]] if name in known else 0.0 for name in names])


def _require_closed(
    equations: Equations, joint: str, t: float, q: FloatArray, length: float
) -> None:
    rows = equations.description.constraints
    gaps = np.abs(equations.constraints(t, q))
    least = _CLOSED * equations.row_scale(t, q, max(length, equations.size(t, q)))
    open_rows = [
        f"{row.name} by {gap:.3g}"
        for row, gap, most in zip(rows, gaps, least, strict=True)
        if row.element == joint and gap > most
    ]
    if open_rows:
        raise Gap(
            f"Joint '{joint}' is to engage at t = {t:.9g} s, where it is open: "
            f"{', '.join(open_rows)}. Choose a condition under which it closes by itself, or a "
            "joint with fewer constraints."
        )


def _impulses(
    mechanism: Mechanism, equations: Equations, joint: str, t: float, q: FloatArray,
    v: FloatArray, multipliers: FloatArray,
) -> dict[str, float]:  # fmt: skip
    """Component → impulse of a joint, as its reactions follow from multipliers."""
    rows = mechanism.description.reactions
    out = np.zeros(len(rows))
    if "reactions" in mechanism.description.kernels:
        mechanism.kernels.reactions(t, q, v, equations.p, multipliers, out)
    pairs = zip(rows, out.tolist(), strict=True)
    return {row.component: 0.0 + value for row, value in pairs if row.element == joint}
