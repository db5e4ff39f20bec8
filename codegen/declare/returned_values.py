"""What elements, joints and bodies return, checked once, by kind.

Each function asks one thing of an element. An exception, and a value of another kind, is a
`ModelError` that names the element, the method and the value.
"""

from collections.abc import Mapping, Set
from dataclasses import replace
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body, Curve
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.declare.element_fields import field_conditions
from codegen.declare.expression_rules import expression_problem
from codegen.declare.returned_kinds import (
    Kind,
    MisfitError,
    by_coordinate,
    expression,
    named,
    one_of,
    optional,
    read,
    refusal,
    returned,
    rows,
    several,
    unit,
    with_fields,
    words,
)
from codegen.declare.symbols import KINDS, Coordinate, alpha, kinds, symbols_in
from codegen.errors import ModelError
from codegen.readers.values import finite_float, one_line, shown

COMPONENTS = ("fx", "fy", "torque")


def check_parts(element: Any) -> None:
    """Check the bodies that an element takes hold of, or the coordinates of a body, once."""
    if isinstance(element, Body):
        with named(element, "coordinates"):
            read(element, "coordinates", element.coordinates, _coordinates_of(element.name))
        return
    with named(element, "bodies"):
        is_body = one_of(Body, needed="a tuple of bodies")
        read(element, "bodies", element.bodies, several(is_body, "a tuple of bodies"))
    with named(element, "instead_of"):
        is_body = one_of(Body, needed="a body or None")
        read(element, "instead_of", replaced_body(element), optional(is_body))


def replaced_body(element: Any) -> Body | None:
    """The body instead of which a link stands, for elements that have one."""
    body: Body | None = getattr(element, "instead_of", None)
    return body


def problems_of(element: Any) -> list[str]:
    """The problems that an element finds itself, and those of numbers that no parameter changes."""
    where, needed = label(element), "a list of sentences"
    sentences = returned(element, "problems", several(one_of(str, needed=needed), needed))
    lines = (one_line(p, 1000) for p in sentences)
    found = [line if where in line else f"{where}: {line}" for line in lines]
    for condition in conditions_of(element):
        if condition.known and not condition.varies:
            found += condition.problems(where, {})
    return found


def conditions_of(element: Any) -> tuple[Condition, ...]:
    """What an element, and its fields, ask of its numbers; a modeller's own need not ask any."""
    own: tuple[Condition, ...] = returned(element, "conditions", _CONDITIONS, otherwise=())
    return (*own, *field_conditions(element))


def _condition(value: Any) -> Condition:
    """A condition of which each part is of its kind, and the sentence shows its numbers."""
    if not isinstance(value, Condition):
        raise refusal(value, "a tuple of Condition")
    numbers = several(expression, "numbers=(value, ...) in a Condition")(value.numbers)
    try:
        value.sentence.format(*(0.5 for _ in numbers))
    except (AttributeError, LookupError, ValueError):
        raise MisfitError(
            f"has the sentence {shown(value.sentence)}, which does not fit its {len(numbers)} "
            "numbers; write them as {:g} or {0:.3g}, and braces twice."
        ) from None
    low, high = (optional(_bound)(bound) for bound in (value.low, value.high))
    return replace(value, numbers=numbers, low=low, high=high)


def _bound(value: Any) -> float:
    number = finite_float(value)
    if number is None:
        raise MisfitError(f"has the bound {shown(value)}; give finite numbers.")
    return number


_CONDITIONS = several(_condition, "a tuple of Condition")


def statement_of(constraint: Any) -> el.Statement:
    """The equations of a joint or driver, their form checked."""

    def check(value: Any) -> el.Statement:
        if not isinstance(value, el.Statement):
            raise refusal(value, "a Statement")
        _check_equations(value)
        statement = with_fields(constraint, "statement()", value, _STATEMENT)
        _check_reaction(statement)
        _check_own_coordinates(constraint, statement)
        return statement

    statement: el.Statement = returned(constraint, "statement", check)
    return statement


