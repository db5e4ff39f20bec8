"""Dynamics: how the machine moves under the forces that act on it, with one set of joints.

From a call of `Machine.simulate` (runtime.machine_facade) to its result:

read       arguments                 → plain values        (runtime.validation.arguments)
follow     joints that come and go   → a run of each set   (runtime.dynamics.connected_simulation)
prepare    Mechanism, values         → PreparedSimulation  (runtime.dynamics.prepared_simulation,
                                                           runtime.assembly.assemble)
formulate  PreparedSimulation        → Coordinates         (runtime.dynamics.formulations)
integrate  Coordinates, Options      → Trajectory          (runtime.integrate.run): of this
  set up   System, Problem, Options  → the table by which compiled code reaches kernels and arrays
                                                           (runtime.integrate.run_state, .wiring)
  start    table                     → modes, derivative and first length of a step
                                                           (runtime.integrate.initialization)
  advance  table                     → accepted steps      (runtime.integrate.loop, .step,
                                                           .step_acceptance; its stages call
                                                           runtime.core.state_derivative)
jam        Trajectory                → its end, where friction jams or a machine locks up
                                                           (runtime.dynamics.checks.jamming)
evaluate   Trajectory                → Samples, works      (runtime.dynamics.output_quantities)
screen     Samples, Trajectory       → Suspicions          (runtime.dynamics.checks.screening)
check      Suspicions                → what contradicts OK (runtime.dynamics.checks.end_checks)

With an accuracy target, runtime.accuracy_target makes several such runs.
"""

import time as clock
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.object_display import counted
from runtime.assembly.redundancy import redundancy_note
from runtime.continuation.singular_position_messages import describe_crossings
from runtime.core.kinds import KNOTS
from runtime.core.outcomes import Outcome, Site
from runtime.dynamics.checks.end_checks import check_result, describe_unresolved_switches
from runtime.dynamics.checks.frictions_at_rest import name_held_frictions
from runtime.dynamics.checks.jamming import describe_jam, end_at_jam
from runtime.dynamics.checks.kinks import end_at_kink
from runtime.dynamics.checks.screening import screen_run
from runtime.dynamics.formulations import Coordinates, ReducedCoordinates, formulate
from runtime.dynamics.impulses import with_impulses
from runtime.dynamics.motion_at_instants import SimulatedMotion
from runtime.dynamics.output_quantities import evaluate, integrate_works
from runtime.dynamics.prepared_simulation import PreparedSimulation, discrete_state
from runtime.integrate.problem import WAITS, Correction, Formulation, Options, Trajectory
from runtime.mechanism.dense_equations import Equations
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import State
from runtime.results.result import Result
from runtime.results.run_records import Ending, Event, event_words
from runtime.results.samples import Partition, Samples, require_memory, sample_bytes, state_bytes
from runtime.validation.arguments import POINTS
from runtime.validation.finite_equations import describe_infinite, name_left_tables
from runtime.validation.scene_support import driven_note

_STARTS = ("t_start", "parameters", "guess", "start", "controllers", "length")
_STATS = {
    "rhs": "rhs_evaluations", "iterations": "stage_iterations", "largest_dq": "largest_correction",
    "seconds": "integration_seconds",
}  # fmt: skip
"""Statistics of a run that have other names in a result."""
_KEPT = 16  # safety: starts that a machine keeps
_NAMES = 6  # layout: constraints by name in the sentence about a crossing
# Ends of a run that tries to go where a table has no number.
_LEAVING = {
    *(Outcome.OUT_OF_RANGE, Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED),
    *(Outcome.INCONSISTENT, Outcome.SINGULAR, Outcome.DISCONTINUOUS),
}

# Ends of a run that tries to go where an equation or a force has no number.
_OF_NO_NUMBER = {Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED}


def simulate_joints(
    mechanism: Mechanism, t_end: float, t_eval: npt.ArrayLike | int | str | None = None, *,
    progress: Progress = silent, **settings: Any,
) -> Result:  # fmt: skip
    """Integrate the equations of motion from the assembled start; see `Machine.simulate`."""
    began = clock.perf_counter()
    row = sample_bytes(mechanism.description) + state_bytes(mechanism.description)
    advice = "Take fewer instants, or write them while the run goes on: out='run.zarr'."
    require_memory_of(mechanism, t_eval, row, advice)
    prepared = prepare_run(mechanism, t_end, t_eval, **settings)
    return run_prepared(*prepared, began, progress, repeats=True)


