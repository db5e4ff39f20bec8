"""A run that goes on where another stopped, also past joints that came or went and conditions.

The last part of a run begins at a checkpoint of that part, before steps that its end has cut, and
takes the steps of a run that went through at once: from there on both have the same bits. What
follows has other joints. Past a condition of the scene the run starts anew from its end, with
clocks and conditions as they stand, so that this condition ends it where it begins to hold the next
time.
"""

import time as clock
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.errors import AnalysisError, InputError
from codegen.readers.arguments import count, flag, number, optional, read_arguments
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks.screening import APART
from runtime.dynamics.connected_simulation import follow, known_parameters
from runtime.dynamics.formulations import formulate
from runtime.dynamics.joined_runs import Change, JoinedMotion, joined
from runtime.dynamics.motion_at_instants import SAVED, SimulatedMotion
from runtime.dynamics.output_conditions import run_until
from runtime.dynamics.prepared_simulation import PreparedSimulation, discrete_state
from runtime.dynamics.simulation import run_prepared, simulate_joints
from runtime.integrate.checkpoints import Checkpoint, Checkpoints
from runtime.integrate.problem import STABILIZING, Events, Partitions, Trajectory
from runtime.integrate.sampling import INTERVAL
from runtime.mechanism.dense_equations import FloatArray
from runtime.progress_bar import Progress, bar, silent
from runtime.results.assembled_state import State
from runtime.results.motion_at_instants import Motion, keep
from runtime.results.result import Result
from runtime.validation.arguments import read_instants, uniform

Resumable = SimulatedMotion | JoinedMotion
_READERS = {
    "t_end": number("a finite number of seconds", unit="s"), "t_eval": optional(read_instants),
    "max_steps": optional(count(1)), "progress": flag,
}  # fmt: skip
_LIMITS = {Outcome.OK, Outcome.MAX_STEPS, Outcome.MEMORY, Outcome.INTERRUPTED}


def resume(
    result: Result, motion: Resumable, t_end: Any, t_eval: Any, max_steps: Any, progress: Any
) -> Result:
    """See `Result.resume`."""
    values = {"t_end": t_end, "t_eval": t_eval, "max_steps": max_steps, "progress": progress}
    given = read_arguments(result.description.title, _READERS, values)
    last, t_eval = _span(result, motion, given.pop("t_end"), given.pop("t_eval"))

    def run(t_end: float, t_eval: Any) -> Result:
        return _go_on(result, motion, t_end, t_eval, **given)

    if not result._until:
        return run(last, t_eval)
    return run_until(run, result._until, last, t_eval, motion.span[1], result.ended_by)


def _go_on(
    result: Result, motion: Resumable, t_end: float, t_eval: str | FloatArray,
    max_steps: int | None, progress: bool,
) -> Result:  # fmt: skip
    """The run up to another end, s, with samples at `t_eval`."""
    parts, changes, told = [result], list[Change](), 0
    if isinstance(motion, JoinedMotion):
        parts, changes, told = [*motion.results], [*motion.changes], len(motion.changes)
    last, since = parts[-1], motion.span[1]
    times = None if isinstance(t_eval, str) else t_eval
    own = last._motion
    assert isinstance(own, SimulatedMotion)
    mechanism, parameters, options = own.ready.mechanism, dict(result.parameters), own.options
    past = last.ended_by in {row.name for row in mechanism.description.watched}
    if max_steps is not None:
        before = parts if past else parts[:-1]
        done = sum(int(part.stats["steps"] + part.stats["rejected"]) for part in before)
        max_steps = max(1, max_steps - done)
    settings = {name: getattr(options, name) for name in SAVED} | {
        "formulation": own.coordinates.name, "max_steps": max_steps,
        "controllers": own.ready.given["controllers"],
    }  # fmt: skip
    with bar(f"resume {result.description.title}", progress) as report:
        if past:
            run = simulate_joints(
                mechanism, t_end, t_eval, progress=report, start=_end_of(last, own),
                length=own.ready.length, parameters=known_parameters(mechanism, parameters),
                **settings,
            )  # fmt: skip
        else:
            run = _resume_part(last, own, t_end, times, max_steps, report)
    if past:
        changes.append(())
    else:
        parts.pop()
    parts.append(run)
    begun, first = len(parts), parts[0]._motion
    assert first is not None
    span = t_end - float(first.span[0])
    follow(parts, changes, mechanism, t_end, t_eval, span, parameters=parameters, **settings)
    if len(parts) == 1:
        return run
    found = joined(parts, changes, since, told)
    if times is not None:
        asked = np.isin(found.t, times)
        asked[-1:] |= found.failed or bool(found.ended_by)
        keep(found, asked, since, np.inf)
    if len(parts) > begun or past:
        found.message = f"Resumed at t = {since:.9g} s. {found.message}"
    return found


