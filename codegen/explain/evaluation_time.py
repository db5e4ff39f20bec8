"""What each part of a scene takes of an evaluation of `accelerations`, measured."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from codegen.artefact import import_generated
from codegen.derive.equations import Equations
from codegen.emit.arguments import Arguments
from codegen.emit.module import Origin, laid_out
from codegen.explain.incremental_cost import Stage
from codegen.explain.kernel_timer import ROUNDS, States, Timed, times
from codegen.explain.sample_states import parameters
from codegen.lower.program import Program

ORIGIN = Origin("linkwright", (), "0" * 64, "python -m codegen explain")


@dataclass(frozen=True)
class Measured:
    """Times of one scene.

    Attributes
    ----------
    parts
        Part → ns that an evaluation takes longer with it than with those before it. They add up to
        the time of the last stage, which is the scene's kernel.
    whole
        ns of the scene's kernel, compiled and timed once more: what the parts should add up to.
    """

    parts: dict[str, float]
    whole: float


def measured(
    equations: Equations, stages: Sequence[Stage], states: States, rounds: int = ROUNDS
) -> Measured | None:
    """Compile every stage and time all of them in turns; None where there is no stage."""
    if not stages:
        return None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kernels = [
            _timed(equations, stage.program, Path(folder) / f"stage_{k}.py")
            for k, stage in enumerate((*stages, stages[-1]))
        ]
        *found, whole = times(kernels, states, rounds)
    before = [0.0, *found[:-1]]
    parts: dict[str, float] = {}
    for stage, after, earlier in zip(stages, found, before, strict=True):
        parts[stage.part] = after - earlier
    return Measured(parts, whole)


def _timed(equations: Equations, program: Program, path: Path) -> Timed:
    declared = parameters(equations)
    text = laid_out(program, ORIGIN, ['"""A stage of a ledger."""'], {}, Arguments(len(declared)))
    path.write_text(text, encoding="utf-8")
    module = import_generated(path)
    p = np.array([*declared, *[0.0] * len(program.constants)])
    module.constants(p)
    kernel = next(k for k in program.kernels if k.name == "accelerations")
    slots = 1 + max((out.slot for out in kernel.outputs), default=0)
    return Timed(module.accelerations, p, max(slots, len(equations.coordinates)))
