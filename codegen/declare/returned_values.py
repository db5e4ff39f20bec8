"""Calls of the methods of elements and bodies: one function for each, which checks the result once.

A modeller's own element may return anything: an exception, or a value of another kind than a reader
demands, is a `ModelError` that names the element, the method and the value.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import wraps
from itertools import chain
from typing import Any, TypeVar

import sympy

from codegen.declare import element as el
from codegen.declare.body import Bodies, Body, Curve, Loads
from codegen.declare.element_fields import Condition, Conditions, field_conditions
from codegen.declare.symbols import KINDS, Coordinate, Time, Velocity, alpha, kinds, nonlinear_in
from codegen.errors import LinkwrightError, ModelError
from codegen.readers.arguments import (
    Reader,
    flag,
    mapping,
    number,
    one_of,
    optional,
    read_arguments,
    row,
    several,
    word,
)
from codegen.readers.calls import failure
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import known_unit
from codegen.readers.values import KindError, finite_float, one_line, shown

WORDS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ ^/.-]*")
Function = TypeVar("Function", bound=Callable[..., Any])
# What methods returned in this build: (element, method, bodies) → (element, bodies, value)
_Known = dict[tuple[int, str, tuple[int, ...]], tuple[Any, Any, Any]]
_known: ContextVar[_Known | None] = ContextVar("known", default=None)
Weights = tuple[tuple[str, sympy.Expr, sympy.Expr], ...]
"""(body, mass, acceleration) of the products that stand in a potential as one number."""


def memoize_methods(function: Function) -> Function:
    """Within the function, each method is called once: what is checked is what is compiled."""

    @wraps(function)
    def call(*arguments: Any, **words: Any) -> Any:
        before = _known.set({})
        try:
            return function(*arguments, **words)
        finally:
            _known.reset(before)

    return call  # type: ignore[return-value]


def returned(
    element: Any, method: str, reader: Reader, bodies: Bodies | None = None, otherwise: Any = None
) -> Any:
    """What a method returns, as it is read, found once within `memoize_methods`.

    It is called with the bodies of a scene where it takes them. Not every element has every method:
    one without has `otherwise`. ModelError, which names the element and the method, if it fails.
    """
    known, key = _known.get(), (id(element), method, tuple(map(id, bodies or ())))
    if known is not None and key in known:
        return known[key][-1]
    value = otherwise
    with named(element, f"{method}()"):
        if (function := getattr(element, method, None)) is not None:
            given = function() if bodies is None else function(bodies)
            value = read_part(element, f"what its {method}() returns", reader, given)
    if known is not None:
        known[key] = element, bodies, value  # which keeps the ids theirs
    return value


def check_attribute(element: Any, attribute: str, reader: Reader) -> None:
    """Check an attribute of an element or body, None where there is none."""
    with named(element, attribute):
        read_part(element, f"its {attribute}", reader, getattr(element, attribute, None))


def read_part(element: Any, what: str, reader: Reader, given: Any) -> Any:
    """What an element or body gave, as it is read; a ModelError names it and says `what` it is."""
    return read_arguments(el.label(element), {what: reader}, {what: given}, ModelError)[what]


@contextmanager
def named(element: Any, what: str) -> Iterator[None]:
    """A block that asks a modeller's element for something: its errors name both."""
    where = el.label(element)
    try:
        yield
    except LinkwrightError as error:
        problems = (p if where in p else f"{where}, {what}: {p}" for p in error.problems)
        raise ModelError(problems) from error
    except Exception as error:
        raise ModelError(f"{where}: its {what} fails with {failure(error)}.") from error


def expression(value: Any) -> sympy.Expr:
    """A number or expression."""
    try:
        return plain_expression(value)
    except KindError:
        raise KindError("it must be an expression.") from None


def expression_that(demand: str, holds: Callable[[sympy.Expr], Any]) -> Reader:
    """A number or expression of which something holds."""

    def read(value: Any) -> sympy.Expr:
        found = expression(value)
        if not holds(found):
            raise KindError(f"it must be {demand}.")
        return found

    return read


