"""What joints and drivers return: equations, reactions, coordinates of their own, closed curves."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from operator import is_
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body, Curve
from codegen.declare.return_values.calls import (
    WORDS,
    call_method,
    call_optional_method,
    call_user_code,
    expression,
    has_attribute,
    name,
    once,
    refusal,
    refuse_duplicates,
    rows,
    unit,
)
from codegen.declare.return_values.elements import problems_of
from codegen.declare.symbols import KINDS, Coordinate, alpha, kinds, symbols_in
from codegen.errors import FAILURES, ModelError
from codegen.plain_values import plain_float, shown

COMPONENTS = ("fx", "fy", "torque")


def statement_of(constraint: Any) -> el.Statement:
    """The equations of a joint or driver, their form checked."""
    statement: el.Statement = once(constraint, "statement", partial(_read_statement, constraint))
    return statement


def _read_statement(constraint: Any) -> el.Statement:
    value = call_method(constraint, "statement")
    if not isinstance(value, el.Statement):
        raise refusal(constraint, "statement()", value, "a Statement")
    where = el.label(constraint)
    given, words, bindings = (vars(value)[word] for word in ("phi", "rows", "bindings"))
    if not isinstance(given, tuple) or not given:
        form = type(given).__name__
        raise ModelError(
            f"{where}: its phi is of type {form}; give a tuple, of one equation (phi,)."
        )
    phi = tuple(expression(constraint, "statement() among phi", e) for e in given)
    listed = words if isinstance(words, tuple | list) else ()
    if len(listed) != len(phi) or not all(
        isinstance(r, str) and WORDS.fullmatch(r) for r in listed
    ):
        raise ModelError(
            f"{where}: its rows {shown(words)} must be {len(phi)} ASCII words, one an equation."
        )
    refuse_duplicates(constraint, "rows", list(listed))
    if not all(isinstance(place, sympy.Expr) for place in bindings):
        raise refusal(constraint, "bindings", bindings, "a placeholder")
    reaction = _reaction(constraint, vars(value)["reaction"], len(phi))
    if not (all(map(is_, phi, given)) and listed is words and reaction is value.reaction):
        value = replace(value, phi=phi, rows=tuple(listed), reaction=reaction)
    _check_own_coordinates(constraint, value)
    return value


def bound_symbols(statement: el.Statement, expressions: tuple[sympy.Basic, ...]) -> set[Any]:
    """The symbols of expressions whose placeholders are bound."""
    symbols: set[Any] = set().union(*map(symbols_in, expressions))
    for place, value in statement.bindings.items():
        if places := symbols_in(place) & symbols:
            symbols = (symbols - places) | {_Bound(s) for s in symbols_in(value)}
    return {s.symbol if isinstance(s, _Bound) else s for s in symbols}


class _Bound:
    """A symbol that was put in for a placeholder, and may have the name of another one."""

    def __init__(self, symbol: sympy.Basic) -> None:
        self.symbol = symbol


def _check_own_coordinates(constraint: Any, statement: el.Statement) -> None:
    """Refuse coordinates that are not the joint's own, or that their row does not determine."""
    where, needed = el.label(constraint), "pairs (row, coordinate)"
    owned = rows(constraint, "own", statement.own, 2, needed)
    for row, own in owned:
        if row not in statement.rows or not isinstance(own, Coordinate) or own.letter not in KINDS:
            raise refusal(constraint, "own", statement.own, needed)
        if own.owner != constraint.name:
            raise ModelError(
                f"{where}: its own coordinate {own} belongs to '{own.owner}'; bring "
                f"coordinate('{constraint.name}', '{own.letter}')."
            )
        phi = statement.phi[statement.rows.index(row)]
        if own not in bound_symbols(statement, (phi,)):
            raise ModelError(
                f"{where}: its own coordinate {own} does not occur in the equation '{row}', which "
                "is to determine it; name the row that does."
            )
    for k, word in enumerate(("rows", "coordinates")):
        refuse_duplicates(constraint, f"own, among {word},", [str(pair[k]) for pair in owned])


