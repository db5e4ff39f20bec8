"""The kernels that solve: accelerations with multipliers, and the recovery of coordinates."""

from itertools import combinations_with_replacement

from codegen.declare.symbols import Parameter
from codegen.lower.constant_hoisting import with_constants
from codegen.lower.graph import Graph
from codegen.lower.kernels.driven_machines import Square
from codegen.lower.kernels.friction import with_friction
from codegen.lower.linear.factorization import Elimination, Strategy
from codegen.lower.linear.labels import Labels
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Check, Kernel, Output, store
from codegen.lower.scene_graph import SceneGraph

Entries = dict[tuple[int, int], int]
"""(row, column) → value, structural non-zeros of Φ_q."""

MISSING = ["rhs_q", "rhs_v"]
"""Stems of the names of -Φ and -(Φ_q q̇ + Φ_t) where they are right sides."""

FAR = 1e5
"""accuracy: ratio of the largest to the smallest mass, or moment of inertia, from which on
solutions are refined: an elimination that divides by the wrong ones loses as many digits as the
ratio has.
"""


def accelerations(scene: SceneGraph, rows: tuple[int, ...]) -> tuple[Kernel, Strategy]:
    """The fused kernel, by the order of elimination that costs least.

    Parameters
    ----------
    rows
        The constraints whose multipliers are wanted.
    """
    if scene.driven:
        return _kinematics(scene), "square"
    strategies: tuple[Strategy, ...] = ("substitute", "mixed", "schur")
    if not scene.equations.masses:
        strategies = ("schur",)
    trials = []
    for strategy in strategies:
        massive = bool(scene.equations.masses)
        kernel = _dynamics(scene, strategy, rows) if massive else _kinematics(scene)
        program = with_constants(scene.graph, (kernel,), len(scene.equations.parameters))
        trials.append((cost(program, program.kernels[-1]), kernel, strategy))
    _, kernel, strategy = min(trials, key=lambda trial: trial[0])
    if _spread(scene) >= FAR:
        kernel = _dynamics(scene, strategy, rows, refine=True)
    return kernel, strategy


def _spread(scene: SceneGraph) -> float:
    """Largest ratio of two masses, or of two moments of inertia, as declared."""
    declared = {Parameter(p.name, real=True): p.value for p in scene.equations.parameters}
    sizes: dict[str, list[float]] = {}
    for q, mass in zip(scene.equations.coordinates, scene.equations.masses, strict=False):
        size = float(mass.subs(declared))
        if size > 0.0:
            sizes.setdefault(q.unit, []).append(size)
    return max((max(found) / min(found) for found in sizes.values()), default=1.0)


def _dynamics(
    scene: SceneGraph,
    strategy: Strategy,
    rows: tuple[int, ...] | None = None,
    refine: bool = False,
) -> Kernel:
    n, graph = scene.n, scene.graph
    entries = {(k, k): mass for k, mass in enumerate(scene.masses) if mass != graph.zero}
    references: dict[int, int] = {}
    lengths = {k for k, q in enumerate(scene.equations.coordinates) if q.unit == "m"}
    with_lengths = {i for i, k in scene.jacobian if k in lengths}
    located = [(k, n + i, i not in with_lengths) for i, k in scene.own]
    labels = _labels(scene)
    labels.step("Sizes that the pivots are compared with: the diagonal of Φ_q M⁻¹ Φ_qᵀ")
    with graph.serving("factorization"):
        for (i, k), entry in scene.jacobian.items():
            entries[n + i, k] = entries[k, n + i] = entry
            if (k, k) not in entries:
                continue
            part = graph.div(graph.mul(entry, entry), scene.masses[k])
            references[n + i] = graph.add(references.get(n + i, graph.zero), part)
        for i, size in references.items():
            labels.add(size, labels.of("size", i))
        system = Elimination(
            graph,
            entries,
            [scene.applied + scene.gamma, *_pushes(scene)],
            frozenset(range(n, n + scene.m)),
            references,
            located,
            labels,
        )
        columns = system.solve(strategy)
        if refine:
            columns = [system.substitution.refined(k, x) for k, x in enumerate(columns)]
            labels.step("Refine by what the equations as stated still lack")
            labels.solved(columns)
        if scene.frictions:
            labels.step("Friction: its forces, and what they change")
        solution, rubbing = with_friction(scene, columns)
        labels.solved([solution])
    outputs = store("a", solution[:n], [q.rate.name for q in scene.equations.coordinates])
    names = scene.row_names()
    told = range(scene.m) if rows is None else rows
    outputs += tuple(Output("lam", row, solution[n + row], names[row]) for row in told)
    checks = tuple(check._replace(constraint=check.constraint - n) for check in system.checks)
    checks += rubbing
    return Kernel(
        "accelerations",
        "q̈ and λ of M q̈ + Φ_qᵀ λ = Q, Φ_q q̈ = γ.",
        (*STATE, "modes", "a", "lam"),
        outputs,
        checks,
        watched=True,
        labels=tuple(labels.found.values()),
        steps=tuple(labels.steps),
    )


