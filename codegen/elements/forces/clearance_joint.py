"""Revolute joint with clearance: a journal is free in its bearing until it touches the wall."""

from typing import Any

import sympy

from codegen.declare.body import Bodies, Loads, Point
from codegen.declare.element import Effect, Measure, Measures, Pulls, label
from codegen.declare.element_fields import Condition, Conditions, quantity
from codegen.declare.symbols import SPEED, rate
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.elements.scalar_measures import distance, same_body, span


def _stiffness_unit(joint: Any) -> str:
    """That of K, by the exponent where it is a number."""
    n = joint.exponent
    return f"N/m^{float(n):g}" if n.is_number and n.is_real else ""


@element
class ClearanceJoint(Effect):
    """A pin joint with clearance: the journal moves within its bearing, and strikes it.

    f = K δⁿ (1 + χ δ̇) while the eccentricity e exceeds the clearance c, with δ = e - c.

    e is the distance of the journal's centre j from the bearing's centre i. Inside the clearance
    nothing acts, so that e = 0, where e has no direction, is harmless; contact and its end are
    events of a run. K δⁿ is Hertz' law for n = 3/2. χ is the damping of Hunt and Crossley (1975);
    Lankarani and Nikravesh (1990) give it for a restitution ε at an impact of speed v as χ = 3 (1 -
    ε²)/(4 v). The joint has no potential, and all its work is counted. The law would pull if the
    surfaces parted faster than 1/χ; after such an impact they part more slowly.

    The friction -μ f tanh(v_t/v_c) acts at the contact, at the journal's radius R from its centre.
    Friction opposes the speed v_t along the bearing's wall; below v_c the contact creeps (P.
    Flores, J. Ambrósio, J. C. P. Claro, H. M. Lankarani: Kinematics and Dynamics of Multibody
    Systems with Imperfect Joints, Springer 2008).
    """

    kind = "clearance joint"
    example = """
        K = model.parameter("K", 1e9)
        mu = model.parameter("mu", 0.1)
        model.clearance_joint("pin", P, Q, clearance=1e-4, stiffness=K, damping=0.5, coefficient=mu,
                              creep=1e-3, radius=0.01)
    """
    name: str
    i: Point
    j: Point
    clearance: sympy.Expr = quantity("m", "positive", binds="positive")
    exponent: sympy.Expr = quantity()
    stiffness: sympy.Expr = quantity(_stiffness_unit, "positive", binds="positive")
    creep: sympy.Expr | None = quantity("m/s", "positive", binds="positive", word="creep speed")
    damping: sympy.Expr = quantity("s/m", "nonnegative", binds="nonnegative")
    coefficient: sympy.Expr = quantity(
        "", "nonnegative", binds="nonnegative", word="coefficient of friction"
    )
    radius: sympy.Expr = quantity("m", "nonnegative", binds="nonnegative")

    @property
    def eccentricity(self) -> sympy.Expr:
        """e, m."""
        return distance(self.i, self.j)

    @property
    def excess(self) -> sympy.Expr:
        """(e² - c²)/2, m²: positive in contact, and smooth at e = 0, which e is not."""
        dx, dy = span(self.i, self.j)
        return (dx**2 + dy**2 - self.clearance**2) / 2

    def pulls(self, bodies: Bodies) -> Pulls:
        """The normal force: f along e is f/e along the excess, and ṡ = e ė."""
        return ((self.excess, self._touching(self._normal(SPEED) / self.eccentricity)),)

    def forces(self, bodies: Bodies) -> Loads:
        """The friction, at one place of both surfaces."""
        if not self._rubs:
            return {}
        (dx, dy), e = span(self.i, self.j), self.eccentricity
        wall = e + self.radius  # from the bearing's centre to the contact
        drag = self._drag()
        found: Loads = {}
        for point, sign, arm in ((self.i, -1, wall), (self.j, 1, self.radius)):
            body = point.body
            if body.fixed:
                continue
            (x, y), f = body.position, sign * drag / e
            fx, fy = -f * dy, f * dx
            turn = (point.x - x) * fy - (point.y - y) * fx + sign * drag * arm
            found |= {body.x: fx, body.y: fy, **body.torque(turn)}
        return {q: self._touching(force) for q, force in found.items()}

    def measures(self, bodies: Bodies) -> Measures:
        """e, the gap c - e, the depth, the normal force, and the friction on the journal.

        The friction is positive where it drives the contact counter-clockwise about the bearing.
        """
        e, force = self.eccentricity, self._touching(self._normal(SPEED))
        found = (
            Measure("length", "", "m", e),
            Measure("gap", "", "m", self.clearance - e),
            Measure("penetration", "", "m", self._touching(e - self.clearance)),
            Measure("force", "normal", "N", force, self.excess),
        )
        if not self._rubs:
            return found
        return (*found, Measure("force", "friction", "N", self._touching(self._drag())))

    def problems(self) -> list[str]:
        """Two points of one body, and a friction without a creep speed or on a particle."""
        where = label(self)
        problems = same_body(where, self.bodies)
        rubs = self.coefficient != 0
        if rubs and self.creep is None:
            problems.append(f"{where} has a coefficient of friction but no creep speed; give both.")
        problems += [
            f"{where} rubs on '{body.name}', which is a particle and cannot turn; use a body, or "
            "leave coefficient= out."
            for body in self.bodies
            if rubs and not body.turns
        ]
        return problems

    def conditions(self) -> Conditions:
        """An exponent of a contact."""
        text = "the exponent is {:g}; give one of at least 1, 1.5 for Hertz' law."
        return (Condition(text, (self.exponent,), low=1.0),)

    @property
    def _rubs(self) -> bool:
        return self.coefficient != 0 and self.creep is not None

    def _normal(self, excess_rate: sympy.Expr) -> sympy.Expr:
        """f = K δⁿ (1 + χ δ̇), by δ̇ = ṡ/e of the excess s."""
        closing, n = excess_rate / self.eccentricity, self.exponent
        over = self.eccentricity + self.clearance
        depth = (2 * self.excess) ** n / over**n  # δⁿ, by δ = (e² - c²)/(e + c)
        return self.stiffness * depth * (1 + self.damping * closing)

    def _drag(self) -> sympy.Expr:
        """-μ f tanh(v_t/v_c), along the wall."""
        (dx, dy), e = span(self.i, self.j), self.eccentricity
        one, other = self.i.body, self.j.body
        slip = (dx * (self.j.vy - self.i.vy) - dy * (self.j.vx - self.i.vx)) / e
        slip += self.radius * other.angular_velocity - (e + self.radius) * one.angular_velocity
        normal = self._normal(rate(self.excess))
        return -self.coefficient * normal * sympy.tanh(slip / self.creep)

    def _touching(self, value: sympy.Expr) -> sympy.Expr:
        return sympy.Piecewise((value, 2 * self.excess > 0), (0, True))

    def shapes(self) -> shapes.Shapes:
        """A journal in a hole."""
        return (shapes.Bearing(self.i, self.j, self.clearance),)
