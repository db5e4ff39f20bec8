"""Matter that a body gains or loses: the law of its mass, and the force of the flow.

A mass that varies is an own coordinate m of a `MassLaw`, whose row m - law(t, q) = 0 determines it,
so that M depends on coordinates alone. The equation of a body whose centre of mass is fixed in it
is M q̈ + Φ_qᵀ λ = Q + Σ ṁ u, u the velocity of the matter relative to the body's own point where it
comes or goes (I. V. Meshchersky, Dynamics of a Point of Variable Mass, 1897; F. O. Eke and
S.-M. Wang, Journal of Applied Mechanics 61, 1994, 855-860). It is not Lagrange's: the matter takes
its momentum and energy along, so that no ∂M/∂q acts.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import sympy

from codegen.declare.body import Bodies, Body, Loads, Point
from codegen.declare.element import Constraint, Effect, Measure, Measures, Statement, label
from codegen.declare.element_fields import quantity
from codegen.declare.state import WatchedCondition
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.drawing import shapes
from codegen.elements.forces.applied import AppliedForce
from codegen.elements.registry import element

AT_ONCE = 1e-9  # accuracy: s; a run ends so long before a mass vanishes, and accelerations with 1/m
MASS_LAW = "mass law"  # kind of a constraint that bodies bring
Pair = tuple[sympy.Expr, sympy.Expr]


@dataclass(frozen=True, eq=False)
class MassLaw(Constraint):
    """The mass and the moment of inertia of a body follow laws of t and coordinates."""

    kind = MASS_LAW
    name: str
    body: Body
    on: Bodies  # the bodies in the laws

    def statement(self) -> Statement:
        """m - law = 0, and J - law = 0, which push nothing."""
        phi = tuple(q - law for q, law in self.body.laws)
        own = {q.letter: q for q, _ in self.body.laws}
        return Statement(phi, tuple(own), None, own=tuple(own.items()))

    @property
    def exhaustion(self) -> WatchedCondition:
        """What ends a run: at its present rate a mass is gone in less than `AT_ONCE`."""
        gone = sympy.Or(*(q + AT_ONCE * q.rate <= 0 for q, _ in self.body.laws))
        indicator = sympy.Piecewise((sympy.S.One, gone), (sympy.S.Zero, True))
        return WatchedCondition(f"{self.body.name}_exhausted", indicator, "until")

    def problems(self) -> list[str]:
        """Laws of velocities, and an inertia that varies where nothing comes or goes."""
        still = not any(q.letter == "mass" for q, _ in self.body.laws)
        found = ["matter that moves within a body is a body of its own; give mass= a law, too."]
        return found * still + [
            f"the {q.letter} {law} contains {s.name}; a mass is an expression of t, coordinates "
            "and parameters, and of the integrals of states, STATE.coordinate."
            for q, law in self.body.laws
            for s in kinds(law, Velocity)
        ]

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The values of the laws at t = 0, integrals of states at 0."""
        laws = dict(self.body.laws)
        places = {s: numbers.get(s, 0.0) for law in laws.values() for s in law.free_symbols}
        return {q: float(law.subs(places)) for q, law in laws.items()}


@element
class MassFlow(Effect):
    """Matter comes to a body, or leaves it, with a velocity of its own.

    F = ṁ u at a point P of the body: ṁ is the rate of the body's mass times the share of this flow,
    and u the velocity of the matter relative to the body there, `relative` in the body's axes, or
    w - v_P with the matter's own `velocity` w in global axes. The matter brings, or takes, the
    energy ṁ v²/2 + J̇ ω²/2 of the body, which is a part of the power of the flow.
    """

    kind = "mass flow"
    example = """
        tank = model.body("tank", mass=100 - 2 * t, inertia=5.0)
        model.mass_flow("jet", tank.at(0, -1), relative=(0, -3))
    """
    name: str
    point: Point
    velocity: Pair | None = quantity(("m/s", "m/s"), default=None)
    relative: Pair | None = quantity(("m/s", "m/s"), default=None)
    share: sympy.Expr = quantity("1", default=sympy.S.One)

    @property
    def push(self) -> AppliedForce:
        """The force ṁ u, N."""
        frame: Literal["body", "ground"] = "ground" if self.relative is None else "body"
        (wx, wy), at = self.velocity or (0, 0), self.point
        (x, y), (vx, vy), omega = at.body.position, at.body.velocity, at.body.angular_velocity
        # of the body's own point there, also where the place itself moves in the body
        ux, uy = self.relative or (wx - vx + omega * (at.y - y), wy - vy - omega * (at.x - x))
        return AppliedForce(self.name, self.point, self.flow * ux, self.flow * uy, frame)

    def forces(self, bodies: Bodies) -> Loads:
        """ṁ u on x, y, and its moment on φ."""
        return self.push.forces(bodies)

    @property
    def flow(self) -> sympy.Expr:
        """ṁ of this flow, kg/s."""
        return self.share * getattr(self.point.body.mass, "rate", sympy.S.Zero)

    @property
    def energy_flux(self) -> sympy.Expr:
        """ṁ v²/2 + J̇ ω²/2, W: the energy that the matter brings beside the work of its force."""
        body = self.point.body
        (vx, vy), omega = body.velocity, body.angular_velocity
        turning = getattr(body.inertia, "rate", sympy.S.Zero) * omega**2
        return (self.flow * (vx**2 + vy**2) + self.share * turning) / 2

    def measures(self, bodies: Bodies) -> Measures:
        """The force in the axes in which its velocity is given, and ṁ of this flow."""
        return *self.push.measures(bodies), Measure("rate", "", "kg/s", self.flow)

    def problems(self) -> list[str]:
        """A body of constant mass, and no velocity or two."""
        found, body = [], self.point.body
        if not body.laws:
            found.append(
                f"{label(self)}: the mass of '{body.name}' is constant; give its law, such as "
                f"model.body('{body.name}', mass=100 - 2*t, inertia=...)."
            )
        if (self.velocity is None) == (self.relative is None):
            found.append(
                f"{label(self)}: give velocity=, that of the matter in global axes, or relative=, "
                f"that relative to '{body.name}' in its axes: (0, 0) where it has none."
            )
        return found

    def shapes(self) -> shapes.Shapes:
        """An arrow."""
        return self.push.shapes()
