"""What elements and bodies answer, read by kind: a modeller's own may raise or answer anything.

Each function asks one question and answers a value of one kind. An exception, and an answer of
another kind, is a `ModelError` that names the element, the question and the answer.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from operator import is_
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.expression_rules import expression_problem
from codegen.declare.plain_expression import plain_expression
from codegen.declare.symbols import KINDS, Coordinate
from codegen.declare.units import known_unit
from codegen.errors import FAILURES, LinkwrightError, ModelError
from codegen.plain_values import NotText, one_line, plain_name, shown
from codegen.public_callables import failure

WORDS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ ^/.-]*")
Pairs = tuple[tuple[Any, ...], ...]


def ask(element: Any, word: str, *arguments: Any, method: bool = True) -> Any:
    """The answer to a question, whatever it is; ModelError where it raises."""
    try:
        answer = getattr(element, word)
        return answer(*arguments) if method else answer
    except LinkwrightError as error:
        where = el.label(element)
        told = (p if where in p else f"{where}: {p}" for p in error.problems)
        raise ModelError(told) from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        call = f"{word}()" if method else word
        raise ModelError(f"{el.label(element)}: its {call} fails with {failure(error)}.") from error


def _refuse(element: Any, word: str, answer: object, needed: str) -> ModelError:
    return ModelError(f"{el.label(element)}: its {word} answers {shown(answer)}; answer {needed}.")


def _expression(element: Any, word: str, answer: Any) -> sympy.Expr:
    try:
        return plain_expression(answer)
    except FAILURES:
        raise _refuse(element, word, answer, "expressions") from None


def _sound(body: Any, word: str, answer: Any) -> sympy.Expr:
    """An expression of a body, which has no placeholders as those of elements have."""
    read = _expression(body, word, answer)
    if problem := expression_problem(read):
        raise ModelError(f"{el.label(body)}: its {word}: {problem}")
    return read


def _tuples(element: Any, word: str, answer: Any, size: int, needed: str) -> Pairs:
    """A tuple or list of tuples of one size."""
    rows = isinstance(answer, tuple | list)
    if not rows or not all(isinstance(row, tuple | list) and len(row) == size for row in answer):
        raise _refuse(element, word, answer, needed)
    return tuple(tuple(row) for row in answer)


def _word(element: Any, word: str, text: Any) -> str:
    """A few ASCII words, fit for the generated text."""
    plain = plain_name(text) if isinstance(text, str) else ""
    if not WORDS.fullmatch(plain):
        raise _refuse(element, word, text, "ASCII words where a name stands")
    return plain


def _unit(element: Any, word: str, text: Any) -> str:
    """A unit as a parameter may have it, or ASCII words; empty for a pure number."""
    plain = plain_name(text) if isinstance(text, str) else NotText()
    if isinstance(plain, NotText) or not (WORDS.fullmatch(plain) or known_unit(plain)):
        raise _refuse(element, word, text, "a unit, such as 'N m', where one stands")
    return plain


def bodies_of(element: Any) -> tuple[Body, ...]:
    """The bodies that an element takes hold of."""
    answer = ask(element, "bodies", method=False)
    if not isinstance(answer, tuple | list) or not all(isinstance(b, Body) for b in answer):
        raise _refuse(element, "bodies", answer, "a tuple of bodies")
    return tuple(answer)


def coordinates_of(body: Any) -> tuple[Coordinate, ...]:
    """The coordinates of a sound body."""
    try:
        answer = ask(body, "coordinates", method=False)
    except ModelError:  # reported where the body is checked
        return ()
    return answer if _are_coordinates(body, answer) else ()


def _are_coordinates(body: Any, answer: Any) -> bool:
    return isinstance(answer, tuple) and all(
        isinstance(q, Coordinate) and q.letter in KINDS and q.owner == body.name for q in answer
    )


def problems_of(element: Any) -> list[str]:
    """The problems that an element finds itself."""
    answer = ask(element, "problems")
    if not isinstance(answer, tuple | list) or not all(isinstance(p, str) for p in answer):
        raise _refuse(element, "problems()", answer, "a list of sentences")
    return [one_line(p, 1000) for p in answer]


def statement_of(constraint: Any) -> el.Statement:
    """The equations of a joint or driver, their form checked."""
    answer = ask(constraint, "statement")
    if not isinstance(answer, el.Statement):
        raise _refuse(constraint, "statement()", answer, "a Statement")
    given, words, bindings = (vars(answer)[word] for word in ("phi", "rows", "bindings"))
    if not isinstance(given, tuple) or not given:
        form = type(given).__name__
        raise ModelError(
            f"{el.label(constraint)}: its phi is of type {form}; give a tuple, of one equation "
            "(phi,)."
        )
    phi = tuple(_expression(constraint, "statement() among phi", e) for e in given)
    rows = words if isinstance(words, tuple | list) else ()
    if len(rows) != len(phi) or not all(isinstance(r, str) and WORDS.fullmatch(r) for r in rows):
        raise ModelError(
            f"{el.label(constraint)}: its rows {shown(words)} must be {len(phi)} ASCII words, one "
            "an equation."
        )
    if not all(isinstance(place, sympy.Expr) for place in bindings):
        raise _refuse(constraint, "bindings", bindings, "placeholder: value")
    for row, own in _tuples(constraint, "own", answer.own, 2, "pairs (row, coordinate)"):
        if row not in rows or not isinstance(own, Coordinate) or own.letter not in KINDS:
            raise _refuse(constraint, "own", answer.own, "pairs (row, coordinate)")
    reaction = _reaction(constraint, vars(answer)["reaction"], len(phi))
    if all(map(is_, phi, given)) and rows is words and reaction is answer.reaction:
        return answer
    return replace(answer, phi=phi, rows=tuple(rows), reaction=reaction)


def _reaction(constraint: Any, reaction: Any, count: int) -> Any:
    if isinstance(reaction, el.ConjugateReaction):
        parts = reaction.components
        try:
            pairs = _tuples(constraint, "reaction", parts, 2, "")
            for name, unit in pairs:
                _word(constraint, "reaction", name)
                _unit(constraint, "reaction", unit)
        except ModelError:
            pairs = ()
        if len(pairs) != count:
            raise ModelError(
                f"{el.label(constraint)}: its reactions {shown(parts)} must be {count} pairs of a "
                "word and a unit."
            )
    elif isinstance(reaction, el.JointReaction):
        on, sign = vars(reaction)["on"], vars(reaction)["sign"]
        if not isinstance(on, el.Frame) or sign not in (1, -1):
            raise _refuse(constraint, "reaction", reaction, "a frame I or J, and a sign 1 or -1")
        for word in ("direction", "arm"):
            vector = vars(reaction)[word]
            if not isinstance(vector, sympy.MatrixBase) and (vector is not None or word != "arm"):
                read = _vector(constraint, f"{word} of its reaction", vector)
                reaction = replace(reaction, **{word: read})
    elif reaction is not None:
        raise _refuse(
            constraint, "reaction", reaction, "a JointReaction, a ConjugateReaction or None"
        )
    return reaction


def _vector(element: Any, word: str, vector: Any) -> sympy.Matrix:
    """Two components, of a sequence."""
    if not isinstance(vector, tuple | list | sympy.Tuple) or not vector:
        raise _refuse(element, word, vector, "two components")
    return sympy.Matrix([_expression(element, word, component) for component in vector])


def forces_of(effect: Any, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
    """The generalized forces of an effect."""
    return _by_coordinate(effect, "forces()", ask(effect, "forces", bodies))


def _by_coordinate(element: Any, word: str, answer: Any) -> dict[Coordinate, sympy.Expr]:
    """Coordinate → expression."""
    keys = answer if isinstance(answer, Mapping) else [None]
    if not all(isinstance(q, Coordinate) and q.letter in KINDS for q in keys):
        raise _refuse(element, word, answer, "a dictionary, coordinate: expression")
    return {q: _expression(element, word, force) for q, force in answer.items()}


def potential_of(effect: Any, bodies: tuple[Body, ...]) -> sympy.Expr | None:
    """The potential energy of an effect."""
    answer = ask(effect, "potential", bodies)
    return None if answer is None else _expression(effect, "potential()", answer)


def optional_answers(effect: Any, bodies: tuple[Body, ...]) -> el.OptionalAnswers:
    """The answers of the methods that an effect has, and those of one without them."""
    return el.OptionalAnswers(
        friction_law(effect),
        _hold(effect, bodies),
        _pulls(effect, bodies),
        _reported(effect, bodies),
    )


def _optional(effect: Any, word: str, otherwise: Any, *arguments: Any) -> Any:
    """The answer of a method that not every effect has, or that a class sets to None."""
    try:
        given = getattr(effect, word, None) is not None
    except FAILURES:
        given = True
    return ask(effect, word, *arguments) if given else otherwise


def friction_law(effect: Any) -> el.FrictionLaw | None:
    """The law of an effect that follows from a joint's reaction; None for others."""
    law = _optional(effect, "friction", None)
    if law is None:
        return None
    if not isinstance(law, el.FrictionLaw):
        raise _refuse(effect, "friction()", law, "a FrictionLaw or None")
    _word(effect, "joint of friction()", law.joint)
    _unit(effect, "unit of friction()", law.unit)
    needed = "loads, tuples of sums of (component, factor)"
    contacts = vars(law)["contacts"]
    if not isinstance(contacts, tuple | list) or not all(
        isinstance(load, tuple | list) for load in contacts
    ):
        raise _refuse(effect, "contacts of friction()", contacts, needed)
    return replace(
        law,
        strength=_expression(effect, "friction()", law.strength),
        along=_expression(effect, "friction()", law.along),
        creep=None if law.creep is None else _expression(effect, "friction()", law.creep),
        contacts=tuple(
            tuple(_sum(effect, "contacts of friction()", entry, needed) for entry in load)
            for load in contacts
        ),
    )


