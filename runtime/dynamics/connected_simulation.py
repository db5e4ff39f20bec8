"""Simulations in which joints come and go: one run after the other, each with those that act.

Every set of joints is a scene of its own, with its own module, coordinates and partition. A run
ends where a joint is released or engages, and the next begins there.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError
from runtime.core.outcomes import Outcome
from runtime.dynamics.joined_results import joined
from runtime.dynamics.motion_at_instants import SimulatedMotion
from runtime.dynamics.reconnection import Gap, cross, known_parameters
from runtime.dynamics.simulation import simulate as simulate_once
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.sibling_scenes import sibling
from runtime.results.assembled_state import Assembly, State
from runtime.results.reconnection import Reconnection
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.validation.output_instants import uniform

_MOST = 10_000  # safety: changes of joints in a run
_AT_ONCE = 16  # safety: changes of joints at one instant
_IN_A_ROW, _SHORT = 64, 1e-5  # safety: so many changes within that part of a run have no end


def simulate(
    mechanism: Mechanism, t_end: float, t_eval: Any = None, *,
    part: Callable[..., Result] = simulate_once, **settings: Any,
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
    t_eval: Any, span: float, *, parameters: Values, part: Callable[..., Result] = simulate_once,
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