def _labels(scene: SceneGraph) -> Labels:
    """Names of the equations of motion: without friction, and for a unit force of each friction."""
    coordinates = [q.name for q in scene.equations.coordinates]
    rates = [f"{q.rate.name}_rate" for q in scene.equations.coordinates]
    rows = scene.row_names()
    right = [*(f"Q_{name}" for name in coordinates), *(f"gamma_{name}" for name in rows)]
    solution = [*rates, *(f"lambda_{name}" for name in rows)]
    frictions = [e.name for e in scene.equations.effects if e.terms.friction]
    tails = ["", *(f"_{name}" for name in frictions)]
    return Labels(
        [*coordinates, *rows],
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
    """Accelerations that the constraints alone determine."""
    names = [q.rate.name for q in scene.equations.coordinates]
    with scene.graph.serving("factorization"):
        (solution,), checks, labels = _only(
            scene,
            [scene.gamma],
            [scene.graph.one] * scene.n,
            ["gamma"],
            [[f"{name}_rate" for name in names]],
        )
    return Kernel(
        "accelerations",
        "q̈ of Φ_q q̈ = γ (of least norm while drivers are missing).",
        (*STATE, "modes", "a", "lam"),
        store("a", solution, names),
        checks,
        watched=True,
        labels=tuple(labels.found.values()),
        steps=tuple(labels.steps),
    )


def correction(scene: SceneGraph) -> Kernel:
    """The changes of q and q̇ that meet the constraints, least in the norm of the weights w."""
    graph = scene.graph
    with graph.serving("correction"):
        right = _missing(graph, scene.jacobian, scene.phi, scene.nu, scene.v)
        names = [q.name for q in scene.equations.coordinates]
        unknowns = _stemmed(["dq", "dv"], names)
        changes, checks, labels = _only(scene, right, scene.w, MISSING, unknowns)
    return _correction(names, changes, checks, labels)


def least_correction(
    graph: Graph,
    jacobian: Entries,
    phi: list[int],
    nu: list[int],
    v: list[int],
    w: list[int],
    names: list[str],
    rows: list[str],
) -> Kernel:
    """The same for constraints, named `rows`, that stand in a graph without their scene."""
    with graph.serving("correction"):
        right = _missing(graph, jacobian, phi, nu, v)
        changes, checks, labels = _least(graph, jacobian, right, w, rows, MISSING)
    return _correction(names, changes, checks, labels)


def _missing(
    graph: Graph, jacobian: Entries, phi: list[int], nu: list[int], v: list[int]
) -> list[list[int]]:
    """-Φ and -(Φ_q q̇ + Φ_t)."""
    rates = [graph.neg(one) for one in nu]
    for (i, k), entry in jacobian.items():
        rates[i] = graph.add(rates[i], graph.mul(entry, v[k]))
    return [[graph.neg(one) for one in phi], [graph.neg(rate) for rate in rates]]


def _correction(
    names: list[str], changes: list[list[int]], checks: tuple[Check, ...], labels: Labels
) -> Kernel:
    dq, dv = changes
    return Kernel(
        "correction",
        "W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ times -Φ and -(Φ_q q̇ + Φ_t): w = 0 holds a coordinate.",
        (*STATE, "w", "dq", "dv"),
        store("dq", dq, names) + store("dv", dv, names),
        checks,
        watched=True,
        labels=tuple(labels.found.values()),
        steps=tuple(labels.steps),
    )


def _only(
    scene: SceneGraph,
    right: list[list[int]],
    weights: list[int],
    stems: list[str],
    unknowns: list[list[str]],
) -> tuple[list[list[int]], tuple[Check, ...], Labels]:
    """Solutions d of Φ_q d = right; where the constraints leave a choice, the least by weight.

    Parameters
    ----------
    stems, unknowns
        With which the names of the right sides begin, and names of the entries of d, by right side.
    """
    rows = scene.row_names()
    if scene.driven:
        coordinates = [q.name for q in scene.equations.coordinates]
        labels = Labels(rows, _stemmed(stems, rows), unknowns)
        system = Square(scene.graph, scene.jacobian, right, labels, coordinates)
        solutions = system.solve()
        if solutions is not None:
            return solutions, tuple(system.checks), labels
    return _least(scene.graph, scene.jacobian, right, weights, rows, stems)


def _least(
    graph: Graph,
    jacobian: Entries,
    right: list[list[int]],
    weights: list[int],
    names: list[str],
    stems: list[str],
) -> tuple[list[list[int]], tuple[Check, ...], Labels]:
    """Solutions d of Φ_q d = right that are least in the norm dᵀ W⁻¹ d."""
    by_row: dict[int, dict[int, int]] = {}
    for (i, k), entry in jacobian.items():
        by_row.setdefault(i, {})[k] = entry
    entries: dict[tuple[int, int], int] = {}
    labels = Labels(
        names,
        _stemmed(stems, names),
        _stemmed([stem.replace("rhs", "mu") for stem in stems], names),
        "S",
    )
    labels.step("The matrix and the right sides")
    rows = range(len(right[0]))
    for i, j in combinations_with_replacement(rows, 2):
        shared = [k for k in by_row.get(i, {}) if k in by_row.get(j, {})]
        if shared or i == j:
            terms = [graph.mul(graph.mul(by_row[i][k], weights[k]), by_row[j][k]) for k in shared]
            entries[i, j] = entries[j, i] = graph.total(terms)
            labels.entry(entries[i, j], i, j)
    for i in rows:
        labels.sides(right, i)
    references = {i: entries[i, i] for i in rows}
    system = Elimination(
        graph, entries, [list(r) for r in right], references=references, labels=labels
    )
    multipliers = system.solve("schur")
    labels.step("W Φ_qᵀ μ")
    solutions = []
    for mu in multipliers:
        d = [graph.zero] * len(weights)
        for (i, k), entry in jacobian.items():
            d[k] = graph.add(d[k], graph.mul(entry, mu[i]))
        solutions.append([graph.mul(w, x) for w, x in zip(weights, d, strict=True)])
    return solutions, tuple(system.checks), labels


def _stemmed(stems: list[str], names: list[str]) -> list[list[str]]:
    return [[f"{stem}_{name}" for name in names] for stem in stems]
