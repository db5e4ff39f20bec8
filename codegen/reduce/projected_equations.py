"""The equations of motion in the coordinates that are kept.

With q̇ = T u̇ + ν and q̈ = T ü + γ of all coordinates by those that are kept, they are

    M_r ü + Φ_rᵀ λ_r = Q_r,   Φ_r ü = γ_r,   M_r = Tᵀ M T,   Q_r = Tᵀ (Q - M γ)

(R. A. Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255; R. von Schwerin,
MultiBody System SIMulation, 1999). The multipliers of the constraints that are left are those of
the machine itself.
"""

from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.linear.factorization import Elimination, Strategy, augmented
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Check, Kernel, Output, store
from codegen.reduce.coordinate_map import CoordinateMap

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
        mapping, closures = self.mapping, self.mapping.closures
        stated = mapping.lowered.kernels["accelerations"]
        values = {(out.array, out.slot): out.value for out in stated.outputs}
        rates = mapping.substituted(values["a", k] for k in mapping.kept)
        rows = {r: values["lam", i] for r, i in enumerate(closures) if ("lam", i) in values}
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
        return Kernel("accelerations", summary, arguments, outputs, checks, watched=True)