def require_memory_of(
    mechanism: Mechanism, t_eval: npt.ArrayLike | int | str | None, row: int, advice: str
) -> None:
    """Refuse instants whose samples, of `row` bytes and two numbers, do not fit into memory."""
    if not isinstance(t_eval, str):
        count = t_eval if isinstance(t_eval, int) else POINTS if t_eval is None else np.size(t_eval)
        row += 2 * np.dtype(np.float64).itemsize
        require_memory(mechanism.title, f"the samples at {count} instants", count * row, advice)


def prepare_run(
    mechanism: Mechanism, t_end: float, t_eval: npt.ArrayLike | int | str | None, *,
    method: str = "dop853", formulation: Formulation = "cartesian",
    correction: Correction = "step", atol: float | None = None, max_step: float | None = None,
    **settings: Any,
) -> tuple[Coordinates, Options]:  # fmt: skip
    """The coordinates and the options of a run from an assembled start; see `Machine.simulate`.

    `settings` are words of `PreparedSimulation`, and fields of `Options`. A start that was given
    before is not assembled again.
    """
    words = {name: settings.pop(name) for name in _STARTS if name in settings}
    # What numbers alone give is kept by its text: 0.0 == -0.0, and messages have an order of names.
    key, kept = repr((words, formulation, method, correction)), mechanism.starts
    given = [word.values() if isinstance(word, dict) else (word,) for word in words.values()]
    plain = {*map(type, chain(*given))} <= {float, type(None)}
    found: Coordinates | None = kept.get(key) if plain else None
    if found is None:
        ready = PreparedSimulation(mechanism, t_end, **words)
        found = formulate(ready, formulation, method, correction)
        if plain and ready.passages is None:  # these depend on the end
            if len(kept) >= _KEPT:
                kept.clear()
            kept[key] = found.again(t_end)  # without the room of the assembly
    coordinates = found.again(t_end) if found.ready.passages is None else found
    # An unknown method is refused by the integrator, together with all else that is wrong.
    fields = {"atol_q": atol, "atol_v": atol, "h_max": max_step} | settings
    correction, times = coordinates.correction, coordinates.ready.instants(t_eval)
    options = Options(method=method, correction=correction, t_eval=times, **fields)
    return coordinates, options


def run_prepared(
    coordinates: Coordinates, options: Options, began: float,
    progress: Progress, run: Trajectory | None = None, *, works: bool = True, energy: bool = False,
    repeats: bool = False, samples: Samples | None = None,
) -> Result:  # fmt: skip
    """The result of a simulation that `began` at an instant of `time.perf_counter`, s.

    `run` is its run, if that exists already; a scene with works needs another one,
    unless they are left out. `samples` are those of the run, with its last state, if they exist
    already. The `energy` of its samples is judged, as always in reduced
    coordinates; a run in these that a check contradicts is repeated in all of them, if `repeats`.
    """
    ready, begin, equations = coordinates.ready, coordinates.begin, coordinates.equations
    works = works and bool(equations.description.work_rows)
    if works or run is None:
        chosen = replace(options, quadrature=True) if works else options
        run = ready.run(coordinates, chosen, progress)
    run = end_at_kink(equations, begin, run, ready.t_end - begin.t)
    run = end_at_jam(equations, run, ready.t_end - begin.t)
    result = _result(equations, run, ready, began, samples)
    result._mechanism = equations.whole.mechanism
    if run.checkpoints is not None:
        end = run.final_t, run.samples_taken, run.discrete
        result._motion = SimulatedMotion(coordinates, options, run.checkpoints, *end)
    if works:
        integrate_works(result, len(run.t), options.t_eval)
    name_held_frictions(result, equations)
    suspicions = screen_run(equations, result.samples, ready.sizes, options, run)
    reduced = isinstance(coordinates, ReducedCoordinates)
    check_result(result, equations, ready.sizes, options, run, suspicions, energy=energy or reduced)
    astray = run.site is Site.KINK and run.outcome is Outcome.NOT_FINITE
    again = repeats and (result.outcome is Outcome.CONTRADICTED or astray)
    if again and isinstance(coordinates, ReducedCoordinates):
        whole = coordinates.cartesian(options.method)
        repetition = run_prepared(whole, options, began, progress, works=works, energy=True)
        why = "Its velocities are inaccurate where a slope grows." if astray else ""
        note_repetition(repetition, result.contradiction or why)
        return repetition
    count, note = describe_unresolved_switches(equations, run.events, suspicions)
    result.stats["events_within_tolerance"] = count
    if run.crossings:
        mobility = coordinates.mobility
        result.singular = describe_crossings(equations, begin.t, begin.q, mobility, run.crossings)
    result.message += note + driven_note(equations.mechanism, begin)
    t = result.t  # the first row shows the state behind a kink at which the run begins
    result.samples = result.samples._replace(t=np.where(t == begin.t, ready.given_t, t))
    return result