def _end_of(result: Result, motion: SimulatedMotion) -> State:
    """The state in which a run ended, with its clocks and conditions."""
    samples, end, ready = result.samples, motion.end, motion.ready
    if result._chosen or not len(samples.t) or samples.t[-1] != end:
        samples, _ = motion.at(result, np.array([end]))
    clocks = discrete_state(ready.mechanism, ready.p, motion.last)
    table = ready.mechanism.description.coordinates
    return State(end, samples.q[-1], samples.v[-1], table, discrete=clocks)


def _resume_part(
    result: Result, motion: SimulatedMotion, t_end: float, times: FloatArray | None,
    max_steps: int | None, progress: Progress,
) -> Result:  # fmt: skip
    """A run with one set of joints up to another end, s; see `Result.resume`."""
    began, first, old = clock.perf_counter(), motion.end, motion.options
    ready = motion.ready.until(t_end)
    coordinates = formulate(ready, motion.coordinates.name, old.method, old.correction)
    works = bool(result.works)
    options = replace(old, t_eval=times, quadrature=works, max_steps=max_steps)
    if works:
        options = replace(options, t_eval=np.union1d([first], [] if times is None else times))
    if ready.controllers and old.correction in STABILIZING:
        span = motion.ready.t_end - motion.ready.begin.t
        options = replace(options, time_scale=old.baumgarte_time(span))
    rows, why = _alike(result, motion, ready)
    kept, span = rows[-1] if rows else None, max(t_end - first, 1e-300)
    made = Checkpoints(rows, motion.checkpoints.spacing)
    run = coordinates.run(
        options, made, kept, motion.known(result, kept) if kept else None,
        lambda t, _: progress(max(0.0, (t - first) / span)),
    )  # fmt: skip
    end = run.final_t, run.samples_taken, run.discrete
    new = SimulatedMotion(coordinates, options, made, *end)
    done = new.works_from(kept, run, first) if works else None
    # An event at the very end of a run may come a little later in a longer one, as of a law.
    told, ended = first, [event for event in result.events if event.time == first]
    if ended:
        told += APART * max(map(abs, (*motion.span, t_end)))
    path = _behind(run, kept, first, told, times, works)._replace(checkpoints=made)
    plain = replace(options, t_eval=times, quadrature=False)
    found = run_prepared(coordinates, plain, began, silent, path, works=False)
    if done is not None:
        _add_works(found, result, motion, *done)
    found.message = f"Resumed at t = {first:.9g} s{why}. {found.message}"
    return found


