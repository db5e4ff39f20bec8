"""Effects that the user writes as plain expressions: a potential V, or generalized forces Q."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.elements.registry import element


@element
@dataclass(frozen=True, eq=False)
class Potential:
    """Potential energy V(q), in joule; its forces are -∂V/∂q."""

    kind: ClassVar[str] = "potential"
    name: str
    energy: sympy.Expr
    bodies: tuple[Body, ...]

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V itself."""
        return self.energy

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """None beside the potential's."""
        return {}

    def problems(self) -> list[str]:
        """A potential depends on positions only."""
        return [
            f"potential '{self.name}': {self.energy} contains the velocity {s.name}; "
            "write a force that depends on velocity as a generalized force."
            for s in kinds(self.energy, Velocity)
        ]


@element
@dataclass(frozen=True, eq=False)
class GeneralizedForce:
    """Forces Q along coordinates, N for lengths and N m for angles."""

    kind: ClassVar[str] = "generalized force"
    name: str
    components: tuple[tuple[Coordinate, sympy.Expr], ...]
    bodies: tuple[Body, ...]

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """A generalized force is not asked whether it has a potential."""
        return None

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """Coordinate → force."""
        return dict(self.components)

    def problems(self) -> list[str]:
        """Nothing beyond the symbols, which the model checks."""
        return []
