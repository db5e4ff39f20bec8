"""The kernel of accelerations and multipliers, by the elimination that costs least."""

from codegen.declare.symbols import Parameter
from codegen.derive.inertia import neutral
from codegen.lower.kernels.corrections import solutions
from codegen.lower.kernels.reaction_friction import with_friction
from codegen.lower.linear.factorization import Elimination, Strategy
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.sparse_rows import Task
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Kernel, Output, store
from codegen.lower.scene_graph import SceneGraph

FAR = 1e5
"""accuracy: ratio of the largest to the smallest mass, or moment of inertia, from which on
solutions are refined: an elimination that divides by the wrong ones loses as many digits as the
ratio has.
"""


def accelerations(scene: SceneGraph, rows: tuple[int, ...]) -> tuple[Kernel, Strategy]:
    """The fused kernel, by the order that costs least; it returns the multipliers of `rows`."""
    if scene.driven:
        return _kinematics(scene), "square"
    if not scene.mass:
        return _kinematics(scene), "schur"
    strategies: tuple[Strategy, ...] = ("substitute", "mixed", "schur")
    trials = [(dynamics_kernel(scene, strategy, rows), strategy) for strategy in strategies]
    kernel, strategy = min(trials, key=lambda trial: cost(scene.graph, trial[0]))
    if _spread(scene) >= FAR:
        kernel = dynamics_kernel(scene, strategy, rows, refine=True)
    return kernel, strategy


def _spread(scene: SceneGraph) -> float:
    """Largest ratio of two masses, or of two moments of inertia, as declared, neutral pose."""
    coordinates = scene.equations.coordinates
    declared = {Parameter(p.name, real=True): p.value for p in scene.equations.parameters}
    sizes: dict[str, list[float]] = {}
    for i, k, mass in scene.equations.mass:
        size = float(mass.subs(declared).subs(neutral(coordinates))) if i == k else 0.0
        if size > 0.0:
            sizes.setdefault(coordinates[k].unit, []).append(size)
    return max((max(group) / min(group) for group in sizes.values()), default=1.0)


def dynamics_kernel(
    scene: SceneGraph, strategy: Strategy, rows: tuple[int, ...], refine: bool = False
) -> Kernel:
    """The fused kernel by one order of elimination, with a step of refinement or without."""
    n, graph = scene.n, scene.graph
    entries = {place: mass for place, mass in scene.mass.items() if mass != graph.zero}
    references: dict[int, int] = {}
    lengths = {k for k, q in enumerate(scene.equations.coordinates) if q.unit == "m"}
    with_lengths = {i for i, k in scene.jacobian if k in lengths}
    located = [(k, n + i, i not in with_lengths) for i, k in scene.massless]
    labels = _labels(scene)
    labels.step("Sizes that the pivots are compared with: the diagonal of Φ_q M⁻¹ Φ_qᵀ")
    with graph.serving("factorization"):
        for (i, k), entry in scene.jacobian.items():
            entries[n + i, k] = entries[k, n + i] = entry
            if (k, k) not in entries:
                continue
            part = graph.div(graph.mul(entry, entry), scene.mass[k, k])
            references[n + i] = graph.add(references.get(n + i, graph.zero), part)
        for i, size in references.items():
            labels.add(size, labels.of("size", i))
        system = Elimination(
            graph,
            entries,
            [scene.forces + scene.gamma, *_pushes(scene)],
            frozenset(range(n, n + scene.m)),
            references,
            located,
            labels,
        )
        columns = system.solve(strategy)
        if refine:
            columns = system.refined(columns)
            labels.step("Refine by what the equations as stated still lack")
            labels.solved(columns)
        if scene.frictions:
            labels.step("Friction: its forces, and what they change")
        solution, rubbing = with_friction(scene, columns)
        labels.solved([solution])
    outputs = store("a", solution[:n], scene.rates)
    outputs += tuple(Output("lam", row, solution[n + row], scene.rows[row]) for row in rows)
    checks = tuple(check._replace(constraint=check.constraint - n) for check in system.checks)
    checks += rubbing
    return Kernel(
        "accelerations",
        "q̈ and λ of M q̈ + Φ_qᵀ λ = Q, Φ_q q̈ = γ.",
        (*STATE, "modes", "a", "lam"),
        outputs,
        checks,
        watched=True,
        **labels.text,
    )


def _labels(scene: SceneGraph) -> Labels:
    """Names of the equations of motion: without friction, and for a unit force of each friction."""
    right = [f"Q_{name}" for name in scene.names] + [f"gamma_{name}" for name in scene.rows]
    solution = [f"{rate}_rate" for rate in scene.rates] + [f"lambda_{name}" for name in scene.rows]
    tails = ["", *(f"_{e.name}" for e in scene.equations.effects if e.terms.friction)]
    return Labels(
        [*scene.names, *scene.rows],
        [[name + tail for name in right] for tail in tails],
        [[name + tail for name in solution] for tail in tails],
    )


def _pushes(scene: SceneGraph) -> list[list[int]]:
    """Right sides of unit forces of friction."""
    zero = scene.graph.zero
    return [
        [*(f.direction.get(k, zero) for k in range(scene.n)), *[zero] * scene.m]
        for f in scene.frictions
    ]


def _kinematics(scene: SceneGraph) -> Kernel:
    """Accelerations that the constraints alone determine, the least where they leave a choice."""
    graph, rates = scene.graph, scene.rates
    ones, unknowns = [graph.one] * scene.n, [[f"{rate}_rate" for rate in rates]]
    right, stems = [scene.gamma], ["gamma"]
    with graph.serving("factorization"):
        task = Task(graph, scene.jacobian, right, ones, scene.names, scene.rows, stems, unknowns)
        (solution,), solver = solutions(task)[0]
    return Kernel(
        "accelerations",
        "q̈ of Φ_q q̈ = γ (of least norm while drivers are missing).",
        (*STATE, "modes", "a", "lam"),
        store("a", solution, rates),
        tuple(solver.checks),
        watched=True,
        **solver.labels.text,
    )
