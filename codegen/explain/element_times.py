"""Times of the parts of a scene: of an evaluation of `accelerations`, and of a run."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from codegen.derive.equations import Equations
from codegen.emit.argument_docstrings import Arguments
from codegen.emit.module import Origin, assemble_module
from codegen.errors import InputError
from codegen.explain.kernel_timer import ROUNDS, States, Timed, times
from codegen.explain.ledger_records import Part, RunCosts
from codegen.explain.measured_run import Run, simulate
from codegen.explain.operations_by_part import Stage, timing_stages
from codegen.explain.sample_states import about_the_start, at, parameters
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.program import Program
from codegen.module_signature import import_generated

ORIGIN = Origin("linkwright", (), "0" * 64, "python -m codegen explain")


class Measured(NamedTuple):
    """Times of one scene, ns."""

    # Part → time by which an evaluation takes longer with it than with those before it. They add up
    # to the time of the last stage, which is the scene's kernel.
    parts: dict[str, float]
    # Time of the scene's kernel, compiled and timed once more: what the parts should add up to.
    whole: float


def with_times(
    programs: tuple[Lowered, ...],
    parts: list[Part],
    runs: tuple[Path, float] | None,
    progress: Callable[[str], None],
) -> tuple[list[Part], float | None, RunCosts | None]:
    """The parts with their nanoseconds, those of the whole kernel, and the costs of a run.

    `programs` as from `operation_costs.cumulative_programs`; `runs` is the model's file and the
    run's length in s, if a run is requested.
    """
    whole = programs[-1]
    equations = whole.scene.equations
    scene = equations.scene
    run: Run | None = None
    if runs is not None:
        if scene.analysis != "dynamics":
            raise InputError(
                f"--run: scene '{scene.name}' is for {scene.analysis}, so "
                "there is no run under forces; leave --run out."
            )
        progress(f"{equations.model}, scene {scene.name}: running")
        run = simulate(runs[0], scene.name, runs[1])
    progress(f"{equations.model}, scene {scene.name}: measuring")
    if run is None:
        states = about_the_start(whole)
    else:
        states = at(whole, run.samples.t, run.samples.q, run.samples.v)
    measured = measure(equations, timing_stages(programs), states)
    if measured is not None:
        parts = [_timed(part, measured.parts) for part in parts]
    if run is not None:
        parts = [_share_of_run(part, run) for part in parts]
    return parts, measured.whole if measured else None, run.costs if run else None


def measure(
    equations: Equations, stages: Sequence[Stage], states: States, rounds: int = ROUNDS
) -> Measured | None:
    """Compile every stage and time all of them in turns; None where there is no stage."""
    if not stages:
        return None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kernels = [
            _compiled(equations, stage.program, Path(folder) / f"stage_{k}.py")
            for k, stage in enumerate((*stages, stages[-1]))
        ]
        *cumulative, whole = times(kernels, states, rounds)
    added = np.diff(cumulative, prepend=0.0).tolist()
    return Measured(dict(zip((stage.part for stage in stages), added, strict=True)), whole)


def _compiled(equations: Equations, program: Program, path: Path) -> Timed:
    declared = parameters(equations)
    text = assemble_module(
        program, ORIGIN, ['"""A stage of a ledger."""'], {}, Arguments(len(declared))
    )
    path.write_text(text, encoding="utf-8")
    module = import_generated(path)
    p = np.array([*declared, *[0.0] * len(program.constants)])
    module.constants(p)
    slots = 1 + max((out.slot for out in program.kernels[-1].outputs), default=0)
    return Timed(module.accelerations, p, max(slots, len(equations.coordinates)))


def _timed(part: Part, times: dict[str, float]) -> Part:
    """The part with its time: zero where it adds no operation, none where it does not act."""
    if part.name in times:
        return replace(part, nanoseconds=times[part.name])
    inside = part.acts and part.role != "fidelity"
    return replace(part, nanoseconds=0.0) if inside and not part.solving else part


def _share_of_run(part: Part, run: Run) -> Part:
    if not part.acts or part.role == "fidelity":
        return part
    costs, events = run.costs, run.events[part.name]
    spent = None if part.nanoseconds is None else part.nanoseconds * 1e-9 * costs.evaluations
    retakes = costs.retakes * events / costs.events if costs.events else 0.0
    return replace(part, run_events=events, run_retakes=retakes, run_seconds=spent)
