"""The kernel of accelerations and multipliers, by the elimination that costs least.

Its order is chosen before values are built.

A constraint with the row b of Φ_q feels the coordinate k with the mobility b_k² / M_kk: a light
body, a small moment of inertia at a long arm, answer to it most. Where one row feels mobilities
that lie far apart, an elimination that begins with M⁻¹ loses as many digits as the ratio has, and
pivots of Φ_q M⁻¹ Φ_qᵀ say nothing of rank.

Friction from reactions: accelerations and multipliers consistent with the friction they cause.

Without friction the solution is x₀; a unit force of friction j adds x_j. With the force -g_j S_j,
S_j the sum of the sizes of its loads, every load is linear in the solution, and the sums obey

    S_i = Σ |c + e_i S_i|,   c = load(x₀) - Σ_{j≠i} g_j S_j load(x_j),   e_i = -g_i load(x_i).

The right side is convex, so Newton's steps from 0 rise to the smallest solution: at once where one
load keeps its sign, in a step more for each sign that changes. Several frictions take a step each
in turn, a fixed number of times, so that the kernel stays one straight line.

A friction that sticks has no such equation: its force is an input, which the run determines so
that the slip stays zero. Whether sliding would jam does not matter then. The force stands in the
place of -g_j S_j.

The kernel checks the solution. Where the slope 1 - d/dS Σ|c + e S| is not positive no friction
balances the loads that it causes: the joint jams, and the result is nan. A remainder means that
the steps did not suffice; it is reported with the joint's name.
"""

import math

from codegen.errors import ModelError
from codegen.lower.constant_hoisting import WEAK_PIVOT
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.corrections import solutions
from codegen.lower.kernels.motion_system import MotionSystem, inertias, motion_system, written_back
from codegen.lower.linear.elimination_order import LARGE, CostExceededError, Structure
from codegen.lower.linear.factorization import Elimination, Entries, Strategy, augmented
from codegen.lower.linear.sparse_row_elimination import Task
from codegen.lower.operation_count import cheapest
from codegen.lower.program import Check, Kernel, Labels, Output, Program, store
from codegen.lower.scene_graph import SceneGraph

FAR = 1e5
"""accuracy: ratio of mobilities, of masses, or of moments of inertia, from which on solutions are
refined: an elimination that divides by the wrong ones loses as many digits as the ratio has.
"""
_NEGLIGIBLE = 1e-6  # accuracy: a slope of a length, or an arm beside the longest, that is none
_POSES = 5  # safety: poses in which arms are looked at; one in which all of them vanish is rare


def inverse_mass_ratio(scene: SceneGraph) -> float:
    """Largest ratio of two mobilities in a row of Φ_q, of two masses, or of two inertias.

    With the parameters as declared, at lengths of 0 and several angles. Raises ModelError where no
    float holds it.
    """
    system = motion_system(scene)
    inertia = inertias(scene, system)
    if not inertia:
        return 1.0
    groups: dict[str, list[float]] = {}
    for k, size in inertia.items():
        groups.setdefault(system.units[k], []).append(size)
    ratios = [max(group) / min(group) for group in groups.values()]
    for i, row in _felt_slopes(scene, system).items():
        try:
            felt: dict[object, float] = {}
            for k in sorted(row.keys() & inertia.keys()):  # of a body in space all axes together
                of = (system.owners[k], system.units[k]) if scene.turns else k
                felt[of] = felt.get(of, 0.0) + row[k] ** 2 / inertia[k]
            ratios.append(max(felt.values()) / min(felt.values()) if felt else 1.0)
        except ArithmeticError:  # beyond the largest float, or nearer to 0 than the smallest
            ratios.append(math.inf)
        if not math.isfinite(ratios[-1]):
            raise ModelError(
                f"joint or driver '{scene.rows[system.rows[i]]}': masses and moments of inertia at "
                f"its arms, from {min(row.values()):.3g} to {max(row.values()):.3g} m, lie more "
                "than 1e308 times apart; give kg, kg m^2 and m of one machine."
            )
    return max(ratios)


