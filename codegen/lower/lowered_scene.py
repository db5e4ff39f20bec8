"""Equations of a scene → the program with all kernels that its outputs need."""

from dataclasses import dataclass

from codegen.derive.equations import Equations, tracked_points
from codegen.derive.watched_functions import PeakedFunction, kinks, peaked_functions
from codegen.garbage_collection import collection_paused
from codegen.lower.constant_hoisting import WEAK_PIVOT, with_constants
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.kernels.accelerations import accelerations, inverse_mass_ratio, weak_pivot
from codegen.lower.kernels.corrections import correction
from codegen.lower.kernels.derived_outputs import derived_kernel, derived_rows
from codegen.lower.kernels.independent_rows import (
    SharedRows,
    free_multipliers,
    with_independent_rows,
)
from codegen.lower.kernels.motion_system import motion_system
from codegen.lower.kernels.scalar_kernels import (
    condition_kernels,
    hold_kernels,
    reaction_outputs,
    sampling_kernels,
    watching_kernels,
)
from codegen.lower.linear.factorization import Strategy
from codegen.lower.module_tables import Description, describe
from codegen.lower.program import (
    STATE,
    Folded,
    Input,
    Kernel,
    Output,
    Program,
    dependencies,
    store,
    storing,
)
from codegen.lower.scene_graph import Reaction, SceneGraph
from codegen.lower.tree_height_reduction import reduce_height


class Selection:
    """The outputs that a scene names; all of them where it names none."""

    def __init__(self, equations: Equations) -> None:
        self.outputs = outputs = equations.scene.outputs
        self.default = outputs is None or "default" in outputs
        # whether the scene asks how the machine moves under forces, and not only where it rests
        self.moves = equations.scene.analysis == "dynamics"
        # A run holds a friction in a joint that sticks against its limit in each position.
        laws = ((e.name, e.terms.friction) for e in equations.effects)
        self._needed = {name for name, law in laws if law and law.limit is not None}
        self._points = tracked_points(equations)
        self._read = {symbol.name for one in equations.derived for symbol in one.series}
        self._massive = bool(equations.mass)

    def energy(self) -> bool:
        """Whether kinetic and potential energy are."""
        return self._names("energy")

    def power(self, source: str = "") -> bool:
        """Whether the power of an effect or driver is; of none: those that balance the energies."""
        return self.moves and self._names("power", source)

    def work(self, source: str) -> bool:
        """Whether the work of an effect or driver is, which has to be named."""
        return self.moves and _is_named(self.outputs, "work", source)

    def reactions(self, scene: SceneGraph) -> list[Reaction]:
        """The forces that are, of elements that transmit them."""
        return [row for row in scene.reactions if self._reported(row)]

    def _reported(self, row: Reaction) -> bool:
        is_place = row.element in self._points and row.unit in ("m", "m/s")
        if f"{row.element}.{row.component}" in self._read:
            return self._massive or {"reaction", "shaking"}.isdisjoint(row.words)
        if is_place or ("reaction" in row.words and row.element in self._needed):
            return True
        asked = (self._names(word, row.element) for word in row.words if word != "reaction")
        if self.outputs is not None and any(asked):
            return True
        return "reaction" in row.words and self._massive and self._names("reaction", row.element)

    def multipliers(self, scene: SceneGraph) -> tuple[int, ...]:
        """Constraints on whose multipliers an output depends; all by default."""
        if self.default:
            return tuple(range(scene.m))
        values = [row.value for row in self.reactions(scene)]
        values += [value for name, value in scene.powers if self.power(name) or self.work(name)]
        literals = (scene.graph.values[k].literal for k in dependencies(scene.graph.values, values))
        needed = {x.slot for x in literals if isinstance(x, Input) and x.array == "lam"}
        for row, name in enumerate(scene.owners):
            if scene.nu[row] != scene.graph.zero and (self.power(name) or self.work(name)):
                needed.add(row)
        return tuple(sorted(needed))

    def _names(self, word: str, element: str = "") -> bool:
        """Whether a word is asked for, of all elements or of one."""
        by_default = self.default and word in ("reaction", "energy", "power")
        return self.outputs is None or by_default or _is_named(self.outputs, word, element)


def _is_named(outputs: tuple[str, ...] | None, word: str, element: str) -> bool:
    """Whether a list of outputs has a word, of all elements or of one."""
    return not {word, f"{word}s", f"{word}({element})"}.isdisjoint(outputs or ())


def peak_arguments(scene: SceneGraph, peaks: tuple[PeakedFunction, ...]) -> Kernel:
    """The kernel that a run calls in each step; see `codegen.derive.watched_functions`."""
    graph = scene.graph
    velocities = dict(zip(scene.q, scene.v, strict=True))
    motion = Direction(graph, {**velocities, scene.time: graph.one}, order=1)
    arguments, rates = list[int](), list[int]()
    for peak in peaks:
        (argument,) = scene.credited(peak.element, peak.argument)
        with graph.serving(peak.element):
            rates.append(motion.jet(argument).first.value())
        arguments.append(argument)
    notes = [f"{peak.element}: {peak.kind}" for peak in peaks]
    outputs = store("u", arguments, notes) + store("rate", rates, notes)
    summary = "Arguments u of peaked functions of the position, as in PEAKS, and du/dt."
    return Kernel("peak_arguments", summary, ("t", "q", "v", "p", "modes", "u", "rate"), outputs)


