"""Prices on the labels: the parts of a ledger with times, and with their shares of a run."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from codegen.derive.equations import Equations
from codegen.errors import InputError
from codegen.explain.evaluation_time import measured
from codegen.explain.incremental_cost import stages
from codegen.explain.ledger_data import Part, RunCosts
from codegen.explain.run_cost import Run, run
from codegen.explain.sample_states import about_the_start, at
from codegen.lower.kernels.scene_kernels import Lowered


def priced(
    equations: Equations,
    programs: tuple[Lowered, ...],
    parts: list[Part],
    runs: tuple[Path, float] | None,
    progress: Callable[[str], None],
) -> tuple[list[Part], float | None, RunCosts | None]:
    """The parts with their nanoseconds, those of the whole kernel, and what a run took.

    Parameters
    ----------
    programs
        As `growth.grown` answers.
    runs
        The model's file and the run's length in s, if one is asked for.
    """
    where = f"{equations.model}, scene {equations.scene.name}"
    done: Run | None = None
    if runs is not None:
        if equations.scene.analysis != "dynamics":
            raise InputError(
                f"--run: scene '{equations.scene.name}' is for {equations.scene.analysis}, so "
                "there is no run under forces; leave --run out."
            )
        progress(f"{where}: running")
        done = run(runs[0], equations, runs[1])
    progress(f"{where}: measuring")
    if done is None:
        states = about_the_start(equations, programs[-1])
    else:
        states = at(equations, programs[-1], done.t, done.q, done.v)
    times = measured(equations, stages(equations, programs), states)
    if times is not None:
        parts = [_timed(part, times.parts) for part in parts]
    if done is None:
        return parts, times.whole if times else None, None
    events = sum(done.events.values())
    costs = RunCosts(
        *(done.t_end, done.evaluations, done.steps, done.rejected, done.retakes),
        *(events, done.seconds),
    )
    return [_run(part, done, events) for part in parts], times.whole if times else None, costs


def _timed(part: Part, times: dict[str, float]) -> Part:
    """A part that adds nothing to the kernel takes no time; what does not act has none to take."""
    counted = part.operations.get("accelerations", 0)
    inside = part.acts and part.role != "fidelity"
    if part.name in times:
        return replace(part, nanoseconds=times[part.name])
    return replace(part, nanoseconds=0.0) if inside and not counted else part


def _run(part: Part, done: Run, events: int) -> Part:
    mine = done.events.get(part.name, 0)
    spent = None if part.nanoseconds is None else part.nanoseconds * 1e-9 * done.evaluations
    if not part.acts or part.role == "fidelity":
        return part
    retakes = done.retakes * mine / events if events else 0.0
    return replace(part, run_events=mine, run_retakes=retakes, run_seconds=spent)
