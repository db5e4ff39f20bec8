"""The same machine in fewer coordinates.

`places` says which coordinates are kept and what stands for the others, `projected` what the
equations of motion then are. The kernels made of them here are called as those of the machine
itself and take the same arguments in fewer coordinates, so that every integrator takes them as it
takes the others. In ``p`` the branches of the loops in closed form stand behind the parameters.
"""

import math
from dataclasses import dataclass

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.differentiation.tangent import differentiate, tangent_program
from codegen.lower.kernels.corrections import least_correction
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.module_tables import Pattern
from codegen.lower.program import STATE, Kernel, Program, store
from codegen.lower.substitution import rebuilt
from codegen.reduce.closed_form_loops import Angle
from codegen.reduce.coordinate_map import REPEATED, Places
from codegen.reduce.lowered_equations import stated
from codegen.reduce.projected_equations import Projected

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Reduced:
    """The reduced equations of a scene.

    Attributes
    ----------
    program
        Its kernels, with their derivatives.
    kept
        Columns of the coordinates that are integrated.
    closures
        Rows of the constraints that hold between them.
    angles
        Columns of the angles in closed form.
    branches
        Those among them whose branch a run has to know, each with the row of its loop.
    jacobian, mass
        Patterns of Φ_r and M_r.
    """

    program: Program
    kept: tuple[int, ...]
    closures: tuple[int, ...]
    angles: tuple[int, ...]
    branches: tuple[tuple[int, int], ...]
    jacobian: Pattern
    mass: Pattern


def reduce(lowered: Lowered) -> Reduced:
    """Put what constraints give into the program of a scene that moves."""
    scene = stated(lowered)
    with scene.graph.serving("reduction"):
        places = Places(scene)
        equations = Projected(places)
        kernels = (
            *_of_constraints(equations),
            *_of_motion(equations),
            *_of_events(places),
            *_of_places(places),
        )
    sides = _sides(places)
    program = with_constants(scene.graph, kernels, len(scene.told.parameters) + len(sides))
    tangents = tangent_program(program)
    whole = Program(
        tangents.values,
        (*program.kernels, *tangents.kernels),
        program.constants,
        program.weak_pivot,
    )
    return Reduced(
        whole,
        places.kept,
        places.closures,
        tuple(angle.column for angle in places.angles),
        tuple((angle.column, angle.row) for angle in sides),
        _pattern(equations.jacobian),
        _pattern(equations.mass),
    )


def _pattern(entries: dict[tuple[int, int], int]) -> Pattern:
    rows, columns = zip(*entries, strict=True) if entries else ((), ())
    return Pattern(tuple(rows), tuple(columns))


def _sides(places: Places) -> list[Angle]:
    """Angles with a branch of their own."""
    return [angle for angle in places.angles if angle.branch is not None]


def _of_constraints(equations: Projected) -> list[Kernel]:
    places, scene = equations.places, equations.places.scene
    rows = scene.row_names(places.closures)
    notes = [f"{rows[i]}, {scene.name(scene.q[places.kept[k]])}" for i, k in equations.jacobian]
    return [
        Kernel(
            "constraints",
            "Φ of the loops that are left.",
            ("t", "q", "p", "phi"),
            store("phi", equations.phi, rows),
        ),
        Kernel(
            "jacobian",
            "Structural non-zeros of Φ_r, at JACOBIAN_ROWS, JACOBIAN_COLUMNS.",
            ("t", "q", "p", "values"),
            store("values", list(equations.jacobian.values()), notes),
        ),
        Kernel(
            "velocity_rhs",
            "ν of the loops that are left.",
            ("t", "q", "p", "nu"),
            store("nu", equations.nu, rows),
        ),
        Kernel(
            "acceleration_rhs",
            "γ of the loops that are left.",
            (*STATE, "gamma"),
            store("gamma", equations.gamma, rows),
        ),
    ]