def words(value: Any) -> str:
    """A few ASCII words, fit for the generated text."""
    if not isinstance(value, str) or not WORDS.fullmatch(value):
        raise KindError("it must be ASCII words.")
    return value


def unit(value: Any) -> str:
    """A unit as a parameter may have it, or ASCII words; empty for a pure number."""
    is_word = isinstance(value, str) and value.isprintable()
    if is_word and (WORDS.fullmatch(value) or known_unit(value)):
        return str(value)
    raise KindError("it must be a unit, such as 'N m'.")


def rows(demand: str, *entries: Reader, name: Callable[[Any], str] | None = None) -> Reader:
    """Rows with these entries; `name` gives the name of a row, which no other may have."""
    read = several(row(demand, *entries), demand)

    def read_rows(value: Any) -> Any:
        found = read(value)
        names = [name(one) for one in found] if name else []
        if twice := next((n for k, n in enumerate(names) if n in names[:k]), None):
            raise KindError(f"it has '{twice}' twice; give each a name.")
        return found

    return read_rows


def record(demand: str, *classes: type[Any], **fields: Reader) -> Reader:
    """A dataclass of one of the classes, with those of the fields read that it has."""
    read = one_of(demand, *classes)

    def read_record(value: Any) -> Any:
        found = read(value)
        given = {word: getattr(found, word) for word in fields if hasattr(found, word)}
        return replace(found, **read_arguments(type(found).__name__, fields, given, ModelError))

    return read_record


def _first(one: tuple[Any, ...]) -> str:
    return str(one[0])


def _hold(value: Any) -> el.Hold:
    hold: el.Hold = _HOLD(value)
    if isinstance(hold, el.OneWay) and nonlinear_in(hold.slip):  # impulses give no change of it
        raise KindError("its slip must be a linear function of velocities, the rate of a scalar.")
    if isinstance(hold, el.Sticking) and hold.static is not None and hold.kinetic.is_nonpositive:
        raise KindError("beside a static coefficient the kinetic one must be positive.")
    return hold


def _measures(value: Any) -> el.Measures:
    return tuple(el.Measure(*one) for one in _MEASURES(value))


def _condition(value: Any) -> Condition:
    condition: Condition = _CONDITION(value)
    count = len(condition.numbers)
    try:
        condition.sentence.format(*(0.5 for _ in condition.numbers))
    except (AttributeError, LookupError, ValueError):
        raise ModelError(
            f"the sentence {shown(condition.sentence)} of a condition does not fit its {count} "
            "numbers; write them as {:g} or {0:.3g}, and braces twice."
        ) from None
    return condition


def _statement(value: Any) -> el.Statement:
    statement: el.Statement = _STATEMENT(value)
    names, count, reaction = statement.rows, len(statement.phi), statement.reaction
    if len({*names}) != count or len(names) != count:
        raise KindError(f"give {count} rows, a word for each equation, in place of {names}.")
    if isinstance(reaction, el.ConjugateReaction) and len(reaction.components) != count:
        raise KindError(f"give {count} reactions, one an equation.")
    return statement


def _vector(value: Any) -> sympy.Matrix:
    """Two components, of a matrix or a sequence."""
    if isinstance(value, sympy.MatrixBase):
        return value
    try:
        return sympy.Matrix([*map(expression, value)])
    except TypeError:
        raise KindError("it must be a pair of components.") from None


def _closed_curve(value: Any) -> Curve:
    curve: Curve = one_of(_PROFILE, Curve)(value)
    curve.at(alpha)  # ModelError where it is no curve of a body
    return curve


