"""The joints of a declaration, one method a type."""

from typing import Any, Literal

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint
from codegen.declare.scene_values import UNITS
from codegen.elements.joints.absolute import Absolute
from codegen.elements.joints.expression import ExpressionConstraint
from codegen.elements.joints.revolute import Revolute
from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.joints.translational import Translational
from codegen.model.base import Declarations


class Joints(Declarations):
    """What holds bodies together."""

    def revolute(self, name: str, i: Point, j: Point) -> Constraint:
        """Points `i` and `j` of two bodies coincide."""
        return self._joint(Revolute(name, *self._pair(name, i, j)))

    def translational(
        self,
        name: str,
        i: Point | Body,
        j: Point | Body,
        axis: tuple[Any, Any] = (1, 0),
        angle: Any = 0,
    ) -> Constraint:
        """Body `j` slides along `axis` of body `i`.

        Parameters
        ----------
        i, j
            Points on the line; a body means its centre of mass.
        axis
            Direction in the frame of body `i`.
        angle
            φ_j - φ_i, rad.
        """
        ax, ay = (self._read.value(a, "m", f"axis of '{name}'") for a in axis)
        offset = self._read.value(angle, "rad", f"angle of '{name}'")
        return self._joint(Translational(name, *self._pair(name, i, j), (ax, ay), offset))

    def revolute_revolute(
        self, name: str, i: Point, j: Point, length: Any, instead_of: Body | None = None
    ) -> Constraint:
        """A massless link of `length` between two points.

        With `instead_of`, the link acts in those scenes that leave this body out.
        """
        span = self._read.value(length, "m", f"length of '{name}'")
        return self._joint(RevoluteRevolute(name, *self._pair(name, i, j), span, instead_of))

    def absolute(
        self, name: str, on: Point | Body, letter: Literal["x", "y", "phi"], value: Any
    ) -> Constraint:
        """A point's global x or y, or a body's φ, keeps `value`."""
        letter = self._read.choice(letter, ("x", "y", "phi"), f"absolute '{name}'")
        number = self._read.value(value, UNITS[letter], f"value of '{name}'")
        point = self._point(name, on)
        return self._joint(Absolute(name, self.ground, point, letter, number))

    def constraint(self, name: str, *phi: Any) -> Constraint:
        """Plain equations: each expression of coordinates, parameters and t is held at zero."""
        equations = tuple(self._read.value(e, "", f"constraint '{name}'") for e in phi)
        return self._joint(ExpressionConstraint(name, equations, self._bodies_in(*equations)))
