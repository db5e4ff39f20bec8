"""Dynamics: how the machine moves under the forces that act on it."""

import time as clock
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from runtime.assembly.redundant_kernels import spared
from runtime.continuation.singularity_classification import passed
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import Coordinates
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.prepared_simulation import Prepared
from runtime.dynamics.work import laid, with_works
from runtime.integrate.problem import Correction, Formulation, Options
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import Assembly
from runtime.results.event_records import Event
from runtime.results.result import Result
from runtime.results.samples import Partition
from runtime.validation.arguments import instants
from runtime.validation.scene_support import carried


def simulate(
    mechanism: Mechanism,
    t_end: float,
    t_eval: npt.ArrayLike | None = None,
    *,
    t_start: float = 0.0,
    method: str = "dop853",
    rtol: float = 1e-8,
    atol: float | None = None,
    parameters: Values | None = None,
    guess: Values | None = None,
    start: Assembly | None = None,
    correction: Correction = "step",
    formulation: Formulation = "cartesian",
    time_scale: float | None = None,
    first_step: float | None = None,
    max_step: float | None = None,
    max_steps: int = 100_000_000,
    progress: Progress = silent,
) -> Result:
    """Integrate the equations of motion from the assembled start.

    Parameters
    ----------
    t_end
        Last instant in s.
    t_eval
        Output instants in s, increasing; without them, the end of every step.
    t_start
        First instant in s; that of `start` where one is given.
    method
        "dop853", of order 8, "dopri5" or "tsit5", of order 5, explicit. "radau5" or "bdf",
        implicit, for stiff equations: contacts and springs much stiffer than the motion is fast;
        "radau5" also where these vibrate. "auto" starts with "dop853" and changes to an implicit
        method where it finds the equations stiff, and back. The last three take exact derivatives,
        built when they are first needed.
    rtol, atol
        Tolerances of a step: `atol` + `rtol` times the value, for each coordinate and velocity;
        `atol` in m, rad, m/s, rad/s. Unless it is given, it is `rtol` times a typical size: 1 rad
        for angles; for lengths that of the machine at its start (its longest arm; without arms its
        largest distance from the origin, or a fixed length), but not more than 1 m; the same a
        second for velocities.
    guess
        Start values by name, over those of the scene.
    start
        An assembled state to start from, in place of the scene's start.
    correction
        Return onto the constraints: once a "step" (dependent coordinates from independent ones), at
        every "stage", by "projection", by "baumgarte" or "hybrid"; see `Options.correction`.
    formulation
        "cartesian" integrates all coordinates; "reduced" those that no constraint gives, with the
        same results: `runtime.dynamics.formulations`.
    time_scale
        τ of Baumgarte's accelerations, s; a thousandth of the run unless given.
    first_step, max_step
        Lengths in s; chosen unless given.
    """
    began = clock.perf_counter()
    ready = Prepared(
        mechanism, t_end, t_start=t_start, parameters=parameters, guess=guess, start=start
    )
    taken = ready.coordinates(formulation, method, correction)
    # An unknown method is refused by the integrator, together with all else that is wrong.
    options = Options(
        method=method,
        rtol=rtol,
        atol_q=atol,
        atol_v=atol,
        t_eval=None if t_eval is None else instants(t_eval),
        correction=taken.correction,
        time_scale=time_scale,
        first_step=first_step,
        h_max=max_step,
        max_steps=max_steps,
    )
    return finished(ready, taken, options, began, progress)


def finished(
    ready: Prepared,
    taken: Coordinates,
    options: Options,
    began: float,
    progress: Progress,
    run: Trajectory | None = None,
) -> Result:
    """The result of a run.

    Parameters
    ----------
    began
        When the analysis did, s of `time.perf_counter`.
    run
        The run, where it has been made; works are integrated in others.
    """
    times = None if options.t_eval is None else np.asarray(options.t_eval, dtype=np.float64)
    begin, plan = ready.begin, None
    if ready.mechanism.description.working:
        ends = ready.run(taken, replace(options, t_eval=None), progress).t
        plan = laid(begin.t, ends, times)
        run = ready.run(taken, replace(options, t_eval=plan.instants), progress)
    elif run is None:
        run = ready.run(taken, options, progress)
    mechanism, equations = taken.mechanism, Equations(taken.mechanism, ready.p)
    found = _result(mechanism, run, ready.p, began, begin)
    if plan:
        found = with_works(found, plan)
    found.singular = tuple(passed(equations, begin.t, begin.q, taken.mobility, run.crossings))
    found.message += carried(mechanism, begin.degrees_of_freedom)
    return found