def _felt_slopes(scene: SceneGraph, system: MotionSystem) -> dict[int, dict[int, float]]:
    """Row by row the largest |Φ_ik| of all poses, beside those of lengths, without rounding."""
    found: dict[int, dict[int, float]] = {}
    lengths = system.lengths
    for entries in map(_Slopes(scene, system).at, range(_POSES)):
        for (i, k), slope in entries.items():
            if math.isfinite(slope) and slope != 0.0:
                row = found.setdefault(i, {})
                row[k] = max(row.get(k, 0.0), abs(slope))
    for i, row in found.items():
        unit = max((s for k, s in row.items() if k in lengths), default=max(row.values()))
        found[i] = {k: s / unit for k, s in row.items()}
    of_angles = (s for row in found.values() for k, s in row.items() if k not in lengths)
    least = dict.fromkeys(lengths, _NEGLIGIBLE)
    other = _NEGLIGIBLE * max(of_angles, default=0.0)
    return {
        i: {k: s for k, s in row.items() if s > least.get(k, other)} for i, row in found.items()
    }


def weak_pivot(spread: float) -> float:
    """The part of its reference below which a pivot is weak, for masses of this spread.

    Masses that lie far apart make genuine pivots as much smaller.
    """
    return WEAK_PIVOT if spread < FAR else float(f"{WEAK_PIVOT / spread:.1e}")


class _Slopes:
    """The entries of Φ_q in numbers."""

    def __init__(self, scene: SceneGraph, system: MotionSystem) -> None:
        self.places, self.turns = list(system.jacobian), scene.turns
        outputs = tuple(Output("out", s, v) for s, v in enumerate(system.jacobian.values()))
        kernel = Kernel("slopes", "", (), outputs)
        self.program = Program(tuple(scene.graph.values), (kernel,), (), WEAK_PIVOT)
        self.lengths = [q.unit == "m" for q in scene.equations.coordinates]
        self.p = [p.value for p in scene.equations.parameters]

    def at(self, pose: int) -> dict[tuple[int, int], float]:
        """Entries in a pose; none where one of them has no value there."""
        angles = (math.sin(1.0 + 2.3 * k + 1.7 * pose) * math.pi for k in range(len(self.lengths)))
        pairs = zip(self.lengths, angles, strict=True)
        q = [0.0 if is_length else angle for is_length, angle in pairs]
        for first in (turn.first for turn in self.turns):
            size = math.hypot(*q[first : first + 4])
            q[first : first + 4] = (e / size for e in q[first : first + 4])
        arguments = {"t": 0.0, "q": q, "p": self.p}
        try:
            found = evaluate(self.program, "slopes", arguments, math)
        except (ArithmeticError, ValueError, LookupError, TypeError):
            return {}
        return {place: found["out"][s] for s, place in enumerate(self.places)}


ALONE, SWEEPS = 6, 12  # steps for a single friction; sweeps over several
AGREED = 1e-7  # accuracy: accepted remainder of the equation of the loads, in parts of the loads
TINY = 1e-300  # safety: added to squares under a root, so that a load of zero has the size zero

Loads = list[list[tuple[int, list[int]]]]
"""A contact → its entries → (value without friction, change for a unit of each friction)."""


def with_friction(scene: SceneGraph, solutions: list[list[int]]) -> tuple[list[int], list[Check]]:
    """The solution with its friction, from the one without and those of unit forces."""
    graph, n = scene.graph, scene.n
    base, *units = solutions
    if not scene.frictions:
        return base, []
    coefficients = [f.choice(graph, f.stiction, graph.neg(f.coefficient)) for f in scene.frictions]
    changes = [
        [graph.mul(coefficient, x) for x in unit[n:]]
        for coefficient, unit in zip(coefficients, units, strict=True)
    ]

    def pressed(entry: dict[int, int]) -> tuple[int, list[int]]:
        return scene.along(entry, base[n:]), [scene.along(entry, change) for change in changes]

    loads = [[[pressed(e) for e in contact] for contact in f.loads] for f in scene.frictions]
    sums = [graph.zero] * len(loads)
    alone = len(loads) == 1
    if not alone:
        sums = [friction.choice(graph, graph.one, graph.zero) for friction in scene.frictions]
    for _ in range(ALONE if alone else SWEEPS):
        for i, (friction, contacts) in enumerate(zip(scene.frictions, loads, strict=True)):
            rest, slope = _remainder(scene, contacts, sums, i)
            sums[i] = graph.sub(sums[i], graph.div(rest, slope))
            if not alone:
                sums[i] = friction.choice(graph, graph.one, sums[i])
    checks: list[Check] = []
    for i, (friction, contacts) in enumerate(zip(scene.frictions, loads, strict=True)):
        row = min(row for load in friction.loads for entry in load for row in entry)
        rest, slope = _remainder(scene, contacts, sums, i)
        allowed = graph.mul(graph.constant(AGREED), graph.add(sums[i], graph.constant(TINY)))
        checks.append(Check(friction.choice(graph, graph.one, slope), graph.one, row))
        root = graph.power(slope, 0.5)  # nan where the joint jams: no number there means anything
        total = graph.div(graph.mul(sums[i], graph.mul(root, root)), slope)
        sums[i] = friction.choice(graph, graph.one, total)
        left = graph.sub(allowed, scene.size([rest]))
        checks.append(Check(friction.choice(graph, graph.one, left), graph.zero, row))
    result = list(base)
    for total, coefficient, unit in zip(sums, coefficients, units, strict=True):
        force = graph.mul(coefficient, total)
        result = [graph.add(x, graph.mul(force, y)) for x, y in zip(result, unit, strict=True)]
    return result, checks


