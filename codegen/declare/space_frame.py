"""Bodies in space in the equations of an element, before any model is known."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from codegen.declare.rotation_entries import rotation_matrix
from codegen.declare.space_body import SpaceBody, SpacePoint
from codegen.declare.symbols import Coordinate, coordinate, given
from codegen.errors import ModelError
from codegen.readers.calls import declaring_class
from codegen.readers.values import shown


@declaring_class("SpaceFrame")
@dataclass(frozen=True)
class SpaceFrame:
    """A body in space in the equations of an element: placeholders for its coordinates."""

    name: str

    @cached_property
    def r(self) -> sympy.ImmutableMatrix:
        """Position of the centre of mass, 3 × 1."""
        return sympy.ImmutableMatrix([coordinate(self.name, c) for c in "xyz"])

    @cached_property
    def p(self) -> tuple[Coordinate, ...]:
        """Euler parameters."""
        return tuple(coordinate(self.name, f"e{k}") for k in range(4))

    @cached_property
    def A(self) -> sympy.ImmutableMatrix:
        """Rotation matrix from the body's frame to the global one, 3 × 3."""
        return rotation_matrix(self.p)

    @cached_property
    def s(self) -> sympy.ImmutableMatrix:
        """Placeholder for a point s' of the body, 3 × 1."""
        return self.given("s")

    @cached_property
    def arm(self: Any) -> sympy.ImmutableMatrix:
        """From the frame's origin to the point, in global axes: A s'."""
        return self.A * self.s

    @cached_property
    def point(self: Any) -> sympy.ImmutableMatrix:
        """Global position of the point: r + A s'."""
        return self.r + self.arm

    def vector(self, letter: str) -> sympy.ImmutableMatrix:
        """A vector of the body in global axes, A a', with the placeholder a' of that letter."""
        return self.A * self.given(letter)

    def given(self, letter: str) -> sympy.ImmutableMatrix:
        """The placeholder of a vector of that letter in the body's axes, 3 × 1."""
        return sympy.ImmutableMatrix([given(f"{self.name}_{letter}{c}") for c in "xyz"])

    def bind(
        self, point: SpacePoint, **vectors: tuple[sympy.Expr, ...]
    ) -> dict[sympy.Symbol, sympy.Expr]:
        """Placeholders → their values for a point of a body, and its vectors by letter."""
        body = point.body
        if not isinstance(body, SpaceBody):
            raise ModelError(f"SpaceFrame.bind: {shown(body)} is no body of a machine in space.")
        bindings = dict(zip((*self.r, *self.p), (*body.position, *body.p), strict=True))
        for letter, components in {"s": point.place, **vectors}.items():
            bindings |= dict(zip(self.given(letter), components, strict=True))
        return bindings


I, J = SpaceFrame("i"), SpaceFrame("j")  # noqa: E741 (the two bodies of a joint)