def _span(
    result: Result, motion: Motion, last: float, chosen: Any
) -> tuple[float, str | FloatArray]:
    """The new end, s, and the instants of the samples, or "steps"."""
    title, end = result.description.title, motion.span[1]
    if result.accuracy is not None:
        raise InputError(
            f"{title}: an accuracy is that of a whole run, and this result has one. Simulate anew "
            f"up to t_end = {last:g} s with this accuracy."
        )
    if result.outcome not in _LIMITS:
        raise AnalysisError(
            f"{title}: the run ended at t = {end:.9g} s ({result.outcome}), and goes on "
            f"there no more than it did before. {result.outcome.advice}"
        )
    if last <= end:
        raise InputError(
            f"{title}: t_end = {last:g} s must lie after t = {end:.9g} s, where the run "
            "stopped; `at` has all instants before."
        )
    if isinstance(chosen, str):
        return last, chosen
    times = uniform(end, last, chosen) if not isinstance(chosen, np.ndarray) else chosen
    if not end <= times[0] <= times[-1] <= last:
        raise InputError(
            f"{title}: t_eval goes from {times[0]:g} to {times[-1]:g} s; the run that goes on "
            f"lies between t = {end:.9g} s and {last:g} s."
        )
    return last, times


def _alike(
    result: Result, motion: SimulatedMotion, ready: PreparedSimulation
) -> tuple[list[Checkpoint], str]:
    """Checkpoints that the run to the later end has too; why the others are left, else empty.

    What follows from the whole span of a run is another from its start on: Baumgarte's time, and
    the instants at which steps meet the explicit functions of time.
    """
    kept, old, taken = motion.checkpoints, motion.ready, motion.options
    end = motion.end if result.outcome is Outcome.OK else np.inf
    rows = kept.until(end)
    same, why = rows, ""
    if ready.t_end == old.t_end:
        return rows, ""
    if taken.correction in STABILIZING and taken.time_scale is None:
        same, why = [], "Baumgarte's time, unless time_scale= is given, follows"
    elif ready.passages is not None and old.passages is not None:
        alike = ready.passages.agrees_until(old.passages)
        same = kept.until(min(end, alike)) if ready.begin.t == old.begin.t else []
        why = "instants at which steps meet explicit functions of time follow"
    if len(same) == len(rows):
        return rows, ""
    if ready.controllers:
        return rows, (
            f", to the tolerance and not bit for bit, as {why} from the whole run, and functions "
            "with a memory, as yours may have, cannot be asked again"
        )
    since = same[-1].t if same else ready.begin.t
    return same, f", taken again from t = {since:.9g} s on, as {why} from the whole run"


def _behind(
    run: Trajectory, kept: Checkpoint | None, first: float, told: float,
    times: FloatArray | None, works: bool,
) -> Trajectory:  # fmt: skip
    """What a run did from an instant on, events after `told`; samples at `times`, None: steps."""
    rows = np.arange(len(run.t))
    if works:  # of a quadrature the ends of intervals; from a checkpoint there is no first one
        rows = rows[0 if kept is None else INTERVAL - 1 :: INTERVAL]
    ends = run.t[rows]
    rows = rows[ends >= first if times is None else np.isin(ends, times)]
    log, sets = run.events, run.partitions
    later, since = log.t > told, max(int(np.searchsorted(sets.t, first, side="right")) - 1, 0)
    return run._replace(
        t=run.t[rows], q=run.q[rows], v=run.v[rows], modes=run.modes[rows], first_t=first,
        events=Events(*(column[later] for column in vars(log).values())),
        partitions=Partitions(np.maximum(sets.t[since:], first), sets.independent[since:]),
        crossings=tuple(crossing for crossing in run.crossings if crossing.t > first),
    )  # fmt: skip


def _add_works(
    found: Result, result: Result, motion: SimulatedMotion, ends: FloatArray,
    totals: dict[str, FloatArray],
) -> None:  # fmt: skip
    """Works since the start of the first run; those of a state in which it stopped are unknown."""
    _, before = motion.at(result, np.array([motion.end]))
    places = np.searchsorted(ends, found.t)
    known = places < len(ends)
    for name, total in totals.items():
        work = np.full(len(found.t), np.nan)
        work[known] = before[name][0] + total[places[known]]
        found.works[name] = work
        found.work_at_end[name] = float(before[name][0] + total[-1])