def _of_motion(equations: Projected) -> list[Kernel]:
    places, scene, graph = equations.places, equations.places.scene, equations.graph
    names = [scene.name(scene.q[k]) for k in places.kept]
    weights = [graph.input("w", slot, f"w_{name}") for slot, name in enumerate(names)]
    return [
        Kernel(
            "mass",
            "Structural non-zeros of M_r, at MASS_ROWS, MASS_COLUMNS.",
            ("q", "p", "values"),
            store(
                "values",
                list(equations.mass.values()),
                [f"{names[i]}, {names[k]}" for i, k in equations.mass],
            ),
        ),
        Kernel(
            "applied_forces",
            "Q_r.",
            (*STATE, "modes", "Q"),
            store("Q", equations.force, names),
        ),
        equations.accelerations(),
        least_correction(
            graph,
            equations.jacobian,
            equations.phi,
            equations.nu,
            [places.replaced[scene.v[k]] for k in places.kept],
            weights,
            names,
            scene.row_names(places.closures),
        ),
    ]


def _of_events(places: Places) -> list[Kernel]:
    """The kernels of events, with the accelerations of all coordinates by those that are kept."""
    graph, scene = places.graph, places.scene
    own = {k: graph.input("a", slot, scene.name(scene.a[k])) for k, slot in places.slots.items()}
    replaced = dict(places.replaced)
    for k, slopes in places.slopes.items():
        terms = [graph.mul(slope, own[j]) for j, slope in slopes.items()]
        replaced[scene.a[k]] = graph.total([*terms, places.bends[k]])
    made = []
    for kernel in (scene.kernels[name] for name in REPEATED if name in scene.kernels):
        values = rebuilt(graph, [out.value for out in kernel.outputs], replaced)
        pairs = zip(kernel.outputs, values, strict=True)
        outputs = tuple(out._replace(value=value) for out, value in pairs)
        made.append(Kernel(kernel.name, kernel.summary, kernel.arguments, outputs))
    return made


def _of_places(places: Places) -> list[Kernel]:
    """All coordinates by those that are kept, and on which branch, how near to a dead centre."""
    graph, scene = places.graph, places.scene
    turn = graph.constant(TURN)
    wound = dict(places.replaced)
    for slot, angle in enumerate(places.angles):
        name = scene.name(scene.q[angle.column])
        turns = graph.mul(turn, graph.input("turns", slot, f"turns_{name}"))
        wound[scene.q[angle.column]] = graph.add(places.replaced[scene.q[angle.column]], turns)
    formulas = rebuilt(graph, list(places.formulas.values()), wound)
    wound |= {scene.q[k]: value for k, value in zip(places.formulas, formulas, strict=True)}
    sides = _sides(places)
    names = [scene.name(scene.q[angle.column]) for angle in sides]
    return [
        Kernel(
            "expand",
            "All coordinates and velocities; the angles in closed form with so many whole turns.",
            (*STATE, "turns", "all_q", "all_v"),
            store("all_q", [wound[q] for q in scene.q], [scene.name(q) for q in scene.q])
            + store(
                "all_v", [places.replaced[v] for v in scene.v], [scene.name(v) for v in scene.v]
            ),
        ),
        Kernel(
            "branches",
            "∂Φ/∂θ of each loop in closed form, all coordinates given: its sign is the branch.",
            ("t", "q", "p", "out"),
            store("out", [angle.slope for angle in sides if angle.slope is not None], names),
        ),
        _dead_centres(places, sides, names),
    ]


def _dead_centres(places: Places, sides: list[Angle], names: list[str]) -> Kernel:
    """ρ² of each loop with a branch, and its rate."""
    graph, scene = places.graph, places.scene
    seeds = {scene.t: graph.one}
    for k in places.kept:
        seeds[places.replaced[scene.q[k]]] = places.replaced[scene.v[k]]
    values, notes = [], []
    for angle, name in zip(sides, names, strict=True):
        assert angle.room is not None
        (room,) = places.put_in([angle.room])
        values += [room, *differentiate(graph, [room], seeds)]
        notes += [f"{name}: ρ²", f"{name}: its rate"]
    return Kernel(
        "dead_centres",
        "ρ² of each loop in closed form, which vanishes at its dead centres, and its rate.",
        (*STATE, "out"),
        store("out", values, notes),
    )