@dataclass(frozen=True)
class Lowered:
    """A scene ready to be emitted: its kernels, their tables, and the graph of their values."""

    program: Program
    description: Description
    strategy: Strategy | None  # the cheapest order of elimination; None: nothing is eliminated
    scene: SceneGraph
    independent: SceneGraph  # the same with independent constraints
    shared: tuple[SharedRows, ...] = ()  # joints with redundant rows, and what they are left as

    @property
    def kernels(self) -> dict[str, Kernel]:
        """The kernels by name."""
        return {kernel.name: kernel for kernel in self.program.kernels}


@collection_paused()
def outline(equations: Equations) -> Lowered:
    """The equations as values of one graph, of which the constraints alone are kernels."""
    scene = SceneGraph(equations)
    kernels = tuple(_constraint_kernels(scene))
    program = Program(tuple(scene.graph.values), kernels, (), WEAK_PIVOT)
    return Lowered(program, describe(scene, scene, [], [], ()), None, scene, scene)


@collection_paused()
def lower(
    equations: Equations, shared: tuple[SharedRows, ...] = (), scene: SceneGraph | None = None
) -> Lowered:
    """Translate every equation into one graph, and arrange its values in kernels.

    Linear systems are solved with what the joints that are `shared` leave. `scene`: of an outline.
    """
    scene, selection = scene or SceneGraph(equations), Selection(equations)
    independent = with_independent_rows(scene, shared)
    resting = equations.scene.analysis == "equilibrium"
    kernels = _constraint_kernels(scene)
    if shared:
        kernels += _constraint_kernels(independent, "independent_")
    strategy: Strategy | None = None
    spread = inverse_mass_ratio(independent)
    recovered, reported = selection.multipliers(scene), selection.reactions(scene)
    if recovered or not resting:
        fused, strategy = accelerations(independent, recovered, spread)
        kernels.append(reduce_height(scene.graph, fused))
    free = 0
    if shared and strategy and equations.mass and recovered:
        found = free_multipliers(independent, scene.jacobian, shared, strategy)
        if found is not None:
            kernel, free = found
            kernels.append(kernel)
    if not resting:
        kernels.append(correction(independent))
    powers: list[tuple[str, str, int]] = []
    if equations.mass:
        powers = _powers(scene, selection)
        kernels += _dynamic_kernels(scene, selection, powers)
    if reported or (equations.mass and selection.default):
        summary = (
            "Reactions: joint forces on the second body in the joint's axes, and forces of drivers."
        )
        outputs = reaction_outputs(scene, reported, switched=False)
        kernels.append(Kernel("reactions", summary, (*STATE, "lam", "out"), outputs))
    if derived := [*derived_rows(scene, reported)]:
        kernels.append(derived_kernel(derived, len(reported)))
    if equations.switches:
        kernels += _switching_kernels(scene, resting)
        kernels += hold_kernels(scene, reported)
    peaks = peaked_functions(equations) if equations.mass and selection.moves else ()
    peaks = (*peaks, *kinks(equations))
    if peaks:
        kernels.append(peak_arguments(scene, peaks))
    kernels += [*condition_kernels(scene), *sampling_kernels(scene), *watching_kernels(scene)]
    _note_weights(scene)
    program = with_constants(
        scene.graph, tuple(kernels), len(equations.parameters), weak_pivot(spread)
    )
    description = describe(
        scene, independent, powers, [*reported, *derived], recovered, peaks, free
    )
    return Lowered(program, description, strategy, scene, independent, shared)


def _constraint_kernels(scene: SceneGraph, kind: str = "") -> list[Kernel]:
    """Φ, Φ_q, ν and, of a scene that moves, γ, each row in the place of a constraint as stated."""
    rows, table = scene.row_names, f"{kind}jacobian".upper()
    entries = [f"{scene.rows[i]}, {scene.names[k]}" for i, k in scene.jacobian]

    def placed(name: str, summary: str, arguments: str, values: list[int]) -> Kernel:
        known = dict(zip(scene.stated, values, strict=True))
        stored = [known.get(i, scene.graph.zero) for i in range(len(rows))]
        return storing(kind + name, summary, arguments, stored, rows)

    sparse = f"Structural non-zeros of Φ_q, at {table}_ROWS, {table}_COLUMNS."
    slopes = list(scene.jacobian.values())
    kernels = [
        placed("constraints", "Φ(q, t).", "t q p phi", scene.phi),
        storing(f"{kind}jacobian", sparse, "t q p values", slopes, entries),
        placed("velocity_rhs", "ν = -Φ_t, so that Φ_q q̇ = ν.", "t q p nu", scene.nu),
    ]
    if scene.equations.scene.analysis != "equilibrium":
        summary = "γ = -(Φ_q q̇)_q q̇ - 2 Φ_qt q̇ - Φ_tt, so that Φ_q q̈ = γ."
        kernels.append(placed("acceleration_rhs", summary, "t q v p gamma", scene.gamma))
    return kernels