def _sum(element: Any, word: str, answer: Any, needed: str) -> tuple[tuple[str, sympy.Expr], ...]:
    """(component, factor) of a sum."""
    pairs = _tuples(element, word, answer, 2, needed)
    return tuple((_word(element, word, c), _expression(element, word, f)) for c, f in pairs)


def _hold(effect: Any, bodies: tuple[Body, ...]) -> el.Sticking | el.Rigid | None:
    hold: el.Sticking | el.Rigid | None = _optional(effect, "hold", None, bodies)
    if hold is None:
        return None
    if not isinstance(hold, el.Sticking | el.Rigid):
        raise _refuse(effect, "hold()", hold, "Sticking, Rigid or None")
    read = {
        word: None if value is None and word == "static" else _expression(effect, "hold()", value)
        for word, value in vars(hold).items()
    }
    return type(hold)(**read)


def _pulls(effect: Any, bodies: tuple[Body, ...]) -> el.Pulls:
    answer = _optional(effect, "pulls", (), bodies)
    pairs = _tuples(effect, "pulls()", answer, 2, "pairs (scalar, force)")
    return tuple(
        (_expression(effect, "pulls()", s), _expression(effect, "pulls()", f)) for s, f in pairs
    )


def _reported(effect: Any, bodies: tuple[Body, ...]) -> el.Reported:
    answer = _optional(effect, "reported", (), bodies)
    rows = _tuples(effect, "reported()", answer, 3, "rows (component, unit, value)")
    return tuple(
        (
            _word(effect, "reported()", component),
            _unit(effect, "reported()", unit),
            _expression(effect, "reported()", value),
        )
        for component, unit, value in rows
    )


