"""Rotational spring-damper-actuator between two bodies (Haug 6.1)."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.drawing import shapes
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element


@element
class TorsionSpring(measures.TurnMeasures, measures.SpringDamper):
    """n = k (θ - θ0) + N0 + c θ̇ + N with θ = φ_j - φ_i; n acts on body i, -n on body j.

    N0 is the preload, the torque at the angle θ0. The elastic part has the potential
    V = k (θ - θ0)² / 2 + N0 (θ - θ0); the damper and the actuator are forces. Where k, θ0 or N0
    varies in a run, the elastic part is booked with them.
    """

    kind = "torsion spring"
    example = """
        k = model.parameter("k", 30.0, unit="N m/rad")
        c = model.parameter("c", 0.4, unit="N m s/rad")
        model.torsion_spring("coil", i, j, stiffness=k, free_angle=pi / 6, damping=c)
    """
    unit = "rad"
    name: str
    i: Body
    j: Body
    stiffness: sympy.Expr
    free_angle: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr
    preload: sympy.Expr = sympy.S.Zero

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """θ and θ0."""
        return self.angle, self.free_angle

    def problems(self) -> list[str]:
        """A body against itself, and numbers that no spring has."""
        problems = measures.angle_problems(self, *self.bodies)
        problems += measures.same_body(label(self), self.bodies)
        return problems + self.characteristic_problems("torque")

    def conditions(self) -> tuple[Condition, ...]:
        """Numbers of a spring."""
        return measures.characteristic(
            "torque",
            ("stiffness", self.stiffness, "N m/rad"),
            ("damping", self.damping, "N m s/rad"),
        )

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A torsion spring, damper and actuator, those that there are."""
        return (shapes.SpiralSpring(self.i, self.j, *self.present),)
