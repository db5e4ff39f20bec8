"""Bushing: springs and dampers along two axes of a body and about a third."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.symbols import SPEED, Coordinate
from codegen.elements.forces.scalar_force import constant, negative, without_angle
from codegen.elements.forces.torsion_spring import turn
from codegen.elements.registry import element

Triple = tuple[sympy.Expr, sympy.Expr, sympy.Expr]
AXES = (("x", "N/m", "N s/m"), ("y", "N/m", "N s/m"), ("phi", "N m/rad", "N m s/rad"))


@element
@dataclass(frozen=True, eq=False)
class Bushing:
    """Forces -k s - c ṡ along the displacements s = (A_iᵀ d, φ_j - φ_i - θ0), d = r_j^P - r_i^P.

    The springs have the potential V = Σ k s² / 2; the dampers are forces. The axes turn with body
    i, so a displaced bushing has a moment about it: all of this follows from s.

    Attributes
    ----------
    i, j
        Points that coincide where the bushing is at rest.
    stiffness
        (k_x, k_y, k_φ) in N/m, N/m, N m/rad.
    damping
        (c_x, c_y, c_φ) in N s/m, N s/m, N m s/rad.
    free_angle
        θ0 in rad.
    """

    kind: ClassVar[str] = "bushing"
    name: str
    i: Point
    j: Point
    stiffness: Triple
    damping: Triple
    free_angle: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two bodies that the bushing connects."""
        return (self.i.body, self.j.body)

    @property
    def displacements(self) -> Triple:
        """Along x' and y' of body i, m, and about the normal, rad."""
        (x, y), (c, s) = self.i.body.position, self.i.body.rotation
        dx, dy = self.j.x - x, self.j.y - y  # from the centre: point i is fixed in its axes
        angle = turn(self.i.body, self.j.body) - self.free_angle
        return c * dx + s * dy - self.i.sx, c * dy - s * dx - self.i.sy, angle

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V of the springs."""
        if not self._conservative or not any(self.stiffness):
            return None
        pairs = zip(self.stiffness, self.displacements, strict=True)
        return sympy.Add(*(k * s**2 / 2 for k, s in pairs))

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """None but those along the displacements."""
        return {}

    def pulls(self, bodies: tuple[Body, ...]) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        """The dampers along the displacements, and springs that vary."""
        rows = zip(self.stiffness, self.damping, self.displacements, strict=True)
        pairs = ((s, c * SPEED + (0 if self._conservative else k * s)) for k, c, s in rows)
        return tuple((s, force) for s, force in pairs if force != 0)

    def problems(self) -> list[str]:
        """A body against itself, and numbers that no bushing has."""
        where = f"bushing '{self.name}'"
        problems = without_angle(where, self.i.body, self.j.body)
        if self.i.body is self.j.body:
            problems.append(f"{where} connects body '{self.i.body.name}' with itself; give two.")
        if not any((*self.stiffness, *self.damping)):
            problems.append(f"{where}: stiffness and damping are all 0; give at least one.")
        rows = zip(AXES, self.stiffness, self.damping, strict=True)
        for (axis, per_way, per_speed), k, c in rows:
            for word, value, unit in (("stiffness", k, per_way), ("damping", c, per_speed)):
                if negative(value):
                    problems.append(
                        f"{where}: the {word} along {axis} is {float(value):g} {unit}; give a "
                        "number that is not negative."
                    )
        return problems

    @property
    def _conservative(self) -> bool:
        return constant(*self.stiffness, self.free_angle)