def own_coordinates(constraint: Any) -> tuple[Coordinate, ...]:
    """The coordinates that a sound joint brings itself."""
    try:
        sound = not problems_of(constraint)
        return tuple(q for _, q in statement_of(constraint).own) if sound else ()
    except ModelError:  # reported where the joint is checked
        return ()


def check_body(body: Body) -> None:
    """Ask a body of a modeller's own everything that is asked of bodies; ModelError if wrong."""
    coordinates = ask(body, "coordinates", method=False)
    if not _are_coordinates(body, coordinates):
        needed = f"a tuple of coordinates of '{body.name}', of letters that are declared"
        raise _refuse(body, "coordinates", coordinates, needed)
    for word in ("position", "velocity", "mass_centre", "rotation"):
        pair = ask(body, word, method=False)
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise _refuse(body, word, pair, "two expressions")
        _ = [_sound(body, word, component) for component in pair]
    for word, may_lack in (
        ("angle", True), ("angular_velocity", False), ("mass", True), ("inertia", True)
    ):  # fmt: skip
        value = ask(body, word, method=False)
        if not isinstance(value, sympy.Expr) and (value is not None or not may_lack):
            raise _refuse(body, word, value, "an expression of SymPy")
        if value is not None:
            _sound(body, word, value)
    for word in ("fixed", "turns"):
        if not isinstance(flag := ask(body, word, method=False), bool):
            raise _refuse(body, word, flag, "True or False")
    block = ask(body, "mass_matrix", method=False)
    pairs = block if isinstance(block, Mapping) else [None]
    if not all(isinstance(p, tuple) and len(p) == 2 and {*p} <= {*coordinates} for p in pairs):
        raise _refuse(body, "mass_matrix", block, "a dictionary, pair of coordinates: expression")
    for entry in block.values():
        if entry is not None:
            _sound(body, "mass_matrix", entry)
    for word, answer in (
        ("inertia_force", ask(body, "inertia_force", method=False)),
        ("torque()", ask(body, "torque", sympy.S.One)),
    ):
        for force in _by_coordinate(body, word, answer).values():
            _sound(body, word, force)
    equations = ask(body, "equations", method=False)
    for word, phi in _tuples(body, "equations", equations, 2, "pairs (word, expression)"):
        _word(body, "equations", word)
        _sound(body, "equations", phi)
