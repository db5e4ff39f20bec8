"""Times of the parts of a scene: of an evaluation of `accelerations`, and of a run.

This is the one place where the compiler uses the runtime: when a run is requested, not when the
module is imported. The import rules name the exception.
"""

import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.derive.equations import Equations
from codegen.emit.argument_docstrings import Arguments
from codegen.emit.module import Origin, assemble_module
from codegen.errors import InputError
from codegen.explain.kernel_timer import ROUNDS, States, Timed, times
from codegen.explain.ledger_records import Ledger, Part, RunCosts
from codegen.explain.operations_by_part import Stage, timing_stages
from codegen.explain.sample_states import COUNT, about_the_start, at, parameters
from codegen.files.generated_modules import import_generated
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.program import Program

ORIGIN = Origin("linkwright", (), "0" * 64, "python -m codegen explain")
MEASURED = 2  # measured: runs of which the faster counts; the first may find cold caches


class Run(NamedTuple):
    """The costs of a run, effect → number of its events, and the states along it: t, q, v."""

    costs: RunCosts
    events: Counter[str]
    samples: Any


class Measured(NamedTuple):
    """Times of one scene, ns."""

    # Part → time by which an evaluation takes longer with it than with those before it. They add up
    # to the time of the last stage, which is the scene's kernel.
    parts: dict[str, float]
    # Time of the scene's kernel, compiled and timed once more: what the parts should add up to.
    whole: float


def with_times(
    ledger: Ledger, programs: tuple[Lowered, ...], file: Path | None, t_end: float | None,
    progress: Callable[[str], None],
) -> Ledger:  # fmt: skip
    """The ledger with the nanoseconds of its parts and of the whole kernel, and a run's costs.

    `programs` as from `operations_by_part.cumulative_programs`; `t_end`, in s, requests a run of
    the model of a file.
    """
    whole = programs[-1]
    equations = whole.scene.equations
    scene, parts, run = equations.scene, ledger.parts, None
    if file is not None and t_end is not None:
        if scene.analysis != "dynamics":
            raise InputError(
                f"--run: scene '{scene.name}' is for {scene.analysis}, so "
                "there is no run under forces; leave --run out."
            )
        progress(f"{ledger.title}: running")
        run = _simulate(file, scene.name, t_end)
    progress(f"{ledger.title}: measuring")
    states = about_the_start(whole) if run is None else at(whole, *run.samples[:3])
    measured = measure(equations, timing_stages(programs), states)
    if measured is not None:
        parts = tuple(_timed(part, measured.parts) for part in parts)
        ledger = replace(ledger, nanoseconds=measured.whole)
    if run is not None:
        parts = tuple(_share_of_run(part, run) for part in parts)
        ledger = replace(ledger, run=run.costs)
    return replace(ledger, parts=parts)


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
    docstring = ['"""A stage of a ledger.', '"""']
    text = assemble_module(program, ORIGIN, docstring, {}, Arguments(len(declared)))
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


def _simulate(model: Path, scene: str, t_end: float) -> Run:
    """Simulate a declared scene `MEASURED` times; InputError if it does not reach its end."""
    from runtime import load

    machine = load(model, scene)
    instants = np.linspace(0.0, t_end, COUNT)
    results = [machine.simulate(t_end, instants, progress=False) for _ in range(MEASURED)]
    first = results[0]
    if first.failed:
        raise InputError(f"--run: the run does not reach its end; {first.message}")
    events = Counter(event.name.partition(":")[0] for event in first.events)
    seconds = min(result.stats["integration_seconds"] for result in results)
    evaluations, steps, rejected, retakes = (
        int(first.stats[name]) for name in ("rhs_evaluations", "steps", "rejected", "retakes")
    )
    costs = RunCosts(t_end, evaluations, steps, rejected, retakes, events.total(), seconds)
    return Run(costs, events, first.samples)


def _share_of_run(part: Part, run: Run) -> Part:
    if not part.acts or part.role == "fidelity":
        return part
    costs, events = run.costs, run.events[part.name]
    spent = None if part.nanoseconds is None else part.nanoseconds * 1e-9 * costs.evaluations
    retakes = costs.retakes * events / costs.events if costs.events else 0.0
    return replace(part, run_events=events, run_retakes=retakes, run_seconds=spent)
