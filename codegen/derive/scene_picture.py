"""The picture of a scene in symbols: poses of its bodies, and the shapes of what acts in it."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import sympy

from codegen.declare.body import Bodies, Body, Curve, Point
from codegen.declare.element import Element, JointReaction, WrenchReaction, label
from codegen.declare.returned_values import returned, statement_of
from codegen.declare.space_body import SpaceBody, SpacePoint
from codegen.declare.symbols import Coordinate, Parameter, Time, derivative, kinds, t
from codegen.drawing import shapes
from codegen.drawing.picture import BodyLayout, Symbol
from codegen.drawing.shapes import Pair, Place, Shape, SpacePlace
from codegen.drawing.space_shapes import Bulk, Form, Wrench
from codegen.readers.arguments import one_of, optional, several
from codegen.readers.calls import errors_at
from codegen.readers.expressions import plain_expression

_SHAPES = optional(several(one_of("a shape", Shape), "a tuple of shapes"))
Hubs = dict[frozenset[Body], tuple[Point, ...]]
"""Two bodies → the points at which a pin connects them."""


class Scoped(NamedTuple):
    """An expression in the placeholders of an element, and what these stand for."""

    expression: sympy.Expr
    bindings: Mapping[sympy.Symbol, sympy.Expr]


class Slope(NamedTuple):
    """The derivative of an expression by coordinates, one after the other."""

    expression: sympy.Expr
    by: tuple[Coordinate, ...]


class BodyNumber(int):
    """A body of a picture, 0 for the ground."""


class PlaneCurve(NamedTuple):
    """A curve of a body, x'(t) and y'(t) in m: t stands for its parameter, which goes to 2π."""

    body: int
    x: sympy.Expr
    y: sympy.Expr


@dataclass(frozen=True)
class ScenePicture:
    """What a scene looks like, in the coordinates and parameters of its equations.

    The layouts of its bodies have expressions in place of slots. Places of its shapes are `Place`
    of expressions, bodies `BodyNumber`, curves `PlaneCurve`.
    """

    bodies: tuple[BodyLayout, ...]  # the ground first
    symbols: tuple[Symbol, ...]
    # parameters that nothing but the picture contains, and their values
    constants: tuple[tuple[sympy.Symbol, float], ...] = ()


NO_PICTURE = ScenePicture((), ())


def scene_picture(
    ground: Body, bodies: Bodies, elements: Mapping[str, list[Element]],
    parameters: Mapping[str, float], known: frozenset[str],
) -> ScenePicture:  # fmt: skip
    """The picture of the bodies that take part and of the elements that act, by their role.

    Of all parameters with their values the equations contain those that are `known`.
    """
    hubs = _hubs([e for e in elements["joint"] if e.kind == "revolute"])
    numbers = {body: k for k, body in enumerate((ground, *bodies))}
    found = [
        Symbol(element.name, element.kind, role, _numbered(shape, numbers))
        for role, members in elements.items()
        for element in members
        for shape in _shapes(element, role, hubs)
    ]
    found += [*_bulks(bodies, found, numbers)]
    found += [
        Symbol(body.name, "body", "body", _numbered(Form(body.at(0, 0, 0), form.text), numbers))
        for body in numbers
        if isinstance(body, SpaceBody)
        for form in body.forms
    ]
    constants = tuple(
        (Parameter(name, real=True), value)
        for name, value in parameters.items()
        if name not in known
    )
    frames = tuple(
        BodyLayout(body.name, bool(body.fixed), (*body.position, *turn), body.outlines)
        for body in numbers
        for turn in (_turn(body),)
    )
    return ScenePicture(frames, tuple(found), constants)


def _turn(body: Body) -> tuple[sympy.Expr, ...]:
    """The angle of a body, its cosine and sine, or its Euler parameters."""
    if isinstance(body, SpaceBody):
        return body.p
    return body.rotation if body.angle is None else (body.angle,)


def _bulks(
    bodies: Bodies, found: Iterable[Symbol], numbers: Mapping[Body, int]
) -> Iterator[Symbol]:
    """The shapes, by mass and inertia, of bodies in space that are held at one place or none."""
    pairs = [one.shape for one in found if isinstance(one.shape, Pair)]
    held = [place.body for pair in pairs for place in (pair.i, pair.j)]
    for body in bodies:
        j: Any = body.inertia
        is_loose = held.count(numbers[body]) < 2
        if isinstance(body, SpaceBody) and is_loose and None not in (body.mass, j):
            entries = (j[0, 0], j[1, 1], j[2, 2], j[0, 1], j[0, 2], j[1, 2])
            shape = Bulk(SpacePoint(body, 0, 0, 0), body.mass, *entries)
            yield Symbol(body.name, "body", "body", _numbered(shape, numbers))


def _numbered(shape: Shape, numbers: Mapping[Body, int]) -> Shape:
    """The shape with numbers for its bodies."""

    def numbered(value: Any) -> Any:
        match value:
            case SpacePoint():
                return SpacePlace(numbers[value.body], *value.place)
            case Point():
                return Place(numbers[value.body], *value.place)
            case Curve():
                return PlaneCurve(numbers[value.body], *value.at(t))
            case Body():
                return BodyNumber(numbers[value])
            case tuple() if not isinstance(value, Scoped | Slope):
                return tuple(map(numbered, value))
        return value

    return replace(shape, **{f.name: numbered(getattr(shape, f.name)) for f in fields(shape)})


def _shapes(element: Element, role: str, hubs: Hubs) -> Iterator[Shape]:
    """The shapes that an element answers, or a mark at each of its points."""
    with errors_at(label(element)):
        drawn = returned(element, "shapes", _SHAPES)
        if drawn is None:
            at = (v for v in vars(element).values() if isinstance(v, Point))
            drawn = tuple(shapes.Mark(point) for point in at)
        for shape in drawn:
            is_placed = isinstance(shape, shapes.Reaction | shapes.Exertion | Wrench)
            yield shape if is_placed else _with_points(shape, hubs)
            if isinstance(shape, shapes.Contact) and shape.gap is not None:
                yield from _contact_sides(shape)
        if role != "force":
            yield from _reaction(element)


def _with_points(shape: Shape, hubs: Hubs) -> Shape:
    """The shape with points for its bodies."""
    values = {f.name: getattr(shape, f.name) for f in fields(shape)}
    bodies = {name: value for name, value in values.items() if isinstance(value, Body)}
    points = [value.body for value in values.values() if isinstance(value, Point)]
    pair = frozenset((*points, *bodies.values()))
    return replace(shape, **{name: _hub_of(body, pair, hubs) for name, body in bodies.items()})


def _hub_of(body: Body, pair: frozenset[Any], hubs: Hubs) -> Point:
    """The pin of a pair of bodies, else that of the body on the ground, else its origin."""
    grounded = (
        ends for both, ends in hubs.items()
        if body in both and any(other.fixed for other in both - {body})
    )  # fmt: skip
    ends = hubs.get(pair) or next(grounded, ())
    return next((end for end in ends if end.body is body), Point(body, 0, 0))


def _contact_sides(contact: shapes.Contact) -> Iterator[shapes.ContactSide]:
    """A contact as each of its moving bodies has it whose pose is x, y and φ."""
    gap = plain_expression(contact.gap)
    moving = [body for body in dict.fromkeys(contact.bodies) if not body.fixed]
    for body in moving:
        plane, angle = body.position, body.angle
        if not all(isinstance(q, Coordinate) for q in plane):
            continue
        if body.turns and not isinstance(angle, Coordinate):
            continue
        own = {*plane, angle}
        slopes = [derivative(gap, q) for q in plane]
        alone = len(moving) == 1 and own.issuperset(kinds(gap, Coordinate))
        level = not any(kinds(slope, Coordinate, Time) for slope in slopes)
        gx, gy = (Slope(gap, (q,)) for q in plane)
        turn, bend, third = (
            Slope(gap, (angle,) * k) if body.turns else sympy.S.Zero for k in (1, 2, 3)
        )
        yield shapes.ContactSide(
            body, gx, gy, turn, contact.force, gap, bend, third, is_grounded=alone, is_level=level,
            is_fixed=level and not kinds(gap, Time), is_stop=contact.is_stop,
        )  # fmt: skip


def _hubs(joints: list[Element]) -> Hubs:
    """Two bodies → the points at which a pin connects them."""
    hubs: Hubs = {}
    for joint in joints:
        ends = [v for v in vars(joint).values() if isinstance(v, Point)]
        if len(ends) == 2:
            hubs.setdefault(frozenset(end.body for end in ends), tuple(ends))
    return hubs


def _reaction(element: Any) -> Iterator[Shape]:
    """The axes of a joint's reaction, and where it acts, on the body that it is told of."""
    statement, reaction = statement_of(element), statement_of(element).reaction
    if isinstance(reaction, WrenchReaction) and len(element.bodies) > 1:
        of, at = reaction.on, reaction.on.s
        x = statement.bindings[of.r[0]]
        by, on = sorted(element.bodies[:2], key=lambda body: body.position[0] == x)
        if reaction.arm is not None:
            at = of.A.T * reaction.arm
        yield Wrench(by, SpacePoint(on, *at.xreplace(statement.bindings)))
    if not isinstance(reaction, JointReaction) or len(element.bodies) < 2:
        return
    frame = reaction.on
    on, by = sorted(element.bodies[:2], key=lambda b: b.position[0] != statement.bindings[frame.x])
    on, by = (on, by)[:: reaction.sign]
    at = frame.point if reaction.arm is None else frame.r + reaction.arm
    x, y, ux, uy = (Scoped(e, statement.bindings) for e in (*at, *reaction.direction))
    yield shapes.Reaction(by, on, x, y, ux, uy)
