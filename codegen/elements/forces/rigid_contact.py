"""Rigid contact: a gap that cannot become negative, and impacts."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Measure, Pulls, Reported, Rigid
from codegen.declare.element_conditions import hold_conditions
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import side
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import WORDS, along_scalar, force_unit
from codegen.elements.forces.spring_damper_contact import gap_problems
from codegen.elements.registry import element

# formula: m/s²; with the masses the typical force of a contact, unless one is declared
GRAVITY = 9.81


@element
class RigidContact(Effect):
    """g ≥ 0, F ≥ 0, F g = 0: a reaction F that is there only where the gap g is closed.

    It acts along the gap as a contact's force does, Q = F g_q, and has the size that keeps the gap
    closed, g̈ = 0; where it would have to pull, the bodies part. A gap that closes with the speed
    ġ⁻ < 0 is an impact: velocities jump by M⁻¹ g_qᵀ times an impulse, the joints being kept, so
    that ġ⁺ = -e ġ⁻ (Newton's law of restitution).

    In mode 1 the gap is open and nothing acts. In mode 0 the kernels exert the reaction F0, a
    typical force; accelerations are linear in it, so that a run finds by which multiple of it the
    gap stays closed, and reports F0 times this multiple.

    The gap is smooth; one that depends on the time is a moving wall, which does work. e goes from
    0, an impact that does not rebound, to 1, one that loses no energy.
    """

    kind = "rigid contact"
    example = """
        e = model.parameter("e", 0.5)
        model.contact("stop", P, Q, restitution=e, free_length=1, direction=(1, 0))
    """
    name: str
    gap: sympy.Expr
    restitution: sympy.Expr = quantity(binds="nonnegative")
    on: tuple[Body, ...]
    unit: str = "m"  # of the gap: "m", "rad", or none where it is not known
    limits: tuple[sympy.Expr, ...] = ()  # of a stop: what is left before each of its limits
    typical_force: sympy.Expr | None = quantity(force_unit, binds="positive", default=None)

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """The reaction F0, where the gap is not open: it pushes."""
        return ((self.gap, -side(self.name) * self._scale(bodies)),)

    def hold(self, bodies: tuple[Body, ...]) -> Rigid:
        """The gap stays closed until the reaction would pull."""
        return Rigid(self.gap, self.restitution, self._scale(bodies))

    def reported(self, bodies: tuple[Body, ...]) -> Reported:
        """The reaction, positive: it pushes."""
        _, exerted, unit = WORDS[self.unit]
        return ((exerted, unit, side(self.name) * self._scale(bodies)),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """The gap and its rate; the force is reported."""
        gap, rate, _ = along_scalar(self.gap, self.unit, sympy.S.Zero, named="gap")
        return gap, rate

    def problems(self) -> list[str]:
        """A gap that is none, and numbers that no impact has."""
        where = f"contact '{self.name}'"
        problems = gap_problems(where, self.gap, self.bodies)
        scale = sympy.S.One if self.typical_force is None else self.typical_force
        for condition in hold_conditions(Rigid(self.gap, self.restitution, scale)):
            problems += condition.problems(where, {}) if condition.known else ()
        return problems

    def _scale(self, bodies: tuple[Body, ...]) -> sympy.Expr:
        if self.typical_force is not None:
            return self.typical_force
        masses = [body.mass for body in bodies if body.mass is not None]
        return sympy.Float(GRAVITY) * (sympy.Add(*masses) if masses else sympy.S.One)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The bodies that touch, and the gap between them, or those of a stop."""
        if self.unit != "m":
            return (shapes.Contact(self.on),)
        is_stop = bool(self.limits)
        gaps = self.limits or (self.gap,)
        return tuple(shapes.Contact(self.on, gap=gap, is_stop=is_stop) for gap in gaps)