_scalar = expression_that(
    "an expression of coordinates, t and parameters, without a velocity, that something moves",
    lambda scalar: kinds(scalar, Coordinate, Time) and not kinds(scalar, Velocity),
)
_SLIP = "an expression with a velocity, the rate at which surfaces slip"
_slip = expression_that(_SLIP, lambda slip: kinds(slip, Velocity))
_creep = expression_that(
    "a positive speed, or None", lambda speed: speed.is_positive or not speed.is_number
)
_along = expression_that(
    "an expression that something moves, or a linear function of velocities",
    lambda along: kinds(along, Coordinate, Time, Velocity) and not nonlinear_in(along),
)
_FINITE = optional(number("a finite number, or None"))
_LOAD = "a tuple of loads, each of sums of (component, factor)"
_LAW = record(
    "a FrictionLaw or None", el.FrictionLaw, joint=words, strength=expression,
    creep=optional(_creep), unit=unit,
    along=lambda s: (several(_along, "slips", 1) if isinstance(s, tuple) else _along)(s),
    contacts=several(several(rows(_LOAD, words, expression), _LOAD, 1), _LOAD, 1),
)  # fmt: skip
_HOLD = record(
    "a Sticking, a Rigid, a OneWay or None", el.Sticking, el.Rigid, el.OneWay, slip=_slip,
    kinetic=expression, static=optional(expression), gap=_scalar, restitution=expression,
    scale=expression,
)  # fmt: skip
_MEASURES = rows(
    "a tuple of Measure(quantity, component, unit, value, along), the quantity one of "
    f"{', '.join(el.QUANTITIES)}, the value an expression, along a scalar that moves, or None",
    word(*el.QUANTITIES), lambda text: text and words(text), unit, expression,
    optional(_scalar), name=lambda one: el.Measure(*one).row,
)  # fmt: skip
_CONDITION = record(
    "a Condition", Condition, low=_FINITE, high=_FINITE,
    numbers=several(expression, "a tuple of numbers"),
)  # fmt: skip
_JOINT_REACTION = record(
    "a JointReaction, a ConjugateReaction or None", el.JointReaction, el.ConjugateReaction,
    el.WrenchReaction, on=one_of("the frame I or J", *el.FRAMES), sign=word(1, -1),
    direction=_vector, arm=optional(_vector), tension=optional(expression),
    components=rows("pairs of a word and a unit", words, unit, name=_first),
)  # fmt: skip
_OWN = "pairs (row, coordinate)"
_STATEMENT = record(
    "a Statement", el.Statement, phi=several(expression, "a tuple of equations, (phi,)", 1),
    rows=several(words, "a tuple of ASCII words"), reaction=optional(_JOINT_REACTION),
    own=rows(_OWN, words, one_of(_OWN, Coordinate), name=lambda one: str(one[1])),
)  # fmt: skip
_PROFILE = "a tuple of pairs (curve, whether it has to be convex)"
LOADS = "a dictionary, coordinate: expression"
_by_coordinate = mapping(LOADS, one_of("a coordinate", Coordinate), expression)


def _asked(method: str, reader: Reader, otherwise: Any = None) -> Callable[..., Any]:
    """The function that asks an element, with the bodies of a scene where the method takes them."""
    return lambda element, bodies=None: returned(element, method, reader, bodies, otherwise)


statement_of: Callable[[Any], el.Statement] = _asked("statement", _statement)
_conditions_of = _asked("conditions", several(_condition, "a tuple of Condition"), ())
friction_law: Callable[[Any], el.FrictionLaw | None] = _asked("friction", optional(_LAW))
forces_of: Callable[..., Loads] = _asked("forces", _by_coordinate)
potential_of: Callable[..., sympy.Expr | None] = _asked("potential", optional(expression))
_WEIGHTS = "rows (body, mass, acceleration)"
weights_of: Callable[..., Weights] = _asked(
    "weights", rows(_WEIGHTS, words, expression, expression), ()
)
measures_of: Callable[..., el.Measures | None] = _asked("measures", optional(_measures))
_hold_of = _asked("hold", optional(_hold))
_pulls_of = _asked(
    "pulls",
    rows("a tuple of pairs (scalar of positions that moves, force)", _scalar, expression),
    (),
)
_REPORTED = "a tuple of rows (component in ASCII words, unit such as 'N m', expression)"
_reported_of = _asked("reported", rows(_REPORTED, words, unit, expression, name=_first), ())
_problems_of = _asked("problems", several(one_of("a text", str), "a list of sentences"))
_profiles_of = _asked("profiles", rows(_PROFILE, _closed_curve, flag), ())


