"""Translational spring-damper-actuator between two points (Haug 6.1)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element_conditions import Condition
from codegen.drawing import shapes
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element


@element
class Spring(measures.SpanMeasures, measures.SpringDamper):
    """f = k (ℓ - ℓ0) + F0 + c ℓ̇ + F along the line of two points, N, positive in tension.

    F0 is the preload, the force at the length ℓ0: the spring is free of force at ℓ0 - F0/k.
    The elastic part has the potential V = k (ℓ - ℓ0)² / 2 + F0 (ℓ - ℓ0), so that equilibrium and
    the balance of energy see it; the damper and the actuator are forces, whose power is booked.
    Where k, ℓ0 or F0 varies in a run, the elastic part has no potential and is booked with them.

    At ℓ = 0 the line has no direction. A run that starts there stops as not finite, and one that
    goes straight through it meets a force that turns about in an instant, which no event locates.
    Only a spring with ℓ0 = 0, and neither damper nor actuator, passes smoothly; for a passage along
    a known line, write a contact or a potential along it.
    """

    kind = "spring"
    example = """
        k = model.parameter("k", 200.0, unit="N/m")
        l0 = model.parameter("l_0", 0.8, unit="m")
        c = model.parameter("c", 3.0, unit="N s/m")
        model.spring("strut", P, Q, stiffness=k, free_length=l0, damping=c)
    """
    name: str
    i: Point
    j: Point
    stiffness: sympy.Expr
    free_length: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr
    preload: sympy.Expr = sympy.S.Zero

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """ℓ and ℓ0."""
        return self.length, self.free_length

    def problems(self) -> list[str]:
        """Two points that keep their distance, and numbers that no spring has."""
        problems = measures.line_problems(self, self.i, self.j)
        return problems + self.characteristic_problems("force")

    def conditions(self) -> tuple[Condition, ...]:
        """Numbers of a spring."""
        return measures.characteristic(
            "force",
            ("stiffness", self.stiffness, "N/m"),
            ("free length", self.free_length, "m"),
            ("damping", self.damping, "N s/m"),
        )

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A spring, damper and actuator, those that there are."""
        return (shapes.Spring(self.i, self.j, *self.present),)
