"""Equations of a scene → values: every element instantiated in one graph."""

from typing import NamedTuple

import sympy

from codegen.declare.symbols import SPEED, Acceleration, Parameter, t
from codegen.derive.effects import EffectTerms, FrictionTerms
from codegen.derive.equations import Equations
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.differentiation.gradient import Slopes
from codegen.lower.graph import Graph
from codegen.lower.sympy_translation import Translator


class Friction(NamedTuple):
    """A force -coefficient · (sum of the sizes of `loads`) along `direction`."""

    coefficient: int
    direction: dict[int, int]  # column → generalized force of a unit force
    # one a contact: a vector, each entry a sum over row → factor of the multiplier
    loads: tuple[tuple[dict[int, int], ...], ...]
    is_stuck: int | None = None  # whether it sticks
    stiction: int | None = None  # its force along `direction`; None: no run determines it


class SceneGraph:
    """The equations of a scene as values of one graph."""

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.n = len(equations.coordinates)
        self.m = sum(len(c.terms.phi) for c in equations.constraints)
        # whether a kinematic scene has as many constraints as coordinates
        self.driven = self.m == self.n > 0 and equations.scene.analysis == "kinematics"
        self.graph = graph = Graph()
        self.columns = {q: k for k, q in enumerate(equations.coordinates)}
        self.w = self._inputs("w", [f"w_{q.name}" for q in equations.coordinates])
        self.q = self._inputs("q", [q.name for q in equations.coordinates])
        self.v = self._inputs("v", [q.rate.name for q in equations.coordinates])
        self.lam = self._inputs("lam", [f"lambda_{name}" for name in self.row_names()])
        switches = enumerate(equations.switches)
        modes = {switch.g: k for k, switch in switches if switch.kind != "contact"}
        self.translate = Translator(graph, self._environment(), modes)
        self.translate.environment |= self._sides()
        self.phi: list[int] = []  # Φ, as ν and γ one value a constraint
        self.nu: list[int] = []
        self.gamma: list[int] = []
        self.jacobian: dict[tuple[int, int], int] = {}  # (row, column) → value, non-zeros in order
        # (row, column) of the constraints that determine a coordinate without mass
        self.massless: list[tuple[int, int]] = []
        self.reactions: list[tuple[str, str, str, int]] = []  # (element, component, unit, value)
        laws = (e.terms.friction for e in equations.effects)
        self._rubbing = {law.joint for law in laws if law}
        self._pressing: dict[tuple[str, str], dict[int, int]] = {}
        self.time = graph.input("t", 0, "t")
        self.slopes = Slopes(graph, (*self.q, self.time))  # by q and t
        velocities = dict(zip(self.q, self.v, strict=True))
        self.moving = Direction(graph, velocities, order=1)  # along q̇ with t held
        self.motion = Direction(graph, {**velocities, self.time: graph.one})  # along q̇ and t
        self._constraints()
        self._effects()

    @property
    def owners(self) -> list[str]:
        """The element of each constraint."""
        return [c.name for c in self.equations.constraints for _ in c.statement.rows]

    # -- inputs ------------------------------------------------------------------------------

    def row_names(self) -> list[str]:
        """A name for each constraint."""
        return [
            f"{c.name}_{row}" if len(c.statement.rows) > 1 else c.name
            for c in self.equations.constraints
            for row in c.statement.rows
        ]

    def _inputs(self, array: str, names: list[str]) -> list[int]:
        return [self.graph.input(array, k, name) for k, name in enumerate(names)]

    def _environment(self) -> dict[sympy.Symbol, int]:
        graph, equations = self.graph, self.equations
        environment: dict[sympy.Symbol, int] = {t: graph.input("t", 0, "t")}
        for k, p in enumerate(equations.parameters):
            frozen = equations.scene.frozen
            number = graph.constant(p.value) if frozen else graph.input("p", k, p.name)
            environment[Parameter(p.name, real=True)] = number
        for k, q in enumerate(equations.coordinates):
            environment[q], environment[q.rate] = self.q[k], self.v[k]
            rate = Acceleration(f"{q.rate.name}_rate", real=True)
            environment[rate] = graph.input("a", k, rate.name)
        return environment

    def _sides(self) -> dict[sympy.Symbol, int]:
        """A choice by its mode for each symbol that says on which side an effect acts."""
        graph = self.graph
        return {
            side.symbol: graph.select(
                graph.mode(side.switch),
                graph.constant(float(side.above)),
                graph.constant(float(side.below)),
            )
            for side in self.equations.sides
        }

    # -- equations ---------------------------------------------------------------------------

    def _constraints(self) -> None:
        still = self.equations.scene.analysis == "equilibrium"  # at rest γ vanishes
        for element in self.equations.constraints:
            terms, bindings = element.terms, dict(element.statement.bindings)
            inner: dict[sympy.Symbol, sympy.Expr | int] = dict(bindings)
            for place, meaning in bindings.items():
                if place in terms.coordinates:
                    inner[place.rate] = meaning.rate if meaning in self.columns else sympy.S.Zero
            first = len(self.phi)
            rows = element.statement.rows
            self.massless += [
                (first + rows.index(row), self.columns[q]) for row, q in element.statement.own
            ]
            for k, multiplier in enumerate(terms.multipliers):
                inner[multiplier] = self.lam[first + k]
            with self.graph.serving(element.name):
                translate = self.translate.scoped(inner)
                for phi in terms.phi:
                    self._row(translate(phi), still)
                for component, unit, reaction in terms.reactions:
                    value = translate(reaction)
                    self.reactions.append((element.name, component, unit, value))
                    if element.name in self._rubbing:
                        self._pressing[element.name, component] = {
                            first + k: translate(sympy.diff(reaction, lam))
                            for k, lam in enumerate(terms.multipliers)
                        }
        self.jacobian = dict(sorted(self.jacobian.items()))

    def _row(self, phi: int, still: bool) -> None:
        """Add Φ, Φ_q, ν and γ of one constraint."""
        graph = self.graph
        slopes = self.slopes.gradient({phi: graph.one})
        for k, q in enumerate(self.q):
            if q in slopes:
                self.jacobian[len(self.phi), k] = slopes[q]
        self.nu.append(graph.neg(slopes.get(self.time, graph.zero)))
        bend = graph.zero if still else self.motion.jet(phi).second.scaled(-1.0).value()
        self.gamma.append(bend)
        self.phi.append(phi)

    def _effects(self) -> None:
        graph, equations = self.graph, self.equations
        self.potential = graph.zero  # V
        self.gradient = [graph.zero] * self.n  # ∂V/∂q
        self.forces = [graph.zero] * self.n  # Q with the forces of the potential and Q_v
        self.powers: list[tuple[str, int]] = []  # (effect, power) of effects without a potential
        # effect → power of all its forces, those of a potential included, where its work is an
        # output
        self.working: dict[str, int] = {}
        self.frictions: list[Friction] = []  # the forces that follow from reactions
        outputs = {*(equations.scene.outputs or ())}
        workless = {contact.effect for contact in equations.contacts if not contact.moving}
        for effect in equations.effects:
            terms = effect.terms
            with graph.serving(effect.name):
                energy = graph.zero
                if terms.potential is not None:
                    energy = self.translate(terms.potential)
                    self.potential = graph.add(self.potential, energy)
                    self._gather(self.gradient, {energy: graph.one})
                power = self._apply_forces(terms, energy)
                if (terms.loads or terms.pulls) and effect.name not in workless:
                    self.powers.append((effect.name, power))
                if outputs & {"works", f"work({effect.name})"}:
                    stored = self.moving.jet(energy).first.value()
                    self.working[effect.name] = graph.sub(power, stored)
                for part, unit, value in terms.reported:
                    self.reactions.append((effect.name, part, unit, self.translate(value)))
                if terms.friction:
                    self._friction(effect.name, terms.friction)
        with graph.serving("masses"):
            # (row, column) → entry of M, the whole diagonal and what else is not zero; empty in
            # kinematic scenes
            self.mass = {(i, k): self.translate(m) for i, k, m in equations.mass}
            for k, force in equations.inertia_force:
                self.forces[k] = graph.add(self.forces[k], self.translate(force))

    def _apply_forces(self, terms: EffectTerms, energy: int) -> int:
        """Add all forces of an effect to `forces`; the power of those without a potential.

        Those of the potential and those along scalars are gathered in one walk back: a spring and
        the damper parallel to it pull along one line.
        """
        graph = self.graph
        weights = {energy: graph.constant(-1.0)}
        power = graph.zero
        for scalar, force in terms.pulls:
            s = self.translate(scalar)
            speed = {SPEED: self.motion.jet(s).first.value()} if force.has(SPEED) else {}
            f = graph.neg((self.translate.scoped(speed) if speed else self.translate)(force))
            weights[s] = graph.add(weights.get(s, graph.zero), f)
            power = graph.add(power, graph.mul(f, self.moving.jet(s).first.value()))
        self._gather(self.forces, weights)
        for q, load in terms.loads:
            k, value = self.columns[q], self.translate(load)
            self.forces[k] = graph.add(self.forces[k], value)
            power = graph.add(power, graph.mul(value, self.v[k]))
        return power

    def _gather(self, totals: list[int], weights: dict[int, int]) -> None:
        """Add Σ weight ∂value/∂q to the totals, one a coordinate."""
        slopes = self.slopes.gradient(weights)
        for k, q in enumerate(self.q):
            totals[k] = self.graph.add(totals[k], slopes.get(q, self.graph.zero))

    def _friction(self, name: str, terms: FrictionTerms) -> None:
        """Add a friction: its force from the multipliers as inputs, its power, and its equation."""
        graph = self.graph
        coefficient = self.translate(terms.grip)
        direction = {self.columns[q]: self.translate(slope) for q, slope in terms.direction}
        loads = tuple(
            tuple(self._load(terms.joint, entry) for entry in contact) for contact in terms.contacts
        )
        is_stuck, stiction = self._stiction(name)
        self.frictions.append(Friction(coefficient, direction, loads, is_stuck, stiction))
        sizes = [self.size([self.along(entry, self.lam) for entry in load]) for load in loads]
        pressing = graph.total(sizes)
        force = graph.neg(graph.mul(coefficient, pressing))
        if is_stuck is not None and stiction is not None:
            force = graph.select(is_stuck, stiction, force)
        self.reactions.append((name, "force" if terms.unit == "N" else "torque", terms.unit, force))
        if terms.sticks:
            self.reactions.append((name, "normal", "N", pressing))
        if terms.limit is not None:
            limit = graph.mul(self.translate(terms.limit), pressing)
            self.reactions.append((name, "limit", terms.unit, limit))
        power = graph.mul(force, self.translate(terms.slip))
        self.powers.append((name, power))
        self.working[name] = power

    def _stiction(self, name: str) -> tuple[int, int] | tuple[None, None]:
        """Whether the friction `name` sticks, and its stiction force, if a run determines that."""
        for place, (effect, switch) in enumerate(self.equations.stiction):
            if effect == name:
                return self.graph.is_sliding(switch), self.graph.input(
                    "stiction", place, f"stiction_{name}"
                )
        return None, None

    def _load(self, joint: str, entry: tuple[tuple[str, sympy.Expr], ...]) -> dict[int, int]:
        """Row → factor of a sum of components of a joint's reaction."""
        factors: dict[int, int] = {}
        for component, factor in entry:
            for row, share in self._pressing[joint, component].items():
                part = self.graph.mul(self.translate(factor), share)
                factors[row] = self.graph.add(factors.get(row, self.graph.zero), part)
        return {row: factor for row, factor in factors.items() if factor != self.graph.zero}

    def along(self, entry: dict[int, int], multipliers: list[int]) -> int:
        """The sum of factors times multipliers."""
        graph = self.graph
        return graph.total([graph.mul(factor, multipliers[row]) for row, factor in entry.items()])

    def size(self, vector: list[int]) -> int:
        """√(vᵀv)."""
        squares = [self.graph.mul(entry, entry) for entry in vector]
        return self.graph.power(self.graph.total(squares), 0.5)
