"""Drivers: constraints that prescribe a motion in time (Haug, section 3.5)."""

from collections.abc import Mapping
from typing import Any

import sympy

from codegen.declare.body import Bodies, Body, Point
from codegen.declare.element import ConjugateReaction, Constraint, I, J, Statement, label
from codegen.declare.element_fields import Axis, Condition, Conditions, direction, quantity
from codegen.declare.space_body import SpaceBody, SpacePoint
from codegen.declare.space_frame import I as IN_SPACE_I
from codegen.declare.space_frame import J as IN_SPACE_J
from codegen.declare.symbols import Coordinate, Letter, kinds, t
from codegen.drawing import shapes
from codegen.drawing.space_shapes import SpaceDrive
from codegen.elements.joints.guides import ALONG, bind_axis
from codegen.elements.joints.points import DIFFERENCE, LEFT_SIDE, SPAN, letter_unit
from codegen.elements.registry import element
from codegen.elements.space.joints import SPAN as SPAN_IN_SPACE
from codegen.elements.space.joints import JointWithAxis

# safety: (1e-90 m)² is below the rounding of any distance. It keeps d / |d| and its derivative from
# 0 / 0 if a guess puts both points in one place: the Jacobian is 0 there, like that of dᵀ d.
NOTHING = 1e-180
DISTANCES: dict[type, tuple[Any, Any, sympy.Expr]] = {
    of: (i, j, sympy.sqrt(span.dot(span) + NOTHING))
    for of, i, j, span in ((Point, I, J, SPAN), (SpacePoint, IN_SPACE_I, IN_SPACE_J, SPAN_IN_SPACE))
}
"""Class of a point → the frames of two bodies, and the distance of their points."""


class Driver(Constraint):
    """A driver: driven - law(t) = 0."""

    law: sympy.Expr

    def problems(self) -> list[str]:
        """A law that contains coordinates is no law of time."""
        return [
            f"{label(self)}: the law {self.law} contains the coordinate {s.name}; "
            f"a motion law depends on {t} and parameters only."
            for s in kinds(self.law, Coordinate)
        ]


def _drive(
    i: Point | Body | None, at: Point | Body, letter: str, axis: Axis | None = None
) -> shapes.Shapes:
    """An arrow along an axis or a coordinate, straight or round."""
    ux, uy = axis or (int(letter == "x"), int(letter == "y"))
    return (shapes.Drive(i, at, letter == "phi", ux, uy),)


def pushed_along(at: SpacePoint, letter: str) -> SpaceDrive:
    """The direction of a force on a point along a global axis."""
    x, y, z = (float(letter == axis) for axis in "xyz")
    return SpaceDrive(at, x, y, z)


@element(driver=True)
class Motion(Driver):
    """A coordinate, or any expression of coordinates, follows a law of the time.

    driven - law(t) = 0; its reaction is the force that the driver exerts along `driven`.
    """

    kind = "driver"
    example = """
        omega = model.parameter("omega", 2.0, unit="rad/s")
        model.driver("motor", i.phi, pi / 4 + omega * t)
    """
    name: str
    driven: sympy.Expr = quantity()
    law: sympy.Expr = quantity(lambda of: getattr(of.driven, "unit", ""))
    on: Bodies
    joints: Mapping[str, Constraint]

    def statement(self) -> Statement:
        """One equation; for a single coordinate the reaction is a force or torque on its body."""
        row, reaction = "motion", ConjugateReaction((("force", ""),))
        if isinstance(self.driven, Coordinate):
            row = self.driven.letter
            reaction = ConjugateReaction.along(row)
        return Statement((self.driven - self.law,), (row,), reaction)

    def shapes(self) -> shapes.Shapes:
        """An arrow at the joint or the body whose coordinate is driven; of expressions none."""
        if not isinstance(self.driven, Coordinate):
            return ()
        letter, joint = self.driven.letter, self.joints.get(self.driven.owner)
        if isinstance(joint, JointWithAxis):
            return (joint.drive(letter),)
        body = next((b for b in self.on if self.driven in (*b.position, b.phi)), None)
        if isinstance(body, SpaceBody):
            return (pushed_along(body.at(0, 0, 0), letter),)
        return () if body is None else _drive(None, body, letter)

    def problems(self) -> list[str]:
        """The law must be one of time alone, twice differentiable, and something must be driven."""
        missing = f"{label(self)}: {self.driven} names no coordinate of a body."
        return [*([] if self.bodies else [missing]), *super().problems()]


