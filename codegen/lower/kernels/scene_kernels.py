"""Equations of a scene → the program of all its kernels."""

from dataclasses import dataclass, replace

from codegen.derive.equations import Equations
from codegen.lower.constant_hoisting import with_constants
from codegen.lower.kernels.contacts import hold_kernels, reaction_note, switched_reactions
from codegen.lower.kernels.corrections import correction
from codegen.lower.kernels.linear_solves import accelerations
from codegen.lower.kernels.selection import Selection, recovered
from codegen.lower.linear.factorization import Strategy
from codegen.lower.module_tables import Description, describe
from codegen.lower.program import STATE, Folded, Kernel, Output, Program, store
from codegen.lower.scene_graph import SceneGraph


@dataclass(frozen=True)
class Lowered:
    """A scene ready to be emitted.

    Attributes
    ----------
    program
        All kernels.
    description
        The tables that go with them.
    strategy
        The order of elimination that was cheapest; None where nothing is eliminated.
    scene
        The equations as values of the graph that the program was made from.
    """

    program: Program
    description: Description
    strategy: Strategy | None
    scene: SceneGraph

    @property
    def kernels(self) -> dict[str, Kernel]:
        """The kernels by name."""
        return {kernel.name: kernel for kernel in self.program.kernels}


def lower(equations: Equations) -> Lowered:
    """Translate every equation into one graph, and arrange its values in kernels."""
    scene, selection = SceneGraph(equations), Selection(equations)
    rows = recovered(scene, selection)
    kernels = [
        Kernel("constraints", "Φ(q, t).", ("t", "q", "p", "phi"), _named(scene, "phi", scene.phi)),
        Kernel(
            "jacobian",
            "Structural non-zeros of Φ_q, at JACOBIAN_ROWS, JACOBIAN_COLUMNS.",
            ("t", "q", "p", "values"),
            store("values", list(scene.jacobian.values()), _jacobian_notes(scene)),
        ),
        Kernel(
            "velocity_rhs",
            "ν = -Φ_t, so that Φ_q q̇ = ν.",
            ("t", "q", "p", "nu"),
            _named(scene, "nu", scene.nu),
        ),
    ]
    resting = equations.scene.analysis == "equilibrium"
    if not resting:
        kernels.append(
            Kernel(
                "acceleration_rhs",
                "γ = -(Φ_q q̇)_q q̇ - 2 Φ_qt q̇ - Φ_tt, so that Φ_q q̈ = γ.",
                (*STATE, "gamma"),
                _named(scene, "gamma", scene.gamma),
            )
        )
    strategy: Strategy | None = None
    if rows or not resting:
        fused, strategy = accelerations(scene, rows)
        kernels.append(fused)
    if not resting:
        kernels.append(correction(scene))
    powers: list[tuple[str, str, int]] = []
    if equations.mass:
        powers = [row for row in _powers(scene) if selection.power(row[0])] + _works(
            scene, selection
        )
        kernels += _dynamic_kernels(scene, selection, powers)
    elif _reported(scene, selection):
        kernels.append(_reactions(scene, selection))
    if equations.switches:
        kernels += _switching_kernels(scene, resting)
        kernels += hold_kernels(scene, selection)
    _note_weights(scene)
    program = with_constants(scene.graph, tuple(kernels), len(equations.parameters))
    description = describe(equations, scene, powers, _reported(scene, selection), rows)
    return Lowered(program, description, strategy, scene)


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
            scene.graph.values[k] = replace(value, origin=origins[abs(number)])


def _reported(scene: SceneGraph, selection: Selection) -> tuple[int, ...]:
    """Which of the scene's reactions are asked for, in order."""
    return tuple(k for k, (name, *_) in enumerate(scene.reactions) if selection.reaction(name))