def note_repetition(result: Result, contradiction: str) -> None:
    """Say why a run in all coordinates took the place of one in reduced coordinates."""
    result.message += (
        " This run is in all coordinates: a check contradicted one in reduced coordinates, which "
        f"is thrown away. {contradiction}"
    )


def ends_early(description: Description, run: Trajectory) -> bool:
    """Whether the last state of a run is one more sample: it failed, or a condition ended it."""
    ended = run.stopped_by >= 0 and not description.watched[run.stopped_by].reconnects
    return run.outcome is not Outcome.OK or ended


def _result(
    equations: Equations, run: Trajectory, ready: PreparedSimulation, began: float,
    samples: Samples | None,
) -> Result:  # fmt: skip
    """The result of a run, with its statistics, events and partitions."""
    begin, description, log = ready.begin, equations.description, run.events
    if samples is None:
        t, q, v, modes = run.t, run.q, run.v, run.modes
        if ends_early(description, run) and (len(t) == 0 or run.final_t > t[-1]):
            t, modes = np.append(t, run.final_t), np.vstack([modes, run.final_modes])
            q, v = np.vstack([q, run.final_q]), np.vstack([v, run.final_v])
        samples = evaluate(equations, t, q, v, modes)
    stats = {_STATS.get(name, name): value for name, value in vars(run.statistics).items()} | {
        "method_changes": len(run.methods) - 1,
        "singular_crossings": len(run.crossings),
        "crossing_error": max((crossing.error for crossing in run.crossings), default=0.0),
        "wall_seconds": clock.perf_counter() - began,
    }
    titles = [switch.title for switch in description.switches]
    titles += [function.title for function in description.time_functions]
    parts = description.table_parts
    knots = {k for k, part in enumerate(parts) if part == KNOTS}  # of which steps alone take notice
    words = event_words(description, log.index, log.direction, run.modes[:1]) if len(log.t) else []
    events = [
        Event(titles[int(index)], float(time), int(direction), at_q, at_v, word)
        for time, index, direction, at_q, at_v, word in zip(
            log.t, log.index, log.direction, log.q, log.v, words, strict=True
        )
        if index not in knots
    ]
    passed, jumps = with_impulses(equations, events, run.final_t)
    names = np.array(description.coordinates.names, dtype=object)
    partitions = [
        Partition(float(t), tuple(names[chosen]))
        for t, chosen in zip(run.partitions.t, run.partitions.independent, strict=True)
    ]
    result = Result(
        description, samples, ready.p, analysis="simulation", outcome=run.outcome,
        message=_message(equations, run) + jumps + redundancy_note(begin) + ready.note, stats=stats,
        events=passed, partitions=tuple(partitions), not_unique=begin.not_unique,
    )  # fmt: skip
    subject = ""  # the condition, joint or driver that the outcome concerns
    if run.index >= 0 and run.outcome.of_switch:
        subject = description.switches[run.index].title
    elif run.index >= 0:
        subject = description.constraints[run.index].name
    result.site = run.site.of(subject)
    if run.outcome in _LEAVING:
        name_left_tables(result, equations)
    ending = run.stopped_by
    if ending >= 0 and not description.watched[ending].reconnects:
        result.ended_by = description.watched[ending].name
    elif ending >= 0 and run.discrete is not None:
        waiting = zip(description.watched, run.discrete.held.tolist(), strict=True)
        rows = tuple(row for row, held in waiting if held == WAITS and row.reconnects)
        clocks = discrete_state(ready.mechanism, ready.p, run.discrete)
        state = State(*run.end, description.coordinates, discrete=clocks)
        result.reconnection = Ending(rows, state, ready.length)
    if run.outcome is Outcome.CONTRADICTED:
        result.contradiction = f"At t = {run.final_t:.9g} s it stopped. {run.note}"
    return result


