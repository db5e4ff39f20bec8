"""Simulations in which joints come and go: one run after the other, each with those that act.

Every set of joints is a scene of its own, with its own module, coordinates and partition. A run
ends where a joint is released or engages, and the next begins there. Positions and velocities stay,
but for velocities that a joint which engages does not permit: these end in an impact of all
constraints, M Δv + Φ_qᵀ Λ = Gᵀ P, Φ_q (v + Δv) = ν, in which closed contacts and freewheels take
part by their impulses P ≥ 0.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError
from runtime.core.outcomes import Outcome
from runtime.dynamics.continued_state import numbered
from runtime.dynamics.joined_results import joined
from runtime.dynamics.motion_at_instants import SimulatedMotion
from runtime.dynamics.prepared_simulation import Handover
from runtime.dynamics.simulation import simulate_joints
from runtime.integrate.problem import Discrete
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.one_sided_impact import Contradiction, impact
from runtime.mechanism.sibling_scenes import sibling
from runtime.results.assembled_state import Assembly, State
from runtime.results.result import Result
from runtime.results.run_records import Ending, Reconnection
from runtime.results.samples import Samples
from runtime.validation.output_instants import uniform
from runtime.validation.parameters import parameter_values

_MOST = 10_000  # safety: changes of joints in a run
_AT_ONCE = 16  # safety: changes of joints at one instant
_IN_A_ROW, _SHORT = 64, 1e-5  # safety: so many changes within that part of a run have no end
# accuracy: of the machine's lengths; a contact with a gap below it is closed
_TOUCHING = 1e-9
_CLOSED = 1e-6  # safety: of the size of its equation; a joint further open does not engage


def simulate(
    mechanism: Mechanism, t_end: float, t_eval: Any = None, *,
    part: Callable[..., Result] = simulate_joints, **settings: Any,
) -> Result:  # fmt: skip
    """Integrate the equations of motion, with other joints from where these come or go.

    `part` makes the run of one set of joints, with these settings.
    """
    if not any(row.reconnects for row in mechanism.description.watched):
        return part(mechanism, t_end, t_eval, **settings)
    start = settings.get("start")
    first = start.t if isinstance(start, Assembly | State) else settings.get("t_start", 0.0)
    if (t_eval is None or isinstance(t_eval, int)) and first <= t_end:
        t_eval = uniform(first, t_end, t_eval)
    parameters = dict(settings.pop("parameters", None) or {})
    idle = mechanism.description.unused  # some scenes that follow may depend on them
    values = {name: value for name, value in parameters.items() if name not in idle}
    results = [part(mechanism, t_end, t_eval, parameters=values, **settings)]
    changes = list[Reconnection | None]()
    settings |= {"parameters": parameters}
    follow(results, changes, mechanism, t_end, t_eval, t_end - first, part=part, **settings)
    if len(results) == 1:
        return results[0]
    found, motion = joined(results, changes), results[0]._motion
    if isinstance(motion, SimulatedMotion):  # what became of the start
        found.message += motion.ready.note
    return found


def follow(
    results: list[Result], changes: list[Reconnection | None], mechanism: Mechanism, t_end: float,
    t_eval: Any, span: float, *, parameters: Values, part: Callable[..., Result] = simulate_joints,
    **settings: Any,
) -> None:  # fmt: skip
    """Append the runs that follow the last of the results, with other joints, and the changes.

    `mechanism` is that of the last one, `span` the time of the whole run, s.
    """
    while True:
        run = results[-1]
        end = run.reconnection
        if end is None or run.outcome is not Outcome.OK or end.state.t >= t_end:
            return
        passed = [change for change in changes if change is not None]
        if _endless(passed, end.state.t, span):
            _end_at_change(run, Outcome.ZENO, _without_end(passed))
            return
        after = sibling(mechanism, mechanism.description.watched[end.row])
        try:
            begin, handover, change = cross(mechanism, after, end, parameters)
        except Gap as gap:
            _end_at_change(run, Outcome.INCONSISTENT, str(gap))
            return
        mechanism, values = after, dict(known_parameters(after, parameters))
        settings |= {"start": begin, "handover": handover, "guess": None, "t_start": 0.0}
        if settings.get("max_steps"):
            done = run.stats["steps"] + run.stats["rejected"]
            settings["max_steps"] = max(1, int(settings["max_steps"] - done))
        instants, none_left = _later(t_eval, change.time, t_end)
        try:
            run = part(mechanism, t_end, instants, parameters=values, **settings)
        except LinkwrightError as error:
            _end_at_change(results[-1], Outcome.INCONSISTENT, f"{change} {error}")
            return
        if none_left and run.outcome is Outcome.OK and not run.ended_by:
            run.samples = Samples._make(array[:0] for array in run.samples)
            run.works = {name: work[:0] for name, work in run.works.items()}
        results.append(run)
        changes.append(change)


def _end_at_change(run: Result, outcome: Outcome, message: str) -> None:
    """Let a run end where a joint should have come or gone, with the state there."""
    end = run.reconnection
    assert end is not None
    motion, late = run._motion, not len(run.t) or run.t[-1] < end.state.t
    if motion is not None and late:
        row, works = motion.at(run, np.array([end.state.t]))
        run.samples = Samples._make(map(np.concatenate, zip(run.samples, row, strict=True)))
        run.works = {name: np.append(work, works[name]) for name, work in run.works.items()}
    run.outcome, run.message = outcome, message


def _later(t_eval: Any, change: float, t_end: float) -> tuple[Any, bool]:
    """The instants behind a change, s, and whether there are none but the end."""
    if not isinstance(t_eval, np.ndarray | list | tuple):
        return t_eval, False
    times: npt.NDArray[np.float64] = np.asarray(t_eval, dtype=np.float64)
    later = times[times > change]
    return (later, False) if len(later) else (np.array([t_end]), True)


def _endless(changes: list[Reconnection], t: float, span: float) -> bool:
    """Whether joints come and go for ever at the instant `t` of a run over a `span`, s."""
    at_once = len(changes) > _AT_ONCE and changes[-1 - _AT_ONCE].time == t
    in_a_row = len(changes) >= _IN_A_ROW and t - changes[-_IN_A_ROW].time < _SHORT * span
    return at_once or in_a_row or len(changes) >= _MOST


def _without_end(changes: list[Reconnection]) -> str:
    last = changes[-1]
    return (
        f"Stopped at t = {last.time:.9g} s. Joints come and go without end, {len(changes)} times, "
        f"the last '{last.joint}': each change makes the condition of the next one hold. Leave a "
        "margin between the conditions under which a joint engages and is released."
    )


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
