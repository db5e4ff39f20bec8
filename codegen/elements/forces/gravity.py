"""Uniform gravity on every body of the scene."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect
from codegen.declare.element_fields import quantity
from codegen.drawing import shapes
from codegen.elements.registry import element


@element
class Gravity(Effect):
    """V = -Σ m (g_x x + g_y y)."""

    kind = "gravity"
    example = 'model.gravity("weight", (0, -9.81))'
    name: str
    g: tuple[sympy.Expr, sympy.Expr] = quantity(("m/s^2", "m/s^2"))

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """Potential energy of the bodies, zero at the global origin."""
        axes = [(k, g) for k, g in enumerate(self.g) if g != 0]
        centres = ((b.mass, tuple(b.mass_centre)) for b in bodies if b.mass is not None)
        return sympy.Add(*(-m * sympy.Add(*(g * r[k] for k, g in axes)) for m, r in centres))

    def weights(self, bodies: tuple[Body, ...]) -> tuple[tuple[str, sympy.Expr, sympy.Expr], ...]:
        """(body, mass, acceleration) of the products m g in the potential."""
        return tuple((b.name, b.mass, g) for b in bodies if b.mass is not None for g in self.g)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Its direction."""
        return (shapes.Gravity(*self.g),)
