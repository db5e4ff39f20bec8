"""The joints of a declaration in which curves touch."""

from collections.abc import Sequence
from itertools import accumulate, pairwise
from math import hypot, pi
from typing import Any

import sympy

from codegen.declare.body import Body, Curve
from codegen.declare.element_conditions import pace, profile_problems
from codegen.declare.symbols import alpha
from codegen.elements.joints.cams import CamFlatFollower, CamFollower, PointFollower
from codegen.model.base import Declarations, Pair, Place
from codegen.object_display import counted
from codegen.readers.values import shown
from codegen.tables.piecewise_cubic import fit
from codegen.tables.table_function import FEWEST, TableFunction

# accuracy: first and last point of a path that agree to this part of its size are one
ROUNDING = 1e-9


class Cams(Declarations):
    """Cams and followers; the parameter at the contact, `alpha`, is a coordinate of the joint."""

    def cam_flat_follower(
        self, name: str, cam: Curve, face: Place, axis: Pair = (1, 0)
    ) -> CamFlatFollower:
        """The closed convex profile `cam` touches the flat face of a follower.

        Parameters
        ----------
        cam
            ``body.circle(...)``, ``body.polar(...)`` or ``body.curve(...)``.
        face, axis
            A point on the face, and the face's direction in the follower's frame: turned by 90°
            counter-clockwise it points from the cam into the follower.

        Notes
        -----
        A face has two contacts with a cam, one on either side. A scene that says nothing of
        ``joint.alpha`` begins where the cam reaches farthest into the follower.
        """
        profile = self._curve(name, cam, closed=True, convex=True)
        made = self._element(CamFlatFollower, name=name, cam=profile, face=face, axis=axis)
        return self._declare(made)  # type: ignore[no-any-return]

    def cam_follower(self, name: str, cam: Curve, follower: Curve) -> CamFollower:
        """Two closed profiles touch; a roller is ``body.circle(radius)``.

        A scene that says nothing of ``joint.alpha`` and ``joint.beta`` begins with the contact from
        outside; for a roller inside a ring, give start guesses of both.
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
        """The smooth curve through points of a body, by cubic splines of the chords' length.

        Parameters
        ----------
        points
            (x', y') in m or as quantities; at least four, no two that follow each other the same.
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
        if len(self.problems) == before:
            for problem in profile_problems(shape, closed, convex):
                self._note(f"{where}: {problem}")
        if len(self.problems) > before:
            return curve.body.circle(1)  # stands in, so that nothing else is said of it
        return Curve(curve.body, x, y, pace(shape))
