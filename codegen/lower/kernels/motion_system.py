"""The system of accelerations and multipliers: its unknowns, its equations, and the way back.

In the plane its columns are the coordinates. A body in space has six, r̈ and ω̇': its equation
between Euler parameters leaves the system, and from the solution follow

    p̈ = ½ Gᵀ ω̇' - (ṗᵀṗ) p   and the multiplier of pᵀp = 1,   λ = ω'ᵀ J' ω' + ½ pᵀ Q_p,

as Φ_p = 2 Φ_π' G and G p = 0 (Nikravesh, Computer-Aided Analysis of Mechanical Systems, 1988,
chapter 11). Forces Q_p other than 2 Gᵀ n' are those that a user writes along Euler parameters.
"""

from dataclasses import dataclass

from codegen.declare.symbols import Parameter
from codegen.derive.equations import TurningBody
from codegen.derive.inertia import neutral
from codegen.lower.differentiation.turning import THREE
from codegen.lower.graph import Graph
from codegen.lower.linear.factorization import Entries
from codegen.lower.scene_graph import SceneGraph


@dataclass(frozen=True)
class MotionSystem:
    """[M Φ_qᵀ; Φ_q 0] [q̈; λ] = [Q; γ] in the columns of motion."""

    names: list[str]  # of the columns
    rates: list[str]
    owners: list[str]
    units: list[str]
    rows: list[int]  # the constraints of the scene that are in it
    mass: Entries
    jacobian: Entries
    forces: list[int]
    gamma: list[int]
    speeds: list[int]  # q̇, and ω' of turns

    @property
    def n(self) -> int:
        """Number of columns."""
        return len(self.names)

    @property
    def lengths(self) -> set[int]:
        """The columns of lengths."""
        return {k for k, unit in enumerate(self.units) if unit == "m"}


def motion_system(scene: SceneGraph) -> MotionSystem:
    """The system of a scene."""
    coordinates = scene.equations.coordinates
    owners, units = [q.owner for q in coordinates], [q.unit for q in coordinates]
    if not scene.turns:
        return MotionSystem(
            scene.names, scene.rates, owners, units, list(range(scene.m)), scene.mass,
            scene.jacobian, scene.forces, scene.gamma, scene.v,
        )  # fmt: skip
    graph, columns = scene.graph, scene.turning.of_motion(scene.n)
    place = {column: k for k, column in enumerate(columns)}
    rows = [i for i in range(scene.m) if i not in scene.norms]
    forces = {k: force for k, force in enumerate(scene.pushes) if force != graph.zero}
    pushes = scene.turning.six(forces)
    mass = {(place[i], place[k]): m for (i, k), m in scene.mass.items() if {i, k} <= place.keys()}
    names, rates, speeds = [*scene.names], [*scene.rates], [*scene.v]
    for body, (turn, at) in zip(scene.equations.turning, scene.turning.turns, strict=True):
        names += [f"{body.name}_turn{c}" for c in "xyz"]
        rates += [f"{body.name}_omega_{c}" for c in "xyz"]
        owners += [body.name] * 3
        units += ["rad"] * 3
        speeds += turn.omega
        if body.inertia is not None and scene.mass:
            inertia = _inertia_of(scene, body)
            mass |= {(place[at + i], place[at + k]): j for (i, k), j in inertia.items()}
            for k, torque in enumerate(_gyroscopic(graph, turn.omega, inertia), at):
                pushes[k] = graph.add(pushes.get(k, graph.zero), torque)
    where = {row: i for i, row in enumerate(rows)}
    jacobian = {(where[i], place[k]): slope for (i, k), slope in scene.turned_jacobian.items()}
    return MotionSystem(
        [names[k] for k in columns], [rates[k] for k in columns], [owners[k] for k in columns],
        [units[k] for k in columns], rows, dict(sorted(mass.items())),
        dict(sorted(jacobian.items())), [pushes.get(k, graph.zero) for k in columns],
        [scene.turned_gamma[i] for i in rows], [speeds[k] for k in columns],
    )  # fmt: skip


def inertias(scene: SceneGraph, system: MotionSystem) -> dict[int, float]:
    """Column → its mass or moment of inertia, as declared, neutral pose, where it has one."""
    equations, names = scene.equations, {name: k for k, name in enumerate(system.names)}
    pose = neutral(equations.coordinates)
    declared = {Parameter(p.name, real=True): p.value for p in equations.parameters}
    entries = [
        (names[scene.names[i]], m)
        for i, k, m in equations.mass
        if i == k and scene.names[i] in names
    ]
    for body in equations.turning if equations.mass else ():
        assert body.inertia is not None
        entries += [
            (names[f"{body.name}_turn{c}"], body.inertia[k, k]) for k, c in enumerate("xyz")
        ]
    sizes = {}
    for k, mass in entries:
        own = mass.free_symbols  # of these alone: to substitute all takes as long as all masses
        known = mass
        for numbers in (declared, pose) if own else ():
            known = known.subs({symbol: numbers[symbol] for symbol in own if symbol in numbers})
        size = float(known)
        if size > 0.0:
            sizes[k] = size
    return sizes


def written_back(
    scene: SceneGraph, system: MotionSystem, solution: list[int], is_change: bool = False
) -> list[int]:
    """Accelerations by coordinates and all multipliers, from the unknowns of the system.

    Or the changes of all by a force along coordinates other than Euler parameters.
    """
    if not scene.turns:
        return solution
    graph, columns = scene.graph, scene.turning.of_motion(scene.n)
    found = dict(zip(columns, solution, strict=False))
    multipliers = dict(zip(system.rows, solution[system.n :], strict=True))
    for body, (turn, at) in zip(scene.equations.turning, scene.turning.turns, strict=True):
        rates = turn.acceleration([found[at + k] for k in THREE], is_change=is_change)
        found |= {turn.first + k: rate for k, rate in enumerate(rates)}
        (row,) = (i for i, k in scene.norms.items() if scene.turns[k] is turn)
        if is_change:
            multipliers[row] = graph.zero
            continue
        half = [graph.mul(graph.constant(0.5), scene.pushes[turn.first + k]) for k in range(4)]
        inertia = _inertia_of(scene, body)
        momentum = [graph.dot(turn.omega, (inertia[i, k] for k in THREE)) for i in THREE]
        multipliers[row] = graph.add(graph.dot(turn.omega, momentum), graph.dot(turn.p, half))
    return [found[k] for k in range(scene.n)] + [multipliers[i] for i in range(scene.m)]


def _inertia_of(scene: SceneGraph, body: TurningBody) -> Entries:
    """All entries of J' as values."""
    assert body.inertia is not None
    places = [(i, k) for i in THREE for k in THREE]
    return {(i, k): scene.translate(body.inertia[i, k]) for i, k in places}


def _gyroscopic(graph: Graph, omega: list[int], j: Entries) -> list[int]:
    """-ω' × J' ω', by the differences of moments: two products where the axes are principal."""
    torques = []
    for k in THREE:
        a, b = (k + 1) % 3, (k + 2) % 3
        products = [
            (graph.sub(j[a, a], j[b, b]), a, b), (j[a, b], b, b), (graph.neg(j[a, b]), a, a),
            (j[k, a], k, b), (graph.neg(j[k, b]), k, a),
        ]  # fmt: skip
        torques.append(
            graph.total([graph.mul(graph.mul(x, omega[c]), omega[d]) for x, c, d in products])
        )
    return torques
