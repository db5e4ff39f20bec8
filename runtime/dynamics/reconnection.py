"""The instant at which a joint is released or engages.

Positions and velocities stay, but for velocities that a joint which engages does not permit: these
end in an impact of all constraints, M Δv + Φ_qᵀ Λ = 0, Φ_q (v + Δv) = ν.
"""

import numpy as np

from runtime.integrate.problem import Memory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.table_rows import Watched
from runtime.results.assembled_state import State
from runtime.results.reconnection import Reconnection
from runtime.validation.parameters import parameter_values

_CLOSED = 1e-6  # safety: of the machine's size; a joint further open than this does not engage


class Gap(Exception):  # noqa: N818 (it is caught where runs follow one another)
    """A joint that does not close where it is to engage."""


def cross(
    before: Mechanism, after: Mechanism, watched: Watched, end: State, parameters: Values
) -> tuple[State, Reconnection]:
    """The state behind the instant at which a condition ended a run; raises Gap."""
    q, v = (_by_names(before, after, x) for x in (end.q, end.v))
    impulse, lost = dict[str, float](), 0.0
    if watched.action == "engage":
        equations = Equations(after, parameter_values(after, known_parameters(after, parameters)))
        _require_closed(equations, watched.target, end.t, q)
        rest = v
        v, multipliers = impact(equations, end.t, q, rest)
        mass = equations.mass(q)
        states = [row.column for row in after.description.states]
        v[states] = rest[states]  # to the last bit
        mass[states, states] = 0.0
        lost = float(rest @ mass @ rest - v @ mass @ v) / 2
        impulse = _impulses(after, equations, watched.target, end.t, q, v, multipliers)
    start = State(end.t, q, v, after.description.coordinates)
    return start, Reconnection(end.t, watched.target, watched.action, impulse, lost)


def carried(before: Mechanism, after: Mechanism, memory: Memory | None) -> Memory | None:
    """What clocks and conditions remember, by the values and conditions of another mechanism.

    Conditions that end runs and change joints are judged anew.
    """
    if memory is None:
        return None
    known, table = before.description.sampled, after.description
    places = [known.index(name) if name in known else -1 for name in table.sampled]
    ticks = [memory.ticks[2 * k : 2 * k + 2] if k >= 0 else np.zeros(2, np.int64) for k in places]
    waiting = tuple(memory.waiting[k] if k >= 0 else np.zeros(0) for k in places)
    held = dict(zip(_renewing(before), memory.held.tolist(), strict=True))
    now = [held[key] if key in held and key[0] else 0.0 for key in _renewing(after)]
    return Memory(np.array(ticks, np.int64).ravel(), waiting, np.array(now))


def _renewing(mechanism: Mechanism) -> list[tuple[str, int]]:
    """Of each condition the value that it renews, and which of that value's it is; others ""."""
    names = [row.target if row.action == "sample" else "" for row in mechanism.description.watched]
    return [(name, names[:k].count(name)) for k, name in enumerate(names)]


def known_parameters(mechanism: Mechanism, parameters: Values) -> Values:
    """Those of the values whose parameters the mechanism has."""
    names = mechanism.description.parameters.names
    return {name: value for name, value in parameters.items() if name in names}


def _by_names(before: Mechanism, after: Mechanism, x: FloatArray) -> FloatArray:
    """A vector (n,) by the coordinates of another mechanism; 0 where there is none of the name."""
    known = {name: k for k, name in enumerate(before.description.coordinates.names)}
    names = after.description.coordinates.names
    return np.array([x[known[name]] if name in known else 0.0 for name in names])


def impact(
    equations: Equations, t: float, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Velocities after an impact of all constraints, (n,), and its impulses Λ, (m,)."""
    n, jacobian = equations.n, equations.jacobian(t, q)
    m = len(jacobian)
    matrix = np.block([[equations.mass(q), jacobian.T], [jacobian, np.zeros((m, m))]])
    right = np.concatenate([np.zeros(n), equations.velocity_rhs(t, q) - jacobian @ v])
    change = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return v + change[:n], change[n:]


def _require_closed(equations: Equations, joint: str, t: float, q: FloatArray) -> None:
    rows = equations.description.constraints
    gaps = np.abs(equations.constraints(t, q))
    open_rows = [
        f"{row.name} by {gap:.3g}"
        for row, gap in zip(rows, gaps, strict=True)
        if row.element == joint and gap > _CLOSED * max(1.0, float(np.abs(q).max(initial=0.0)))
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
    return {row.component: value for row, value in pairs if row.element == joint}
