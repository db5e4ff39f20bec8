"""The kernels of the reduced formulation.

`coordinate_map` gives all coordinates by those that are kept, `projected_equations` the equations
of motion in these. The kernels have the names and arguments of the scene's own, in fewer
coordinates, so that every integrator accepts them. In ``p`` the branches of the loops in closed
form follow the parameters.
"""

import math
from dataclasses import dataclass, replace

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.differentiation.program_tangents import differentiate, tangent_program
from codegen.lower.kernels.corrections import least_correction
from codegen.lower.lowered_scene import Lowered
from codegen.lower.module_tables import Pattern
from codegen.lower.program import STATE, Kernel, Program, store, storing
from codegen.lower.substitution import substitute
from codegen.reduce.coordinate_map import EVENT_KERNELS, CoordinateMap
from codegen.reduce.projected_equations import ProjectedEquations

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Reduced:
    """The reduced equations of a scene."""

    program: Program  # its kernels, with their derivatives
    kept: tuple[int, ...]  # columns of the coordinates that are integrated
    closures: tuple[int, ...]  # rows of the constraints that hold between them
    angles: tuple[int, ...]  # columns of the angles in closed form
    branches: tuple[tuple[int, int], ...]  # (angle, row of its loop) whose branch a run has to know
    jacobian: Pattern  # pattern of Φ_r
    mass: Pattern  # pattern of M_r


def reduce(lowered: Lowered) -> Reduced:
    """The equations of motion of a scene in the coordinates that its constraints leave."""
    graph = lowered.scene.graph
    with graph.serving("reduction"):
        mapping = CoordinateMap(lowered)
        equations = ProjectedEquations(mapping)
        kernels = (
            *_constraint_kernels(equations),
            *_motion_kernels(equations),
            *_event_kernels(mapping),
            *_expansion_kernels(mapping),
        )
    branching = mapping.branching
    declared = len(lowered.description.parameters) + len(branching)
    program = with_constants(graph, kernels, declared)
    tangents = tangent_program(program)
    return Reduced(
        replace(tangents, kernels=(*program.kernels, *tangents.kernels)),
        mapping.kept,
        mapping.closures,
        tuple(angle.column for angle in mapping.angles),
        tuple((angle.column, angle.row) for angle in branching),
        Pattern.of(equations.jacobian),
        Pattern.of(equations.mass),
    )


def _constraint_kernels(equations: ProjectedEquations) -> list[Kernel]:
    mapping, jacobian = equations.mapping, equations.jacobian
    rows, nu, gamma = mapping.row_names, equations.nu, equations.gamma
    notes = [f"{rows[i]}, {mapping.names[mapping.kept[k]]}" for i, k in jacobian]
    left = "Φ_r: the constraints that are left."
    sparse = "Structural non-zeros of Φ_r, at JACOBIAN_ROWS, JACOBIAN_COLUMNS."
    velocity = "ν_r = -∂Φ_r/∂t, so that Φ_r u̇ = ν_r."
    return [
        storing("constraints", left, "t q p phi", equations.phi, rows),
        storing("jacobian", sparse, "t q p values", list(jacobian.values()), notes),
        storing("velocity_rhs", velocity, "t q p nu", nu, rows),
        storing("acceleration_rhs", "γ_r, so that Φ_r ü = γ_r.", "t q v p gamma", gamma, rows),
    ]


def _motion_kernels(equations: ProjectedEquations) -> list[Kernel]:
    mapping, mass = equations.mapping, equations.mass
    names = [mapping.names[k] for k in mapping.kept]
    weights = [mapping.graph.input("w", slot, f"w_{name}") for slot, name in enumerate(names)]
    rates = [mapping.substitutes[mapping.scene.v[k]] for k in mapping.kept]
    notes = [f"{names[i]}, {names[k]}" for i, k in mass]
    sparse = "Structural non-zeros of M_r = Tᵀ M T, at MASS_ROWS, MASS_COLUMNS."
    pull = "Generalized forces Q_r = Tᵀ (Q - M γ)."
    phi, nu = equations.phi, equations.nu
    return [
        storing("reduced_mass", sparse, "t q p values", list(mass.values()), notes),
        storing("applied_forces", pull, "t q v p modes Q", equations.force, names),
        equations.accelerations(),
        least_correction(
            mapping.graph, equations.jacobian, phi, nu, rates, weights, names, mapping.row_names
        ),
    ]


