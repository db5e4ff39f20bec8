"""Bushing: springs and dampers along two axes of a body and about a third."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Pulls, label
from codegen.declare.symbols import SPEED
from codegen.elements.forces.scalar_measures import (
    angle_problems,
    is_constant,
    negative_problems,
    relative_angle,
)
from codegen.elements.registry import element

Triple = tuple[sympy.Expr, sympy.Expr, sympy.Expr]
AXES = (("x", "N/m", "N s/m"), ("y", "N/m", "N s/m"), ("phi", "N m/rad", "N m s/rad"))


@element
class Bushing(Effect):
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

    kind = "bushing"
    name: str
    i: Point
    j: Point
    stiffness: Triple
    damping: Triple
    free_angle: sympy.Expr

    @property
    def displacements(self) -> Triple:
        """Along x' and y' of body i, m, and about the normal, rad."""
        (x, y), (c, s) = self.i.body.position, self.i.body.rotation
        dx, dy = self.j.x - x, self.j.y - y  # from the centre: point i is fixed in its axes
        angle = relative_angle(self.i.body, self.j.body) - self.free_angle
        return c * dx + s * dy - self.i.sx, c * dy - s * dx - self.i.sy, angle

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V of the springs."""
        if not self._conservative or not any(self.stiffness):
            return None
        pairs = zip(self.stiffness, self.displacements, strict=True)
        return sympy.Add(*(k * s**2 / 2 for k, s in pairs))

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """The dampers along the displacements, and springs that vary."""
        rows = zip(self.stiffness, self.damping, self.displacements, strict=True)
        pairs = ((s, c * SPEED + (0 if self._conservative else k * s)) for k, c, s in rows)
        return tuple((s, force) for s, force in pairs if force != 0)

    def problems(self) -> list[str]:
        """A body against itself, and numbers that no bushing has."""
        body = self.i.body
        problems = angle_problems(self, body, self.j.body)
        if body is self.j.body:
            problems.append(f"{label(self)} connects body '{body.name}' with itself; give two.")
        if not any((*self.stiffness, *self.damping)):
            problems.append(f"{label(self)}: stiffness and damping are all 0; give at least one.")
        for (axis, *units), *values in zip(AXES, self.stiffness, self.damping, strict=True):
            words = (f"{word} along {axis}" for word in ("stiffness", "damping"))
            problems += negative_problems(self, *zip(words, values, units, strict=True))
        return problems

    @property
    def _conservative(self) -> bool:
        return is_constant(*self.stiffness, self.free_angle)
