"""The ledger: the parts of a machine that a scene contains, why, and the cost of each."""

from collections.abc import Callable
from pathlib import Path

from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.driver import valid_scenes
from codegen.errors import InputError
from codegen.explain.incremental_cost import (
    SOLUTION,
    cumulative_programs,
    operations_by_part,
    operations_of,
)
from codegen.explain.inventory import Entry, OutputEntry, inventory, output_inventory
from codegen.explain.ledger_data import Ledger, Part
from codegen.explain.marginal_cost import own_operations
from codegen.model import Model
from codegen.model_file import read_model

SHARED = {SOLUTION: "solution of M q̈ + Φ_qᵀ λ = Q", "correction": "recovery of q and q̇"}


def explain(
    model: str | Path | Model,
    scene: str | Scene | None = None,
    *,
    measure: bool = False,
    t_end: float | None = None,
    progress: Callable[[str], None] = lambda message: None,
) -> tuple[Ledger, ...]:
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
    path = file.path
    found = []
    for chosen in valid_scenes(file.model, scene):
        progress(f"{file.model.name}, scene {chosen.name}: deriving")
        equations = derive(file.model, chosen)
        if t_end is not None and (path is None or chosen.root is not None):
            raise InputError(
                f"scene '{chosen.name}' is not declared in a file, and a run needs the names of "
                "both; declare the scene, or explain it without a run."
            )
        runs = (path, t_end) if path is not None and t_end is not None else None
        entries = inventory(file.model, chosen)
        outputs = output_inventory(file.model, chosen)
        found.append(_ledger(equations, entries, outputs, measure, runs, progress))
    return tuple(found)


def _ledger(
    equations: Equations,
    entries: tuple[Entry, ...],
    outputs: tuple[OutputEntry, ...],
    measure: bool,
    runs: tuple[Path, float] | None,
    progress: Callable[[str], None],
) -> Ledger:
    programs = cumulative_programs(equations)
    counts = operations_by_part(equations, programs)
    totals = operations_of(programs[-1])
    parts = [
        Part(
            *(e.name, e.kind, e.role, e.acts, e.why),
            counts.get(e.name, {}) if e.acts else {},
            own_operations(equations, e.name) if e.acts and e.role == "effect" else {},
            events=tuple(s.text for s in equations.switches if s.effect == e.name),
        )
        for e in entries
    ]
    shared = [name for name in counts if name not in {part.name for part in parts}]
    parts += [
        Part(name or "sums", SHARED.get(name, "shared"), "shared", True, "shared", counts[name])
        for name in shared
    ]
    whole, costs = None, None
    if measure or runs is not None:
        from codegen.explain.part_times import with_times  # numba only where something is timed

        parts, whole, costs = with_times(equations, programs, parts, runs, progress)
    return Ledger(
        equations.model,
        equations.scene.name,
        tuple(k for k in totals if totals[k]),
        tuple(parts),
        totals,
        equations.left_out,
        outputs,
        whole,
        costs,
    )
