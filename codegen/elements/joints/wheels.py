"""Gears (Haug, section 3.4) and belts, and the bearings and the carrier of two wheels."""

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import sympy

from codegen.declare.body import Body, Ground, Point
from codegen.declare.element import (
    ConjugateReaction,
    Constraint,
    Frame,
    I,
    J,
    JointReaction,
    Statement,
    label,
)
from codegen.declare.element_fields import (
    Condition,
    Conditions,
    ground_unless_given,
    quantity,
    shared_fields,
)
from codegen.declare.state import Connection
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints.points import SPAN, Revolute
from codegen.elements.joints.weld import Weld
from codegen.elements.registry import element
from codegen.elements.scalar_measures import angle_problems, same_body

ROUNDING = 1e-6
"""accuracy: relative difference of centre distance and radii that rounded inputs explain."""
SAME = 1e-12
"""accuracy: m; places of a body that are nearer than this are one."""

SHARE_I, SHARE_J, LINE = given("share_i"), given("share_j"), given("line")
THETA = LINE + SHARE_I * I.phi + SHARE_J * J.phi
MESH = (SPAN[0] * sympy.sin(THETA) - SPAN[1] * sympy.cos(THETA),)
TOWARDS_J = sympy.Matrix([sympy.cos(THETA), sympy.sin(THETA)])


@element
class Gear(Constraint):
    """Two gears mesh, outside or one within the other; the ratio of their radii is the gear ratio.

    d_x sin θ - d_y cos θ = 0 with d = r_j^P - r_i^P and the angle θ of the line of centres.

    Rolling without slip makes equal arcs pass the pitch point on both circles,
    R_i (θ̇ - φ̇_i) + R_j (θ̇ - φ̇_j) = 0, hence (Haug, section 3.4)

        θ = θ_0 + (R_i φ_i + R_j φ_j) / (R_i + R_j),

    and the equation says that the line of centres has this angle. The equation is smooth, and holds
    on a carrier that turns, through any number of turns. An internal gear has a negative radius and
    the same formula. `line` θ_0 is the angle of the line from centre i to centre j, rad, at which
    the teeth mesh with φ_i = φ_j = 0. With None, θ_0 is the angle at which the bearings hold the
    centres while their carrier is at φ = 0; without bearings it is 0. Both θ and θ + π satisfy the
    equation, so give a guess nearer to the angle that you mean.

    Bearings or a carrier keep the gears' centres apart, not this joint. The reaction acts from gear
    i on gear j, at the centre of j, with x along the line of centres: `fy` is the tangential force
    at the teeth, `torque` its moment, and `fx` is 0. The teeth bear in both directions, without
    play; there is no pressure angle.

    The bearings are found among `joints`, the joints of the model: revolute joints and welds; not
    the welds in the model's `connections`, which are released or engage.
    """

    kind = "gear"
    example = 'model.gear("mesh", i, j, 0.2, 0.3)'
    name: str
    i: Point
    j: Point
    radius_i: sympy.Expr = quantity("m")
    radius_j: sympy.Expr = quantity("m")
    line: sympy.Expr | None = quantity("rad")
    joints: Mapping[str, Constraint]
    connections: Mapping[str, Connection]

    def problems(self) -> list[str]:
        """A wheel without a bearing once a weld is released."""
        return released_bearings(self)

    def carriers(self, joints: Mapping[str, Constraint]) -> "Carriers":
        """The bodies that keep the centres apart."""
        return find_carriers([self.i], [self.j], joints)

    def statement(self) -> Statement:
        """One equation, m: the distance of centre j from the line that the angles call for."""
        total = self.radius_i + self.radius_j
        bindings = I.bind(self.i) | J.bind(self.j) | {LINE: self._line()}
        bindings |= {SHARE_I: self.radius_i / total, SHARE_J: self.radius_j / total}
        return Statement(MESH, ("mesh",), JointReaction(TOWARDS_J), bindings)

    def conditions(self) -> Conditions:
        """Radii of two pitch circles, which touch at the distance of the gears' bearings."""
        i, j = self.radius_i, self.radius_j
        pair = f"the radii ({i}, {j}) m"
        radii: tuple[tuple[sympy.Expr, str], ...] = (
            ((i * j) ** 2, "contain a 0{}; give the radii of the pitch circles."),
            (sympy.Max(i, j), "are those of two internal gears{}; make one positive."),
            (
                sympy.expand(i + j) ** 2,
                "add up to 0{}, and the centres coincide; give the internal gear the larger one.",
            ),
        )
        conditions = tuple(
            Condition(
                f"{pair} {text.format('' if v.is_number else ', {1:g} and {2:g}')}", (v, i, j),
                open=True,
            )
            for v, text in radii
        )  # fmt: skip
        carriers = self.carriers(lasting(self))
        if not carriers:
            return conditions
        carrier, dx, dy = carriers[0]
        distance, mesh = sympy.sqrt(dx**2 + dy**2), sympy.Abs(i + j)
        text = (
            f"the bearings on '{carrier.name}' hold the centres {{1:.9g}} m apart, but {pair} mesh "
            "at {2:.9g} m; change one or the other (an internal gear has a negative radius)."
        )
        apart = sympy.Abs(distance - mesh) - ROUNDING * mesh
        return (*conditions, Condition(text, (apart, distance, mesh), low=None, high=0.0))

    def _line(self) -> sympy.Expr:
        if self.line is not None:
            return self.line
        carriers = self.carriers(lasting(self))
        return sympy.atan2(carriers[0][2], carriers[0][1]) if carriers else sympy.S.Zero

    def shapes(self) -> shapes.Shapes:
        """Two toothed wheels."""
        return toothed_wheels((self.i, self.radius_i), (self.j, self.radius_j))


