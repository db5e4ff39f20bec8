"""Checks of a model and its bodies before the equations of its scenes are derived.

Each finding is a sentence that names the element, shows the numbers and says what to do. All of
them are reported together.
"""

import math
from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any

import sympy

from codegen.check.elements import element_problems, unknown
from codegen.check.space import inertia_problems
from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect, label
from codegen.declare.returned_values import (
    LOADS,
    check_attribute,
    expression,
    named,
    own_coordinates,
    read_part,
    rows,
    words,
)
from codegen.declare.space_body import SpaceBody
from codegen.declare.symbols import Coordinate, t
from codegen.declare.value_reader import expression_problem
from codegen.errors import ModelError
from codegen.readers.arguments import Reader, flag, mapping, one_of, optional, row
from codegen.readers.calls import errors_at
from codegen.readers.expressions import constant_value
from codegen.readers.values import KindError, one_line, shown

if TYPE_CHECKING:
    from codegen.model import Model

LONGEST = 2000  # layout: characters of a sentence


def check_model(model: "Model") -> list[str]:
    """Problems of the declaration, whatever the scene."""
    problems = [*model.problems]
    if not (model.bodies or model.noted):
        problems.append(f"model '{model.name}' has no body; declare one with model.body(...).")
    known = known_symbols(model)
    of_bodies = {name: [*body_problems(model, b, known)] for name, b in model.bodies.items()}
    sound = tuple(body for name, body in model.bodies.items() if not of_bodies[name])
    forms = (form for choices in model.fidelities.values() for form in choices.values())
    elements: tuple[Constraint | Effect, ...] = (
        *model.joints.values(),
        *model.drivers.values(),
        *model.effects.values(),
        *(form for form in forms if not isinstance(form, str)),
    )
    for element in {id(e): e for e in elements if e.name not in model.noted}.values():
        try:
            with errors_at(label(element)):
                problems += element_problems(model, element, sound, known)
        except ModelError as error:
            problems += error.problems
    problems += chain.from_iterable(of_bodies.values())
    problems += [
        f"state '{name}' has no rate; give rate=, or model.state_equation({name}, ...)."
        for name, state in model.states.items()
        if not state.given
    ]
    problems += filter(None, (p.problem(p.value) for p in model.parameters.values()))
    problems += _collisions(model)
    problems += _lost_symbols(model, known, problems)
    return list(dict.fromkeys(one_line(p, LONGEST) for p in problems))


def _lost_symbols(
    model: "Model", known: frozenset[sympy.Symbol], problems: list[str]
) -> Iterator[str]:
    """Unknown symbols of values that have no share in the equations, such as 0 times a place."""
    for where, symbols in model.symbols:
        for symbol in sorted(symbols - known, key=str):
            sentence = unknown(model, where, symbol)
            end, named = sentence.removeprefix(where), f"'{symbol}'"
            if not any(p.endswith(end) or (p.startswith(where) and named in p) for p in problems):
                yield sentence


def known_symbols(model: "Model") -> frozenset[sympy.Symbol]:
    """Parameters, the time, and the coordinates and velocities of bodies and joints."""
    coordinates = [q for body in model.bodies.values() for q in body.coordinates]
    in_space = (body for body in model.bodies.values() if isinstance(body, SpaceBody))
    coordinates += [turn for body in in_space for turn in body.turning]
    coordinates += [q for joint in model.joints.values() for q in own_coordinates(joint)]
    coordinates += [q for body in model.bodies.values() for q, _ in body.laws]
    moving = (symbol for q in coordinates for symbol in (q, q.rate))
    of_states = (symbol for s in model.states.values() for symbol in (s.symbol, s.integral))
    return frozenset((*model.defaults, t, *moving, *of_states))


