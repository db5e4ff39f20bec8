"""Bushing: springs and dampers along two axes of a body and about a third."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Measure, Pulls, label
from codegen.declare.element_conditions import Condition, sign_conditions
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import SPEED
from codegen.drawing import shapes
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element

Triple = tuple[sympy.Expr, sympy.Expr, sympy.Expr]
AXES = (("x", "N/m", "N s/m"), ("y", "N/m", "N s/m"), ("phi", "N m/rad", "N m s/rad"))


@element
class Bushing(Effect):
    """Forces -k s - c ṡ along the displacements s = (A_iᵀ d, φ_j - φ_i - θ0), d = r_j^P - r_i^P.

    The springs have the potential V = Σ k s² / 2; the dampers are forces. The axes turn with body
    i, so a displaced bushing has a moment about it: all of this follows from s.
    """

    kind = "bushing"
    example = """
        kx, ky = (model.parameter(k, 90.0, unit="N/m") for k in ("k_x", "k_y"))
        cx, cy = (model.parameter(c, 3.0, unit="N s/m") for c in ("c_x", "c_y"))
        model.bushing("rubber", P, Q, stiffness=(kx, ky, 5.0), damping=(cx, cy, 0.2))
    """
    name: str
    i: Point
    j: Point
    stiffness: Triple = quantity(tuple(row[1] for row in AXES))
    damping: Triple = quantity(tuple(row[2] for row in AXES))
    free_angle: sympy.Expr = quantity("rad")

    @property
    def displacements(self) -> Triple:
        """Along x' and y' of body i, m, and about the normal, rad."""
        (x, y), (c, s) = self.i.body.position, self.i.body.rotation
        dx, dy = self.j.x - x, self.j.y - y  # from the centre: point i is fixed in its axes
        angle = measures.relative_angle(self.i.body, self.j.body) - self.free_angle
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

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """The displacements, their rates, and the force and torque on body j."""
        found: tuple[Measure, ...] = ()
        rows = zip(AXES, self.stiffness, self.damping, self.displacements, strict=True)
        for (axis, *_), k, c, s in rows:
            force, unit = -k * s - c * SPEED, "rad" if axis == "phi" else "m"
            found += (
                Measure("deflection", axis, unit, s),
                Measure("rate", axis, f"{unit}/s", SPEED, s),
                Measure("torque", "", "N m", force, s)
                if axis == "phi"
                else Measure("force", f"f{axis}", "N", force, s),
            )
        return found

    def problems(self) -> list[str]:
        """A body against itself, and one that does nothing."""
        problems = measures.angle_problems(self, *self.bodies)
        problems += measures.same_body(label(self), self.bodies)
        if not any((*self.stiffness, *self.damping)):
            problems.append(f"{label(self)}: stiffness and damping are all 0; give at least one.")
        return problems

    def conditions(self) -> tuple[Condition, ...]:
        """Springs and dampers that resist."""
        rows = zip(AXES, self.stiffness, self.damping, strict=True)
        return sign_conditions(
            *(
                (f"{word} along {axis}", value, unit)
                for (axis, *units), *values in rows
                for word, value, unit in zip(("stiffness", "damping"), values, units, strict=True)
            )
        )

    @property
    def _conservative(self) -> bool:
        return measures.is_constant(*self.stiffness, self.free_angle)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A pin of rubber: a spring from point to point."""
        return (shapes.Spring(self.i, self.j),)
