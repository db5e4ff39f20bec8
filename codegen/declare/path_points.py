"""Points whose paths are outputs of a scene: they exert nothing."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.symbols import Coordinate

TRACKED = "tracked point"


@dataclass(frozen=True, eq=False)
class TrackedPoint:
    """A point of a body, r + A s', as an effect without a force that reports where it is."""

    kind: ClassVar[str] = TRACKED
    name: str
    point: Point

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The body that carries the point."""
        return (self.point.body,)

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """None."""
        return None

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """None."""
        return {}

    def reported(self, bodies: tuple[Body, ...]) -> tuple[tuple[str, str, sympy.Expr], ...]:
        """Its global coordinates, m."""
        return (("x", "m", self.point.x), ("y", "m", self.point.y))

    def problems(self) -> list[str]:
        """A point of the ground does not move."""
        if self.point.body.fixed:
            return [f"{TRACKED} '{self.name}' is a point of the ground; give one of a body."]
        return []


def tracked(elements: Iterable[Any]) -> tuple[str, ...]:
    """Names of the tracked points among elements, or among their equations."""
    return tuple(element.name for element in elements if element.kind == TRACKED)
