"""Equations of a scene → values: every element instantiated in one graph."""

from typing import NamedTuple

import sympy

from codegen.declare.symbols import (
    LETTERS,
    SPEED,
    Acceleration,
    Coordinate,
    Parameter,
    QuasiCoordinate,
    t,
)
from codegen.derive.effect_terms import EffectTerms, FrictionTerms, Measure
from codegen.derive.equations import OWN, Equations
from codegen.derive.piecewise_conditions import Boundary
from codegen.errors import ModelError
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.differentiation.gradient import Slopes
from codegen.lower.differentiation.turning import Turn, TurningColumns, jets_of
from codegen.lower.graph import Graph
from codegen.lower.sympy_translation import Translator


class Friction(NamedTuple):
    """A force -coefficient · (sum of the sizes of `loads`) along `direction`."""

    coefficient: int
    direction: dict[int, int]  # column → generalized force of a unit force
    # one a contact: a vector, each entry a sum over row → factor of the multiplier
    loads: list[list[dict[int, int]]]
    is_stuck: int | None  # whether it sticks by a force that a run determines; None: never
    stiction: int  # that force along `direction`

    def choice(self, graph: Graph, sticking: int, sliding: int) -> int:
        """One value while the friction sticks, another while it slides."""
        return sliding if self.is_stuck is None else graph.select(self.is_stuck, sticking, sliding)


class Reaction(NamedTuple):
    """A component of a force that an element transmits or exerts."""

    element: str
    component: str
    unit: str
    value: int
    words: tuple[str, ...] = ("reaction",)  # the outputs of the element of which it is a part