def _note_weights(scene: SceneGraph) -> None:
    """Give the numbers m g, which SymPy multiplied out, their origin."""
    origins: dict[float, Folded] = {}
    for effect in scene.equations.effects:
        for body, mass, g in effect.terms.weights:
            if mass.is_number and g.is_number:
                factors = float(mass), float(g)
                weight = abs(factors[0] * factors[1])
                if weight not in (*factors, 0.0):
                    origins.setdefault(weight, Folded("*", factors, f"{body}: m g"))
    for k, value in enumerate(scene.graph.values):
        number = value.literal
        if value.origin is None and isinstance(number, float) and abs(number) in origins:
            scene.graph.values[k] = value._replace(origin=origins[abs(number)])


def _dynamic_kernels(
    scene: SceneGraph, selection: Selection, powers: list[tuple[str, str, int]]
) -> list[Kernel]:
    names, resting = scene.names, not selection.moves
    entries = [names[i] if i == k else f"{names[i]}, {names[k]}" for i, k in scene.mass]
    sparse = "Structural non-zeros of M, at MASS_ROWS, MASS_COLUMNS."
    of, end = " of the effects", "."
    if scene.equations.inertia_force:
        of, end = "", ", and of inertia, Q_v."
    forces = f"Generalized forces Q = ΣQ_e - ∂V/∂q{of}, without friction from reactions{end}"
    kernels = [
        storing("mass", sparse, "q p values", list(scene.mass.values()), entries),
        storing("applied_forces", forces, "t q v p modes Q", scene.forces, names),
    ]
    if resting or selection.energy():
        energy = (Output("return", 0, scene.potential),)
        kernels += [
            Kernel("potential", "Potential energy V, J.", ("t", "q", "p", "modes"), energy),
            storing("potential_gradient", "∂V/∂q.", "t q p modes g", scene.gradient, names),
        ]
    if selection.energy() and not resting:
        energy = (Output("return", 0, _kinetic_energy(scene)),)
        kernels.append(Kernel("kinetic_energy", "T = q̇ᵀ M q̇ / 2, J.", ("q", "v", "p"), energy))
    if powers or (selection.default and not resting):
        summary = "Power in W: Q_eᵀ q̇ of each effect without a potential, λᵀ Φ_t of each driver."
        values, sources = [w for *_, w in powers], [source for source, *_ in powers]
        kernels.append(storing("powers", summary, "t q v p modes lam out", values, sources))
    return kernels


def _kinetic_energy(scene: SceneGraph) -> int:
    graph, system = scene.graph, motion_system(scene)
    terms, v = [], system.speeds
    of_states = {system.names.index(state.integral.name) for state in scene.equations.states}
    for (i, k), mass in system.mass.items():
        if i <= k and k not in of_states:
            term = graph.mul(mass, graph.mul(v[i], v[k]))
            terms.append(term if i == k else graph.mul(graph.constant(2.0), term))
    return graph.mul(graph.constant(0.5), graph.total(terms))


def _switching_kernels(scene: SceneGraph, resting: bool) -> list[Kernel]:
    switches = scene.equations.switches
    notes = [f"{switch.effect}: {switch.text}" for switch in switches]
    values = (scene.credited(switch.effect, switch.g, switch.rate) for switch in switches)
    g, rates = zip(*values, strict=True)
    summary = "Switching functions g: a condition holds where its g > 0."
    kernels = [storing("switching", summary, "t q v p g", g, notes)]
    if not resting:
        summary = "dg/dt along the motion."
        kernels.append(storing("switching_rates", summary, "t q v a p rate", rates, notes))
    return kernels


def _powers(scene: SceneGraph, selection: Selection) -> list[tuple[str, str, int]]:
    """Q·q̇ of each effect; λ Φ_t of each driver (its force -Φ_qᵀ λ on velocities Φ_q q̇ = ν).

    A user's equation that contains the time does work as a driver does. Of an effect with a
    potential the first are the powers of its other forces, which make a balance with the energies.
    Behind them stand, where they are outputs, the powers of all its forces, and those whose
    integrals are.
    """
    graph, stored = scene.graph, scene.conservative
    powers = [
        (name, "nonconservative" if name in stored else "effect", power)
        for name, power in scene.powers
        if name not in stored or selection.power()
    ]
    row = 0
    for element in scene.equations.constraints:
        rows = range(row, row + len(element.terms.phi))
        row = rows.stop
        if element.driver or any(scene.nu[k] != graph.zero for k in rows):
            work = graph.dot((scene.nu[k] for k in rows), (scene.lam[k] for k in rows))
            powers.append((element.name, "driver", graph.neg(work)))
    working = scene.working | {name: w for name, _, w in powers if name not in scene.working}
    selected = [row for row in powers if selection.power(row[0])]
    for name, value in working.items():
        if selection.work(name) and value != graph.zero:
            selected.append((f"work({name})", "work", value))
        elif name in stored and selection.moves and _is_named(selection.outputs, "power", name):
            selected.append((f"power({name})", "power", value))
    return selected
