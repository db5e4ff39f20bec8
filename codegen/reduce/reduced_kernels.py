"""The kernels of the reduced formulation.

`coordinate_map` gives all coordinates by those that are kept. The kernels have the names and
arguments of the scene's own, in fewer coordinates, so that every integrator accepts them. In ``p``
the branches of the loops in closed form follow the parameters.

The equations of motion in the coordinates that are kept.

With q̇ = T u̇ + ν and q̈ = T ü + γ of all coordinates by those that are kept, they are

    M_r ü + Φ_rᵀ λ_r = Q_r,   Φ_r ü = γ_r,   M_r = Tᵀ M T,   Q_r = Tᵀ (Q - M γ)

(R. A. Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255; R. von Schwerin,
MultiBody System SIMulation, 1999). The multipliers of the constraints that are left are those of
the machine itself.
"""

import math
from dataclasses import dataclass, replace

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.differentiation.program_tangents import differentiate, tangent_program
from codegen.lower.graph import substitute
from codegen.lower.kernels.corrections import least_correction
from codegen.lower.linear.factorization import Elimination, Strategy, augmented
from codegen.lower.lowered_scene import Lowered
from codegen.lower.module_tables import Pattern
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Check, Kernel, Output, Program, store, storing
from codegen.lower.tree_height_reduction import reduce_height
from codegen.reduce.coordinate_map import EVENT_KERNELS, CoordinateMap

Entries = dict[tuple[int, int], int]


