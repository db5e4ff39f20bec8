"""Equations of a scene → values: every element instantiated in one graph."""

import sympy

from codegen.declare.symbols import Acceleration, Parameter, t
from codegen.derive.equations import Equations
from codegen.lower.graph import Graph
from codegen.lower.translate import Translator


class SceneGraph:
    """The equations of a scene as values of one graph.

    Attributes
    ----------
    phi, nu, gamma
        One value a constraint.
    jacobian
        (row, column) → value, structural non-zeros in order.
    own
        (row, column) of the constraints that determine a coordinate without mass.
    reactions
        (element, component, unit, value).
    masses
        Diagonal of M; empty in kinematic scenes.
    potential, gradient, applied
        V, ∂V/∂q, and Q with the forces of the potential.
    powers
        (effect, power) of the effects without a potential.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.n = len(equations.coordinates)
        self.m = sum(len(c.terms.phi) for c in equations.constraints)
        self.graph = graph = Graph()
        self.w = [graph.input("w", k, f"w_{q.name}") for k, q in enumerate(equations.coordinates)]
        self.q = [graph.input("q", k, q.name) for k, q in enumerate(equations.coordinates)]
        self.v = [graph.input("v", k, q.rate.name) for k, q in enumerate(equations.coordinates)]
        self.lam = [
            graph.input("lam", k, f"lambda_{name}") for k, name in enumerate(self.row_names())
        ]
        self.translate = Translator(graph, self._environment(), self._switches())
        self.phi: list[int] = []
        self.nu: list[int] = []
        self.gamma: list[int] = []
        self.jacobian: dict[tuple[int, int], int] = {}
        self.own: list[tuple[int, int]] = []
        self.reactions: list[tuple[str, str, str, int]] = []
        self._constraints()
        self._effects()

    # -- inputs ------------------------------------------------------------------------------

    def row_names(self) -> list[str]:
        """A name for each constraint."""
        return [
            f"{c.name}_{row}" if len(c.statement.rows) > 1 else c.name
            for c in self.equations.constraints
            for row in c.statement.rows
        ]

    def _environment(self) -> dict[sympy.Symbol, int]:
        graph, equations = self.graph, self.equations
        found: dict[sympy.Symbol, int] = {t: graph.input("t", 0, "t")}
        for k, p in enumerate(equations.parameters):
            frozen = equations.scene.frozen
            found[Parameter(p.name, real=True)] = (
                graph.constant(p.value) if frozen else graph.input("p", k, p.name)
            )
        for k, q in enumerate(equations.coordinates):
            found[q], found[q.rate] = self.q[k], self.v[k]
            rate = Acceleration(f"{q.rate.name}_rate", real=True)
            found[rate] = graph.input("a", k, rate.name)
        return found

    def _switches(self) -> dict[sympy.Expr, int]:
        return {switch.g: k for k, switch in enumerate(self.equations.switches)}

    # -- equations ---------------------------------------------------------------------------

    def _constraints(self) -> None:
        columns = {q: k for k, q in enumerate(self.equations.coordinates)}
        for element in self.equations.constraints:
            terms, bindings = element.terms, dict(element.statement.bindings)
            inner: dict[sympy.Symbol, sympy.Expr | int] = dict(bindings)
            for place, meaning in bindings.items():
                if place in terms.coordinates:
                    inner[place.rate] = meaning.rate if meaning in columns else sympy.S.Zero
            first = len(self.phi)
            rows = element.statement.rows
            self.own += [(first + rows.index(row), columns[q]) for row, q in element.statement.own]
            for k, multiplier in enumerate(terms.multipliers):
                inner[multiplier] = self.lam[first + k]
            with self.graph.serving(element.name):
                translate = self.translate.scoped(inner)
                for phi, nu, gamma, row in zip(
                    terms.phi, terms.nu, terms.gamma, terms.jacobian, strict=True
                ):
                    for place, entry in zip(terms.coordinates, row, strict=True):
                        column = columns.get(bindings.get(place, place))
                        if column is not None:
                            key = (len(self.phi), column)
                            before = self.jacobian.get(key, self.graph.zero)
                            self.jacobian[key] = self.graph.add(before, translate(entry))
                    self.phi.append(translate(phi))
                    self.nu.append(translate(nu))
                    self.gamma.append(translate(gamma))
                for component, unit, reaction in terms.reactions:
                    value = translate(reaction)
                    self.reactions.append((element.name, component, unit, value))
        self.jacobian = {k: v for k, v in sorted(self.jacobian.items()) if v != self.graph.zero}

    def _effects(self) -> None:
        graph, equations = self.graph, self.equations
        columns = {q: k for k, q in enumerate(equations.coordinates)}
        self.potential = graph.zero
        self.gradient = [graph.zero] * self.n
        self.forces = [graph.zero] * self.n
        self.powers: list[tuple[str, int]] = []
        for effect in equations.effects:
            with graph.serving(effect.name):
                if effect.terms.potential is not None:
                    own = self.translate(effect.terms.potential)
                    self.potential = graph.add(self.potential, own)
                for q, slope in effect.terms.gradient:
                    k = columns[q]
                    self.gradient[k] = graph.add(self.gradient[k], self.translate(slope))
                power = graph.zero
                for q, force in effect.terms.forces:
                    k, value = columns[q], self.translate(force)
                    self.forces[k] = graph.add(self.forces[k], value)
                    power = graph.add(power, graph.mul(value, self.v[k]))
                if effect.terms.forces:
                    self.powers.append((effect.name, power))
        with graph.serving("masses"):
            self.masses = [self.translate(m) for m in equations.masses]
        self.applied = [graph.sub(f, g) for f, g in zip(self.forces, self.gradient, strict=True)]
