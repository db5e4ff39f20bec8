"""The ledger: the parts of a machine that a scene contains, why, and the cost of each."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from codegen.declare.scene import Scene
from codegen.derive.equations import derive
from codegen.errors import InputError
from codegen.explain import operations_by_part as costs
from codegen.explain.elements_and_outputs_in_scene import Inventory, output_inventory
from codegen.explain.ledger_records import Ledger, Part
from codegen.explain.loops import loops_sentence
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.model import Model
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

SHARED = {costs.SOLUTION: "solution of M q̈ + Φ_qᵀ λ = Q", "correction": "recovery of q and q̇"}

Progress = Callable[[str], None]


def explain(
    model: str | Path | Model, scene: str | Scene | None = None, *, measure: bool = False,
    t_end: float | None = None, progress: Progress = lambda message: None,
) -> tuple[Ledger, ...]:  # fmt: skip
    """Ledgers of one scene of a model, or of all.

    Parameters
    ----------
    model, scene
        As for `build`.
    measure
        Compile the parts of `accelerations` and time them: some seconds a scene.
    t_end
        Also run the scene for this many seconds with its defaults, and report the time that the run
        spent on each part; kernels are then timed at states along the run. The scene must be
        declared in a file.

    Raises
    ------
    InputError
        As `build` does; or if the scene cannot be run.
    """
    file = read_model(model)
    ledgers = []
    for chosen in valid_scenes(file.model, scene):
        progress(f"{file.model.name}, scene {chosen.name}: deriving")
        if t_end is not None and (file.path is None or chosen.root is not None):
            raise InputError(
                f"scene '{chosen.name}' is not declared in a file, and a run needs the names of "
                "both; declare the scene, or explain it without a run."
            )
        ledger, programs = _ledger(file.model, chosen)
        if measure or t_end is not None:
            from codegen.explain.element_times import with_times  # numba only to time something

            ledger = with_times(ledger, programs, file.path, t_end, progress)
        ledgers.append(ledger)
    return tuple(ledgers)


def _ledger(model: Model, scene: Scene) -> tuple[Ledger, tuple[Lowered, ...]]:
    """A ledger without times, and the programs that it is made from."""
    equations = derive(model, scene)
    programs = costs.cumulative_programs(equations)
    counts = costs.operations_by_part(programs)
    totals = costs.operations_of(programs[-1])
    parts = []
    for part in Inventory(model, scene).parts():
        effect = part.acts and part.role == "effect"
        own = costs.marginal_operations(programs[-1], part.name) if effect else {}
        events = tuple(s.text for s in equations.switches if s.effect == part.name)
        added = counts.get(part.name, {}) if part.acts else {}
        parts.append(replace(part, operations=added, own=own, events=events))
    declared = {part.name for part in parts}
    parts += [
        Part(name or "sums", SHARED.get(name, "shared"), "shared", True, "shared", operations)
        for name, operations in counts.items()
        if name not in declared
    ]
    kernels, outputs = tuple(k for k in totals if totals[k]), output_inventory(model, scene)
    left_out = equations.left_out
    ledger = Ledger(equations.model, scene.name, kernels, tuple(parts), totals, left_out, outputs)
    ledger = replace(ledger, loops=loops_sentence(programs[-1]))
    return ledger, programs