class ProjectedEquations:
    """M_r, Q_r and the constraints that are left."""

    def __init__(self, mapping: CoordinateMap) -> None:
        self.mapping, self.graph = mapping, mapping.graph
        self.phi = mapping.substituted(mapping.scene.phi[i] for i in mapping.closures)  # Φ_r
        self.nu: list[int] = []  # ν_r
        self.gamma: list[int] = []  # γ_r
        self.jacobian: Entries = {}  # structural non-zeros of Φ_r by (row, slot)
        self._constrain()
        self.mass: Entries = {}  # structural non-zeros of M_r by (slot, slot)
        self.force = [self.graph.zero] * len(mapping.kept)  # Q_r
        self._project()

    def accelerations(self) -> Kernel:
        """ü and λ_r with the fewest operations.

        M_r is no pivot where a coordinate belongs to a joint: its entry vanishes at every contact,
        as the follower moves with the place of the contact only where the two do not touch.
        """
        mapping, trials = self.mapping, [self._substituted()]
        massless = any((k, k) not in self.mass for k in range(len(mapping.kept)))
        if not (mapping.scene.frictions or massless or mapping.own.keys() & {*mapping.kept}):
            strategies: tuple[Strategy, ...] = ("schur", "mixed", "substitute")
            trials += [self._eliminated(s) for s in strategies[: 3 if self.jacobian else 1]]
        return min(trials, key=lambda kernel: cost(self.graph, kernel))

    # -- equations ---------------------------------------------------------------------------

    def _add(self, entries: Entries, key: tuple[int, int], value: int) -> None:
        entries[key] = self.graph.add(entries.get(key, self.graph.zero), value)

    def _constrain(self) -> None:
        graph, mapping, scene = self.graph, self.mapping, self.mapping.scene
        gamma = mapping.substituted(scene.gamma[i] for i in mapping.closures)
        for row, i in enumerate(mapping.closures):
            own = {k: e for (r, k), e in scene.jacobian.items() if r == i}
            bias = gamma[row]
            for k, factor in zip(own, mapping.substituted(own.values()), strict=True):
                for j, slope in mapping.slopes[k].items():
                    self._add(self.jacobian, (row, mapping.slots[j]), graph.mul(factor, slope))
                bias = graph.sub(bias, graph.mul(factor, mapping.bias[k]))
            (shift,) = differentiate(graph, [self.phi[row]], {scene.time: graph.one})
            self.nu.append(graph.neg(shift))
            self.gamma.append(bias)
        self.jacobian = self._present(self.jacobian)

    def _project(self) -> None:
        graph, mapping = self.graph, self.mapping
        forces = mapping.substituted(mapping.scene.forces)
        rows: dict[int, dict[int, int]] = {}
        for (k, other), mass in mapping.scene.mass.items():
            rows.setdefault(k, {})[other] = mass
        for k, slopes in mapping.slopes.items():
            pull = forces[k]
            for other, mass in zip(rows[k], mapping.substituted(rows[k].values()), strict=True):
                pull = graph.sub(pull, graph.mul(mass, mapping.bias[other]))
                self._gather_mass(mass, slopes, mapping.slopes[other])
            for j, slope in slopes.items():
                i = mapping.slots[j]
                self.force[i] = graph.add(self.force[i], graph.mul(slope, pull))
        self.mass |= {(j, i): entry for (i, j), entry in self.mass.items()}
        self.mass = self._present(self.mass)

    def _gather_mass(self, mass: int, slopes: dict[int, int], others: dict[int, int]) -> None:
        """Add an entry of M to the upper triangle of M_r."""
        for j, slope in slopes.items():
            i, heavy = self.mapping.slots[j], self.graph.mul(mass, slope)
            for other, along in others.items():
                if i <= self.mapping.slots[other]:
                    key = i, self.mapping.slots[other]
                    self._add(self.mass, key, self.graph.mul(heavy, along))

    def _present(self, entries: Entries) -> Entries:
        return {key: e for key, e in sorted(entries.items()) if e != self.graph.zero}

    # -- solutions ---------------------------------------------------------------------------

    def _eliminated(self, strategy: Strategy) -> Kernel:
        """By elimination of the projected equations."""
        graph, n, m = self.graph, len(self.mapping.kept), len(self.mapping.closures)
        with graph.serving("factorization"):
            entries, sizes = augmented(graph, self.mass, self.jacobian, n)
            right = [[*self.force, *self.gamma]]
            duals = frozenset(range(n, n + m))
            system = Elimination(graph, entries, right, duals, sizes)
            (solution,) = system.solve(strategy)
        checks = tuple(c._replace(constraint=c.constraint - n) for c in system.checks)
        return self._kernel(solution[:n], dict(enumerate(solution[n:])), checks)

    def _substituted(self) -> Kernel:
        """By substitution in the kernel of the scene itself."""
        mapping, closures = self.mapping, self.mapping.stated
        stated = mapping.lowered.kernels["accelerations"]
        values = {(out.array, out.slot): out.value for out in stated.outputs}
        rates = mapping.substituted(values["a", k] for k in mapping.kept)
        weights = [mapping.scene.weights[i] for i in mapping.closures]
        alone = {
            r: min(row) for r, row in enumerate(weights) if [*row.values()] == [self.graph.one]
        }
        rows = {r: values["lam", i] for r, i in alone.items() if ("lam", i) in values}
        multipliers = dict(zip(rows, mapping.substituted(rows.values()), strict=True))
        checks = []
        for check in stated.checks:
            pivot, reference = mapping.substituted([check.pivot, check.reference])
            if self.graph.number(pivot) is None or self.graph.number(reference) is None:
                # The constraints that are left are reported by the first numbers, then all.
                row = check.constraint
                row = closures.index(row) if row in closures else len(closures) + row
                checks.append(check._replace(pivot=pivot, reference=reference, constraint=row))
        return self._kernel(rates, multipliers, tuple(checks))

    def _kernel(
        self, rates: list[int], multipliers: dict[int, int], checks: tuple[Check, ...]
    ) -> Kernel:
        mapping, names = self.mapping, self.mapping.row_names
        outputs = store("a", rates, [mapping.rate_names[k] for k in mapping.kept])
        outputs += tuple(Output("lam", r, x, names[r]) for r, x in multipliers.items())
        summary = "ü and λ_r of M_r ü + Φ_rᵀ λ_r = Q_r, Φ_r ü = γ_r."
        arguments = (*STATE, "modes", "a", "lam")
        whole = Kernel("accelerations", summary, arguments, outputs, checks, watched=True)
        return reduce_height(self.graph, whole)


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
        mapping.stated,
        tuple(angle.column for angle in mapping.angles),
        tuple((angle.column, mapping.scene.stated[angle.row]) for angle in branching),
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