def toothed_wheels(*wheels: tuple[Any, sympy.Expr]) -> shapes.Shapes:
    """What gears look like: their points or bodies, and radii."""
    return tuple(shapes.Wheel(at, radius, toothed=True) for at, radius in wheels)


def lasting(element: Any) -> dict[str, Constraint]:
    """The joints of the model without the welds that come and go."""
    return {
        name: joint
        for name, joint in element.joints.items()
        if not (isinstance(joint, Weld) and name in element.connections)
    }


def released_bearings(element: Any) -> list[str]:
    """The problem of wheels that only a weld which comes and goes keeps on a carrier."""
    kept, joints = lasting(element), element.joints
    if element.carriers(kept) or not element.carriers(joints):
        return []
    welds = [name for name in joints if name not in kept]
    others = ({name: joints[name] for name in joints if name != weld} for weld in welds)
    needed = [w for w, o in zip(welds, others, strict=True) if not element.carriers(o)]
    names = " and ".join(f"'{name}'" for name in needed or welds)
    problem = (
        f"{label(element)}: a wheel is on its carrier by weld {names}, which comes and goes, and "
        "without it the wheel has no bearing; give the wheel a revolute joint there, and let "
        "model.relative(..., 'phi', ...) come and go in place of the weld."
    )
    return [problem]


Carriers = list[tuple[Body, sympy.Expr, sympy.Expr]]


def find_carriers(
    i: Iterable[Point], j: Iterable[Point], joints: Mapping[str, Constraint]
) -> Carriers:
    """The bodies that keep two axles apart, and the way from one to the other in their frames, m.

    `i` and `j` are where the axles of the wheels may be. A body keeps them apart if each is its
    own, or sits on it by revolute joints or welds at just this place, over other bodies on the same
    axle too. Bodies that welds join anywhere count as one: those with a bearing come first, the
    ground last. None where the declaration shows no such body.
    """
    ways = (product(_axle(one, joints), _axle(other, joints)) for one, other in product(i, j))
    found = [
        (from_i + from_j, a.body, b.sx - a.sx, b.sy - a.sy)
        for way in ways
        for (a, from_i), (b, from_j) in way
        if a.body is b.body
    ]
    return [row[1:] for row in sorted(found, key=lambda row: (row[0], row[1].fixed))]


def _axle(point: Point, joints: Mapping[str, Constraint]) -> list[tuple[Point, bool]]:
    """The place of an axle in all bodies that keep it, and whether only a weld elsewhere does."""
    pins = [pin for pin in joints.values() if isinstance(pin, Revolute | Weld)]
    found = [(point, False)]
    for place, away in found:
        for pin in pins:
            for here, there, way in ((pin.i, pin.j, -1), (pin.j, pin.i, 1)):
                if here.body is not place.body or any(p.body is there.body for p, _ in found):
                    continue
                x, y = place.sx - here.sx, place.sy - here.sy
                if _is_zero(x) and _is_zero(y):
                    found.append((there, away))
                elif isinstance(pin, Weld):
                    c, s = sympy.cos(pin.angle), way * sympy.sin(pin.angle)
                    at = Point(there.body, there.sx + c * x - s * y, there.sy + s * x + c * y)
                    found.append((at, True))
    return found


def _is_zero(gap: sympy.Expr) -> bool:
    """Whether a length is 0 but for rounding, whatever its symbols are."""
    symbols = sorted(gap.free_symbols, key=str)
    number = gap.xreplace({s: sympy.Float(2.0 + k) ** 0.5 for k, s in enumerate(symbols)})
    return bool(number.is_comparable and abs(number) <= SAME)