class SceneGraph:
    """The equations of a scene as values of one graph."""

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.n = len(equations.coordinates)
        self.names = [q.name for q in equations.coordinates]
        self.rates = [q.rate.name for q in equations.coordinates]  # names of the velocities
        self.owners: list[str] = []  # the element of each constraint
        self.rows: list[str] = []  # names of the constraints
        for c in equations.constraints:
            several = len(c.statement.rows) > 1
            self.owners += [c.name] * len(c.statement.rows)
            self.rows += [f"{c.name}_{row}" if several else c.name for row in c.statement.rows]
        self.row_names = self.rows  # also where others than the declared ones are solved for
        self.m = len(self.rows)
        self.graph = graph = Graph()
        self.columns = {q: k for k, q in enumerate(equations.coordinates)}
        self.w = self._inputs("w", [f"w_{name}" for name in self.names])
        self.q = self._inputs("q", self.names)
        self._column_of = {q: k for k, q in enumerate(self.q)}
        self.v = self._inputs("v", self.rates)
        self.lam = self._inputs("lam", [f"lambda_{name}" for name in self.rows])
        self.time = graph.input("t", 0, "t")
        self.translate = Translator(graph, self._environment(), equations.switches)
        # The pieces of laws of motion are chosen by the time, and not by modes.
        self.translate_law = Translator(graph, self.translate.environment, ())
        self.phi: list[int] = []  # Φ, as ν and γ one value a constraint
        self.nu: list[int] = []
        self.gamma: list[int] = []
        self._bends: list[list[int]] = []  # of each row γ by every way in which bodies turn
        self.jacobian: dict[tuple[int, int], int] = {}  # (row, column) → value, non-zeros in order
        # the same in the columns of the accelerations that are solved for, where bodies turn
        self.turned_jacobian: dict[tuple[int, int], int] = {}
        self.norms: dict[int, int] = {}  # row of the equation between Euler parameters → its turn
        # (row, column) of the constraints that determine a coordinate without mass
        self.massless: list[tuple[int, int]] = []
        self.reactions: list[Reaction] = []
        laws = (e.terms.friction for e in equations.effects)
        self._rubbing = {law.joint for law in laws if law}
        self._pressing: dict[tuple[str, str], dict[int, int]] = {}
        # the rotations of bodies in space, which have own columns behind those of coordinates
        self.turns = [
            Turn(graph, k, self.columns[body.p[0]], self.q, self.v)
            for k, body in enumerate(equations.turning)
        ]
        self._column_of |= {
            axis: self.n + k for k, axis in enumerate(a for turn in self.turns for a in turn.axes)
        }
        self.turning = TurningColumns(graph, self.turns, self.n)
        self.slopes = Slopes(graph, (*self.q, self.time), self.turns)  # by q and t
        self._slopes_in_ground = Slopes(graph, (*self.q, self.time), self.turns, in_ground=True)
        velocities = dict(zip(self.q, self.v, strict=True))
        jets, in_ground = (jets_of(self.turns, in_ground=where) for where in (False, True))
        self.moving = Direction(graph, velocities, order=1, jets=jets)  # along q̇ with t held
        along = {**velocities, self.time: graph.one}
        self.motion = Direction(graph, along, jets=jets)  # along q̇ and t
        in_space = (Direction(graph, along, jets=in_ground, first=k) for k in (min, max))
        self._motions = [self.motion, *(in_space if self.turns else ())]
        # what elements on the ground, and all constraints, exert on the bodies, where it is asked
        columns = self.n + 3 * len(self.turns)
        self.of_ground = [graph.zero] * columns if equations.shakes else []
        self._constraints()
        # of each row the constraints that it combines → their factors: here every one alone
        self.weights: list[dict[int, int]] = [{i: graph.one} for i in range(self.m)]
        self.stated = list(range(self.m))  # the constraint as which each row is reported
        self._effects()
        if equations.shakes:
            self._ground()

    def _inputs(self, array: str, names: list[str]) -> list[int]:
        return [self.graph.input(array, k, name) for k, name in enumerate(names)]

    def _environment(self) -> dict[sympy.Symbol, int]:
        """The value of each symbol; where one says on which side an effect acts, by its mode."""
        graph, equations = self.graph, self.equations
        environment: dict[sympy.Symbol, int] = {t: self.time}
        for k, p in enumerate(equations.parameters):
            frozen = equations.scene.frozen
            number = graph.constant(p.value) if frozen else graph.input("p", k, p.name)
            environment[Parameter(p.name, real=True)] = number
        for k, q in enumerate(equations.coordinates):
            environment[q], environment[q.rate] = self.q[k], self.v[k]
            rate = Acceleration(f"{q.rate.name}_rate", real=True)
            environment[rate] = graph.input("a", k, rate.name)
        given = {k: place for place, (_, k) in enumerate(equations.shares, len(equations.stiction))}
        for side in equations.sides:
            above, below = (graph.constant(float(x)) for x in (side.above, side.below))
            value = graph.select(graph.mode(side.switch), above, below)
            if (k := side.switch) in given:
                name = f"share_{equations.switches[k].effect}"
                share = graph.input("stiction", given[k], name)
                part = graph.mul(share, graph.constant(float(side.above - side.below)))
                value = graph.select(graph.is_sliding(k), graph.add(below, part), value)
            elif equations.switches[k].boundary is Boundary.MIXED:
                value = graph.select(graph.is_sliding(k), graph.constant(0.0), value)
            environment[side.symbol] = value
        return environment

    def credited(self, element: str, *expressions: sympy.Expr) -> list[int]:
        """The values of expressions that serve an element."""
        with self.graph.serving(element):
            return [self.translate(expression) for expression in expressions]

    # -- equations ---------------------------------------------------------------------------

    def _constraints(self) -> None:
        turning = {body.name: k for k, body in enumerate(self.equations.turning)}
        for element in self.equations.constraints:
            terms, statement, first = element.terms, element.statement, len(self.phi)
            inner: dict[sympy.Symbol, sympy.Expr | int] = dict(statement.bindings)
            for place, meaning in statement.bindings.items():
                if place in terms.coordinates:
                    inner[place.rate] = meaning.rate if meaning in self.columns else sympy.S.Zero
            for row, q in statement.own:
                self.massless.append((first + statement.rows.index(row), self.columns[q]))
            inner |= zip(terms.multipliers, self.lam[first:], strict=False)
            if element.kind == OWN and element.name in turning:
                self.norms[first] = turning[element.name]
            with self.graph.serving(element.name):
                translate = self.translate_law.scoped(inner)
                for phi in terms.phi:
                    self._row(translate(phi))
                for component, unit, reaction in terms.reactions:
                    value = translate(reaction)
                    self.reactions.append(Reaction(element.name, component, unit, value))
                    if element.name in self._rubbing:
                        self._pressing[element.name, component] = {
                            first + k: translate(sympy.diff(reaction, lam))
                            for k, lam in enumerate(terms.multipliers)
                        }
        self.jacobian = dict(sorted(self.jacobian.items()))
        self.gamma, self.turned_gamma = self.turning.gammas(self._bends, self.turned_jacobian)

    def _row(self, phi: int) -> None:
        """Add Φ, Φ_q, ν and γ of one constraint."""
        graph, resting = self.graph, self.equations.scene.analysis == "equilibrium"
        slopes = self.slopes.gradient({phi: graph.one})
        row = {self._column_of[q]: slope for q, slope in slopes.items() if q != self.time}
        if self.turns and len(self.phi) not in self.norms:
            turned = self.turning.six(row)
            self.turned_jacobian |= {(len(self.phi), k): slope for k, slope in turned.items()}
            found = self._slopes_in_ground.gradient({phi: graph.one})
            row = {self._column_of[q]: slope for q, slope in found.items() if q != self.time}
            row = self.turning.by_coordinates(row)
        self.jacobian |= {(len(self.phi), k): slope for k, slope in row.items()}
        self.nu.append(graph.neg(slopes.get(self.time, graph.zero)))
        bends = [graph.zero] * len(self._motions)  # at rest γ vanishes
        if (norm := self.norms.get(len(self.phi))) is not None and not resting:
            bends = [graph.mul(graph.constant(-2.0), self.turns[norm].square)] * len(bends)
        elif not resting:
            bends = [way.jet(phi).second.scaled(-1.0).value() for way in self._motions]
        self._bends.append(bends)
        self.phi.append(phi)

    def _effects(self) -> None:
        graph, equations = self.graph, self.equations
        self.potential = graph.zero  # V
        columns = self.n + 3 * len(self.turns)
        self.gradient = [graph.zero] * columns  # ∂V/∂q
        self.forces = [graph.zero] * columns  # Q with the forces of the potential and Q_v
        # (effect, power) of the forces without a potential
        self.powers: list[tuple[str, int]] = []
        # effect → power of all its forces, those of a potential included, where that or its work is
        # an output
        self.working: dict[str, int] = {}
        self.conservative: set[str] = set()  # the effects that have a potential
        self.frictions: list[Friction] = []  # the forces that follow from reactions
        outputs = {*(equations.scene.outputs or ())}
        workless = {contact.effect for contact in equations.contacts if not contact.moving}
        states = {state.name for state in equations.states}
        workless |= states
        for effect in equations.effects:
            terms = effect.terms
            ending = "s", f"({effect.name})"
            with graph.serving(effect.name):
                energy = graph.zero
                if terms.potential is not None:
                    energy = self.translate(terms.potential)
                    self.conservative.add(effect.name)
                    self.potential = graph.add(self.potential, energy)
                    self._gather(self.gradient, {energy: graph.one})
                power = self._apply_forces(terms, energy, effect.on_ground)
                if (terms.loads or terms.pulls or terms.flux) and effect.name not in workless:
                    self.powers.append((effect.name, power))
                asked = outputs & {f"{word}{of}" for word in ("power", "work") for of in ending}
                if asked and effect.name not in states and terms.watched is None:
                    stored = self.moving.jet(energy).first.value()
                    self.working[effect.name] = graph.sub(power, stored)
                for part, unit, value in terms.reported:
                    words = _words(unit, part)
                    reaction = Reaction(effect.name, part, unit, self.translate(value), words)
                    self.reactions.append(reaction)
                for measure in terms.measures:
                    self._measure(effect.name, measure)
                if terms.friction:
                    self._friction(effect.name, terms.friction)
        with graph.serving("masses"):
            # (row, column) → entry of M, the whole diagonal and what else is not zero; empty in
            # kinematic scenes
            self.mass = {(i, k): self._of_body(i, m) for i, k, m in equations.mass}
            self.pushes = self.forces  # Q where bodies turn, in own columns
            if self.turns:
                self.gradient, self.forces = map(self._by_coordinates, (self.gradient, self.forces))
            for k, force in equations.inertia_force:
                self.forces[k] = graph.add(self.forces[k], self._of_body(k, force))

    def _by_coordinates(self, forces: list[int]) -> list[int]:
        """Forces of coordinates and of turns, all by coordinates."""
        row = self.turning.seven(dict(enumerate(forces)))
        return [row.get(k, self.graph.zero) for k in range(self.n)]

    def _of_body(self, k: int, expression: sympy.Expr) -> int:
        """The value of an expression of the body with coordinate k, which errors name."""
        try:
            return self.translate(expression)
        except ModelError as error:
            where = f"body '{self.equations.coordinates[k].owner}'"
            raise ModelError(f"{where}: {problem}" for problem in error.problems) from error

    def _ground(self) -> None:
        """Add the force on the ground, and its moment about the origin, as sums over all bodies."""
        graph, total, equations = self.graph, self.of_ground, self.equations
        fx = fy = torque = graph.zero
        with graph.serving("ground"):
            for (i, k), slope in self.jacobian.items():
                total[k] = graph.sub(total[k], graph.mul(slope, self.lam[i]))
            for body in equations.bodies:
                own = {q.letter: k for q, k in self.columns.items() if q.owner == body}
                if not {"x", "y"} <= own.keys() <= {*LETTERS}:
                    where = (
                        f"scene '{equations.scene.name}': the force on the ground needs x, y and"
                    )
                    has = f"body '{body}' has {', '.join(own)}; leave that output out."
                    raise ModelError(f"{where} phi, but {has}")
                x, y = own["x"], own["y"]
                fx, fy = graph.sub(fx, total[x]), graph.sub(fy, total[y])
                torque = graph.sub(torque, graph.mul(self.q[x], total[y]))
                torque = graph.add(torque, graph.mul(self.q[y], total[x]))
                torque = graph.sub(torque, total[own["phi"]]) if "phi" in own else torque
        for part, unit, value in ("fx", "N", fx), ("fy", "N", fy), ("torque", "N m", torque):
            self.reactions.append(Reaction("ground", part, unit, value, ("shaking",)))

    def _apply_forces(self, terms: EffectTerms, energy: int, on_ground: bool) -> int:
        """Add all forces of an effect, in one walk back; the power of those without a potential."""
        graph = self.graph
        weights = {energy: graph.constant(-1.0)}
        power = graph.zero
        for scalar, force in terms.pulls:
            s = self.translate(scalar)
            speed = {SPEED: self.motion.jet(s).first.value()} if force.has(SPEED) else {}
            f = graph.neg((self.translate.scoped(speed) if speed else self.translate)(force))
            weights[s] = graph.add(weights.get(s, graph.zero), f)
            power = graph.add(power, graph.mul(f, self.moving.jet(s).first.value()))
        totals = [self.forces, *([self.of_ground] if on_ground and self.of_ground else ())]
        for total in totals:
            self._gather(total, weights)
        if terms.flux is not None:
            power = graph.add(power, self.translate(terms.flux))
        for q, load in terms.loads:
            k, value = self._column_of[self._place(q)], self.translate(load)
            for total in totals:
                total[k] = graph.add(total[k], value)
            power = graph.add(power, graph.mul(value, self.translate(q.rate)))
        return power

    def _place(self, q: Coordinate) -> int:
        """The input of a coordinate, or of a turn of a body in space."""
        if isinstance(q, QuasiCoordinate):
            names = [body.name for body in self.equations.turning]
            return self.turns[names.index(q.owner)].axes["xyz".index(q.letter[-1])]
        return self.q[self.columns[q]]

    def _measure(self, name: str, measure: Measure) -> None:
        """Add a quantity of an effect that is an output; it switches nothing itself."""
        translate, inner = self.translate.comparing, dict[sympy.Expr, int]()
        if measure.along is not None and measure.value.has(SPEED):
            inner[SPEED] = self.motion.jet(self.translate(measure.along)).first.value()
        value = translate.scoped(inner)(measure.value)
        row = Reaction(name, measure.row, measure.unit, value, (measure.quantity,))
        self.reactions.append(row)

    def _gather(self, totals: list[int], weights: dict[int, int]) -> None:
        """Add Σ weight ∂value/∂q to the totals, one a coordinate."""
        slopes = self.slopes.gradient(weights)
        for q, slope in slopes.items():  # in the order of the coordinates
            if q != self.time:
                k = self._column_of[q]
                totals[k] = self.graph.add(totals[k], slope)

    def _friction(self, name: str, terms: FrictionTerms) -> None:
        """Add a friction: its force from the multipliers as inputs, its power, and its equation."""
        graph = self.graph
        coefficient = self.translate(terms.grip)
        direction = {self.columns[q]: self.translate(slope) for q, slope in terms.direction}
        loads = [[self._load(terms.joint, entry) for entry in c] for c in terms.contacts]
        is_stuck, stiction = None, graph.zero
        for place, (effect, switch) in enumerate(self.equations.stiction):
            if effect == name:
                is_stuck = graph.is_sliding(switch)
                stiction = graph.input("stiction", place, f"stiction_{name}")
        friction = Friction(coefficient, direction, loads, is_stuck, stiction)
        self.frictions.append(friction)
        sizes = [self.size([self.along(entry, self.lam) for entry in load]) for load in loads]
        pressing = graph.total(sizes)
        force = friction.choice(graph, stiction, graph.neg(graph.mul(coefficient, pressing)))
        for k, slope in direction.items() if self.of_ground else ():
            self.of_ground[k] = graph.add(self.of_ground[k], graph.mul(force, slope))
        kind, words = "force" if terms.unit == "N" else "torque", _words(terms.unit)
        self.reactions.append(Reaction(name, kind, terms.unit, force, words))
        normal = words if terms.sticks else words[1:]
        self.reactions.append(Reaction(name, "normal", "N", pressing, normal))
        if terms.limit is not None:
            limit = graph.mul(self.translate(terms.limit), pressing)
            self.reactions.append(Reaction(name, "limit", terms.unit, limit, words))
        power = graph.mul(force, self.translate(terms.slip))
        self.powers.append((name, power))
        self.working[name] = graph.add(self.working.get(name, graph.zero), power)

    def _load(self, joint: str, entry: tuple[tuple[str, sympy.Expr], ...]) -> dict[int, int]:
        """Row → factor of a sum of components of a joint's reaction."""
        factors: dict[int, int] = {}
        for component, factor in entry:
            for row, share in self._pressing[joint, component].items():
                part = self.graph.mul(self.translate(factor), share)
                factors[row] = self.graph.add(factors.get(row, self.graph.zero), part)
        return {row: factor for row, factor in factors.items() if factor != self.graph.zero}

    def multipliers(self, of_rows: list[int]) -> list[int]:
        """The multipliers of all constraints, by those of the rows, which may combine them."""
        graph, found = self.graph, [self.graph.zero] * len(self.lam)
        for row, factors in enumerate(self.weights):
            for i, factor in factors.items():
                found[i] = graph.add(found[i], graph.mul(factor, of_rows[row]))
        return found

    def along(self, entry: dict[int, int], multipliers: list[int]) -> int:
        """The sum of factors times multipliers."""
        return self.graph.dot(entry.values(), [multipliers[row] for row in entry])

    def size(self, vector: list[int]) -> int:
        """√(vᵀv)."""
        return self.graph.power(self.graph.dot(vector, vector), 0.5)


def _words(unit: str, part: str = "") -> tuple[str, ...]:
    """The outputs of which a component that an effect reports is a part, by its unit or name."""
    named = (part,) if part in ("force", "torque") else ()
    return ("reaction", *{"N": ("force",), "N m": ("torque",)}.get(unit, named))