def _result(
    mechanism: Mechanism, run: Trajectory, p: FloatArray, began: float, begin: Assembly
) -> Result:
    """Outputs at the samples; a run that stopped early gets its last state as one more."""
    t, q, v, modes = run.t, run.q, run.v, run.modes
    if run.outcome is not Outcome.OK and (len(t) == 0 or run.final_t > t[-1]):
        t = np.append(t, run.final_t)
        q, v = np.vstack([q, run.final_q]), np.vstack([v, run.final_v])
        modes = np.vstack([modes, run.final_modes[None, :]])
    samples = evaluate(mechanism, p, t, q, v, modes)
    counts = run.statistics
    stats = {
        "steps": counts.steps,
        "rejected": counts.rejected,
        "retakes": counts.retakes,
        "rhs_evaluations": counts.rhs,
        "corrections": counts.corrections,
        "newton_iterations": counts.newton,
        "stage_iterations": counts.iterations,
        "jacobians": counts.jacobians,
        "factorizations": counts.factorizations,
        "dense_outputs": counts.dense_outputs,
        "repartitions": counts.repartitions,
        "events": counts.events,
        "method_changes": len(run.methods) - 1,
        "singular_crossings": len(run.crossings),
        "crossing_error": max((crossing.error for crossing in run.crossings), default=0.0),
        "largest_correction": counts.largest_dq,
        "integration_seconds": counts.seconds,
        "wall_seconds": clock.perf_counter() - began,
    }
    switches = mechanism.description.switches
    events = [
        Event(
            switches[int(index)].title,
            float(time),
            int(direction),
            at_q,
            at_v,
        )
        for time, index, direction, at_q, at_v in zip(
            run.events.t, run.events.index, run.events.direction, run.events.q, run.events.v,
            strict=True,
        )
    ]  # fmt: skip
    names = mechanism.description.coordinates.names
    partitions = [
        Partition(float(t), tuple(name for name, free in zip(names, chosen, strict=True) if free))
        for t, chosen in zip(run.partitions.t, run.partitions.independent, strict=True)
    ]
    return Result(
        mechanism.description,
        samples,
        p,
        analysis="simulation",
        outcome=run.outcome,
        message=_message(mechanism, run) + spared(begin),
        stats=stats,
        events=events,
        partitions=partitions,
        not_unique=begin.not_unique,
    )


def _changes(run: Trajectory) -> str:
    """Which methods were used, where it was more than one."""
    if len(run.methods) == 1:
        return ""
    shown = [f"{name} from t = {t:.6g} s" for t, name in run.methods[:6]]
    rest = len(run.methods) - len(shown)
    return f" Methods: {', '.join(shown)}{f', and {rest} more changes' if rest else ''}."


def _crossed(mechanism: Mechanism, run: Trajectory) -> str:
    """Which singular positions were passed, and what it cost, where there were any."""
    if not run.crossings:
        return ""
    first = run.crossings[0]
    worst = max(run.crossings, key=lambda crossing: crossing.error)
    count = len(run.crossings)
    told = (
        f" Passed {count} singular position{'s' if count > 1 else ''} on the branch on which the "
        f"velocity is continuous, the first at t = {first.t:.6g} s, where "
        f"{mechanism.description.constraints.names[first.row]} lost its hold."
    )
    if worst.error > 1.0:
        told += (
            f" Rounding there exceeds rtol: the step at t = {worst.t:.6g} s may err by "
            f"{worst.error:.1g} times the tolerance."
        )
    return told


def _message(mechanism: Mechanism, run: Trajectory) -> str:
    """How the run ended, with its time and the element concerned."""
    if run.outcome is Outcome.OK:
        return (
            f"Reached t = {run.final_t:g} s in {run.statistics.steps} steps."
            f"{_changes(run)}{_crossed(mechanism, run)}"
        )
    told = mechanism.description
    where = ""
    if run.index >= 0:
        if run.outcome.of_switch:
            switch = told.switches[run.index]
            where = f", condition {switch.condition} of {switch.name}"
        else:
            row = told.constraints[run.index]
            where = f", {'driver' if row.element in told.drivers else 'joint'} {row.name}"
    note = f" {run.note}" if run.note else ""
    if run.outcome in {Outcome.SINGULAR, Outcome.NEWTON_FAILED} and run.statistics.steps == 0:
        held = ", ".join(row.name for row in told.start if row.role == "fixed")
        return (
            f"Stopped at t = {run.final_t:.9g} s{where}. The run starts in a singular position or "
            f"too near to one, and no motion leads out that fits its velocities.{note} Start "
            f"further away{f' (held: {held})' if held else ''}, or on the motion that is meant."
        )
    return (
        f"Stopped at t = {run.final_t:.9g} s{where}. {run.outcome.meaning}{note} "
        f"{run.outcome.advice}"
    )
