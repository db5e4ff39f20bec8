"""What elements, joints and bodies return, each asked by one function, and checked once."""

from collections.abc import Callable, Mapping
from itertools import chain
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body, Curve
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.declare.element_fields import field_conditions
from codegen.declare.returned_kinds import (
    Kind,
    by_coordinate,
    check_attribute,
    choice,
    expression,
    named,
    one_of,
    position_scalar,
    record,
    refusal,
    returned,
    rows,
    several,
    unit,
    words,
)
from codegen.declare.symbols import KINDS, Coordinate, Velocity, alpha, kinds
from codegen.errors import ModelError
from codegen.readers.arguments import optional
from codegen.readers.values import KindError, finite_float, one_line, shown

Weights = tuple[tuple[str, sympy.Expr, sympy.Expr], ...]
"""(body, mass, acceleration) of the products that stand in a potential as one number."""


def _first(row: tuple[Any, ...]) -> str:
    return str(row[0])


def _slip(value: Any) -> sympy.Expr:
    slip = expression(value)
    if not kinds(slip, Velocity):
        raise KindError(
            f"is {shown(slip)}, without a velocity; give the rate at which the surfaces slip."
        )
    return slip


def _law(value: Any) -> el.FrictionLaw:
    law: el.FrictionLaw = _FRICTION(value)
    if law.creep is not None and law.creep.is_number and not law.creep.is_positive:
        raise KindError(f"has the creep speed {law.creep}; give a positive speed, or None.")
    return law


def _hold(value: Any) -> el.Hold:
    hold: el.Hold = _HOLD(value)
    if isinstance(hold, el.OneWay) and any(
        kinds(hold.slip.diff(v), Velocity) for v in kinds(hold.slip, Velocity)
    ):  # whose change in an impact does not follow from impulses alone
        raise KindError(
            f"has the slip {shown(hold.slip)}, no linear function of velocities; give the rate of "
            "a scalar."
        )
    if isinstance(hold, el.Sticking) and hold.static is not None and hold.kinetic.is_nonpositive:
        raise KindError(
            f"has the coefficient {hold.kinetic}, beside a static one; give a positive number."
        )
    return hold


def _measures(value: Any) -> tuple[el.Measure, ...]:
    return tuple(el.Measure(*row) for row in _MEASURES(value))


def _condition(value: Any) -> Condition:
    condition: Condition = _CONDITION(value)
    try:
        condition.sentence.format(*(0.5 for _ in condition.numbers))
    except (AttributeError, LookupError, ValueError):
        raise KindError(
            f"has the sentence {shown(condition.sentence)}, which does not fit its "
            f"{len(condition.numbers)} numbers; write them as {{:g}} or {{0:.3g}}, and braces "
            "twice."
        ) from None
    return condition


def _bound(value: Any) -> float:
    number = finite_float(value)
    if number is None:
        raise KindError(f"is {shown(value)}; give a finite number, or None.")
    return number


def _statement(value: Any) -> el.Statement:
    statement: el.Statement = _STATEMENT(value)
    names, count, reaction = statement.rows, len(statement.phi), statement.reaction
    if len({*names}) != count or len(names) != count:
        raise KindError(f"has the rows {names}; give {count} words, one an equation.")
    if isinstance(reaction, el.ConjugateReaction) and len(reaction.components) != count:
        raise KindError(f"has the reactions {reaction.components}; give {count}, one an equation.")
    return statement


def _vector(value: Any) -> sympy.Matrix:
    """Two components, of a matrix or a sequence."""
    if isinstance(value, sympy.MatrixBase):
        return value
    try:
        parts = [*value]
    except TypeError:
        raise refusal(value, "a pair of components") from None
    return sympy.Matrix([*map(expression, parts)])


def _closed_curve(value: Any) -> Curve:
    if not isinstance(value, Curve):
        raise refusal(value, _PROFILE)
    value.at(alpha)  # ModelError where it is no curve of a body
    return value


