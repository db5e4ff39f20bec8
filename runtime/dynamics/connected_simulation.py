"""Simulations in which joints come and go: one run after the other, each with those that act.

Every set of joints is a scene of its own, with its own module, coordinates and partition. A run
ends where joints are released or engage, all those whose conditions begin to hold at one instant,
and the next begins there. Positions and velocities stay, but for velocities that a joint which
engages does not permit: these end in one impact of all constraints of the new set, M Δv + Φ_qᵀ Λ =
Gᵀ P, Φ_q (v + Δv) = ν, in which closed contacts and freewheels take part by their impulses P ≥ 0.
What an impact makes true is a change of its own, at the same instant. The runs have one result, in
the tables of all their machines.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from codegen.errors import LinkwrightError, ModelError
from codegen.object_display import without_rounding
from runtime.assembly.mirrored_joints import mirrored_joints
from runtime.assembly.regular_start import place_counted
from runtime.core.outcomes import Outcome
from runtime.dynamics.joined_runs import Change, joined
from runtime.dynamics.motion_at_instants import SimulatedMotion
from runtime.dynamics.simulation import simulate_joints
from runtime.mechanism.dense_equations import Contradiction, Equations, FloatArray, impact
from runtime.mechanism.mechanism import Mechanism, Numbers, sibling, sibling_named
from runtime.results.assembled_state import Assembly, State
from runtime.results.result import Result
from runtime.results.run_records import Ending, Reconnection, sentences
from runtime.results.samples import Samples
from runtime.validation.arguments import parameter_values, uniform

_MOST = 10_000  # safety: changes of joints in a run
_AT_ONCE = 16  # safety: changes at one instant, each of all joints that come or go
_IN_A_ROW, _SHORT = 64, 1e-5  # safety: so many changes in this part of a run never end
_CLOSED = 1e-6  # safety: of the size of its equation; a joint that is open by more does not engage


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
    changes = list[Change]()
    settings |= {"part": part, "parameters": parameters}
    follow(results, changes, mechanism, t_end, t_eval, t_end - first, **settings)
    if len(results) == 1:
        return results[0]
    found, motion = joined(results, changes), results[0]._motion
    found.message += motion.ready.note if isinstance(motion, SimulatedMotion) else ""
    return found


def follow(
    results: list[Result], changes: list[Change], mechanism: Mechanism, t_end: float,
    t_eval: Any, span: float, *, parameters: Numbers, part: Callable[..., Result] = simulate_joints,
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
        if endless := _without_end([*filter(None, changes)], end.state.t, span):
            _end_at_change(run, Outcome.ZENO, endless)
            return
        try:
            after = sibling(mechanism, (row.target for row in end.rows))
            begin, change = cross(mechanism, after, end, parameters)
        except Gap as gap:
            _end_at_change(run, Outcome.INCONSISTENT, str(gap))
            return
        except ModelError as error:
            why = f"{_what_changes(end)}, and the joints that act then form no machine: {error}"
            remedy = "Or let another joint be released by the same condition."
            _end_at_change(run, Outcome.INCONSISTENT, f"{why} {remedy}")
            return
        mechanism, values = after, known_parameters(after, parameters)
        settings |= {"start": begin, "length": end.length, "guess": None, "t_start": 0.0}
        if settings.get("max_steps"):
            done = run.stats["steps"] + run.stats["rejected"]
            settings["max_steps"] = max(1, int(settings["max_steps"] - done))
        instants, none_left = t_eval, False
        if isinstance(t_eval, np.ndarray | list | tuple):
            times: FloatArray = np.asarray(t_eval, dtype=np.float64)
            instants = times[times > begin.t]
            none_left = not len(instants)
        try:
            run = part(
                mechanism, t_end, np.array([t_end]) if none_left else instants, parameters=values,
                **settings,
            )  # fmt: skip
        except LinkwrightError as error:
            _end_at_change(results[-1], Outcome.INCONSISTENT, f"{sentences(change)} {error}")
            return
        if none_left and run.outcome is Outcome.OK and not run.ended_by:
            run.samples = run.samples.at(slice(0))
            run.works = {name: work[:0] for name, work in run.works.items()}
        results.append(run)
        changes.append(change)


def _end_at_change(run: Result, outcome: Outcome, message: str) -> None:
    """Let a run end where a joint should have come or gone, with the state there."""
    end, motion = run.reconnection, run._motion
    assert end is not None
    if motion is not None and (not len(run.t) or run.t[-1] < end.state.t):
        row, works = motion.at(run, np.array([end.state.t]))
        run.samples = Samples.joined([run.samples, row])
        run.works = {name: np.append(work, works[name]) for name, work in run.works.items()}
    run.outcome, run.message = outcome, message


def _without_end(changes: list[Change], t: float, span: float) -> str:
    """That joints come and go for ever at the instant `t` of a run over a `span`, s; else empty."""
    count = len(changes)
    at_once = count >= _AT_ONCE and changes[-_AT_ONCE][0].time == t
    in_a_row = count >= _IN_A_ROW and t - changes[-_IN_A_ROW][0].time < _SHORT * span
    if not (at_once or in_a_row or count >= _MOST):
        return ""
    last = changes[-1][-1]
    return (
        f"Stopped at t = {last.time:.9g} s. Joints come and go without end, {count} times, "
        f"the last '{last.joint}': each change makes the condition of the next one hold. "
        "Leave a margin between the conditions under which a joint engages and is released."
    )


class Gap(Exception):  # noqa: N818 (it is caught where runs follow one another)
    """A joint that does not close where it is to engage."""


def cross(
    before: Mechanism, after: Mechanism, end: Ending, parameters: Numbers
) -> tuple[State, Change]:
    """The state behind the instant at which joints come or go; raises Gap."""
    description, engaged = after.description, [r.target for r in end.rows if r.action == "engage"]
    t, was = end.state.t, before.description.coordinates.names
    known = [was.index(name) if name in was else -1 for name in description.coordinates.names]
    q, v = (np.append(x, 0.0)[known] for x in (end.state.q, end.state.v))
    impulses = {row.target: (dict[str, float](), dict[str, str]()) for row in end.rows}
    lost = 0.0
    if engaged:
        equations = Equations(after, parameter_values(after, known_parameters(after, parameters)))
        _count(equations, t, q, v, known)
        _require_closed(equations, engaged, t, q, end.length)
        rest = v
        try:
            v, multipliers, work = impact(equations, t, q, rest, end.length)
        except Contradiction as found:
            where = f"{_what_changes(end)}, and {found}"
            raise Gap(f"{where}. Choose another instant, or release it.") from None
        states = [row.column for row in description.states]
        v[states] = rest[states]  # to the last bit
        if not without_rounding(np.abs([v - rest, rest]).max(axis=1, initial=0.0))[0]:
            v, multipliers, work = rest, np.zeros_like(multipliers), 0.0
        lost = float((rest - v) @ equations.mass(q) @ (rest + v)) / 2 + work
        reactions = np.zeros(len(description.reactions))
        if "reactions" in description.kernels:
            after.kernels.reactions(t, q, v, equations.p, multipliers, reactions)
        for row, value in zip(description.reactions, reactions.tolist(), strict=True):
            if row.element in engaged:
                impulse, units = impulses[row.element]
                impulse[row.component] = 0.0 + value
                units[row.component] = f"{row.unit} s" if row.unit else ""
    change, mirrored = [], mirrored_joints(description, q)
    for _, action, joint, _ in end.rows:
        impulse, units = impulses[joint]
        own, opposite = lost if joint in engaged[:1] else 0.0, joint in mirrored
        change.append(Reconnection(t, joint, action, impulse, own, units, opposite))
    start = State(t, q, v, description.coordinates, discrete=end.state.discrete)
    return start, tuple(change)


def _count(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, known: Sequence[int]
) -> None:
    """Let joints that engage count from where their bodies stand; -1 in `known` is new."""
    made, counted = equations.start, equations.mechanism.shape["counted"]
    made.arrays["ease_q"][:] = np.where(np.less(known, 0) & (counted > 0), np.inf, 1.0)
    place_counted(made.table, t, equations.p, q)
    for column in np.flatnonzero(made.arrays["ease_q"] > 1.0):
        slopes = equations.jacobian(t, q)[counted[column] - 1]
        v[column] = -(slopes @ v) / slopes[column]


def _what_changes(end: Ending) -> str:
    """Which joints are to come or go, and when."""
    words = {"engage": "engage", "release": "be released"}
    joints = [f"'{row.target}' is to {words[row.action]}" for row in end.rows]
    return f"Joint {' and '.join(joints)} at t = {end.state.t:.9g} s"


def known_parameters(mechanism: Mechanism, parameters: Numbers) -> dict[str, float]:
    """Those of the values whose parameters the mechanism has."""
    names = mechanism.description.parameters.names
    return {name: value for name, value in parameters.items() if name in names}


def _require_closed(
    equations: Equations, joints: Sequence[str], t: float, q: FloatArray, length: float
) -> None:
    gaps = np.abs(equations.constraints(t, q))
    least = _CLOSED * equations.row_scale(t, q, max(length, equations.size(t, q)))
    open_rows = [
        (row, f"{row.name} by {gap:.3g}")
        for row, gap, most in zip(equations.description.constraints, gaps, least, strict=True)
        if row.element in joints and gap > most
    ]
    if open_rows:
        raise Gap(
            f"Joint '{open_rows[0][0].element}' is to engage at t = {t:.9g} s, where it is open: "
            f"{', '.join(text for _, text in open_rows)}. Choose a condition under which it closes "
            "by itself, or a joint with fewer constraints."
        )
    mirrored = mirrored_joints(equations.description, q, keeping=True)
    if turned := [joint for joint in mirrored if joint in joints]:
        raise Gap(
            f"Joint '{turned[0]}' is to engage at t = {t:.9g} s, where its bodies are turned by "
            "half a turn against the drawing. Choose another instant, or draw it as it engages."
        )


def scene_of_start(mechanism: Mechanism, start: object) -> Mechanism:
    """The mechanism with the joints that act in the state `start`, where these come and go.

    A state of any other scene, and values by name, leave the mechanism as it is.
    """
    state = start.state() if isinstance(start, Result) else start
    scene = state.scene if isinstance(state, State) else ""
    return sibling_named(mechanism, scene) or mechanism


def parameters_there(
    there: Mechanism, mechanism: Mechanism, parameters: Numbers | None
) -> Numbers | None:
    """Numbers of the parameters of `mechanism`, without those that only its other scenes need.

    `there` is the mechanism of the scene in which a run begins.
    """
    changes = any(row.reconnects for row in there.description.watched)
    if not parameters or there is mechanism or changes:
        return parameters
    idle = {*there.description.unused} - {*mechanism.description.unused}
    return {name: value for name, value in parameters.items() if name not in idle}
