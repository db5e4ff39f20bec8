"""The joints and drivers of a declaration, one method a type.

A driver takes its name, the driven quantity, and its law: an expression of the time t and of
parameters. Positions are in m and angles in rad; differences and distances go from `i` to `j`.
"""

from collections.abc import Sequence
from itertools import accumulate, pairwise
from math import hypot, pi
from typing import Any

import sympy

from codegen.declare.body import Body, Curve, Point
from codegen.declare.cam_profiles import CamProfile
from codegen.declare.element import Constraint
from codegen.declare.element_fields import pace, profile_problems
from codegen.declare.symbols import Letter, alpha
from codegen.elements import drivers
from codegen.elements.joints.cams import CamFlatFollower, CamFollower, PointFollower
from codegen.elements.joints.guides import (
    RackAndPinion,
    RevoluteTranslational,
    RollingDisc,
    Screw,
    Translational,
)
from codegen.elements.joints.points import (
    Absolute,
    Distance,
    ExpressionConstraint,
    Relative,
    Revolute,
    RevoluteRevolute,
)
from codegen.elements.joints.weld import Weld
from codegen.elements.joints.wheels import Belt, Gear
from codegen.model.base import Declarations, Pair, Place, declares
from codegen.object_display import counted
from codegen.readers.values import shown
from codegen.tables.piecewise_cubic import fit
from codegen.tables.piecewise_function import close, closed_where_smooth
from codegen.tables.table_function import FEWEST, TableFunction

# accuracy: first and last point of a path that agree to this part of its size are one
ROUNDING = 1e-9