@shared_fields
class WheelPair:
    """Two wheels whose bearings are on a carrier."""

    name: str
    i: Body
    j: Body
    carrier: Body = ground_unless_given()
    radius_i: sympy.Expr = quantity("m")
    radius_j: sympy.Expr = quantity("m")
    offset: sympy.Expr = quantity("m")
    joints: Mapping[str, Constraint]
    connections: Mapping[str, Connection]

    def problems(self) -> list[str]:
        """Wheels without an angle, a wheel for its own carrier, other bearings."""
        where, (i, j, carrier) = label(self), (self.i, self.j, self.carrier)
        problems = angle_problems(self, i, j, carrier)
        if i is j:
            problems += same_body(where, (i, j))
        elif isinstance(carrier, Ground) and (carrier is i or carrier is j):
            problems.append(
                f"{where}: the ground is one of its wheels and, as no carrier is given, carries "
                "the bearings too; give two bodies that turn, or as carrier= an arm that turns."
            )
        elif carrier is i or carrier is j:
            problems.append(
                f"{where}: the carrier '{carrier.name}' is one of its wheels; give the body that "
                "carries the bearings, or leave it out for the ground."
            )
        else:
            found = [body for body, *_ in self.carriers(lasting(self))]
            if found and carrier not in found:
                problems.append(
                    f"{where} turns against '{carrier.name}', but the bearings of '{i.name}' and "
                    f"'{j.name}' are on '{found[0].name}'; give carrier= that body."
                )
            problems += released_bearings(self)
        return problems

    def carriers(self, joints: Mapping[str, Constraint]) -> Carriers:
        """The bodies beside the wheels that carry both.

        A wheel's axle is at a revolute joint or weld of its own, or at its centre of mass.
        """
        pins = [pin for pin in joints.values() if isinstance(pin, Revolute | Weld)]
        ends = [
            Point(self.i, 0, 0),
            Point(self.j, 0, 0),
            *(e for pin in pins for e in (pin.i, pin.j)),
        ]
        on_i, on_j = ([end for end in ends if end.body is w] for w in (self.i, self.j))
        found = find_carriers(on_i, on_j, joints)
        return [carrier for carrier in found if carrier[0] not in (self.i, self.j)]


RADIUS_I, RADIUS_J = given("radius_i"), given("radius_j")
CARRIER, OFFSET = Frame("carrier"), given("offset")
BELT = (RADIUS_J * (J.phi - CARRIER.phi) - RADIUS_I * (I.phi - CARRIER.phi) - OFFSET,)


@shared_fields
class Pulleys(WheelPair):
    """Two pulleys and a belt round them, which may be crossed."""

    radius_i: sympy.Expr = quantity(
        "m", "positive", binds="positive", word="radius of the first pulley"
    )
    radius_j: sympy.Expr = quantity(
        "m", "positive", binds="positive", word="radius of the second pulley"
    )
    crossed: bool

    def shapes(self) -> shapes.Shapes:
        """Two pulleys and the belt."""
        i, j, radius_i, radius_j = self.i, self.j, self.radius_i, self.radius_j
        belt = shapes.Belt(i, j, radius_i, radius_j, self.crossed)
        return shapes.Wheel(i, radius_i), shapes.Wheel(j, radius_j), belt


@element
class Belt(Pulleys, Constraint):
    """A belt or a chain runs round two pulleys; the ratio of their radii is the gear ratio.

    R_j (φ_j - φ_c) - R_i (φ_i - φ_c) = s0: equal lengths of belt leave i and reach j.

    The pulleys turn in bearings of the carrier c, the ground or an arm that turns. A crossed belt
    turns them in opposite directions: R_i is negative in the equation. s0 is the value of the left
    side when the belt was laid on.

    The reaction is the force of the belt along the rim of pulley j, N: the difference of its
    tensions. R_j times this force turns pulley j, and R_i times this force holds pulley i back. The
    belt is never slack. Both tensions together pull the bearings towards each other; the carrier
    takes this load, which the model does not compute.
    """

    kind = "belt"
    example = """
        r_i, r_j = (model.parameter(r, 0.2, unit="m") for r in ("r_i", "r_j"))
        model.belt("chain", i, j, r_i, r_j)
    """

    def statement(self) -> Statement:
        """One equation, m: length of belt."""
        bindings = I.bind(Point(self.i, 0, 0)) | J.bind(Point(self.j, 0, 0))
        bindings |= {RADIUS_I: -self.radius_i if self.crossed else self.radius_i}
        bindings |= {RADIUS_J: self.radius_j, OFFSET: self.offset}
        bindings |= CARRIER.bind(Point(self.carrier, 0, 0))
        return Statement(BELT, ("belt",), ConjugateReaction((("force", "N"),)), bindings)
