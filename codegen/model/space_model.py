"""The declaration of a machine in space: ``Model(name, space=True)``.

Its methods have the names of those in the plane, and take three numbers where those take two. The
pose of a body at the drawing is where assembly begins. A joint is declared in global axes at the
drawing, ``at=(x, y, z), axis=(ux, uy, uz)``, or by points and axes of the bodies.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np
import sympy

from codegen.declare.drawn_pose import (
    SMALL,
    Array,
    attitude_of_axes,
    attitude_of_vector,
    perpendicular,
    rotation_of,
    symbolic,
)
from codegen.declare.element import Constraint
from codegen.declare.space_body import UPRIGHT, Axis, SpaceBody, SpaceGround, SpacePoint
from codegen.elements.scalar_measures import is_constant
from codegen.elements.space.joints import (
    Cylindrical,
    DistanceInSpace,
    RevoluteInSpace,
    Spherical,
    TranslationalInSpace,
    Universal,
    WeldInSpace,
)
from codegen.errors import ModelError
from codegen.model.space_effects import Place, SpaceEffects
from codegen.readers.values import KindError, members, shown

SPINS = ("omega_x", "omega_y", "omega_z")


class SpaceModel(SpaceEffects):
    """A machine in space."""

    in_space = True
    _ground_class = SpaceGround

    def body(  # type: ignore[override]
        self, name: str, mass: Any = None, inertia: Any = None, *, at: Any = (0, 0, 0),
        axes: Any = None,
    ) -> SpaceBody:  # fmt: skip
        """A rigid body with its centre of mass at its origin.

        Parameters
        ----------
        mass
            In kg; may be left out if only kinematic scenes use the body.
        inertia
            About the centre of mass in body axes, kg m²: three principal moments; six numbers J_xx,
            J_yy, J_zz, J_xy, J_xz, J_yz, entries of the matrix; or the matrix, 3 × 3.
        at
            The centre of mass at the drawing, m, where assembly begins.
        axes
            The body's axes at the drawing: two of them, x' and y', in global numbers, of which y'
            is made perpendicular to x'; or a rotation vector, whose length is the angle in rad; or
            Euler parameters, four numbers. By default the global axes.
        """
        where = f"body '{name}'"
        m = self._positive(mass, "kg", f"mass of {where}")
        if not (m is None or is_constant(m)):
            self._note(
                f"mass of {where} is {m}; masses that vary are there for machines in the plane "
                "alone so far. Give a number or an expression of parameters."
            )
        j = None if inertia is None else self._inertia(inertia, f"inertia of {where}")
        place = self._vector(at, "m", f"{where}: at")
        attitude = self._attitude(axes, f"{where}: axes")
        return self._declare(SpaceBody(name, m, j, self.token, place=place, attitude=attitude))

    # -- joints ------------------------------------------------------------------------------

    def spherical(self, name: str, i: Place, j: Place, *, at: Any = None) -> Constraint:
        """A ball joint: points of two bodies coincide.

        Parameters
        ----------
        i, j
            Points of the bodies; or, with `at`, the bodies.
        at
            The place of the joint at the drawing, in global axes, m.
        """
        return self._declare(Spherical(name, *self._ends(name, i, j, at)))

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
        return self._with_axis(RevoluteInSpace, name, i, j, at, axis)

    def cylindrical(
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Body `j` turns about an axis of body `i` and slides along it; words as of `revolute`."""
        return self._with_axis(Cylindrical, name, i, j, at, axis)

    def translational(  # type: ignore[override]
        self, name: str, i: Place, j: Place, *, at: Any = None, axis: Any
    ) -> Constraint:
        """Body `j` slides along an axis of body `i` without turning; words as of `revolute`.

        The bodies keep the attitude to each other that they have at the drawing.
        """
        return self._with_axis(TranslationalInSpace, name, i, j, at, axis)

    def weld(self, name: str, i: Place, j: Place, *, at: Any = None) -> Constraint:  # type: ignore[override]
        """Two bodies are fixed to each other as they are at the drawing; words as of `spherical`.

        With points, these coincide.
        """
        return self._with_axis(WeldInSpace, name, i, j, at, (0, 0, 1))

    def universal(
        self, name: str, i: Place, j: Place, *, at: Any = None, axes: Sequence[Any]
    ) -> Constraint:
        """A Cardan joint: points coincide, and an axis of each body stays perpendicular.

        Parameters
        ----------
        i, j, at
            As of `spherical`.
        axes
            The axis of body `i` and that of body `j` at the drawing, in global axes; or
            ``(i.along(...), j.along(...))``.
        """
        ends, where = self._ends(name, i, j, at), f"universal '{name}': axes"
        try:
            pair = members(axes, 2)
        except KindError:
            self._note(f"{where}={shown(axes)}; give two axes.")
            pair = [(1, 0, 0), (0, 1, 0)]
        inner = (self._in_body(e.body, one, where) for e, one in zip(ends, pair, strict=True))
        return self._declare(Universal(name, *ends, *map(symbolic, inner)))

    def distance(self, name: str, i: Place, j: Place, value: Any = None) -> Constraint:  # type: ignore[override]
        """Two points keep the distance `value`, m; by default that of the drawing."""
        ends = self._point(name, i), self._point(name, j)
        if value is None:
            value = float(np.linalg.norm(self._drawn(ends[1]) - self._drawn(ends[0])))
        length = self._value(value, "m", f"distance '{name}': value", "positive")
        return self._declare(DistanceInSpace(name, *ends, length))

    @property
    def _ground(self) -> SpaceGround:
        assert isinstance(self.ground, SpaceGround)
        return self.ground

    # -- reading -----------------------------------------------------------------------------

    def unit_of(self, name: str) -> str | None:
        """As in the plane; rad/s of ``"rod.omega_x"``, a component of ω'."""
        owner, _, letter = name.rpartition(".")
        return "rad/s" if owner in self.bodies and letter in SPINS else super().unit_of(name)

    def _quantities(self) -> list[str]:
        return [*super()._quantities(), *(f"{b}.{spin}" for b in self.bodies for spin in SPINS)]

    def _point(self, name: str, place: Any) -> SpacePoint:
        point = place.at(0, 0, 0) if isinstance(place, SpaceBody) else place
        if not isinstance(point, SpacePoint) or not isinstance(point.body, SpaceBody):
            self._note(
                f"'{name}': {shown(place)} is neither a point nor a body of a machine in space; "
                "write body.at(x, y, z)."
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

    def _inertia(self, value: Any, where: str) -> sympy.ImmutableMatrix:
        """J' from three, six or nine numbers; the unit matrix stands in for others."""
        try:
            given = members(value)
            if len(given) == 3 and not isinstance(given[0], int | float | sympy.Basic | str):
                rows = [members(row, 3) for row in given]
                given = [x for row in rows for x in row]
                read = [self._value(x, "kg m^2", where) for x in given]
                matrix = sympy.ImmutableMatrix(3, 3, read)
                if matrix != matrix.T:
                    self._note(f"{where} is {shown(value)}; give a symmetric matrix.")
                return matrix
            read = [self._value(x, "kg m^2", where) for x in given]
            xx, yy, zz, xy, xz, yz = {3: (*read, 0, 0, 0), 6: (*read,)}[len(read)]
        except (KindError, KeyError):
            self._note(
                f"{where} is {shown(value)}; give three principal moments, six numbers J_xx, J_yy, "
                "J_zz, J_xy, J_xz, J_yz, or a matrix, 3 x 3."
            )
            return sympy.ImmutableMatrix.eye(3)
        return sympy.ImmutableMatrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def _attitude(self, axes: Any, where: str) -> tuple[float, ...]:
        """Euler parameters at the drawing, from what `body` takes."""
        if axes is None:
            return UPRIGHT
        found = None
        with suppress(KindError):
            given = members(axes)
            if len(given) == 2:
                found = attitude_of_axes(*(np.array(self._vector(x, "1", where)) for x in given))
            elif len(given) == 3:
                found = attitude_of_vector(np.array(self._vector(given, "rad", where)))
            elif len(given) == 4:
                p = np.array(self._vector(given, "1", where, 4))
                size = float(np.linalg.norm(p))
                found = tuple((p / size).tolist()) if size > SMALL else None
        if found is None:
            self._note(
                f"{where} is {shown(axes)}; give two axes that are not parallel, a rotation vector "
                "in rad, or four Euler parameters."
            )
        return found or UPRIGHT

    def _drawn(self, point: SpacePoint) -> Array:
        """The global place of a point at the drawing, m, for the parameters' defaults."""
        place = [float(sympy.sympify(s).subs(self.defaults)) for s in point.place]
        body = point.body
        return np.asarray(body.place + rotation_of(body.attitude) @ place)

    def _ends(self, name: str, i: Any, j: Any, at: Any) -> tuple[SpacePoint, SpacePoint]:
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

    def _with_axis(
        self, cls: type[Any], name: str, i: Any, j: Any, at: Any, axis: Any
    ) -> Constraint:
        """A joint with an axis; f and g are the most nearly body axes that there are."""
        ends, where = self._ends(name, i, j, at), f"{cls.kind} '{name}': axis"
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
        joint: Constraint = self._declare(cls(name, *ends, axes))
        return joint


ELEMENTS = (
    "body, spherical, revolute, cylindrical, translational, universal, weld, distance, constraint, "
    "driver, rotation_driver, translation_driver, point_driver, distance_driver, gravity, force, "
    "torque, spring, torsion_spring, line_force, potential, generalized_force, contact, stop, "
    "release and engage"
)
"""What a machine in space may be declared with, in words."""
REFUSED = (
    *("absolute", "belt", "bushing", "cam_flat_follower", "cam_follower", "clearance_joint"),
    *("coupler", "curve_through", "draw_ground", "dry_friction", "elastic_belt", "friction"),
    *("gear", "gear_with_backlash", "mass_flow", "motor", "one_way_clutch", "particle"),
    *("point_follower", "rack_and_pinion", "relative", "relative_driver"),
    *("revolute_revolute", "revolute_translational", "rolling_disc", "screw"),
)
"""Words of the plane that a machine in space does not have yet."""


def _refusal(word: str) -> Callable[..., NoReturn]:
    def refuse(self: SpaceModel, *_: Any, **__: Any) -> NoReturn:
        raise ModelError(
            f"model.{word}: model '{self.name}' is in space, and this is there for machines in the "
            f"plane alone so far. In space there are {ELEMENTS}."
        )

    refuse.__name__, refuse.__doc__ = word, "Refused for a machine in space."
    return refuse


for _word in REFUSED:
    setattr(SpaceModel, _word, _refusal(_word))