def _event_kernels(mapping: CoordinateMap) -> list[Kernel]:
    """The kernels of events, with the accelerations of all coordinates by those that are kept."""
    graph, kernels = mapping.graph, mapping.lowered.kernels
    own = {
        k: graph.input("a", slot, f"{mapping.rate_names[k]}_rate")
        for k, slot in mapping.slots.items()
    }
    substitutes = dict(mapping.substitutes)
    for k, slopes in mapping.slopes.items():
        terms = [graph.mul(slope, own[j]) for j, slope in slopes.items()]
        substitutes[mapping.accelerations[k]] = graph.total([*terms, mapping.bias[k]])
    repeated = []
    for kernel in (kernels[name] for name in EVENT_KERNELS if name in kernels):
        values = substitute(graph, [out.value for out in kernel.outputs], substitutes)
        pairs = zip(kernel.outputs, values, strict=True)
        outputs = tuple(out._replace(value=value) for out, value in pairs)
        repeated.append(Kernel(kernel.name, kernel.summary, kernel.arguments, outputs))
    return repeated


def _expansion_kernels(mapping: CoordinateMap) -> list[Kernel]:
    """All coordinates by those that are kept, the branches, and the distances to dead centres."""
    graph, scene = mapping.graph, mapping.scene
    turn = graph.constant(TURN)
    full = dict(mapping.substitutes)
    for slot, angle in enumerate(mapping.angles):
        name = mapping.names[angle.column]
        turns = graph.mul(turn, graph.input("turns", slot, f"turns_{name}"))
        q = scene.q[angle.column]
        full[q] = graph.add(mapping.substitutes[q], turns)
    formulas = substitute(graph, list(mapping.formulas.values()), full)
    full |= {scene.q[k]: value for k, value in zip(mapping.formulas, formulas, strict=True)}
    rates = [mapping.substitutes[v] for v in scene.v]
    positions = store("all_q", [full[q] for q in scene.q], mapping.names)
    velocities = store("all_v", rates, mapping.rate_names)
    whole = "All coordinates and velocities; angles in closed form plus the given whole turns."
    branching = mapping.branching
    names = [mapping.names[angle.column] for angle in branching]
    slopes = [angle.slope for angle in branching if angle.slope is not None]
    branch = "∂Φ/∂θ of each loop in closed form, in all coordinates; its sign is the branch."
    return [
        Kernel("expand", whole, (*STATE, "turns", "all_q", "all_v"), positions + velocities),
        storing("branches", branch, "t q p out", slopes, names),
        _dead_centres(mapping, names),
    ]


def _dead_centres(mapping: CoordinateMap, names: list[str]) -> Kernel:
    """ρ² of each loop with a branch, its rate, and the largest that ρ² may be."""
    graph, scene = mapping.graph, mapping.scene
    seeds = {scene.time: graph.one}
    for k in mapping.kept:
        seeds[mapping.substitutes[scene.q[k]]] = mapping.substitutes[scene.v[k]]
    values, notes = [], []
    for angle, name in zip(mapping.branching, names, strict=True):
        assert angle.discriminant is not None
        assert angle.size is not None
        discriminant, size = mapping.substituted([angle.discriminant, angle.size])
        values += [discriminant, *differentiate(graph, [discriminant], seeds), size]
        notes += [f"{name}: ρ²", f"{name}: its rate", f"{name}: the largest that it may be"]
    summary = "ρ² of each loop in closed form, which vanishes at its dead centres; rate and size."
    return storing("dead_centres", summary, "t q v p out", values, notes)
