"""Coulomb friction under a normal force that is given, at a slip that is given."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Measure, Reported, Sticking, label
from codegen.declare.element_conditions import static_condition
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import Coordinate, Velocity, kinds, side
from codegen.elements.forces.scalar_measures import is_constant, same_body
from codegen.elements.registry import element


def coefficient_problems(
    effect: Effect, kinetic: sympy.Expr, static: sympy.Expr | None, creep: sympy.Expr | None
) -> list[str]:
    """A static coefficient that contradicts the kinetic one, and two laws at once."""
    where, problems = label(effect), list[str]()
    if static is None:
        return problems
    if creep is not None:
        problems.append(
            f"{where} has both static= and creep=; a friction that creeps never sticks: give "
            "creep= for the smooth law, or static= for the one that sticks, or both with "
            "fidelity='sticking' or 'regularised' to let scenes choose."
        )
    elif kinetic == 0:
        problems.append(
            f"{where}: the coefficient of friction is 0 and the static one {static}; a friction "
            "that sticks also acts when it slides: give a positive coefficient."
        )
    elif kinetic.is_number and static.is_number:
        (condition,) = static_condition(kinetic, static)
        problems += condition.problems(where, {})
    return problems


@element
class DryFriction(Effect):
    """f = -μ N sign(ṡ) along the slip ṡ; at ṡ = 0 the force that keeps it, up to μ_s N (Coulomb).

    The slip is a velocity, linear in the velocities of the bodies, ṡ = J q̇ + b; f acts as Q = Jᵀ f.
    b is the speed of a belt, say. A change of sign of ṡ is an event of a run; where the force that
    keeps ṡ at 0 lies within ±μ_s N, the run goes on sticking. The reported power is that on the
    bodies, Q·q̇: a belt that carries a block along does work.

    With a creep speed v_c the law is smooth instead, f = -μ N tanh(ṡ/v_c), and creeps where it
    would stick, at ṡ = v_c f/(μ N) nearly. Where a normal force that varies is negative, nothing
    presses.
    """

    kind = "dry friction"
    example = """
        mu, mu_s = model.parameter("mu", 0.2), model.parameter("mu_s", 0.3)
        model.dry_friction("rub", P, Q, axis=(1, 0), normal=50.0, coefficient=mu, static=mu_s)
    """
    name: str
    slip: sympy.Expr
    normal: sympy.Expr = quantity(
        "N", "nonnegative", binds="nonnegative", word="normal force", advice=", as it presses"
    )
    coefficient: sympy.Expr = quantity(
        "", "nonnegative", binds="nonnegative", word="coefficient of friction"
    )
    on: tuple[Body, ...]
    static: sympy.Expr | None = quantity("", binds="positive", default=None)
    creep: sympy.Expr | None = quantity(
        "m/s", "positive", binds="positive", default=None, word="creep speed"
    )

    @property
    def force(self) -> sympy.Expr:
        """f, N."""
        direction = side(self.name) if self.creep is None else sympy.tanh(self.slip / self.creep)
        return -self.coefficient * self.pressing * direction

    @property
    def pressing(self) -> sympy.Expr:
        """N, where something presses; else 0."""
        return self.normal if is_constant(self.normal) else sympy.Max(self.normal, 0)

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """Q = Jᵀ f."""
        force = self.force
        return {v.coordinate: force * sympy.diff(self.slip, v) for v in kinds(self.slip, Velocity)}

    def hold(self, bodies: tuple[Body, ...]) -> Sticking | None:
        """Where it sticks, if it does."""
        sticks = self.creep is None
        return Sticking(self.slip, self.coefficient, self.static) if sticks else None

    def reported(self, bodies: tuple[Body, ...]) -> Reported:
        """f itself."""
        return (("force", "N", self.force),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """The slip and N, beside f."""
        return (
            Measure("rate", "", "m/s", self.slip),
            Measure("force", "normal", "N", self.pressing),
        )

    def problems(self) -> list[str]:
        """A slip that is no velocity, and two laws at once."""
        where = label(self)
        if problems := same_body(where, self.bodies):
            return problems
        speeds = kinds(self.slip, Velocity)
        if not speeds:
            problems.append(
                f"{where}: the slip {self.slip} is no velocity, for it contains none; write one, "
                "such as block.vx - speed, or give two points."
            )
        curved = [v for v in speeds if kinds(sympy.diff(self.slip, v), Velocity)]
        if curved:
            problems.append(
                f"{where}: the slip {self.slip} is not linear in {curved[0].name}; write the "
                "velocity itself, such as block.vx - speed."
            )
        return problems + coefficient_problems(self, self.coefficient, self.static, self.creep)
