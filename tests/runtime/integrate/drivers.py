"""Ways in from Python to the parts of a step, which only compiled code calls."""

from runtime.core.arrays import f8, i8, integers
from runtime.core.jit import compiled
from runtime.integrate import loop, sampling, step, step_acceptance, step_control
from runtime.integrate.problem import Options
from runtime.integrate.run import Run
from tests.runtime.integrate.systems import pendulum_problem


@compiled(i8(integers, f8, f8))
def take_trial_step(context, t, h):
    return step.take_trial_step(context, t, h)


@compiled(f8(integers, f8))
def propose(context, h):
    return step_control.propose(context, h)


@compiled(i8(integers))
def plan_step(context):
    return loop.plan_step(context)


@compiled(i8(integers))
def try_step(context):
    return loop.try_step(context)


@compiled(i8(integers))
def follow_plan(context):
    return loop.follow_plan(context)


@compiled(i8(integers))
def end_at_event(context):
    return step_acceptance.end_at_event(context)


@compiled(i8(integers))
def stay(context):
    return step_acceptance.stay(context)


@compiled(i8(integers))
def accept_step(context):
    return step_acceptance.accept_step(context)


@compiled(i8(integers))
def judge_events(context):
    return step_acceptance.judge_events(context)


@compiled(i8(integers, f8, f8, f8, i8))
def emit(context, t, t1, h, dense_ready):
    return sampling.emit(context, t, t1, h, dense_ready)


def started(system, problem, **options):
    """A run whose first step is prepared, with room for samples."""
    run = Run(system, problem, Options(**options))
    assert run.start() == 0
    run.recording.make_room(64)
    return run


def tried(run, h):
    """Take a trial step of this length; its code."""
    record = run.state.record
    record["length"], record["end"] = h, record["t"] + h
    record["next_length"] = h
    return take_trial_step(run.state.table, record["t"], h)


def swinging(system, **options):
    return started(system, pendulum_problem(-1.0, 2.0, 10.0), **options)