def _dynamic_kernels(
    scene: SceneGraph, selection: Selection, powers: list[tuple[str, str, int]]
) -> list[Kernel]:
    coordinates = [q.name for q in scene.equations.coordinates]
    graph = scene.graph
    resting = not selection.moves
    kernels = [
        Kernel(
            "mass",
            "Structural non-zeros of M, at MASS_ROWS, MASS_COLUMNS.",
            ("q", "p", "values"),
            store("values", list(scene.mass.values()), _mass_notes(scene)),
        ),
        Kernel(
            "applied_forces",
            _meaning_of_forces(scene),
            (*STATE, "modes", "Q"),
            store("Q", scene.forces, coordinates),
        ),
    ]
    if resting or selection.energy():
        kernels += [
            Kernel(
                "potential",
                "Potential energy V, J.",
                ("t", "q", "p", "modes"),
                (Output("return", 0, scene.potential),),
            ),
            Kernel(
                "potential_gradient",
                "∂V/∂q.",
                ("t", "q", "p", "modes", "g"),
                store("g", scene.gradient, coordinates),
            ),
        ]
    if selection.energy() and not resting:
        energies = [
            graph.mul(mass, graph.mul(scene.v[i], scene.v[k]))
            if i == k
            else graph.mul(graph.constant(2.0), graph.mul(mass, graph.mul(scene.v[i], scene.v[k])))
            for (i, k), mass in scene.mass.items()
            if i <= k
        ]
        kinetic = graph.mul(graph.constant(0.5), graph.total(energies))
        kernels.append(
            Kernel(
                "kinetic_energy",
                "T = q̇ᵀ M q̇ / 2, J.",
                ("q", "v", "p"),
                (Output("return", 0, kinetic),),
            )
        )
    if powers or (selection.outputs is None and not resting):
        kernels.append(
            Kernel(
                "powers",
                "Power in W: Q_eᵀ q̇ of each effect without a potential, λᵀ Φ_t of each driver.",
                (*STATE, "modes", "lam", "out"),
                store("out", [w for *_, w in powers], [source for source, *_ in powers]),
            )
        )
    if _reported(scene, selection) or selection.outputs is None:
        kernels.append(_reactions(scene, selection))
    return kernels


def _mass_notes(scene: SceneGraph) -> list[str]:
    names = [q.name for q in scene.equations.coordinates]
    return [names[i] if i == k else f"{names[i]}, {names[k]}" for i, k in scene.mass]


def _meaning_of_forces(scene: SceneGraph) -> str:
    known = "without friction from reactions"
    if scene.equations.inertia_force:
        return f"Generalized forces Q = ΣQ_e - ∂V/∂q, {known}, and of inertia, Q_v."
    return f"Generalized forces Q = ΣQ_e - ∂V/∂q of the effects, {known}."


def _reactions(scene: SceneGraph, selection: Selection) -> Kernel:
    switched = switched_reactions(scene)
    outputs = tuple(
        Output("out", row, scene.reactions[k][3], reaction_note(scene, k))
        for row, k in enumerate(_reported(scene, selection))
        if k not in switched
    )
    return Kernel(
        "reactions",
        "Reactions: joint forces on the second body in the joint's axes, and forces of drivers.",
        (*STATE, "lam", "out"),
        outputs,
    )


def _switching_kernels(scene: SceneGraph, resting: bool) -> list[Kernel]:
    switches = scene.equations.switches
    notes = [f"{switch.effect}: {switch.text}" for switch in switches]
    g, rates = [], []
    for switch in switches:
        with scene.graph.serving(switch.effect):
            g.append(scene.translate(switch.g))
            rates.append(scene.translate(switch.rate))
    switching = Kernel(
        "switching",
        "Switching functions g: a condition holds where its g > 0.",
        (*STATE, "g"),
        store("g", g, notes),
    )
    if resting:
        return [switching]
    return [
        switching,
        Kernel(
            "switching_rates",
            "dg/dt along the motion.",
            ("t", "q", "v", "a", "p", "rate"),
            store("rate", rates, notes),
        ),
    ]


def _powers(scene: SceneGraph) -> list[tuple[str, str, int]]:
    """Q·q̇ of each effect; λ Φ_t of each driver (its force -Φ_qᵀ λ on velocities Φ_q q̇ = ν).

    An equation of one's own that contains the time does work as a driver does.
    """
    powers = [(name, "effect", power) for name, power in scene.powers]
    row = 0
    for element in scene.equations.constraints:
        rows = range(row, row + len(element.terms.phi))
        row = rows.stop
        if element.driver or any(scene.nu[k] != scene.graph.zero for k in rows):
            terms = [scene.graph.mul(scene.nu[k], scene.lam[k]) for k in rows]
            powers.append((element.name, "driver", scene.graph.neg(scene.graph.total(terms))))
    return powers


def _works(scene: SceneGraph, selection: Selection) -> list[tuple[str, str, int]]:
    """The powers whose integrals are asked for, of effects with all that they exert."""
    whole = [(name, value) for name, _, value in _powers(scene) if name not in scene.working]
    pairs = [*scene.working.items(), *whole]
    return [(f"work({name})", "work", value) for name, value in pairs if selection.work(name)
            and value != scene.graph.zero]  # fmt: skip


def _named(scene: SceneGraph, array: str, values: list[int]) -> tuple[Output, ...]:
    return store(array, values, scene.row_names())


def _jacobian_notes(scene: SceneGraph) -> list[str]:
    rows = scene.row_names()
    return [f"{rows[i]}, {scene.equations.coordinates[k].name}" for i, k in scene.jacobian]