class Constraints(Declarations):
    """The joints and drivers of a declaration."""

    @declares(Revolute)
    def revolute(self, name: str, i: Point, j: Point) -> Constraint:
        """Points `i` and `j` of two bodies coincide."""

    @declares(Translational)
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

    @declares(RevoluteRevolute)
    def revolute_revolute(
        self, name: str, i: Point, j: Point, length: Any, instead_of: Body | None = None
    ) -> Constraint:
        """A massless link of `length` between two points.

        With `instead_of`, a body, the link acts only in the scenes that leave this body out.
        """

    @declares(RevoluteTranslational)
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
            The slide block that the joint replaces: the joint acts in the scenes that leave this
            body out.
        """

    @declares(Weld)
    def weld(self, name: str, i: Place, j: Place, angle: Any = 0) -> Constraint:
        """Points `i` and `j` coincide and φ_j - φ_i keeps `angle`, rad: two bodies move as one."""

    @declares(Gear)
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
            Angle of the line from centre `i` to centre `j`, rad, at which the teeth mesh with φ_i =
            φ_j = 0. By default it follows from the bearings of the centres, with the carrier at φ =
            0; without such bearings it is 0. Welded bodies count as one.
        """

    @declares(RackAndPinion)
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

    @declares(Belt)
    def belt(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *,
        carrier: Body | None = None, crossed: bool = False, offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A belt or chain that neither stretches nor slips couples two pulleys.

        Parameters
        ----------
        i, j
            The pulleys.
        radius_i, radius_j
            Their radii, m, both positive.
        carrier
            The body that carries the bearings of both; None: the ground.
        crossed
            Whether the belt is crossed, and turns the pulleys in opposite directions.
        offset
            s0 in m: R_j (φ_j - φ_c) - R_i (φ_i - φ_c) when the belt was laid on. For a crossed belt
            R_i counts as negative.
        """

    @declares(Screw)
    def screw(
        self, name: str, frame: Place, nut: Place, spindle: Body, lead: Any, axis: Pair = (1, 0),
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A nut travels along an axis by `lead` for each turn of a spindle.

        Parameters
        ----------
        frame
            A point of the body in which the spindle turns, on the axis of travel.
        nut
            A point of the nut; a body means its centre of mass.
        spindle
            The body that turns: the spindle's wheel, or its motor.
        lead
            h, the travel of one turn, m; negative for a left-hand thread.
        axis
            Direction of travel in the frame of `frame`.
        offset
            The nut's place along `axis` from `frame`, m, at equal φ of spindle and `frame`'s body.
        """

    @declares(RollingDisc)
    def rolling_disc(
        self, name: str, disc: Place, line: Place, radius: Any, axis: Pair = (1, 0),
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A disc rolls along a line of another body without slip.

        Parameters
        ----------
        disc
            The disc's centre; a body means its centre of mass.
        line
            A point on the line; a body means its centre of mass.
        radius
            The disc's radius, m.
        axis
            Direction of the line in the frame of its body; the disc lies to the left of it.
        offset
            How far along `axis` the centre lies from `line`, m, where both bodies have the same φ.
        """

    @declares(Absolute, point="on")
    def absolute(self, name: str, on: Place, letter: Letter, value: Any) -> Constraint:
        """A point's global x or y, or a body's φ, keeps `value`."""

    @declares(Relative)
    def relative(self, name: str, i: Place, j: Place, letter: Letter, value: Any) -> Constraint:
        """Global x or y of point `j`, or φ of its body, minus that of `i` keeps `value`."""

    @declares(Distance, length="value")
    def distance(self, name: str, i: Place, j: Place, value: Any) -> Constraint:
        """Points `i` and `j` keep the distance `value`, m; either may be on the ground."""

    def constraint(self, name: str, *phi: Any) -> Constraint:
        """Plain equations: each expression of coordinates, parameters and t is kept at zero.

        The expressions must be smooth in the coordinates. Pieces of powers, sines and cosines are
        smooth if their values and slopes agree on both sides of a condition that is linear in a
        coordinate; steps end where pieces meet. A motion ends where it reaches a pole, an end of
        asin or acos, the cut of atan2, or a root at 0 whose slope jumps; the message names the
        constraint.
        """
        read = (self._value(e, "", f"constraint '{name}'") for e in phi)
        equations = tuple(closed_where_smooth(e) for e in read)
        return self._declare(ExpressionConstraint(name, equations, self._bodies_in(*equations)))

    @declares(drivers.Motion)
    def driver(self, name: str, driven: Any, law: Any) -> Constraint:
        """A coordinate, or any expression of coordinates, follows `law`, an expression of t."""

    @declares(drivers.PointDriver, point="on")
    def point_driver(self, name: str, on: Place, letter: Letter, law: Any) -> Constraint:
        """A point's global x or y, or its body's φ, follows `law`."""

    @declares(drivers.RelativeDriver)
    def relative_driver(
        self, name: str, i: Place, j: Place, letter: Letter, law: Any
    ) -> Constraint:
        """Global x or y of point `j`, or φ of its body, minus that of `i` follows `law`."""

    def rotation_driver(self, name: str, i: Place, j: Place, law: Any) -> Constraint:
        """φ_j - φ_i follows `law`: the motor in a revolute joint between two bodies."""
        return self.relative_driver(name, i, j, "phi", law)

    @declares(drivers.TranslationDriver)
    def translation_driver(
        self, name: str, i: Place, j: Place, law: Any, axis: Pair = (1, 0)
    ) -> Constraint:
        """The distance of `j` from `i` along `axis` of body `i` follows `law`: a driven slider."""

    @declares(drivers.DistanceDriver)
    def distance_driver(self, name: str, i: Place, j: Place, law: Any) -> Constraint:
        """The distance of two points follows `law`, which stays positive: a cylinder."""

    def cam_flat_follower(
        self, name: str, cam: Curve, face: Place, axis: Pair = (1, 0)
    ) -> CamFlatFollower:
        """The closed convex profile `cam` touches the flat face of a follower.

        Parameters
        ----------
        cam
            ``body.circle(...)``, ``body.polar(...)`` or ``body.curve(...)``.
        face, axis
            A point on the face, and the direction of the face in the follower's frame. This
            direction, turned by 90° counter-clockwise, points from the cam into the follower.

        Notes
        -----
        A face can touch a cam on either side. A scene without a value of ``joint.alpha`` begins
        where the cam reaches farthest into the follower.
        """
        profile = self._curve(name, cam, closed=True, convex=True)
        made = self._element(CamFlatFollower, name=name, cam=profile, face=face, axis=axis)
        return self._declare(made)  # type: ignore[no-any-return]

    def cam_follower(self, name: str, cam: Curve, follower: Curve) -> CamFollower:
        """Two closed profiles touch; a roller is ``body.circle(radius)``.

        If a scene has no values of ``joint.alpha`` and ``joint.beta``, the follower begins outside
        the cam; for a roller inside a ring, give guesses of both.
        """
        curves = (self._curve(name, curve, closed=True) for curve in (cam, follower))
        return self._declare(CamFollower(name, *curves))

    def point_follower(self, name: str, curve: Curve, point: Place) -> PointFollower:
        """A point of one body moves along a curve of another, open or closed."""
        return self._declare(
            PointFollower(name, self._curve(name, curve), self._point(name, point))
        )

    def curve_through(
        self, name: str, body: Body, points: Sequence[tuple[Any, Any]], closed: bool = True
    ) -> Curve:
        """The smooth curve through points of a body, by cubic splines over the lengths of chords.

        Parameters
        ----------
        points
            (x', y') in m or as quantities; at least four, of which no two neighbours coincide.
        closed
            A closed curve returns to its first point at α = 2π; on an open one α
            runs from 0 to 1.
        """
        where = f"curve '{name}'"
        before = len(self.problems)
        on = self._body(where, body)
        closed = self._read.flag(closed, f"{where}: closed", True)
        given = self._read.pairs(points, where, "points")
        rows = [
            [self._read.finite(c, "m", f"{where}, point {k}") for c in pair]
            for k, pair in enumerate(given)
        ]
        if closed and len(rows) > 1:
            size = max(abs(c) for row in rows for c in row)
            if all(abs(a - b) <= ROUNDING * size for a, b in zip(rows[0], rows[-1], strict=True)):
                rows.pop()  # the first point again, to rounding
            rows.append(rows[0])
        chords = [hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(rows)]
        along = list(accumulate(chords, initial=0.0))
        for k, chord in enumerate(chords):
            if chord == 0.0:
                self._note(f"{where}: points {k} and {k + 1} are both {tuple(rows[k])}; drop one.")
        fewest = FEWEST["spline"]
        if len(rows) < fewest:
            count = f"{counted(len(given), 'point')} {'is' if len(given) == 1 else 'are'}"
            self._note(f"{where}: {count} too few; give at least {fewest}.")
        if not self._claim("curve", name) or len(self.problems) > before:
            return on.circle(1)
        unit = 2 * pi if closed else 1.0
        at = [unit * (distance / along[-1]) for distance in along]
        x, y = (
            TableFunction(fit(f"{name}_{axis}", at, [row[k] for row in rows], closed))(alpha)
            for k, axis in enumerate("xy")
        )
        return on.curve(x, y)

    def _curve(self, name: str, curve: Any, closed: bool = False, convex: bool = False) -> Curve:
        """The curve with its expressions read, its shape looked at for the default parameters."""
        if not isinstance(curve, Curve) or not isinstance(curve.body, Body):
            self._note(
                f"'{name}': {shown(curve)} is no curve; write body.circle(r) or body.curve(x, y)."
            )
            return self.ground.circle(1)
        where = f"curve of '{name}' on body '{curve.body.name}'"
        before = len(self.problems)
        x, y = (self._read.value(c, "m", where, profile=True) for c in (curve.x, curve.y))
        shape = sympy.Matrix([x, y]).subs(self.defaults)
        pieces = shape.has(sympy.Piecewise)
        if len(self.problems) == before:
            is_known = isinstance(curve, CamProfile) and shape.free_symbols == {alpha}
            cut = curve.undercut(self.defaults) if is_known else ""  # type: ignore[attr-defined]
            for problem in [cut] if cut else profile_problems(shape, closed or pieces, convex):
                self._note(f"{where}: {problem}")
        if len(self.problems) > before:
            return curve.body.circle(1)  # stands in, so that nothing else is said of it
        if pieces:
            x, y = close(x), close(y)
        return Curve(curve.body, x, y, pace(shape))