_LOAD = "a tuple of loads, each of sums of (component, factor)"
_FRICTION = record(
    el.FrictionLaw, needed="a FrictionLaw or None", joint=words, strength=expression,
    creep=optional(expression), along=position_scalar, unit=unit,
    contacts=several(several(rows(_LOAD, words, expression), _LOAD, 1), _LOAD, 1),
)  # fmt: skip
_HOLD = record(
    el.Sticking, el.Rigid, el.OneWay, needed="a Sticking, a Rigid, a OneWay or None", slip=_slip,
    kinetic=expression, static=optional(expression), gap=position_scalar, restitution=expression,
    scale=expression,
)  # fmt: skip
_MEASURES = rows(
    "a tuple of Measure(quantity, component, unit, value, along)", choice(*el.QUANTITIES),
    lambda text: text and words(text), unit, expression, optional(position_scalar),
    unique=lambda row: el.Measure(*row).row,
)  # fmt: skip
_CONDITION = record(
    Condition, needed="a tuple of Condition", low=optional(_bound), high=optional(_bound),
    numbers=several(expression, "a tuple of numbers"),
)  # fmt: skip
_JOINT_REACTION = record(
    el.JointReaction, el.ConjugateReaction,
    needed="a JointReaction, a ConjugateReaction or None",
    on=one_of(el.Frame, needed="the frame I or J"),
    sign=choice(1, -1),
    direction=_vector, arm=optional(_vector),
    components=rows("pairs of a word and a unit", words, unit, unique=_first),
)  # fmt: skip
_OWN = "pairs (row, coordinate)"
_STATEMENT = record(
    el.Statement, needed="a Statement", phi=several(expression, "a tuple of equations, (phi,)", 1),
    rows=several(words, "a tuple of words"), reaction=optional(_JOINT_REACTION),
    own=rows(_OWN, words, one_of(Coordinate, needed=_OWN), unique=lambda row: str(row[1])),
)  # fmt: skip
_SENTENCES = several(one_of(str, needed="a list of sentences"), "a list of sentences")
_PROFILE = "a tuple of pairs (curve, whether it has to be convex)"


def _asked(word: str, kind: Kind, otherwise: Any = None) -> Callable[..., Any]:
    """The function that asks an element, with the bodies of a scene where the method takes them."""
    return lambda element, bodies=None: returned(element, word, kind, bodies, otherwise)


statement_of: Callable[[Any], el.Statement] = _asked("statement", _statement)
_conditions_of = _asked("conditions", several(_condition, "a tuple of Condition"), ())
friction_law: Callable[[Any], el.FrictionLaw | None] = _asked("friction", optional(_law))
forces_of: Callable[..., dict[Coordinate, sympy.Expr]] = _asked("forces", by_coordinate)
potential_of: Callable[..., sympy.Expr | None] = _asked("potential", optional(expression))
weights_of: Callable[..., Weights] = _asked(
    "weights", rows("a tuple of rows (body, mass, acceleration)", words, expression, expression), ()
)
measures_of: Callable[..., tuple[el.Measure, ...] | None] = _asked("measures", optional(_measures))
_hold_of = _asked("hold", optional(_hold))
_pulls_of = _asked(
    "pulls", rows("a tuple of pairs (scalar, force)", position_scalar, expression), ()
)
_reported_of = _asked(
    "reported",
    rows("a tuple of rows (component, unit, value)", words, unit, expression, unique=_first),
    (),
)
_problems_of = _asked("problems", _SENTENCES)
_profiles_of = _asked("profiles", rows(_PROFILE, _closed_curve, one_of(bool, needed=_PROFILE)), ())