def _reaction(constraint: Any, reaction: Any, count: int) -> Any:
    if isinstance(reaction, el.ConjugateReaction):
        parts = reaction.components
        try:
            pairs = rows(constraint, "reaction", parts, 2, "")
            for component, measure in pairs:
                name(constraint, "reaction", component)
                unit(constraint, "reaction", measure)
        except ModelError:
            pairs = ()
        if len(pairs) != count:
            raise ModelError(
                f"{el.label(constraint)}: its reactions {shown(parts)} must be {count} pairs of a "
                "word and a unit."
            )
        refuse_duplicates(constraint, "reactions", [component for component, _ in pairs])
    elif isinstance(reaction, el.JointReaction):
        on, sign = vars(reaction)["on"], vars(reaction)["sign"]
        if not isinstance(on, el.Frame) or sign not in (1, -1):
            raise refusal(constraint, "reaction", reaction, "a frame I or J, and a sign 1 or -1")
        for word in ("direction", "arm"):
            vector = vars(reaction)[word]
            if not isinstance(vector, sympy.MatrixBase) and (vector is not None or word != "arm"):
                axis = _vector(constraint, f"{word} of its reaction", vector)
                reaction = replace(reaction, **{word: axis})
    elif reaction is not None:
        needed = "a JointReaction, a ConjugateReaction or None"
        raise refusal(constraint, "reaction", reaction, needed)
    return reaction


def _vector(constraint: Any, word: str, vector: Any) -> sympy.Matrix:
    """Two components, of a sequence."""
    if not isinstance(vector, tuple | list | sympy.Tuple) or not vector:
        raise refusal(constraint, word, vector, "a pair of components")
    return sympy.Matrix([expression(constraint, word, component) for component in vector])


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
    if not coordinates or not has_attribute(constraint, "near"):
        return {}
    value = call_user_code(constraint, "near()", lambda: constraint.near(dict(numbers)))
    try:
        places = {q: plain_float(value[q]) for q in coordinates}
        if all(map(math.isfinite, places.values())):
            return places
    except FAILURES:  # of a mapping or a number of the modeller's own
        pass
    needed = "a dictionary with a finite number for each own coordinate"
    raise refusal(constraint, "near()", value, needed)


def closed_curves(constraint: Any) -> tuple[tuple[str, Curve, bool], ...]:
    """The closed curves of a joint: how messages name each, and whether it has to be convex."""
    needed = "a tuple of pairs (curve, whether it has to be convex)"
    value = call_optional_method(constraint, "profiles", ())
    pairs = rows(constraint, "profiles()", value, 2, needed)
    for curve, convex in pairs:
        if not isinstance(curve, Curve) or not isinstance(convex, bool):
            raise refusal(constraint, "profiles()", value, needed)
        if not isinstance(curve.body, Body):
            raise refusal(constraint, "profiles() among bodies", curve.body, "a body")
        shape = call_user_code(constraint, "curve in profiles()", partial(curve.at, alpha))
        for place in shape:
            expression(constraint, "profiles()", place)
    return tuple(
        (f"curve of '{constraint.name}' on body '{curve.body.name}'", curve, convex)
        for curve, convex in pairs
    )


def moving_frame_problem(constraint: Any, statement: el.Statement) -> str | None:
    """Why a reaction cannot be found: the frame that it acts on is bound to no body."""
    reaction = statement.reaction
    if not isinstance(reaction, el.JointReaction) or reaction.on.x in statement.bindings:
        return None
    if kinds(sympy.Tuple(*statement.phi), Coordinate) and reaction.on.name:
        frame = reaction.on.name
        return (
            f"{el.label(constraint)}: its reaction acts on frame {frame}, which its bindings bind "
            f"to no body; add {frame.upper()}.bind(point), or return a ConjugateReaction."
        )
    return None