def _check_equations(value: el.Statement) -> None:
    phi, names = (vars(value)[word] for word in ("phi", "rows"))
    if not isinstance(phi, tuple) or not phi:
        form = type(phi).__name__
        raise ModelError(f"its phi is of type {form}; give a tuple, of one equation (phi,).")
    listed = isinstance(names, tuple | list)
    if not listed or len(names) != len(phi) or len({*map(str, names)}) != len(phi):
        raise ModelError(
            f"its rows {shown(names)} must be {len(phi)} ASCII words, one an equation, all "
            "different."
        )


def _check_reaction(statement: el.Statement) -> None:
    reaction, count = statement.reaction, len(statement.phi)
    if isinstance(reaction, el.ConjugateReaction) and len(reaction.components) != count:
        raise ModelError(
            f"its reactions {shown(reaction.components)} must be {count} pairs of a word and a "
            "unit."
        )


def _reaction(value: Any) -> Any:
    if isinstance(value, el.ConjugateReaction):
        return el.ConjugateReaction(_PAIRS(value.components))
    if isinstance(value, el.JointReaction):
        on: object = value.on
        if not isinstance(on, el.Frame) or value.sign not in (1, -1):
            raise refusal(value, "a frame I or J, and a sign 1 or -1")
        arm = None if value.arm is None else _vector(value.arm)
        return el.JointReaction(_vector(value.direction), value.on, value.sign, arm)
    if value is not None:
        raise refusal(value, "a JointReaction, a ConjugateReaction or None")
    return None


def _vector(value: Any) -> sympy.Matrix:
    """Two components, of a matrix or a sequence."""
    if isinstance(value, sympy.MatrixBase):
        return value
    if not isinstance(value, tuple | list | sympy.Tuple) or not value:
        raise refusal(value, "a pair of components")
    return sympy.Matrix([*map(expression, value)])


def _own_coordinate(value: Any) -> Coordinate:
    if not isinstance(value, Coordinate) or value.letter not in KINDS:
        raise refusal(value, "pairs (row, coordinate)")
    return value


_PAIRS = rows("pairs of a word and a unit", words, unit, unique=lambda row: str(row[0]))
_STATEMENT: dict[str, Kind] = {
    "phi": several(expression, "a tuple of equations"),
    "rows": several(words, "a tuple of words"),
    "reaction": _reaction,
    "own": rows("pairs (row, coordinate)", words, _own_coordinate, unique=lambda row: str(row[1])),
}


def _check_own_coordinates(constraint: Any, statement: el.Statement) -> None:
    """Refuse coordinates that are not the joint's own, or that their row does not determine."""
    for row, own in statement.own:
        if own.owner != constraint.name:
            raise ModelError(
                f"its own coordinate {own} belongs to '{own.owner}'; bring "
                f"coordinate('{constraint.name}', '{own.letter}')."
            )
        phi = [e for e, name in zip(statement.phi, statement.rows, strict=True) if name == row]
        if own not in bound_symbols(statement, tuple(phi)):
            raise ModelError(
                f"its own coordinate {own} does not occur in the equation '{row}', which is to "
                "determine it; name the row that does."
            )


def bound_symbols(statement: el.Statement, expressions: tuple[sympy.Basic, ...]) -> set[Any]:
    """The symbols of expressions whose placeholders are bound."""
    symbols: set[Any] = set().union(*map(symbols_in, expressions))
    meanings: set[Any] = set()
    for place, value in statement.bindings.items():
        if places := symbols_in(place) & symbols:
            symbols -= places
            meanings |= symbols_in(value)
    return symbols | meanings


def reaction_components(statement: el.Statement) -> tuple[str, ...]:
    """The names under which a constraint reports its reaction."""
    reaction = statement.reaction
    if isinstance(reaction, el.ConjugateReaction):
        return tuple(component for component, _ in reaction.components)
    return () if reaction is None else COMPONENTS


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

    def check(value: Any) -> dict[Coordinate, float]:
        places = {q: finite_float(value.get(q)) for q in coordinates} if value else {}
        if not places or None in places.values():
            raise refusal(value, "a dictionary with a finite number for each own coordinate")
        return places  # type: ignore[return-value]

    with named(constraint, "near()"):
        places: dict[Coordinate, float] = read(constraint, "near()", near(dict(numbers)), check)
    return places