@element(driver=True)
class PointDriver(Driver):
    """A point follows a law of the time in global x or y, or a body follows one with its angle.

    x_j^P - C(t) = 0, y_j^P - C(t) = 0 or φ_j - C(t) = 0.

    The reaction is the force of the driver on the body, at the point and along the global axis, N,
    or its torque on the body, N m.
    """

    kind = "point driver"
    example = """
        points = [0, 1, 2, 3, 4], [0, 0.3, 0.8, 1, 0.8]
        lift = model.table("lift", *points, units=("s", "m"), kind="spline")
        model.point_driver("hand", Q, "y", lift(t))
    """
    name: str
    point: Point
    letter: Letter
    law: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction.along(self.letter)
        phi = (LEFT_SIDE[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, J.bind(self.point))

    def problems(self) -> list[str]:
        """The law is one of time, and the ground stays where it is."""
        problems = super().problems()
        if self.point.body.fixed:
            problems.append(
                f"{label(self)} moves a point of the ground; give one of a moving body."
            )
        return problems

    def shapes(self) -> shapes.Shapes:
        """An arrow at the point, straight or round."""
        return _drive(None, self.point, self.letter)


@element(driver=True)
class RelativeDriver(Driver):
    """Body j moves relative to body i by a law of the time, such as that of a motor or servo.

    x_j^P - x_i^P - C(t) = 0, y_j^P - y_i^P - C(t) = 0 or φ_j - φ_i - C(t) = 0, in global axes.

    With φ this is the revolute-rotational driver: the motor in a revolute joint. The reaction is
    the force on body j at its point, along the global axis, N, or the torque on body j, N m. The
    opposite force or torque acts on body i.
    """

    kind = "relative driver"
    example = 'model.rotation_driver("motor", P, Q, 2 * t**2)'
    declared_by = ("relative_driver", "rotation_driver")
    name: str
    i: Point
    j: Point
    letter: Letter
    law: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation, m or rad."""
        reaction = ConjugateReaction.along(self.letter)
        phi = (DIFFERENCE[self.letter] - self.law,)
        return Statement(phi, (self.letter,), reaction, I.bind(self.i) | J.bind(self.j))

    def shapes(self) -> shapes.Shapes:
        """An arrow at the point of body j, straight, or round; of bodies about their pin."""
        if self.letter == "phi" and self.j.place == (0, 0):
            return _drive(self.i.body, self.j.body, self.letter)
        return _drive(None, self.j, self.letter)


@element(driver=True)
class TranslationDriver(Driver):
    """A slider follows a law of the time along its guide, as a feed or a linear motor moves it.

    u_iᵀ d_ij - C(t) = 0: how far point j is ahead of point i along an axis of body i.

    It drives a translational joint between the points, which another joint may hold instead. C
    may pass through 0. The reaction is the force on body j along the axis, N; the opposite force
    acts on body i on the same line of action.
    """

    kind = "translation driver"
    example = 'model.translation_driver("slide", P, Q, sin(3 * t), axis=(2, 1))'
    name: str
    i: Point
    j: Point
    axis: Axis = direction()
    law: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """One equation, m."""
        reaction = ConjugateReaction((("force", "N"),))
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        return Statement((ALONG - self.law,), ("along",), reaction, bindings)

    def shapes(self) -> shapes.Shapes:
        """An arrow along the axis."""
        return _drive(self.i, self.j, "", self.axis)


@element(driver=True)
class DistanceDriver(Driver):
    """A cylinder or a winch: the distance of two points follows a law of the time.

    sqrt(dᵀ d) - C(t) = 0 with d = r_j^P - r_i^P: a cylinder or a winch between two points.

    Haug squares both sides. Here the distance itself is driven, so that the multiplier is a force,
    and a negative C has no solution. Where C reaches 0 the two points meet, the direction between
    them is lost and the motion ends. For a stroke that passes through 0, use `TranslationDriver` or
    `RelativeDriver`.

    The reaction is the force on body j away from point i, N: positive where the driver pushes the
    points apart. The opposite force acts on body i.
    """

    kind = "distance driver"
    example = 'model.distance_driver("cylinder", P, Q, 2 + sin(3 * t) / 2)'
    name: str
    i: Point
    j: Point
    law: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """One equation, m."""
        reaction = ConjugateReaction((("force", "N"),))
        i, j, distance = DISTANCES[type(self.i)]
        bindings = i.bind(self.i) | j.bind(self.j)
        return Statement((distance - self.law,), ("distance",), reaction, bindings)

    def conditions(self) -> Conditions:
        """A law that is positive at t = 0, as far as can be told."""
        law = str(self.law).replace("{", "{{").replace("}", "}}")
        other = "driver" if isinstance(self.i, SpacePoint) else "relative_driver"
        text = (
            f"the law {law} is {{:g}} m at t = 0; a distance stays positive: where two points pass "
            f"each other drive with model.translation_driver or model.{other}."
        )
        return (Condition(text, (self.law.subs(t, 0),), open=True),)

    def shapes(self) -> shapes.Shapes:
        """An actuator."""
        return (shapes.Spring(self.i, self.j, elastic=False, actuator=True, pushes=True),)
