"""The joints of a declaration, one method a type."""

from types import MappingProxyType
from typing import Any

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint
from codegen.declare.symbols import KINDS, LETTERS, Letter
from codegen.elements.joints.absolute import Absolute
from codegen.elements.joints.distance import Distance
from codegen.elements.joints.gear import Gear
from codegen.elements.joints.rack_and_pinion import RackAndPinion
from codegen.elements.joints.relative import Relative
from codegen.elements.joints.revolute import Revolute
from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.joints.revolute_translational import RevoluteTranslational
from codegen.elements.joints.translational import Translational
from codegen.elements.joints.user_expression import ExpressionConstraint
from codegen.elements.joints.weld import Weld
from codegen.model.base import Declarations, Pair, Place


class Joints(Declarations):
    """The joints of a declaration."""

    def revolute(self, name: str, i: Point, j: Point) -> Constraint:
        """Points `i` and `j` of two bodies coincide."""
        return self._declare(Revolute(name, *self._pair(name, i, j)))

    def translational(
        self, name: str, i: Place, j: Place, axis: Pair = (1, 0), angle: Any = 0
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
        line = self._read.axis(axis, name)
        offset = self._value(angle, "rad", f"angle of '{name}'")
        return self._declare(Translational(name, *self._pair(name, i, j), line, offset))

    def revolute_revolute(
        self, name: str, i: Point, j: Point, length: Any, instead_of: Body | None = None
    ) -> Constraint:
        """A massless link of `length` between two points.

        With `instead_of`, the link acts in those scenes that leave this body out.
        """
        span = self._value(length, "m", f"length of '{name}'", "positive")
        stood_for = self._own_body(f"'{name}'", "instead_of", instead_of)
        return self._declare(RevoluteRevolute(name, *self._pair(name, i, j), span, stood_for))

    def revolute_translational(
        self, name: str, i: Place, j: Place, axis: Pair = (1, 0), distance: Any = 0,
        instead_of: Body | None = None,
    ) -> Constraint:  # fmt: skip
        """Point `j`, a pin, slides along a line of body `i`; both bodies may turn.

        Parameters
        ----------
        i
            A point on the line; a body means its centre of mass.
        j
            The pin.
        axis
            Direction of the line in the frame of body `i`.
        distance
            Distance of the pin from the line, m; positive to the left of `axis`.
        instead_of
            The slide block that the joint stands for: the joint acts in those scenes that leave
            this body out.
        """
        line = self._read.axis(axis, name)
        offset = self._value(distance, "m", f"distance of '{name}'")
        pair = self._pair(name, i, j)
        stood_for = self._own_body(f"'{name}'", "instead_of", instead_of)
        return self._declare(RevoluteTranslational(name, *pair, line, offset, stood_for))

    def weld(self, name: str, i: Place, j: Place, angle: Any = 0) -> Constraint:
        """Points `i` and `j` coincide and φ_j - φ_i keeps `angle`, rad: two bodies move as one."""
        offset = self._value(angle, "rad", f"angle of '{name}'")
        return self._declare(Weld(name, *self._pair(name, i, j), offset))

    def gear(
        self, name: str, i: Place, j: Place, radius_i: Any, radius_j: Any, line: Any = None
    ) -> Constraint:
        """Two gears mesh: pinned to one frame, or on a carrier that turns.

        Parameters
        ----------
        i, j
            The gears' centres; a body means its centre of mass. Bearings or a carrier keep them
            ``abs(radius_i + radius_j)`` apart.
        radius_i, radius_j
            Radii of the pitch circles, m; negative for an internal gear.
        line
            Angle of the line from centre `i` to centre `j`, rad, at which the teeth mesh with
            φ_i = φ_j = 0. Left out, it is as the bearings hold the centres, the carrier at φ = 0;
            without bearings to be seen it is 0.
        """
        ri, rj = (self._value(r, "m", f"radius of '{name}'") for r in (radius_i, radius_j))
        angle = self._optional(line, "rad", f"line of centres of '{name}'")
        joints = MappingProxyType(self.joints)
        return self._declare(Gear(name, *self._pair(name, i, j), ri, rj, angle, joints))

    def rack_and_pinion(
        self, name: str, pinion: Place, rack: Place, radius: Any, axis: Pair = (1, 0),
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A pinion rolls along a rack, at its pitch radius from the rack's pitch line.

        Parameters
        ----------
        pinion
            The pinion's centre; a body means its centre of mass.
        rack
            A point on the pitch line; a body means its centre of mass.
        radius
            The pinion's pitch radius, m.
        axis
            Direction of the pitch line in the rack's frame; the pinion lies to the left of it.
        offset
            How far along `axis` the centre lies from `rack`, m, where both bodies have the same φ.
        """
        size = self._value(radius, "m", f"radius of '{name}'")
        line = self._read.axis(axis, name)
        start = self._value(offset, "m", f"offset of '{name}'")
        pair = self._pair(name, pinion, rack)
        return self._declare(RackAndPinion(name, *pair, size, line, start))

    def absolute(self, name: str, on: Place, letter: Letter, value: Any) -> Constraint:
        """A point's global x or y, or a body's φ, keeps `value`."""
        letter = self._read.choice(letter, LETTERS, f"absolute '{name}'")
        number = self._value(value, KINDS[letter].unit, f"value of '{name}'")
        point = self._point(name, on)
        return self._declare(Absolute(name, self.ground, point, letter, number))

    def relative(self, name: str, i: Place, j: Place, letter: Letter, value: Any) -> Constraint:
        """Global x or y of point `j`, or φ of its body, minus that of `i` keeps `value`."""
        letter = self._read.choice(letter, LETTERS, f"relative '{name}'")
        number = self._value(value, KINDS[letter].unit, f"value of '{name}'")
        return self._declare(Relative(name, *self._pair(name, i, j), letter, number))

    def distance(self, name: str, i: Place, j: Place, value: Any) -> Constraint:
        """Points `i` and `j` keep the distance `value`, m; either may be on the ground."""
        span = self._value(value, "m", f"distance of '{name}'", "positive")
        return self._declare(Distance(name, *self._pair(name, i, j), span))

    def constraint(self, name: str, *phi: Any) -> Constraint:
        """Plain equations: each expression of coordinates, parameters and t is kept at zero."""
        equations = tuple(self._value(e, "", f"constraint '{name}'") for e in phi)
        return self._declare(ExpressionConstraint(name, equations, self._bodies_in(*equations)))
