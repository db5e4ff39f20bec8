"""Times of the parts of a scene: of an evaluation of `accelerations`, and of a run."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from codegen.artefact import import_generated
from codegen.derive.equations import Equations
from codegen.emit.arguments import Arguments
from codegen.emit.module import Origin, laid_out
from codegen.errors import InputError
from codegen.explain.incremental_cost import Stage, timing_stages
from codegen.explain.kernel_timer import ROUNDS, States, Timed, times
from codegen.explain.ledger_data import Part, RunCosts
from codegen.explain.run_cost import Run, simulate
from codegen.explain.sample_states import about_the_start, at, parameters
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.program import Program

ORIGIN = Origin("linkwright", (), "0" * 64, "python -m codegen explain")


@dataclass(frozen=True)
class Measured:
    """Times of one scene.

    Attributes
    ----------
    parts
        Part → ns by which an evaluation takes longer with it than with those before it. They add up
        to the time of the last stage, which is the scene's kernel.
    whole
        ns of the scene's kernel, compiled and timed once more: what the parts should add up to.
    """

    parts: dict[str, float]
    whole: float


def with_times(
    equations: Equations,
    programs: tuple[Lowered, ...],
    parts: list[Part],
    runs: tuple[Path, float] | None,
    progress: Callable[[str], None],
) -> tuple[list[Part], float | None, RunCosts | None]:
    """The parts with their nanoseconds, those of the whole kernel, and the costs of a run.

    Parameters
    ----------
    programs
        As `incremental_cost.cumulative_programs` returns them.
    runs
        The model's file and the run's length in s, if a run is requested.
    """
    where = f"{equations.model}, scene {equations.scene.name}"
    run: Run | None = None
    if runs is not None:
        if equations.scene.analysis != "dynamics":
            raise InputError(
                f"--run: scene '{equations.scene.name}' is for {equations.scene.analysis}, so "
                "there is no run under forces; leave --run out."
            )
        progress(f"{where}: running")
        run = simulate(runs[0], equations.scene.name, runs[1])
    progress(f"{where}: measuring")
    if run is None:
        states = about_the_start(equations, programs[-1])
    else:
        states = at(equations, programs[-1], run.t, run.q, run.v)
    found = measure(equations, timing_stages(equations, programs), states)
    if found is not None:
        parts = [_timed(part, found.parts) for part in parts]
    whole = found.whole if found else None
    if run is None:
        return parts, whole, None
    events = sum(run.events.values())
    costs = RunCosts(
        *(run.t_end, run.evaluations, run.steps, run.rejected, run.retakes),
        *(events, run.seconds),
    )
    return [_share_of_run(part, run, events) for part in parts], whole, costs


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
        *found, whole = times(kernels, states, rounds)
    before = [0.0, *found[:-1]]
    parts: dict[str, float] = {}
    for stage, after, earlier in zip(stages, found, before, strict=True):
        parts[stage.part] = after - earlier
    return Measured(parts, whole)


def _compiled(equations: Equations, program: Program, path: Path) -> Timed:
    declared = parameters(equations)
    text = laid_out(program, ORIGIN, ['"""A stage of a ledger."""'], {}, Arguments(len(declared)))
    path.write_text(text, encoding="utf-8")
    module = import_generated(path)
    p = np.array([*declared, *[0.0] * len(program.constants)])
    module.constants(p)
    kernel = next(k for k in program.kernels if k.name == "accelerations")
    slots = 1 + max((out.slot for out in kernel.outputs), default=0)
    return Timed(module.accelerations, p, max(slots, len(equations.coordinates)))


def _timed(part: Part, found: dict[str, float]) -> Part:
    """The part with its time: zero where it adds no operation, none where it does not act."""
    operations = part.operations.get("accelerations", 0)
    inside = part.acts and part.role != "fidelity"
    if part.name in found:
        return replace(part, nanoseconds=found[part.name])
    return replace(part, nanoseconds=0.0) if inside and not operations else part


def _share_of_run(part: Part, run: Run, events: int) -> Part:
    if not part.acts or part.role == "fidelity":
        return part
    mine = run.events.get(part.name, 0)
    spent = None if part.nanoseconds is None else part.nanoseconds * 1e-9 * run.evaluations
    retakes = run.retakes * mine / events if events else 0.0
    return replace(part, run_events=mine, run_retakes=retakes, run_seconds=spent)