def check_parts(element: Any) -> None:
    """Check the bodies that an element takes hold of, or the coordinates of a body, once."""
    if isinstance(element, Body):
        needed = f"a tuple of coordinates of '{element.name}', of letters that are declared"

        def own(value: Any) -> None:
            if not isinstance(value, tuple) or not all(
                isinstance(q, Coordinate) and q.letter in KINDS and q.owner == element.name
                for q in value
            ):
                raise refusal(value, needed)

        check_attribute(element, "coordinates", own)
        return
    bodies = "a tuple of bodies"
    check_attribute(element, "bodies", several(one_of(Body, needed=bodies), bodies))
    check_attribute(element, "instead_of", optional(one_of(Body, needed="a body or None")))


def problems_of(element: Any) -> list[str]:
    """The problems that an element finds itself, and those of numbers that no parameter changes."""
    where = label(element)
    lines = [one_line(problem, 1000) for problem in _problems_of(element)]
    found = [line if where in line else f"{where}: {line}" for line in lines]
    for condition in conditions_of(element):
        if condition.known and not condition.varies:
            found += condition.problems(where, {})
    return found


def conditions_of(element: Any) -> tuple[Condition, ...]:
    """What an element, and its fields, ask of its numbers; a modeller's own need not ask any."""
    return (*_conditions_of(element), *field_conditions(element))


def replaced_body(element: Any) -> Body | None:
    """The body instead of which a link stands, for elements that have one."""
    body: Body | None = getattr(element, "instead_of", None)
    return body


def own_coordinates(constraint: Any) -> tuple[Coordinate, ...]:
    """The coordinates that a sound joint brings itself."""
    try:
        sound = not problems_of(constraint)
        return tuple(q for _, q in statement_of(constraint).own) if sound else ()
    except ModelError:  # reported where the joint is checked
        return ()


def place_near(
    constraint: Any, coordinates: list[Coordinate], numbers: Mapping[sympy.Symbol, float]
) -> dict[Coordinate, float]:
    """Where a joint expects its own `coordinates`; empty for joints that say nothing of it."""
    near = getattr(constraint, "near", None)
    if not coordinates or near is None:
        return {}
    with named(constraint, "near()"):
        value = near(dict(numbers))
        places = {q: finite_float(value.get(q)) for q in coordinates} if value else {}
        if not places or None in places.values():
            raise refusal(value, "a dictionary with a finite number for each own coordinate")
    return places  # type: ignore[return-value]


def closed_curves(constraint: Any) -> tuple[tuple[str, Curve, bool], ...]:
    """The closed curves of a joint: how messages name each, and whether it has to be convex."""
    return tuple(
        (f"curve of '{constraint.name}' on body '{curve.body.name}'", curve, convex)
        for curve, convex in _profiles_of(constraint)
    )


def optional_terms(effect: Any, bodies: tuple[Body, ...]) -> el.OptionalTerms:
    """What the methods return that not every effect has."""
    law, hold = friction_law(effect), _hold_of(effect, bodies)
    if law and law.creep is None and not isinstance(hold, el.Sticking):
        raise ModelError(
            f"{label(effect)}: its friction() has no creep speed, so that it sticks, but "
            "hold() returns no Sticking; return one, or give creep=."
        )
    return el.OptionalTerms(law, hold, _pulls_of(effect, bodies), _reported_of(effect, bodies))


def effect_expressions(effect: Any, bodies: tuple[Body, ...]) -> list[sympy.Basic]:
    """All expressions that an effect returns, and the coordinates on which it acts."""
    forces = forces_of(effect, bodies)
    law, hold, pulls, reported = optional_terms(effect, bodies)
    found: list[Any] = [*forces, *forces.values(), potential_of(effect, bodies), *chain(*pulls)]
    found += [value for _, _, value in reported]
    for measure in measures_of(effect, bodies) or ():
        found += (measure.value, measure.along)
    found += vars(hold).values() if hold else ()
    if law:
        found += (law.strength, law.creep, law.along)
        found += (factor for load in law.contacts for entry in load for _, factor in entry)
    found += chain.from_iterable(rest for _, *rest in weights_of(effect, bodies))
    return [e for e in found if e is not None]
