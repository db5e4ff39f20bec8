"""Motor between a rotor and a stator, whose torque falls in a straight line with its speed."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Measure, Pulls
from codegen.declare.element_fields import ground_unless_given, quantity
from codegen.declare.symbols import SPEED
from codegen.drawing import shapes
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element


@element
class Motor(measures.TurnMeasures, Effect):
    """T = T_s (u - ω/ω_0) on the rotor j, -T on the stator i, with ω = φ̇_j - φ̇_i.

    The line of a motor with permanent magnets, whose armature has neither inductance nor friction:
    T_s is its torque at rest and ω_0 its speed without load, both at the rated voltage, and u the
    voltage as a multiple of it, from -1 to 1 as a rule. With u = 0 it is short-circuited and brakes
    by T_s/ω_0 of viscous damping. Beyond ω_0 it is a generator.
    """

    kind = "motor"
    example = """
        T_s = model.parameter("T_s", 0.8, unit="N m")
        omega_0 = model.parameter("omega_0", 300.0, unit="rad/s")
        model.motor("motor", on=j, from_=i, stall_torque=T_s, no_load_speed=omega_0)
    """
    name: str
    i: Body = ground_unless_given()
    j: Body
    stall_torque: sympy.Expr = quantity("N m", "positive", binds="positive")
    no_load_speed: sympy.Expr = quantity(
        "rad/s", "positive", binds="positive", word="no-load speed"
    )
    voltage: sympy.Expr = quantity()

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """T tends to make θ = φ_j - φ_i larger."""
        line = SPEED / self.no_load_speed - self.voltage
        return ((self.angle, self.stall_torque * line),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """θ, ω and T."""
        line = self.voltage - SPEED / self.no_load_speed
        return measures.along_scalar(self.angle, "rad", self.stall_torque * line)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A round arrow between two bodies."""
        return (shapes.SpiralSpring(self.i, self.j, elastic=False, actuator=True),)