def _methods_note(run: Trajectory) -> str:
    """Sentence naming the methods where there were several."""
    if len(run.methods) == 1:
        return ""
    shown = [f"{name} from t = {t:.6g} s" for t, name in run.methods[:6]]
    rest = len(run.methods) - len(shown)
    return f" Methods: {', '.join(shown)}{f', and {rest} more changes' if rest else ''}."


def _crossings_note(description: Description, run: Trajectory) -> str:
    """Sentence about the singular positions that were passed; empty without any."""
    if not run.crossings:
        return ""
    first = run.crossings[0]
    worst = max(run.crossings, key=lambda crossing: crossing.error)
    count = len(run.crossings)
    names = [description.constraints[row].name for row in sorted(first.rows)]
    more = len(names) - _NAMES
    *others, last = names if more <= 1 else [*names[:_NAMES], f"{more} others"]
    dependent = f"s {', '.join(others)} and {last}" if others else f" {last}"
    text = (
        f" Passed {count} singular position{'s' if count > 1 else ''} on the branch on which the "
        f"velocity is continuous, the first at t = {first.t:.6g} s, where "
        f"constraint{dependent} became dependent (see `Result.singular`)."
    )
    if worst.error > 1.0:
        text += (
            f" Rounding there exceeds rtol: the step at t = {worst.t:.6g} s may err by "
            f"{worst.error:.1g} times the tolerance."
        )
    return text


def text_of_end(t: float, steps: int) -> str:
    """That a run has reached its end, an instant in s."""
    return f"Reached t = {t:g} s in {counted(steps, 'step')}."


def _message(equations: Equations, run: Trajectory) -> str:
    """How the run ended, with time and element."""
    description = equations.description
    if run.stopped_by >= 0:
        name, note = description.watched[run.stopped_by].name, run.note
        return f"Ended at t = {run.final_t:.9g} s, where '{name}' began to hold. {note}".rstrip()
    if run.outcome is Outcome.OK:
        return (
            f"{text_of_end(run.final_t, run.statistics.steps)}"
            f"{_methods_note(run)}{_crossings_note(description, run)} {run.note}"
        ).rstrip()
    where = ""
    if run.index >= 0 and run.outcome.of_switch:
        switch = description.switches[run.index]
        where = f", condition {switch.condition} of {switch.name}"
    elif run.index >= 0:
        row = description.constraints[run.index]
        where = f", {'driver' if row.element in description.drivers else 'joint'} {row.name}"
    all_said = (run.outcome is Outcome.ZENO and run.index < 0) or run.site is Site.KINK
    if all_said and run.note:
        return f"Stopped at t = {run.final_t:.9g} s{where}. {run.note}"
    reason = describe_jam(equations, run)
    if not reason and run.outcome in _OF_NO_NUMBER:
        reason = describe_infinite(equations, *run.end, run.final_modes)
    if reason:
        return f"Stopped at t = {run.final_t:.9g} s{where}. {reason}"
    note, advice = f" {run.note}" if run.note else "", f" {run.outcome.advice}"
    if run.outcome is Outcome.SINGULAR and run.note:
        advice = ""  # the note has its own
    elif run.outcome is Outcome.SINGULAR and description.drivers:
        note = " A driver may ask for more than the joints permit; `kinematics` names the lock-up."
    # An implicit step takes derivatives; it may fail for other reasons.
    astray = run.outcome is Outcome.NEWTON_FAILED and run.statistics.jacobians == 0
    if (run.outcome is Outcome.SINGULAR or astray) and run.statistics.steps == 0:
        fixed = ", ".join(row.name for row in description.start if row.role == "fixed")
        return (
            f"Stopped at t = {run.final_t:.9g} s{where}. The run starts in a singular position or "
            f"too near to one, and no motion leads out that fits its velocities.{note} Start "
            f"further away{f' (fixed: {fixed})' if fixed else ''}, or on the motion that is meant."
        )
    return f"Stopped at t = {run.final_t:.9g} s{where}. {run.outcome.meaning}{note}{advice}"