def _remainder(scene: SceneGraph, contacts: Loads, sums: list[int], i: int) -> tuple[int, int]:
    """S_i - Σ |c + e S|, and its derivative by S_i."""
    graph = scene.graph
    rest, slope = sums[i], graph.one
    for load in contacts:
        pressed, pull = [], graph.zero
        for free, changes in load:
            terms = [graph.mul(e, s) for e, s in zip(changes, sums, strict=True)]
            pressed.append(graph.total([free, *terms]))
            pull = graph.add(pull, graph.mul(pressed[-1], changes[i]))
        squares = [graph.mul(x, x) for x in pressed]
        size = graph.power(graph.total([graph.constant(TINY), *squares]), 0.5)
        rest = graph.sub(rest, size)
        slope = graph.sub(slope, graph.div(pull, size))
    return rest, slope


CLOSE = 1.1  # measured: ratio of two costs that count as equal, since shared values are not counted

ORDERS: tuple[Strategy, ...] = ("substitute", "mixed", "schur")
"""The orders of a small system that are compared; of equal ones the first is taken."""

ORDERS_OF_LARGE: tuple[Strategy, ...] = (*ORDERS, "leaves")
SUBSTITUTING: tuple[Strategy, ...] = ("substitute", "leaves")
"""The orders that divide by no mass before a constraint determines its coordinate."""

FILLS: tuple[Strategy, ...] = ("mixed", "leaves", "schur", "substitute")
"""From the least fill to the most, in any machine: the first ones limit the cost of the others."""
ARGUMENTS = "t q v p modes a lam"


def is_large(scene: SceneGraph) -> bool:
    """Whether a scene has so many unknowns that its order is chosen by structure."""
    return scene.n + scene.m >= LARGE


def elimination(
    scene: SceneGraph, labels: Labels, structure: Structure | None = None,
    right: list[list[int]] | None = None,
) -> Elimination:  # fmt: skip
    """The system [M Φ_qᵀ; Φ_q 0], by default with a right side for the forces and each friction.

    In a `structure` its values are kinds of values.
    """
    system, graph = motion_system(scene), structure or scene.graph
    n, m = system.n, len(system.rows)
    mass, jacobian = (_kinds(scene, e, structure) for e in (system.mass, system.jacobian))
    entries, references = augmented(graph, mass, jacobian, n)
    for i, size in references.items():
        labels.name(size, "size", i)
    duals = frozenset(range(n, n + m))
    forces = scene.frictions if right is None else ()
    right = right or [system.forces + system.gamma]
    for friction in forces:  # a unit force of it
        push = scene.turning.six(friction.direction)
        columns = scene.turning.of_motion(scene.n)
        right.append([*(push.get(k, scene.graph.zero) for k in columns), *[scene.graph.zero] * m])
    if structure:
        right = [structure.kinds(scene.graph, column) for column in right]
    lengths = system.lengths
    with_lengths = {i for i, k in system.jacobian if k in lengths}
    column = {name: k for k, name in enumerate(system.names)}
    pairs = [(system.rows.index(i), column[scene.names[k]]) for i, k in scene.massless]
    located = [(k, n + i, i not in with_lengths) for i, k in pairs]
    owners = [*system.owners, *(scene.owners[i] for i in system.rows)]
    return Elimination(graph, entries, right, duals, references, located, labels, owners)


def _kinds(scene: SceneGraph, entries: Entries, structure: Structure | None) -> Entries:
    if structure is None:
        return entries
    return {place: structure.kind(scene.graph, value) for place, value in entries.items()}


def cheapest_by_structure(
    scene: SceneGraph, orders: tuple[Strategy, ...] = ORDERS_OF_LARGE
) -> Strategy:
    """The first of the orders that cost least, by the structure of the equations of motion."""
    costs, least = dict[Strategy, float](), math.inf
    for strategy in sorted(orders, key=FILLS.index):
        structure = Structure(CLOSE * least)
        try:
            elimination(scene, Labels(), structure).solve(strategy)
        except CostExceededError:
            continue
        costs[strategy] = structure.cost
        least = min(costs.values())
    return next(s for s in orders if costs.get(s, math.inf) <= CLOSE * least)