def closed_curves(constraint: Any) -> tuple[tuple[str, Curve, bool], ...]:
    """The closed curves of a joint: how messages name each, and whether it has to be convex."""
    curves = returned(constraint, "profiles", _PROFILES, otherwise=())
    return tuple(
        (f"curve of '{constraint.name}' on body '{curve.body.name}'", curve, convex)
        for curve, convex in curves
    )


def _closed_curve(value: Any) -> Curve:
    if not isinstance(value, Curve):
        raise refusal(value, _PROFILE)
    value.at(alpha)  # ModelError where it is no curve of a body
    return value


_PROFILE = "a tuple of pairs (curve, whether it has to be convex)"
_PROFILES = rows(_PROFILE, _closed_curve, one_of(bool, needed=_PROFILE))


def moving_frame_problem(constraint: Any, statement: el.Statement) -> str | None:
    """Why a reaction cannot be found: the frame that it acts on is bound to no body."""
    reaction = statement.reaction
    if not isinstance(reaction, el.JointReaction) or reaction.on.x in statement.bindings:
        return None
    if kinds(sympy.Tuple(*statement.phi), Coordinate) and reaction.on.name:
        frame = reaction.on.name
        return (
            f"{label(constraint)}: its reaction acts on frame {frame}, which its bindings bind "
            f"to no body; add {frame.upper()}.bind(point), or return a ConjugateReaction."
        )
    return None


def check_body(body: Body, known: Set[sympy.Symbol]) -> None:
    """Ask a body of a modeller's own everything that is asked of bodies; ModelError if wrong.

    Its expressions consist of the `known` symbols.
    """

    def sound(value: Any) -> sympy.Expr:
        checked = expression(value)
        if problem := expression_problem(checked):
            raise MisfitError(f"is wrong: {problem}")
        if unknown := sorted(s.name for s in checked.free_symbols - known):
            raise MisfitError(
                f"has the symbol {shown(unknown[0])}, which is none of the model; write it in "
                "coordinates, velocities, parameters and t."
            )
        return checked

    def scalar(value: Any) -> sympy.Expr:
        return sound(one_of(sympy.Expr, needed="an expression of SymPy")(value))

    def pair(value: Any) -> Any:
        if not isinstance(value, tuple | list) or len(value) != 2:
            raise refusal(value, "two expressions")
        return [*map(sound, value)]

    def block(value: Any) -> None:
        pairs = {(a, b) for a in body.coordinates for b in body.coordinates}
        if not isinstance(value, Mapping) or not {*value} <= pairs:
            raise refusal(value, "a dictionary, pair of coordinates: expression")
        for entry in value.values():
            optional(sound)(entry)

    def forces(value: Any) -> None:
        for force in by_coordinate(value).values():
            sound(force)

    flag = one_of(bool, needed="True or False")
    for word, kind in {
        **dict.fromkeys(("angle", "mass", "inertia"), optional(scalar)),
        "angular_velocity": scalar,
        **dict.fromkeys(("position", "velocity", "mass_centre", "rotation"), pair),
        "fixed": flag,
        "turns": flag,
        "mass_matrix": block,
        "inertia_force": forces,
        "equations": rows("pairs (word, expression)", words, sound),
    }.items():
        with named(body, word):
            read(body, word, getattr(body, word), kind)
    with named(body, "torque()"):
        read(body, "torque()", body.torque(sympy.S.One), forces)


def _coordinates_of(name: str) -> Kind:
    needed = f"a tuple of coordinates of '{name}', of letters that are declared"

    def coordinates(value: Any) -> Any:
        if not isinstance(value, tuple) or not all(
            isinstance(q, Coordinate) and q.letter in KINDS and q.owner == name for q in value
        ):
            raise refusal(value, needed)
        return value

    return coordinates
