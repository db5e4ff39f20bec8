"""Rotational spring-damper-actuator between two bodies (Haug 6.1)."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body
from codegen.declare.symbols import SPEED, Coordinate
from codegen.elements.forces.scalar_force import constant, negative, without_angle
from codegen.elements.registry import element


def turn(i: Body, j: Body) -> sympy.Expr:
    """θ = φ_j - φ_i, rad, counted through full turns; `without_angle` refuses other bodies."""
    phi_i, phi_j = (sympy.S.Zero if b.angle is None else b.angle for b in (i, j))
    return phi_j - phi_i


@element
@dataclass(frozen=True, eq=False)
class TorsionSpring:
    """n = k (θ - θ0) + c θ̇ + N with θ = φ_j - φ_i; n acts on body i, -n on body j.

    The elastic part has the potential V = k (θ - θ0)² / 2; the damper and the actuator are forces.
    Where k or θ0 varies in a run, the elastic part is booked with them.

    Attributes
    ----------
    i, j
        The two bodies.
    stiffness, free_angle, damping, actuator
        k in N m/rad, θ0 in rad, c in N m s/rad, N in N m.
    """

    kind: ClassVar[str] = "torsion spring"
    name: str
    i: Body
    j: Body
    stiffness: sympy.Expr
    free_angle: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies that the spring turns against each other."""
        return (self.i, self.j)

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V of the elastic part."""
        if self.stiffness == 0 or not self._conservative:
            return None
        return self.stiffness * (turn(self.i, self.j) - self.free_angle) ** 2 / 2

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """None but those that turn."""
        return {}

    def pulls(self, bodies: tuple[Body, ...]) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        """The torque of the damper and the actuator, and of a spring that varies."""
        angle = turn(self.i, self.j)
        torque = self.damping * SPEED + self.actuator
        if not self._conservative:
            torque += self.stiffness * (angle - self.free_angle)
        return () if torque == 0 else ((angle, torque),)

    def problems(self) -> list[str]:
        """A body against itself, and numbers that no spring has."""
        where = f"torsion spring '{self.name}'"
        problems = without_angle(where, self.i, self.j)
        if self.i is self.j:
            problems.append(f"{where} turns body '{self.i.name}' against itself; give two bodies.")
        if self.stiffness == 0 and self.damping == 0 and self.actuator == 0:
            problems.append(
                f"{where} does nothing; give it a stiffness, a damping, an actuator or a torque."
            )
        for word, value, unit in (
            ("stiffness", self.stiffness, "N m/rad"),
            ("damping", self.damping, "N m s/rad"),
        ):
            if negative(value):
                problems.append(
                    f"{where}: the {word} is {float(value):g} {unit}; give a number that is not "
                    "negative, and write other characteristics with torque=."
                )
        return problems

    @property
    def _conservative(self) -> bool:
        return constant(self.stiffness, self.free_angle)