def accelerations(
    scene: SceneGraph, rows: tuple[int, ...], spread: float
) -> tuple[Kernel, Strategy]:
    """The fused kernel, by the order that costs least; it returns the multipliers of `rows`.

    Where the masses have a `spread` that is far, it substitutes as long as it can, which divides
    by no mass, and refines the solution.
    """
    if not scene.mass:
        driven = scene.equations.scene.analysis == "kinematics" and scene.m == scene.n > 0
        return _kinematics(scene), "square" if driven else "schur"
    if spread >= FAR:
        order = cheapest_by_structure(scene, SUBSTITUTING) if is_large(scene) else "substitute"
        return dynamics_kernel(scene, order, rows, refine=True), order
    orders = (cheapest_by_structure(scene),) if is_large(scene) else ORDERS
    trials = {strategy: dynamics_kernel(scene, strategy, rows) for strategy in orders}
    kernel = cheapest(scene.graph, list(trials.values()))
    return kernel, next(strategy for strategy, trial in trials.items() if trial is kernel)


def dynamics_kernel(
    scene: SceneGraph, strategy: Strategy, rows: tuple[int, ...], refine: bool = False
) -> Kernel:
    """The fused kernel by one order of elimination, with a step of refinement or without."""
    n, graph, names = scene.n, scene.graph, scene.row_names
    motion = motion_system(scene)
    labels = _labels(scene, motion)
    labels.step("Sizes that the pivots are compared with: the diagonal of Φ_q M⁻¹ Φ_qᵀ")
    with graph.serving("factorization"):
        system = elimination(scene, labels)
        columns = system.solve(strategy)
        if refine:
            columns = system.refined(columns)
            labels.step("Refine by what the equations as stated still lack")
            labels.solved(columns)
        if scene.frictions:
            labels.step("Friction: its forces, and what they change")
        found = [written_back(scene, motion, column, k > 0) for k, column in enumerate(columns)]
        found = [[*column[:n], *scene.multipliers(column[n:])] for column in found]
        solution, rubbing = with_friction(scene, found)
        if scene.m == len(names):
            labels.solved(columns[:1] if scene.turns else [solution])
    outputs = store("a", solution[:n], scene.rates)
    outputs += tuple(Output("lam", row, solution[n + row], names[row]) for row in rows)
    stated = [scene.stated[row] for row in motion.rows]
    checks = [
        check._replace(constraint=stated[check.constraint - motion.n]) for check in system.checks
    ]
    checks += rubbing
    summary = "q̈ and λ of M q̈ + Φ_qᵀ λ = Q, Φ_q q̈ = γ."
    return labels.kernel("accelerations", summary, ARGUMENTS, outputs, checks)


def _labels(scene: SceneGraph, system: MotionSystem) -> Labels:
    """Names of the equations of motion: without friction, and for a unit force of each friction."""
    rows = [scene.rows[i] for i in system.rows]
    right = [f"Q_{name}" for name in system.names] + [f"gamma_{name}" for name in rows]
    solution = [f"{rate}_rate" for rate in system.rates] + [f"lambda_{name}" for name in rows]
    tails = ["", *(f"_{e.name}" for e in scene.equations.effects if e.terms.friction)]
    return Labels(
        [*system.names, *rows],
        [[name + tail for name in right] for tail in tails],
        [[name + tail for name in solution] for tail in tails],
    )


def _kinematics(scene: SceneGraph) -> Kernel:
    """Accelerations that the constraints alone determine, the least where they leave a choice."""
    graph, rates, stated = scene.graph, scene.rates, scene.stated
    ones, unknowns = [graph.one] * scene.n, [[f"{rate}_rate" for rate in rates]]
    right, stems = [scene.gamma], ["gamma"]
    with graph.serving("factorization"):
        task = Task(graph, scene.jacobian, right, ones, scene.names, scene.rows, stems, unknowns)
        (solution,), solver = solutions(task)[0]
    outputs = store("a", solution, rates)
    summary = "q̈ of Φ_q q̈ = γ (of least norm while drivers are missing)."
    checks = [check._replace(constraint=stated[check.constraint]) for check in solver.checks]
    return solver.labels.kernel("accelerations", summary, ARGUMENTS, outputs, checks)
