"""Points that coincide, that keep their distance or a coordinate, and equations of a user's own.

See Haug, 3.2 and 3.3.
"""

from typing import Any

import sympy

from codegen.declare.body import Bodies, Body, Point
from codegen.declare.element import (
    ConjugateReaction,
    Constraint,
    I,
    J,
    JointReaction,
    Statement,
    label,
)
from codegen.declare.element_fields import ground_unless_given, quantity
from codegen.declare.symbols import KINDS, Coordinate, Letter, given
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.elements.scalar_measures import Rubbing, RubbingJoint, relative_angle

COINCIDENT = tuple(I.point - J.point)
X_AXIS = I.A * sympy.Matrix([1, 0])


@element
class Revolute(RubbingJoint):
    """A hinge: a pin holds a point of body i and a point of body j together, and both may turn.

    r_i + A_i s'_i - r_j - A_j s'_j = 0; the reaction axes are those of the first body.
    """

    kind = "revolute"
    friction_arm = "radius"
    example = 'model.revolute("pin", P, Q)'
    name: str
    i: Point
    j: Point

    def statement(self) -> Statement:
        """Two equations, the x and y distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j)
        return Statement(COINCIDENT, ("x", "y"), JointReaction(X_AXIS), bindings)

    def rubbing(self) -> Rubbing:
        """φ_j - φ_i, under the size of the force."""
        i, j = self.i.body, self.j.body
        place = self.j.x, self.j.y
        return Rubbing(relative_angle(i, j), ("fx", "fy"), (i, j), place, i.rotation)

    def shapes(self) -> shapes.Shapes:
        """A pin."""
        return (shapes.Pin(self.i, self.j),)


LENGTH = given("length")
SPAN = J.point - I.point
LINK = (SPAN.dot(SPAN) - LENGTH**2,)


@element
class RevoluteRevolute(Constraint):
    """A massless link with a pin at either end keeps two points at its length.

    (r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - L² = 0; the reaction's x axis points along the link.

    `instead_of` names the body that the link stands for: the joint acts in the scenes that leave
    this body out.
    """

    kind = "revolute-revolute"
    example = 'model.revolute_revolute("link", P, Q, 2.0)'
    name: str
    i: Point
    j: Point
    length: sympy.Expr = quantity(
        "m", "positive", binds="positive", advice=", or use a revolute joint"
    )
    instead_of: Body | None = None

    @property
    def bodies(self) -> Bodies:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j) | {LENGTH: self.length}
        return Statement(LINK, ("length",), JointReaction(SPAN / LENGTH), bindings)

    def shapes(self) -> shapes.Shapes:
        """A rod with a pin at either end."""
        return (shapes.Rod(self.i, self.j),)


@element
class Distance(RevoluteRevolute):
    """Two points keep their distance, as the ends of a taut wire or of a massless link do.

    (r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - c² = 0; one of the points may be on the ground.

    The equation and the reaction are those of a massless link of length c. The x axis of the
    reaction points from point i to point j.
    """

    kind = "distance"
    example = 'model.distance("wire", P, Q, 2.0)'


VALUE = given("value")
LEFT_SIDE = {"x": J.point[0], "y": J.point[1], "phi": J.phi}
DIFFERENCE = {"x": SPAN[0], "y": SPAN[1], "phi": J.phi - I.phi}
GLOBAL_X = sympy.Matrix([1, 0])


def letter_unit(element: Any) -> str:
    """Unit of the coordinate whose letter an element has."""
    return KINDS[element.letter].unit


@element
class Absolute(Constraint):
    """A point keeps its global x or y, or a body its angle.

    x_j^P = c, y_j^P = c or φ_j = c; the reaction is that of the ground on the body.
    """

    kind = "absolute"
    example = 'model.absolute("level", Q, "y", 0.5)'
    name: str
    ground: Body = ground_unless_given()
    point: Point
    letter: Letter
    value: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.ground.at(0, 0)) | J.bind(self.point) | {VALUE: self.value}
        phi = (LEFT_SIDE[self.letter] - VALUE,)
        return Statement(phi, (self.letter,), JointReaction(X_AXIS), bindings)

    def shapes(self) -> shapes.Shapes:
        """A mark at the point."""
        return (shapes.Mark(self.point),)


@element
class Relative(Constraint):
    """Two points keep the difference of their x or y, or two bodies the difference of their angles.

    x_j^P - x_i^P = c, y_j^P - y_i^P = c or φ_j - φ_i = c, in global axes.

    The reaction is the force of the constraint on body j at its point, in global axes. The opposite
    force acts on body i at its own point. If the two forces have different lines of action, the
    global axes bear their moment. So a relative x or y between two free bodies keeps their linear
    momentum and their energy, but not their angular momentum.
    """

    kind = "relative"
    example = 'model.relative("beside", P, Q, "x", 0.5)'
    name: str
    i: Point
    j: Point
    letter: Letter
    value: sympy.Expr = quantity(letter_unit)

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.i) | J.bind(self.j) | {VALUE: self.value}
        reaction = JointReaction(GLOBAL_X)
        return Statement((DIFFERENCE[self.letter] - VALUE,), (self.letter,), reaction, bindings)

    def shapes(self) -> shapes.Shapes:
        """Marks at both points."""
        return shapes.Mark(self.i), shapes.Mark(self.j)


@element
class ExpressionConstraint(Constraint):
    """A constraint of your own: one or more equations, such as those of a rope over a pulley.

    The bearing of a pulley carries the rope only if an expression contains the pulley's x and y.
    """

    kind = "constraint"
    example = 'model.constraint("pulley", i.y + 2 * j.y - 1)'
    name: str
    phi: tuple[sympy.Expr, ...]
    on: Bodies

    def statement(self) -> Statement:
        """The expressions as they stand; the reactions are their multipliers' forces -λ."""
        rows = tuple(f"row{k}" if len(self.phi) > 1 else "row" for k in range(len(self.phi)))
        names = (row.replace("row", "force") for row in rows)
        reaction = ConjugateReaction(tuple(zip(names, map(_force_unit, self.phi), strict=True)))
        return Statement(self.phi, rows, reaction)

    def problems(self) -> list[str]:
        """An equation without coordinates constrains nothing."""
        if not self.bodies:
            return [f"{label(self)}: {self.phi} names no coordinate of a body."]
        return []


def _force_unit(phi: sympy.Expr) -> str:
    """N or N m of the multiplier, where numbers alone multiply coordinates of one unit; else ""."""
    coordinates = phi.atoms(Coordinate)
    plain = all(phi.diff(x).is_number for x in coordinates)
    units = {x.measure.force_unit for x in coordinates} if plain else set()
    return units.pop() if len(units) == 1 else ""
