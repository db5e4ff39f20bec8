"""The joints of a machine in space, and the points and axes at the drawing that declare them."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import sympy

from codegen.declare.drawn_pose import SMALL, Array, perpendicular, rotation_of, symbolic
from codegen.declare.element import Constraint
from codegen.declare.space_body import Axis, SpaceBody, SpaceGround, SpacePoint
from codegen.elements.space import composite_joints as couplers
from codegen.elements.space import joints
from codegen.model.base import shown_element
from codegen.model.space_effects import Place, SpaceEffects
from codegen.readers.values import KindError, members, shown

Ends = tuple[SpacePoint, SpacePoint]
_OFF = 1.15  # accuracy: degrees by which digits left out of two axes may change their angle


class SpaceJoints(SpaceEffects):
    """Joints of a declaration in space."""

    def spherical(self, name: str, i: Place, j: Place, *, at: Any = None) -> Constraint:
        """A ball joint: points of two bodies coincide.

        Parameters
        ----------
        i, j
            Points of the bodies; or, with `at`, the bodies.
        at
            The place of the joint at the drawing, in global axes, m.
        """
        return self._declare(joints.Spherical(name, *self._ends(name, i, j, at)))

    def revolute(  # type: ignore[override]
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """A hinge: points of two bodies coincide, and the bodies share an axis.

        Parameters
        ----------
        i, j, at
            As of `spherical`.
        axis
            Its direction at the drawing, in global axes; or an axis of each body, as
            ``(i.along(1, 0, 0), j.along(1, 0, 0))``.
        """
        return self._with_axis(joints.RevoluteInSpace, name, self._ends(name, i, j, at), axis)

    def cylindrical(
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Body `j` turns about an axis of body `i` and slides along it; words as of `revolute`."""
        return self._with_axis(joints.Cylindrical, name, self._ends(name, i, j, at), axis)

    def translational(  # type: ignore[override]
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Body `j` slides along an axis of body `i` without turning; words as of `revolute`.

        The bodies keep the attitude to each other that they have at the drawing.
        """
        return self._with_axis(joints.TranslationalInSpace, name, self._ends(name, i, j, at), axis)

    def weld(self, name: str, i: Place, j: Place, *, at: Any = None) -> Constraint:  # type: ignore[override]
        """Two bodies are fixed to each other as they are at the drawing; words as of `spherical`.

        With points, these coincide.
        """
        return self._with_axis(joints.WeldInSpace, name, self._ends(name, i, j, at), (0, 0, 1))

    def universal(
        self, name: str, i: Place, j: Place, *, at: Any = None, axes: Sequence[Any],
        angle: Any = sympy.pi / 2,
    ) -> Constraint:  # fmt: skip
        """A Cardan joint: points coincide, and an axis of each body keeps its angle to the other.

        Parameters
        ----------
        i, j, at
            As of `spherical`.
        axes
            The axis of body `i` and that of body `j` at the drawing, in global axes; or
            ``(i.along(...), j.along(...))``.
        angle
            Of the axes to each other, rad, at which those in global numbers must be drawn; if it is
            no right angle, the joint is the revolute-revolute one of intersecting axes.
        """
        ends, where = self._ends(name, i, j, at), f"universal '{name}': axes"
        try:
            pair = members(axes, 2)
        except KindError:
            self._note(f"{where}={shown(axes)}; give two axes.")
            pair = [(1, 0, 0), (0, 1, 0)]
        h = [self._in_body(end.body, one, where) for end, one in zip(ends, pair, strict=True)]
        cosine = self._cosine(f"universal '{name}'", angle, ends, pair, h)
        return self._declare(joints.Universal(name, *ends, symbolic(h[0]), symbolic(h[1]), cosine))

    def distance(self, name: str, i: Place, j: Place, value: Any = None) -> Constraint:  # type: ignore[override]
        """Two points keep the distance `value`, m; by default that of the drawing."""
        ends = self._ends(name, i, j, None)
        length = self._length(f"distance '{name}': value", ends, value)
        return self._declare(joints.DistanceInSpace(name, *ends, length))

    def planar(self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any) -> Constraint:
        """A plane of body `j` slides and turns on a plane of body `i`; words as of `revolute`.

        `axis` is the normal of the planes.
        """
        return self._with_axis(joints.Planar, name, self._ends(name, i, j, at), axis)

    def parallel_axes(self, name: str, i: SpaceBody, j: SpaceBody, *, axis: Any) -> Constraint:
        """Axes of two bodies stay parallel; `axis` as of `revolute`."""
        return self._with_axis(joints.ParallelAxes, name, self._ends(name, i, j, None), axis)

    def point_in_plane(
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Point `j` stays in the plane of body `i` through point `i`.

        Parameters
        ----------
        i, j, at
            As of `spherical`.
        axis
            The normal at the drawing, in global axes; or that of the body, ``i.along(1, 0, 0)``.
        """
        return self._with_axis_of_i(joints.PointInPlane, name, self._ends(name, i, j, at), axis)

    def point_on_line(
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Point `j` stays on the line of body `i` through point `i` along `axis`.

        Words as of `point_in_plane`.
        """
        return self._with_axis_of_i(joints.PointOnLine, name, self._ends(name, i, j, at), axis)

    def strut(self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any) -> Constraint:
        """A rod without mass slides along a line of body `i`; a ball at point `j` ends it.

        Words as of `point_in_plane`: the line passes through point `i` along `axis`.
        """
        return self._with_axis_of_i(joints.Strut, name, self._ends(name, i, j, at), axis)

    def revolute_spherical(
        self, name: str, i: Place, j: Place, length: Any = None, *, axis: Any
    ) -> Constraint:
        """A link without mass turns about an axis of body `i`; a ball at point `j` ends it.

        Point `i` is that of the axis which is nearest to the ball, `length` their distance, m, by
        default that of the drawing; `axis` is as of `point_in_plane`.
        """
        ends = self._ends(name, i, j, None)
        length = self._length(f"revolute_spherical '{name}': length", ends, length)
        return self._with_axis_of_i(couplers.RevoluteSpherical, name, ends, axis, length)

    def revolute_revolute(  # type: ignore[override]
        self, name: str, i: Place, j: Place, length: Any = None, *, axis: Any
    ) -> Constraint:
        """A link without mass with parallel hinges at points `i` and `j`, perpendicular to them.

        `length`, m, is by default that of the drawing; `axis` is as of `revolute`. With hinges
        whose axes intersect it is `universal` with their angle.
        """
        ends = self._ends(name, i, j, None)
        length = self._length(f"revolute_revolute '{name}': length", ends, length)
        return self._with_axis(couplers.RevoluteRevoluteInSpace, name, ends, axis, length)

    def revolute_cylindrical(
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any, hinge: Any,
        angle: Any = sympy.pi / 2,
    ) -> Constraint:  # fmt: skip
        """A sleeve slides along an axis of body `i` and turns about it; body `j` hinges on it.

        Parameters
        ----------
        i, j, at
            As of `spherical`; point `j` is where the hinge meets the axis.
        axis, hinge
            The axis of body `i` and the hinge of body `j` at the drawing, in global axes; or
            ``i.along(...)`` and ``j.along(...)``.
        angle
            Of the two to each other, rad, by default a right angle; not 0. Axes in global numbers
            must be drawn at it.
        """
        ends, where = self._ends(name, i, j, at), f"revolute_cylindrical '{name}'"
        h = self._in_body(ends[0].body, axis, f"{where}: axis")
        pin = self._in_body(ends[1].body, hinge, f"{where}: hinge")
        cosine = self._cosine(where, angle, ends, (axis, hinge), (h, pin))
        cls, along = couplers.RevoluteCylindrical, ends[0].body.along(*h)
        return self._with_axis_of_i(cls, name, ends, along, symbolic(pin), cosine)

    def revolute_translational(  # type: ignore[override]
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any, hinge: Any
    ) -> Constraint:
        """A block slides along a line of body `i` without turning; body `j` hinges on it.

        The line passes through point `i` along `axis`, as of `point_in_plane`. The hinge passes
        through point `j`; the bodies share its direction `hinge`, given as the axis of `revolute`.
        """
        ends = self._ends(name, i, j, at)
        u = self._in_body(ends[0].body, axis, f"revolute_translational '{name}': axis")
        m = perpendicular(u)
        line = tuple(symbolic(one) for one in (u, m, np.cross(u, m)))
        cls = couplers.RevoluteTranslationalInSpace
        return self._with_axis(cls, name, ends, hinge, line, word="hinge")

    def screw(  # type: ignore[override]
        self, name: str, i: Place, j: Place, lead: Any, *, at: Any = None, axis: Any,
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """Body `j` turns about an axis of body `i` and moves along it by `lead` in each turn.

        `lead`, m, is negative for a left-hand thread; `offset`, m, is the slide of the joint where
        its angle is 0, as at the drawing. Other words as of `revolute`.
        """
        ends, where = self._ends(name, i, j, at), f"screw '{name}'"
        named = (("lead", lead), ("offset", offset))
        numbers = (self._value(value, "m", f"{where}: {word}") for word, value in named)
        return self._with_axis(joints.ScrewInSpace, name, ends, axis, *numbers)

    # -- reading -----------------------------------------------------------------------------

    @property
    def _ground(self) -> SpaceGround:
        assert isinstance(self.ground, SpaceGround)
        return self.ground

    def _point(self, name: str, place: Any) -> SpacePoint:
        point = place.at(0, 0, 0) if isinstance(place, SpaceBody) else place
        if not isinstance(point, SpacePoint) or not isinstance(point.body, SpaceBody):
            self._note(
                f"'{name}': {shown_element(place)} is neither a point nor a body of a machine in "
                "space; write body.at(x, y, z)."
            )
            point = SpacePoint(self._ground, 0, 0, 0)
        where = f"point of '{name}' on body '{point.body.name}'"
        place = [self._read.value(s, "m", where) for s in (point.sx, point.sy, point.sz)]
        self._note_speeds(where, *place)
        return SpacePoint(point.body, *place)

    def _body(self, where: str, body: Any) -> SpaceBody:
        found = super()._body(where, body)
        assert isinstance(found, SpaceBody)
        return found

    def _vector(self, value: Any, unit: str, where: str, count: int = 3) -> tuple[float, ...]:
        """Finite numbers; the first axis stands in for others."""
        try:
            return tuple(self._read.finite(x, unit, where) for x in members(value, count))
        except KindError:
            like = (1.0, *(0.0,) * (count - 1))
            self._note(f"{where} is {shown(value)}; give {count} numbers, as {like}.")
            return like

    def _drawn(self, point: SpacePoint) -> Array:
        """The global place of a point at the drawing, m, for the parameters' defaults."""
        place = [float(sympy.sympify(s).subs(self.defaults)) for s in point.place]
        body = point.body
        return np.asarray(body.place + rotation_of(body.attitude) @ place)

    def _ends(self, name: str, i: Any, j: Any, at: Any) -> Ends:
        """The points of a joint, given as such or by its place at the drawing."""
        if at is None:
            return self._point(name, i), self._point(name, j)
        place = np.array(self._vector(at, "m", f"'{name}': at"))
        ends = []
        for body in (self._body(f"'{name}', with at=", one) for one in (i, j)):
            arm = rotation_of(body.attitude).T @ (place - np.array(body.place))
            ends.append(SpacePoint(body, *symbolic(arm)))
        return ends[0], ends[1]

    def _in_body(self, body: SpaceBody, axis: Any, where: str) -> Array:
        """A unit vector of a body, from global numbers at the drawing or an axis of the body."""
        own = isinstance(axis, Axis)
        if own and axis.body is not body:
            self._note(f"{where}: {shown(axis)} is no axis of body '{body.name}'.")
        given = axis.direction if own else axis
        vector = np.array(self._vector(given, "1", where))
        size = float(np.linalg.norm(vector))
        if not size > SMALL:
            self._note(f"{where} {shown(given)} has no direction; give one.")
            return np.array([1.0, 0.0, 0.0])
        turned = vector if own else rotation_of(body.attitude).T @ vector
        return np.asarray(turned / size)

    def _pair(self, axis: Any, where: str) -> list[Any]:
        """The direction of an axis for each of two bodies, the same one or two."""
        given: list[Any] = []
        with suppress(KindError):
            given = members(axis)
        if len(given) == 2:
            return given
        if len(given) != 3 or any(isinstance(one, Axis) for one in given):
            self._note(
                f"{where} is {shown(axis)}; give three numbers in global axes, or an axis of each "
                "body, as (i.along(1, 0, 0), j.along(1, 0, 0))."
            )
            axis = (1, 0, 0)
        return [axis, axis]

    def _length(self, where: str, ends: Ends, value: Any) -> Any:
        """The distance of two points, by default at the drawing."""
        if value is None:
            value = float(np.linalg.norm(self._drawn(ends[1]) - self._drawn(ends[0])))
        return self._value(value, "m", where, "positive")

    def _cosine(
        self, where: str, angle: Any, ends: Ends, pair: Sequence[Any], own: Sequence[Array]
    ) -> sympy.Expr:
        """Of the angle of two axes that are not parallel; global ones are drawn at it.

        `pair` are the axes as given, `own` those in the bodies.
        """
        cosine: sympy.Expr = sympy.cos(self._value(angle, "rad", f"{where}: angle"))
        if cosine.is_number and 1.0 - abs(float(cosine)) < SMALL:
            self._note(f"{where}: its axes are parallel; use a revolute or cylindrical joint.")
        if cosine.is_number and not any(isinstance(one, Axis) for one in pair):
            a, b = (rotation_of(e.body.attitude) @ h for e, h in zip(ends, own, strict=True))
            drawn, kept = np.degrees(np.arccos(np.clip([a @ b, float(cosine)], -1.0, 1.0)))
            if abs(drawn - kept) > _OFF:
                bodies = " and ".join(f"'{end.body.name}'" for end in ends)
                self._note(
                    f"{where}: at the drawing the axes of {bodies} are {drawn:.4g}° apart, and the "
                    f"joint keeps them at {kept:.4g}°. Give such axes, or another angle=."
                )
        return cosine

    def _with_axis_of_i(
        self, cls: type[Any], name: str, ends: Ends, axis: Any, *numbers: Any
    ) -> Constraint:
        """A joint with an axis of body i alone."""
        body = ends[0].body
        h = rotation_of(body.attitude) @ self._in_body(body, axis, f"{cls.kind} '{name}': axis")
        return self._with_axis(cls, name, ends, tuple(h.tolist()), *numbers)

    def _with_axis(
        self, cls: type[Any], name: str, ends: Ends, axis: Any, *numbers: Any, word: str = "axis"
    ) -> Constraint:
        """A joint with an axis; f and g are the most nearly body axes that there are."""
        where = f"{cls.kind} '{name}': {word}"
        pair = self._pair(axis, where)
        h, h_j = (self._in_body(end.body, one, where) for end, one in zip(ends, pair, strict=True))
        f = perpendicular(h)
        of_i, of_j = (rotation_of(end.body.attitude) for end in ends)
        cosine = float((of_i @ h) @ (of_j @ h_j))
        if pair[0] is not pair[1] and cosine <= SMALL:
            bodies = " and ".join(f"'{end.body.name}'" for end in ends)
            angle = np.degrees(np.arccos(max(-1.0, cosine)))
            self._note(
                f"{where}: at the drawing those of {bodies} are {angle:.4g}° apart, and the joint "
                "may close with opposite ones. Reverse one of the two, or give the attitude of a "
                "body at the drawing, axes=."
            )
        f_j = of_j.T @ of_i @ f
        f_j -= h_j * (h_j @ f_j)  # perpendicular to its axis, whatever the drawing is
        size = float(np.linalg.norm(f_j))
        f_j = f_j / size if size > SMALL else perpendicular(h_j)
        axes = tuple(symbolic(one) for one in (f, np.cross(h, f), h, f_j, h_j))
        joint: Constraint = self._declare(cls(name, *ends, axes, *numbers))
        return joint
