"""Effects that the user writes as plain expressions: a potential V, or generalized forces Q."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, label
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.elements.registry import element


@element
class Potential(Effect):
    """Potential energy V(q), in joule; its forces are -∂V/∂q."""

    kind = "potential"
    example = 'model.potential("pendulum", 20 * (1 - cos(i.phi)))'
    name: str
    energy: sympy.Expr = quantity("J")
    on: tuple[Body, ...]

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V itself."""
        return self.energy

    def problems(self) -> list[str]:
        """A potential depends on positions only."""
        return [
            f"{label(self)}: {self.energy} contains the velocity {s.name}; "
            "write a force that depends on velocity as a generalized force."
            for s in kinds(self.energy, Velocity)
        ]


@element
class GeneralizedForce(Effect):
    """Forces Q along coordinates, N for lengths and N m for angles."""

    kind = "generalized force"
    example = 'model.generalized_force("friction", {j.phi: -0.1 * (j.omega - i.omega)})'
    name: str
    components: tuple[tuple[Coordinate, sympy.Expr], ...]
    on: tuple[Body, ...]

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """Coordinate → force."""
        return dict(self.components)
