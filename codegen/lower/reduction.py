"""The same machine in fewer coordinates: `--formulation reduced`.

What constraints give outright is put in (`outright`), loops of one and two bodies are closed in
closed form (`loops`), and what is left are f coordinates, or some more with the constraints that
still hold between them. With q̇ = T u̇ + ν and q̈ = T ü + γ of all coordinates by those that are
left, the equations of motion are

    M_r ü + Φ_rᵀ λ_r = Q_r,   Φ_r ü = γ_r,   M_r = Tᵀ M T,   Q_r = Tᵀ (Q - M γ)

(R. A. Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255; R. von Schwerin,
MultiBody System SIMulation, 1999). The kernels are called as those of the machine itself and take
the same arguments in fewer coordinates, so that every integrator takes them as it takes the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from codegen.lower.description import Description, Pattern
from codegen.lower.factorization import Elimination
from codegen.lower.graph import Graph
from codegen.lower.hoist import with_constants
from codegen.lower.kernels import Lowered
from codegen.lower.loops import Loop, Loops
from codegen.lower.outright import Outright, Rates, combined
from codegen.lower.program import STATE, Check, Input, Kernel, Op, Output, Program, store
from codegen.lower.rebuild import rebuilt
from codegen.lower.solutions import least_correction
from codegen.lower.tangent import differentiate

REPEATED = ("switching", "switching_rates", "gap_accelerations", "holds", "restitution")
"""Kernels whose equations are those of the machine itself, in other coordinates."""


@dataclass(frozen=True)
class Reduced:
    """The reduced equations of a scene.

    Attributes
    ----------
    kept
        Columns of the coordinates that are integrated.
    closures
        Rows of the constraints that hold between them.
    branches
        Coordinates of the angles in closed form whose branch a run has to know, by column.
    jacobian, mass
        Patterns of Φ_r and M_r.
    """

    program: Program
    kept: tuple[int, ...]
    closures: tuple[int, ...]
    branches: tuple[int, ...]
    jacobian: Pattern
    mass: Pattern


def reduce(lowered: Lowered) -> Reduced:
    """Put what constraints give into the program of a scene."""
    return _Reduction(lowered).reduced()


class _Reduction:
    def __init__(self, lowered: Lowered) -> None:
        self.told = told = lowered.description
        program = lowered.program
        self.graph = graph = Graph.of(program.values)
        self.kernels = {kernel.name: kernel for kernel in program.kernels}
        n, m = len(told.coordinates), len(told.constraints)
        names = [name.replace(".", "_") for name, *_ in told.coordinates]
        rates = [rate.replace(".", "_") for _, rate, _ in told.coordinates]
        self.q = [graph.input("q", k, name) for k, name in enumerate(names)]
        self.v = [graph.input("v", k, rate) for k, rate in enumerate(rates)]
        self.a = [graph.input("a", k, f"{rate}_rate") for k, rate in enumerate(rates)]
        self.t = graph.input("t", 0, "t")
        self.phi = self._outputs("constraints", m)
        self.entries = dict(
            zip(
                zip(told.jacobian.rows, told.jacobian.columns, strict=True),
                self._outputs("jacobian", len(told.jacobian.rows)),
                strict=True,
            )
        )
        self.nu = self._outputs("velocity_rhs", m)
        self.gamma = self._outputs("acceleration_rhs", m)
        self.masses = self._outputs("mass", n)
        self.forces = self._outputs("applied_forces", n)
        with graph.serving("reduction"):
            self._eliminate()

    def _outputs(self, kernel: str, count: int) -> list[int]:
        values = [self.graph.zero] * count
        for out in self.kernels[kernel].outputs:
            values[out.slot] = out.value
        return values

    # -- coordinates -------------------------------------------------------------------------

    def _eliminate(self) -> None:
        told, graph = self.told, self.graph
        started = _started(told)
        weightless = {k for k, mass in enumerate(self.masses) if mass == graph.zero}
        outright = Outright(
            graph, self.q, self.phi, self.entries, self.nu, self.gamma,
            frozenset(started), frozenset(weightless),
        )  # fmt: skip
        left = outright.coordinates
        rows = dict(outright.rows)
        freedoms = len(left) - len(rows)
        independent = [*(k for k in started if k in left), *(k for k in left if k not in started)]
        independent = independent[: max(freedoms, 0)]
        angles = [k for k in left if k not in independent and self._turns(k, rows, outright)]
        loops = Loops(
            graph, self.q, {i: row.value for i, row in rows.items()}, angles,
            len(told.parameters),
        )  # fmt: skip
        self.loops = loops.found
        closed = {k for loop in self.loops for k in loop.columns}
        solved = {i for loop in self.loops for i in loop.rows}
        self.kept = tuple(k for k in left if k not in closed)
        self.closures = tuple(i for i in rows if i not in solved)
        self._place(outright)
        self._rate(outright)

    def _turns(self, k: int, rows: dict[int, object], outright: Outright) -> bool:
        """Whether a coordinate is an angle that nothing but its sine and cosine is asked of."""
        graph = self.graph
        if self.told.coordinates[k][2] != "rad":
            return False
        ends = {graph.function(op, self.q[k]): None for op in (Op.SIN, Op.COS)}
        given = outright.formulas()
        inner = {self.q[j]: formula for j, formula in given.items()}
        values = [v for v in self.forces]
        for name in REPEATED:
            if name in self.kernels:
                values += [out.value for out in self.kernels[name].outputs]
        from codegen.lower.rebuild import reached

        return self.q[k] not in reached(graph, rebuilt(graph, values, inner), ends)

    def _place(self, outright: Outright) -> None:
        """What stands for every coordinate."""
        graph = self.graph
        self.replaced: dict[int, int] = {}
        for slot, k in enumerate(self.kept):
            self.replaced[self.q[k]] = graph.input("q", slot, self._name(self.q[k]))
            self.replaced[self.v[k]] = graph.input("v", slot, self._name(self.v[k]))
        self.known = dict(self.replaced)
        self.checks: list[Check] = []
        for loop in self.loops:
            for angle in loop.angles:
                s, c = rebuilt(graph, [angle.s, angle.c], self.replaced)
                self.replaced[graph.function(Op.SIN, self.q[angle.column])] = s
                self.replaced[graph.function(Op.COS, self.q[angle.column])] = c
                self.replaced[self.q[angle.column]] = graph.function(Op.ATAN2, s, c)
                if angle.room:
                    room, square = rebuilt(graph, list(angle.room), self.replaced)
                    self.checks.append(Check(room, square, angle.row))
        formulas = outright.formulas()
        places = rebuilt(graph, list(formulas.values()), self.replaced)
        # A given angle that is one of the closed ones but for a constant keeps its sine and cosine.
        for k, formula in formulas.items():
            for op in (Op.SIN, Op.COS):
                of_formula = rebuilt(
                    graph, [graph.function(op, self.q[k])], {self.q[k]: formula}
                )
                (self.replaced[graph.function(op, self.q[k])],) = rebuilt(
                    graph, of_formula, self.replaced
                )
        self.replaced |= {self.q[k]: place for k, place in zip(formulas, places, strict=True)}

    def _rate(self, outright: Outright) -> None:
        """Every coordinate's rates by those that are kept."""
        graph = self.graph
        known = {k: Rates({k: graph.one}, graph.zero, graph.zero) for k in self.kept}
        for loop in self.loops:
            known |= self._loop_rates(outright, loop, known)
        rates = {
            k: combined(graph, one, known) for k, one in outright.rates().items() if k not in known
        }
        rates |= known
        # Bottom up: velocities first, as γ is made of them.
        self.slopes: dict[int, dict[int, int]] = {}
        velocities: dict[int, int] = {}
        for k, one in rates.items():
            slopes = rebuilt(graph, list(one.slopes.values()), self.replaced)
            self.slopes[k] = dict(zip(one.slopes, slopes, strict=True))
            (own,) = rebuilt(graph, [one.velocity], self.replaced)
            terms = [
                graph.mul(slope, self.replaced[self.v[j]]) for j, slope in self.slopes[k].items()
            ]
            velocities[k] = graph.total([*terms, own])
        self.replaced |= {self.v[k]: velocities[k] for k in rates}
        bends = rebuilt(graph, [rates[k].acceleration for k in rates], self.replaced)
        self.bends = dict(zip(rates, bends, strict=True))

    def _loop_rates(self, outright: Outright, loop: Loop, known: dict[int, Rates]) -> dict[int, Rates]:
        """Rates of a loop's angles: its rows solved for them."""
        graph = self.graph
        columns = loop.columns
        matrix, right = [], []
        for i in loop.rows:
            row = outright.rows[i]
            matrix.append([row.entries.get(k, graph.zero) for k in columns])
            others = {j: graph.neg(e) for j, e in row.entries.items() if j not in columns}
            right.append(combined(graph, Rates(others, row.nu, row.gamma), known))
        if len(columns) == 1:
            inverse = [[graph.div(graph.one, matrix[0][0])]]
        else:
            (a, b), (c, d) = matrix
            over = graph.div(graph.one, graph.sub(graph.mul(a, d), graph.mul(b, c)))
            inverse = [
                [graph.mul(over, d), graph.neg(graph.mul(over, b))],
                [graph.neg(graph.mul(over, c)), graph.mul(over, a)],
            ]
        places = dict(enumerate(right))
        return {
            k: combined(graph, Rates(dict(enumerate(line)), graph.zero, graph.zero), places)
            for k, line in zip(columns, inverse, strict=True)
        }

    def _name(self, number: int) -> str:
        literal = self.graph.values[number].literal
        assert isinstance(literal, Input)
        return literal.name

    # -- kernels -----------------------------------------------------------------------------

    def reduced(self) -> Reduced:
        """The program and its tables."""
        graph = self.graph
        with graph.serving("reduction"):
            self._equations()
            kernels = [*self._constraint_kernels(), *self._motion_kernels(), *self._repeated()]
            kernels += [self._expand(), self._branches()]
        declared = len(self.told.parameters) + len(self._sides())
        program = with_constants(graph, tuple(kernels), declared)
        rows, columns = zip(*self.jacobian, strict=True) if self.jacobian else ((), ())
        heavy = tuple(zip(*self.mass, strict=True)) if self.mass else ((), ())
        return Reduced(
            program,
            self.kept,
            self.closures,
            tuple(angle.column for angle in self._sides()),
            Pattern(tuple(rows), tuple(columns)),
            Pattern(*heavy),
        )

    def _sides(self) -> list:
        return [a for loop in self.loops for a in loop.angles if a.branch is not None]

    def _equations(self) -> None:
        graph, slots = self.graph, {k: slot for slot, k in enumerate(self.kept)}
        phi = rebuilt(graph, [self.phi[i] for i in self.closures], self.replaced)
        nu = rebuilt(graph, [self.nu[i] for i in self.closures], self.replaced)
        gamma = rebuilt(graph, [self.gamma[i] for i in self.closures], self.replaced)
        self.closure_phi = phi
        self.closure_nu, self.closure_gamma = [], []
        self.jacobian: dict[tuple[int, int], int] = {}
        for row, i in enumerate(self.closures):
            own = {k: e for (r, k), e in self.entries.items() if r == i}
            factors = rebuilt(graph, list(own.values()), self.replaced)
            rate, bend = nu[row], gamma[row]
            for k, factor in zip(own, factors, strict=True):
                for j, slope in self.slopes[k].items():
                    key = (row, slots[j])
                    before = self.jacobian.get(key, graph.zero)
                    self.jacobian[key] = graph.add(before, graph.mul(factor, slope))
                bend = graph.sub(bend, graph.mul(factor, self.bends[k]))
            (shift,) = differentiate(graph, [phi[row]], {self.t: graph.one})
            self.closure_nu.append(graph.neg(shift))
            self.closure_gamma.append(bend)
        self.jacobian = {k: e for k, e in sorted(self.jacobian.items()) if e != graph.zero}
        self._project(slots)

    def _project(self, slots: dict[int, int]) -> None:
        """M_r and Q_r."""
        graph = self.graph
        forces = rebuilt(graph, self.forces, self.replaced)
        self.mass: dict[tuple[int, int], int] = {}
        self.force = [graph.zero] * len(self.kept)
        for k, slopes in self.slopes.items():
            mass = self.masses[k]
            pull = graph.sub(forces[k], graph.mul(mass, self.bends[k]))
            for j, slope in slopes.items():
                place = slots[j]
                self.force[place] = graph.add(self.force[place], graph.mul(slope, pull))
                heavy = graph.mul(mass, slope)
                for other, along in slopes.items():
                    key = (place, slots[other])
                    if key[0] <= key[1]:
                        before = self.mass.get(key, graph.zero)
                        self.mass[key] = graph.add(before, graph.mul(heavy, along))
        self.mass |= {(j, i): entry for (i, j), entry in self.mass.items()}
        self.mass = {k: e for k, e in sorted(self.mass.items()) if e != graph.zero}

    def _names(self, rows: Sequence[int]) -> list[str]:
        told = self.told.constraints
        return [f"{told[i][0]}_{told[i][2]}" for i in rows]

    def _constraint_kernels(self) -> list[Kernel]:
        rows = self._names(self.closures)
        notes = [f"{rows[i]}, {self._name(self.q[self.kept[k]])}" for i, k in self.jacobian]
        return [
            Kernel("constraints", "Φ of the loops that are left.", ("t", "q", "p", "phi"),
                   store("phi", self.closure_phi, rows)),
            Kernel("jacobian", "Structural non-zeros of Φ_r, at JACOBIAN_ROWS, JACOBIAN_COLUMNS.",
                   ("t", "q", "p", "values"), store("values", list(self.jacobian.values()), notes)),
            Kernel("velocity_rhs", "ν of the loops that are left.", ("t", "q", "p", "nu"),
                   store("nu", self.closure_nu, rows)),
            Kernel("acceleration_rhs", "γ of the loops that are left.", (*STATE, "gamma"),
                   store("gamma", self.closure_gamma, rows)),
        ]  # fmt: skip

    def _motion_kernels(self) -> list[Kernel]:
        graph, n, m = self.graph, len(self.kept), len(self.closures)
        names = [self._name(self.q[k]) for k in self.kept]
        rates = [self._name(self.v[k]) for k in self.kept]
        with graph.serving("factorization"):
            entries = dict(self.mass)
            for (i, k), entry in self.jacobian.items():
                entries[n + i, k] = entries[k, n + i] = entry
            right = [[*self.force, *self.closure_gamma]]
            system = Elimination(graph, entries, right, frozenset(range(n, n + m)), self._sizes())
            (solution,) = system.solve("schur")
        checks = [c._replace(constraint=self.closures[c.constraint - n]) for c in system.checks]
        self.accelerations = solution[:n]
        weights = [graph.input("w", k, f"w_{name}") for k, name in enumerate(names)]
        return [
            Kernel("mass", "Structural non-zeros of M_r, at MASS_ROWS, MASS_COLUMNS.",
                   ("q", "p", "values"),
                   store("values", list(self.mass.values()), [""] * len(self.mass))),
            Kernel("applied_forces", "Q_r.", (*STATE, "modes", "Q"), store("Q", self.force, names)),
            Kernel("accelerations", "ü and λ_r of M_r ü + Φ_rᵀ λ_r = Q_r, Φ_r ü = γ_r.",
                   (*STATE, "modes", "a", "lam"),
                   store("a", solution[:n], rates)
                   + store("lam", solution[n:], self._names(self.closures)),
                   (*self.checks, *checks), watched=True),
            least_correction(graph, self.jacobian, self.closure_phi, self.closure_nu,
                             [self.replaced[self.v[k]] for k in self.kept], weights, names),
        ]  # fmt: skip

    def _sizes(self) -> dict[int, int]:
        """Φ_r M_d⁻¹ Φ_rᵀ of each loop, with the diagonal of M_r."""
        graph, n = self.graph, len(self.kept)
        found: dict[int, int] = {}
        for (i, k), entry in self.jacobian.items():
            if (k, k) in self.mass:
                part = graph.div(graph.mul(entry, entry), self.mass[k, k])
                found[n + i] = graph.add(found.get(n + i, graph.zero), part)
        return found

    def _repeated(self) -> list[Kernel]:
        """The kernels of events, in the reduced coordinates."""
        graph = self.graph
        places = {k: slot for slot, k in enumerate(self.kept)}
        own = [graph.input("a", s, self._name(self.a[k])) for k, s in places.items()]
        replaced = dict(self.replaced)
        for k, slopes in self.slopes.items():
            terms = [graph.mul(slope, own[places[j]]) for j, slope in slopes.items()]
            replaced[self.a[k]] = graph.total([*terms, self.bends[k]])
        made = []
        for name in REPEATED:
            if name in self.kernels:
                kernel = self.kernels[name]
                values = rebuilt(graph, [out.value for out in kernel.outputs], replaced)
                outputs = tuple(
                    out._replace(value=value)
                    for out, value in zip(kernel.outputs, values, strict=True)
                )
                made.append(Kernel(name, kernel.summary, kernel.arguments, outputs))
        return made

    def _expand(self) -> Kernel:
        names = [name for name, *_ in self.told.coordinates]
        rates = [rate for _, rate, _ in self.told.coordinates]
        return Kernel(
            "expand",
            "All coordinates and velocities.",
            (*STATE, "all_q", "all_v"),
            store("all_q", [self.replaced[q] for q in self.q], names)
            + store("all_v", [self.replaced[v] for v in self.v], rates),
        )

    def _branches(self) -> Kernel:
        sides = self._sides()
        names = [self._name(self.q[a.column]) for a in sides]
        return Kernel(
            "branches",
            "∂Φ/∂θ of each loop in closed form, all coordinates given: its sign is the branch.",
            ("t", "q", "p", "out"),
            store("out", [a.slope for a in sides], names),
        )


def _started(told: Description) -> list[int]:
    """Columns of the coordinates whose start is fixed: first those whose velocity is."""
    fixed = {name for name, _, role in told.start if role == "fixed"}
    rates = [k for k, (_, rate, _) in enumerate(told.coordinates) if rate in fixed]
    places = [k for k, (name, *_) in enumerate(told.coordinates) if name in fixed]
    return [*rates, *(k for k in places if k not in rates)]
