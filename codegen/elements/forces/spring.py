"""Translational spring-damper-actuator between two points (Haug 6.1)."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.symbols import SPEED, Coordinate
from codegen.elements.forces.point_distance import Line
from codegen.elements.forces.scalar_force import constant, negative
from codegen.elements.registry import element


@element
@dataclass(frozen=True, eq=False)
class Spring:
    """f = k (ℓ - ℓ0) + c ℓ̇ + F along the line of two points, N, positive in tension.

    The elastic part has the potential V = k (ℓ - ℓ0)² / 2, so that equilibrium and the balance of
    energy see it; the damper and the actuator are forces, whose power is booked. Where k or ℓ0
    varies in a run, the elastic part has no potential and is booked with them.

    At ℓ = 0 the line has no direction. A run that starts there stops as not finite, and one that
    goes straight through it meets a force that turns about in an instant, which no event locates.
    Only a spring with ℓ0 = 0, and neither damper nor actuator, passes smoothly; for a passage along
    a known line, write a contact or a potential along it.

    Attributes
    ----------
    i, j
        The two points.
    stiffness, free_length, damping, actuator
        k in N/m, ℓ0 in m, c in N s/m, F in N.
    """

    kind: ClassVar[str] = "spring"
    name: str
    i: Point
    j: Point
    stiffness: sympy.Expr
    free_length: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies at both ends."""
        return (self.i.body, self.j.body)

    @property
    def line(self) -> Line:
        """From point i to point j."""
        return Line(self.i, self.j)

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V of the elastic part."""
        if self.stiffness == 0 or not self._conservative:
            return None
        return self.stiffness * (self.line.length - self.free_length) ** 2 / 2

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """None but those along the line."""
        return {}

    def pulls(self, bodies: tuple[Body, ...]) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        """The tension of the damper and the actuator, and of a spring that varies."""
        tension = self.damping * SPEED + self.actuator
        if not self._conservative:
            tension += self.stiffness * (self.line.length - self.free_length)
        return () if tension == 0 else ((self.line.length, tension),)

    def problems(self) -> list[str]:
        """Two points that keep their distance, and numbers that no spring has."""
        where, problems = f"spring '{self.name}'", []
        i, j = self.i, self.j
        if i.body is j.body:
            reason = "coincide" if self.line.length == 0 else "keep their distance"
            problems.append(
                f"{where}: both ends, ({i.sx}, {i.sy}) and ({j.sx}, {j.sy}), are on body "
                f"'{i.body.name}' and {reason}; connect two bodies."
            )
        if self.stiffness == 0 and self.damping == 0 and self.actuator == 0:
            problems.append(
                f"{where} does nothing; give it a stiffness, a damping, an actuator or a force."
            )
        for word, value, unit in (
            ("stiffness", self.stiffness, "N/m"),
            ("free length", self.free_length, "m"),
            ("damping", self.damping, "N s/m"),
        ):
            if negative(value):
                problems.append(
                    f"{where}: the {word} is {float(value):g} {unit}; give a number that is not "
                    "negative, and write other characteristics with force=."
                )
        return problems

    @property
    def _conservative(self) -> bool:
        return constant(self.stiffness, self.free_length)
