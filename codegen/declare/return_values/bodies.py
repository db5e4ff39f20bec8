"""What bodies return: coordinates, pose, inertia, equations between their coordinates."""

from collections.abc import Mapping, Set
from typing import Any

import sympy

from codegen.declare.body import Body
from codegen.declare.element import label
from codegen.declare.expression_rules import expression_problem
from codegen.declare.return_values.calls import (
    by_coordinate,
    call_user_code,
    expression,
    name,
    read_property,
    refusal,
    rows,
)
from codegen.declare.symbols import KINDS, Coordinate
from codegen.errors import ModelError
from codegen.plain_values import shown


def coordinates_of(body: Any) -> tuple[Coordinate, ...]:
    """The coordinates of a sound body."""
    try:
        value = read_property(body, "coordinates")
    except ModelError:  # reported where the body is checked
        return ()
    return value if _are_coordinates(body, value) else ()


def _are_coordinates(body: Any, value: Any) -> bool:
    return isinstance(value, tuple) and all(
        isinstance(q, Coordinate) and q.letter in KINDS and q.owner == body.name for q in value
    )


def check_body(body: Body, known: Set[sympy.Symbol]) -> None:
    """Ask a body of a modeller's own everything that is asked of bodies; ModelError if wrong.

    Its expressions consist of the `known` symbols.
    """
    coordinates = read_property(body, "coordinates")
    if not _are_coordinates(body, coordinates):
        needed = f"a tuple of coordinates of '{body.name}', of letters that are declared"
        raise refusal(body, "coordinates", coordinates, needed)
    for word in ("position", "velocity", "mass_centre", "rotation"):
        pair = read_property(body, word)
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise refusal(body, word, pair, "two expressions")
        _ = [_sound(body, word, component, known) for component in pair]
    for word, may_lack in (
        ("angle", True), ("angular_velocity", False), ("mass", True), ("inertia", True)
    ):  # fmt: skip
        value = read_property(body, word)
        if not isinstance(value, sympy.Expr) and (value is not None or not may_lack):
            raise refusal(body, word, value, "an expression of SymPy")
        if value is not None:
            _sound(body, word, value, known)
    for word in ("fixed", "turns"):
        if not isinstance(flag := read_property(body, word), bool):
            raise refusal(body, word, flag, "True or False")
    block = read_property(body, "mass_matrix")
    entries: dict[Any, Any] = {None: None}
    if isinstance(block, Mapping):
        entries = call_user_code(body, "mass_matrix", lambda: dict(block))
    if not all(isinstance(p, tuple) and len(p) == 2 and {*p} <= {*coordinates} for p in entries):
        raise refusal(body, "mass_matrix", block, "a dictionary, pair of coordinates: expression")
    for entry in entries.values():
        if entry is not None:
            _sound(body, "mass_matrix", entry, known)
    for word, value in (
        ("inertia_force", read_property(body, "inertia_force")),
        ("torque()", call_user_code(body, "torque()", lambda: body.torque(sympy.S.One))),
    ):
        for force in by_coordinate(body, word, value).values():
            _sound(body, word, force, known)
    equations = read_property(body, "equations")
    for word, phi in rows(body, "equations", equations, 2, "pairs (word, expression)"):
        name(body, "equations", word)
        _sound(body, "equations", phi, known)


def _sound(body: Any, word: str, value: Any, known: Set[sympy.Symbol]) -> sympy.Expr:
    """An expression of a body, which has no placeholders as those of elements have."""
    checked = expression(body, word, value)
    if problem := expression_problem(checked):
        raise ModelError(f"{label(body)}: its {word}: {problem}")
    if unknown := sorted(s.name for s in checked.free_symbols - known):
        raise ModelError(
            f"{label(body)}: its {word} has the symbol {shown(unknown[0])}, which is none of the "
            "model; write it in coordinates, velocities, parameters and t."
        )
    return checked
