"""An element of a user's own: a string that unwinds from a drum."""

from dataclasses import dataclass
from typing import Any, ClassVar

import sympy

from codegen import (
    Body,
    Coordinate,
    I,
    J,
    JointReaction,
    Model,
    Point,
    Statement,
    coordinate,
    element,
    given,
)

R, FREE, AT = given("radius"), given("length"), coordinate("drum", "alpha")
OUT = sympy.Matrix([sympy.cos(AT), sympy.sin(AT)])
ALONG = sympy.Matrix([-sympy.sin(AT), sympy.cos(AT)])
APART = I.A.T * (J.point - I.point)


@element
@dataclass(frozen=True, eq=False)
class StringOnDrum:
    """eᵀ d - R = 0 and e⊥ᵀ d + ℓ0 + R α = 0: a string from a drum of body i holds point j.

    It leaves the drum in the direction e(α), and is longer by R α than it was at α = 0.
    """

    kind: ClassVar[str] = "string on a drum"
    name: str
    drum: Point
    end: Point
    radius: Any
    length: Any

    @property
    def bodies(self) -> tuple[Body, ...]:
        return (self.drum.body, self.end.body)

    @property
    def alpha(self) -> Coordinate:
        return coordinate(self.name, "alpha")

    def statement(self) -> Statement:
        phi = (OUT.dot(APART) - R, ALONG.dot(APART) + FREE + R * AT)
        bindings = I.bind(self.drum) | J.bind(self.end) | {AT: self.alpha}
        bindings |= {R: sympy.sympify(self.radius), FREE: sympy.sympify(self.length)}
        own = (("radial", self.alpha),)
        return Statement(phi, ("radial", "length"), JointReaction(I.A * ALONG), bindings, own)

    def problems(self) -> list[str]:
        return []


def winch() -> Model:
    """A free drum and a free load."""
    model = Model("winch")
    drum = model.body("drum", mass=2.0, inertia=0.5)
    load = model.body("load", mass=3.0, inertia=0.7)
    model.add(StringOnDrum("string", drum.at(0.1, 0), load.at(0, 0.2), 0.25, 1.0))
    return model