def _collisions(model: "Model") -> Iterator[str]:
    """Two things that would have one name in the generated text."""
    owners: dict[str, str] = {"t": "the time"}
    declared = [("body", body.name, body.coordinates) for body in model.bodies.values()]
    declared += [("joint", joint.name, own_coordinates(joint)) for joint in model.joints.values()]
    declared += [("state", name, (s.integral,)) for name, s in model.states.items()]
    for kind, owner, coordinates in declared:
        for symbol in (s for q in coordinates for s in (q, q.rate)):
            owners[symbol.name] = f"a coordinate or velocity of {kind} '{owner}'"
    for name in model.parameters:
        if name in owners:
            yield f"parameter '{name}' has the name of {owners[name]}; rename it."


def body_problems(model: "Model", body: Body, known: frozenset[sympy.Symbol]) -> Iterator[str]:
    """Problems of a body: of what an own class returns, of its mass and inertia."""
    if not type(body).__module__.startswith("codegen."):
        try:
            _check_returned(body, known)
        except ModelError as error:
            yield from error.problems
            return
    given = [("mass", body.mass, "kg"), ("inertia", body.inertia, "kg m^2")]
    if isinstance(body, SpaceBody):
        given = given[:1]
        yield from inertia_problems(model, body)
    for word, value, unit in given:
        if value is None:
            continue
        if problem := expression_problem(value):  # of a body that a modeller made by hand
            yield f"{word} of body '{body.name}': {problem}"
            continue
        symbols = value.free_symbols
        values = {q: q.measure.neutral for q, _ in body.laws} | model.defaults
        if unknown := sorted(s.name for s in symbols if s not in values):
            yield (
                f"{word} of body '{body.name}': unknown symbol {', '.join(map(repr, unknown))}; "
                "a mass is an expression of t, coordinates and parameters."
            )
            continue
        number = value.subs(values) if symbols else value
        try:
            size = constant_value(number)
        except (TypeError, ValueError, ArithmeticError):  # it is complex, or zoo
            size = math.nan
        if not 0.0 < size < math.inf:
            shown = one_line(number) if math.isnan(size) else f"{size:g}"
            yield (
                f"{word} of body '{body.name}' is {shown} {unit}; it must be positive and "
                "finite (leave it out where the scene is kinematic)."
            )


def _check_returned(body: Body, known: frozenset[sympy.Symbol]) -> None:
    """Ask a body of a modeller's own, in `known` symbols, all that bodies are asked; ModelError."""

    def sound(value: Any) -> sympy.Expr:
        checked = expression(value)
        if problem := expression_problem(checked):
            raise ModelError(problem)
        if unknown := sorted(s.name for s in checked.free_symbols - known):
            raise ModelError(
                f"{shown(checked)} has the symbol {shown(unknown[0])}, which is none of the model; "
                "write it in coordinates, velocities, parameters and t."
            )
        return checked

    def scalar(value: Any) -> sympy.Expr:
        return sound(one_of("an expression of SymPy", sympy.Expr)(value))

    def own(value: Any) -> Any:
        if value not in body.coordinates:
            raise KindError(f"it must be a coordinate of body '{body.name}'.")
        return value

    pair = row("two expressions", sound, sound)
    pairs = "a dictionary, pair of its own coordinates: expression"
    readers: dict[str, Reader] = {
        **dict.fromkeys(("angle", "mass", "inertia"), optional(scalar)),
        **dict.fromkeys(("position", "velocity", "mass_centre", "rotation"), pair),
        **dict.fromkeys(("fixed", "turns"), flag),
        "angular_velocity": scalar,
        "mass_matrix": mapping(pairs, row(pairs, own, own), optional(sound)),
        "inertia_force": mapping("a dictionary, own coordinate: expression", own, sound),
        "equations": rows("pairs (word, expression)", words, sound),
    }
    for attribute, reader in readers.items():
        check_attribute(body, attribute, reader)
    loads = mapping(LOADS, one_of("a coordinate", Coordinate), sound)
    with named(body, "torque()"):
        read_part(body, "what its torque() returns", loads, body.torque(sympy.S.One))