def check_parts(element: Any) -> None:
    """Check the bodies that an element takes hold of, or the coordinates of a body, once."""
    if isinstance(element, Body):
        demand = f"a tuple of coordinates of '{element.name}', of letters that are declared"

        def own(q: Any) -> None:
            if not isinstance(q, Coordinate) or q.letter not in KINDS or q.owner != element.name:
                raise KindError

        check_attribute(element, "coordinates", several(own, demand))
        return
    check_attribute(element, "bodies", several(one_of("a body", Body), "a tuple of bodies"))
    check_attribute(element, "instead_of", optional(one_of("a body or None", Body)))


def problems_of(element: Any) -> list[str]:
    """The problems that an element finds itself, and those of numbers that no parameter changes."""
    where = el.label(element)
    lines = [one_line(problem, 1000) for problem in _problems_of(element)]
    found = [line if where in line else f"{where}: {line}" for line in lines]
    for condition in conditions_of(element):
        if condition.known and not condition.varies:
            found += condition.problems(where, {})
    return found


def conditions_of(element: Any) -> Conditions:
    """What an element, and its fields, ask of its numbers; a modeller's own need not ask any."""
    return (*_conditions_of(element), *field_conditions(element))


def replaced_body(element: Any) -> Body | None:
    """The body instead of which a link stands, for elements that have one."""
    return getattr(element, "instead_of", None)


def own_coordinates(constraint: Any) -> tuple[Coordinate, ...]:
    """The coordinates that a sound joint brings itself, or where a scene asks for them."""
    try:
        own = () if problems_of(constraint) else tuple(q for _, q in statement_of(constraint).own)
        return own or tuple(getattr(constraint, q) for q in getattr(constraint, "countable", ()))
    except ModelError:  # reported where the joint is checked
        return ()


def place_near(
    constraint: Any, coordinates: list[Coordinate], numbers: Mapping[sympy.Symbol, float]
) -> dict[Coordinate, float]:
    """Where a joint expects its own `coordinates`; empty for joints that say nothing of it."""

    def places(value: Any) -> dict[Coordinate, float]:
        found = {q: finite_float(value.get(q)) for q in coordinates} if value else {}
        if not found or None in found.values():
            raise KindError("it must be a dictionary with a finite number for each own coordinate.")
        return found  # type: ignore[return-value]

    near = getattr(constraint, "near", None)
    if not coordinates or near is None:
        return {}
    with named(constraint, "near()"):
        return read_part(constraint, "what its near() returns", places, near(dict(numbers)))  # type: ignore[no-any-return]


def closed_curves(constraint: Any) -> tuple[tuple[str, Curve, bool], ...]:
    """The closed curves of a joint: how messages name each, and whether it has to be convex."""
    return tuple(
        (f"curve of '{constraint.name}' on body '{curve.body.name}'", curve, convex)
        for curve, convex in _profiles_of(constraint)
    )


def optional_terms(effect: Any, bodies: Bodies) -> el.OptionalTerms:
    """What the methods return that not every effect has."""
    law, hold = friction_law(effect), _hold_of(effect, bodies)
    if law and law.creep is None and not isinstance(hold, el.Sticking):
        raise ModelError(
            f"{el.label(effect)}: its friction() has no creep speed, so that it sticks, but "
            "hold() returns no Sticking; return one, or give creep=."
        )
    return el.OptionalTerms(law, hold, _pulls_of(effect, bodies), _reported_of(effect, bodies))


def effect_expressions(effect: Any, bodies: Bodies) -> list[sympy.Basic]:
    """All expressions that an effect returns, and the coordinates on which it acts."""
    forces = forces_of(effect, bodies)
    law, hold, pulls, reported = optional_terms(effect, bodies)
    found: list[Any] = [*forces, *forces.values(), potential_of(effect, bodies), *chain(*pulls)]
    found += [value for _, _, value in reported]
    for measure in measures_of(effect, bodies) or ():
        found += (measure.value, measure.along)
    found += vars(hold).values() if hold else ()
    if law:
        found += (law.strength, law.creep, *law.slips)
        found += (factor for load in law.contacts for entry in load for _, factor in entry)
    found += chain.from_iterable(rest for _, *rest in weights_of(effect, bodies))
    return [e for e in found if e is not None]
