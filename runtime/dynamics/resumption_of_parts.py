"""Simulations that go on where joints came or went, or where a condition ended them.

The last part of a run goes on as a run of its own does, with the same bits; what follows has other
joints. Past a condition of the scene the run starts anew from its end, with clocks and conditions
as they stand, so that this condition ends it where it begins to hold the next time.
"""

from typing import Any

import numpy as np

from codegen.readers.arguments import count, flag, optional, read_arguments
from runtime.core.outcomes import Outcome
from runtime.dynamics.connected_simulation import follow
from runtime.dynamics.joined_results import JoinedMotion, joined
from runtime.dynamics.motion_at_instants import SimulatedMotion
from runtime.dynamics.output_conditions import end_next_time
from runtime.dynamics.prepared_simulation import Handover
from runtime.dynamics.reconnection import known_parameters
from runtime.dynamics.resumption import read_span
from runtime.dynamics.resumption import resume as resume_part
from runtime.dynamics.simulation import simulate
from runtime.mechanism.dense_equations import FloatArray
from runtime.progress_bar import bar
from runtime.results.assembled_state import State
from runtime.results.reconnection import Reconnection
from runtime.results.result import Result
from runtime.results.result_restriction import keep

Resumable = SimulatedMotion | JoinedMotion


def resume(
    result: Result, motion: Resumable, t_end: Any, t_eval: Any, max_steps: Any, progress: Any
) -> Result:
    """See `Result.resume`."""
    others = {"max_steps": optional(count(1)), "progress": flag}
    values = {"max_steps": max_steps, "progress": progress}
    given = read_arguments(result.description.title, others, values)
    last, times = read_span(result, motion, t_end, t_eval)
    whole = _go_on(result, motion, last, times, **given)
    whole._until = result._until
    found = end_next_time(whole, motion.span[1], result.ended_by) if result._until else None
    if found is None:
        return whole
    name, end = found
    if times is not None:
        times = np.append(times[times < end], end)
    again = _go_on(result, motion, end, times, **given)
    again._until = result._until
    if again.outcome is Outcome.OK:
        again.ended_by = name
        again.message = f"Ended at t = {end:.9g} s, where '{name}' began to hold. {again.message}"
    return again


def _go_on(
    result: Result, motion: Resumable, t_end: float, times: FloatArray | None,
    max_steps: int | None, progress: bool,
) -> Result:  # fmt: skip
    """The run up to another end, s, with samples at `times`, None: the ends of steps."""
    parts, changes = [result], list[Reconnection | None]()
    if isinstance(motion, JoinedMotion):
        parts, changes = list(motion.results), list(motion.changes)
    last, since, t_eval = parts[-1], motion.span[1], "steps" if times is None else times
    own = last._motion
    assert isinstance(own, SimulatedMotion)
    mechanism, parameters = own.ready.mechanism, dict(result.parameters)
    past = last.ended_by in {row.name for row in mechanism.description.watched}
    if max_steps is not None:
        before = parts if past else parts[:-1]
        max_steps = max(1, max_steps - sum(map(_trials, before)))
    settings = _settings(own, max_steps)
    if past:
        start = {
            "start": _end_of(last, own), "handover": Handover(own.last, own.ready.length),
            "parameters": dict(known_parameters(mechanism, parameters)),
        }  # fmt: skip
        with bar(f"resume {result.description.title}", progress) as report:
            run = simulate(mechanism, t_end, t_eval, progress=report, **settings | start)
        parts, changes = [*parts, run], [*changes, None]
    else:
        run = resume_part(last, own, t_end, t_eval, max_steps, progress)
        parts[-1] = run
    span = t_end - float(parts[0]._motion.span[0])  # type: ignore[union-attr]
    begun = len(parts)
    follow(parts, changes, mechanism, t_end, t_eval, span, parameters=parameters, **settings)
    if len(parts) == 1:
        return run
    found = joined(parts, changes, since)
    if times is not None:
        asked = np.isin(found.t, times)
        asked[-1:] |= found.failed or bool(found.ended_by)
        keep(found, asked, since, np.inf)
    if len(parts) > begun or past:
        found.message = f"Resumed at t = {since:.9g} s. {found.message}"
    return found


def _trials(part: Result) -> int:
    return int(part.stats["steps"] + part.stats["rejected"])


def _settings(motion: SimulatedMotion, max_steps: int | None) -> dict[str, Any]:
    """The words of `simulate` for the settings of a run."""
    options = motion.options
    return {
        "method": options.method, "rtol": options.rtol, "atol": options.atol_q,
        "correction": options.correction, "formulation": motion.coordinates.name,
        "time_scale": options.time_scale, "first_step": options.first_step,
        "max_step": options.h_max, "max_steps": max_steps, "max_bytes": options.max_bytes,
        "step_limit": options.step_limit, "controllers": motion.ready.given["controllers"],
    }  # fmt: skip


def _end_of(result: Result, motion: SimulatedMotion) -> State:
    """The state in which a run ended."""
    samples, end = result.samples, motion.end
    if result._chosen or not len(samples.t) or samples.t[-1] != end:
        samples, _ = motion.at(result, np.array([end]))
    table = motion.ready.mechanism.description.coordinates
    return State(end, samples.q[-1], samples.v[-1], table)
