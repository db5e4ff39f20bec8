"""Translational spring-damper-actuator between two points (Haug 6.1)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.elements.forces.scalar_measures import SpringDamper, characteristic, distance
from codegen.elements.registry import element


@element
class Spring(SpringDamper):
    """f = k (ℓ - ℓ0) + c ℓ̇ + F along the line of two points, N, positive in tension.

    The elastic part has the potential V = k (ℓ - ℓ0)² / 2, so that equilibrium and the balance of
    energy see it; the damper and the actuator are forces, whose power is booked. Where k or ℓ0
    varies in a run, the elastic part has no potential and is booked with them.

    At ℓ = 0 the line has no direction. A run that starts there stops as not finite, and one that
    goes straight through it meets a force that turns about in an instant, which no event locates.
    Only a spring with ℓ0 = 0, and neither damper nor actuator, passes smoothly; for a passage along
    a known line, write a contact or a potential along it.
    """

    kind = "spring"
    name: str
    i: Point
    j: Point
    stiffness: sympy.Expr
    free_length: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """ℓ and ℓ0."""
        return distance(self.i, self.j), self.free_length

    def problems(self) -> list[str]:
        """Two points that keep their distance, and numbers that no spring has."""
        i, j, problems = self.i, self.j, []
        if i.body is j.body:
            reason = "coincide" if self.scalar[0] == 0 else "keep their distance"
            problems.append(
                f"{label(self)}: both ends, ({i.sx}, {i.sy}) and ({j.sx}, {j.sy}), are on body "
                f"'{i.body.name}' and {reason}; connect two bodies."
            )
        return problems + self.characteristic_problems("force")

    def conditions(self) -> tuple[Condition, ...]:
        """Numbers of a spring."""
        return characteristic(
            "force",
            ("stiffness", self.stiffness, "N/m"),
            ("free length", self.free_length, "m"),
            ("damping", self.damping, "N s/m"),
        )
