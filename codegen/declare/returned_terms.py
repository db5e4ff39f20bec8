"""What effects return, checked once, by kind: potential, forces, laws, reported quantities."""

from itertools import chain
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.element import Effect, label
from codegen.declare.returned_kinds import (
    Kind,
    MisfitError,
    by_coordinate,
    expression,
    optional,
    position_scalar,
    refusal,
    returned,
    rows,
    several,
    unit,
    with_fields,
    words,
)
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.errors import ModelError
from codegen.readers.values import shown

Weights = tuple[tuple[str, sympy.Expr, sympy.Expr], ...]
"""(body, mass, acceleration) of the products that stand in a potential as one number."""


def forces_of(effect: Any, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
    """The generalized forces of an effect."""
    forces: dict[Coordinate, sympy.Expr] = returned(effect, "forces", by_coordinate, bodies)
    return forces


def potential_of(effect: Any, bodies: tuple[Body, ...]) -> sympy.Expr | None:
    """The potential energy of an effect."""
    return returned(effect, "potential", optional(expression), bodies)


def weights_of(effect: Any, bodies: tuple[Body, ...]) -> Weights:
    """The weights in the potential of an effect."""
    weights: Weights = returned(effect, "weights", _WEIGHTS, bodies, otherwise=())
    return weights


def optional_terms(effect: Any, bodies: tuple[Body, ...]) -> el.OptionalTerms:
    """What the methods return that not every effect has."""
    law, hold = friction_law(effect), _hold(effect, bodies)
    if law and law.creep is None and not isinstance(hold, el.Sticking):
        raise ModelError(
            f"{label(effect)}: its friction() has no creep speed, so that it sticks, but "
            "hold() returns no Sticking; return one, or give creep=."
        )
    pulls = returned(effect, "pulls", _PULLS, bodies, otherwise=())
    reported = returned(effect, "reported", _REPORTED, bodies, otherwise=())
    return el.OptionalTerms(law, hold, pulls, reported)


def friction_law(effect: Any) -> el.FrictionLaw | None:
    """The law of an effect that follows from a joint's reaction; None for others."""

    def check(value: Any) -> el.FrictionLaw:
        if not isinstance(value, el.FrictionLaw):
            raise refusal(value, "a FrictionLaw or None")
        law = with_fields(effect, "friction()", value, _FRICTION)
        if law.creep is not None and law.creep.is_number and not law.creep.is_positive:
            raise MisfitError(f"has the creep speed {law.creep}; give a positive speed, or None.")
        return law

    law: el.FrictionLaw | None = returned(effect, "friction", optional(check))
    return law


def _hold(effect: Any, bodies: tuple[Body, ...]) -> el.Hold | None:
    def check(value: Any) -> Any:
        if not isinstance(value, el.Hold):
            raise refusal(value, "a Sticking, a Rigid, a OneWay or None")
        fields = {word: _HOLD.get(word, expression) for word in vars(value)}
        hold = with_fields(effect, "hold()", value, fields)
        if isinstance(hold, el.OneWay) and any(
            kinds(hold.slip.diff(v), Velocity) for v in kinds(hold.slip, Velocity)
        ):  # whose change in an impact does not follow from impulses alone
            raise MisfitError(
                f"has the slip {shown(hold.slip)}, no linear function of velocities; give the "
                "rate of a scalar."
            )
        if (
            isinstance(hold, el.Sticking)
            and hold.static is not None
            and hold.kinetic.is_nonpositive
        ):
            raise MisfitError(
                f"has the coefficient {hold.kinetic}, beside a static one; give a positive number."
            )
        return hold

    hold: el.Hold | None = returned(effect, "hold", optional(check), bodies)
    return hold


def measures_of(effect: Any, bodies: tuple[Body, ...]) -> tuple[el.Measure, ...] | None:
    """The quantities that an effect says it has; None of one that says nothing."""
    found = returned(effect, "measures", optional(_MEASURES), bodies)
    return None if found is None else tuple(el.Measure(*row) for row in found)


def _quantity(value: Any) -> str:
    if value not in el.QUANTITIES:
        raise refusal(value, f"one of {', '.join(el.QUANTITIES)}")
    return str(value)


def _slip(value: Any) -> sympy.Expr:
    slip = expression(value)
    if not kinds(slip, Velocity):
        raise MisfitError(
            f"is {shown(slip)}, without a velocity; give the rate at which the surfaces slip."
        )
    return slip


_LOAD = "a tuple of loads, each of sums of (component, factor)"


_LOADS = several(several(rows(_LOAD, words, expression), _LOAD, 1), _LOAD, 1)
_WEIGHTS = rows("a tuple of rows (body, mass, acceleration)", words, expression, expression)
_PULLS = rows("a tuple of pairs (scalar, force)", position_scalar, expression)
_REPORTED = rows(
    "a tuple of rows (component, unit, value)", words, unit, expression,
    unique=lambda row: str(row[0]),
)  # fmt: skip
_MEASURES = rows(
    "a tuple of Measure(quantity, component, unit, value, along)", _quantity,
    lambda text: text and words(text), unit, expression, optional(position_scalar),
    unique=lambda row: el.Measure(*row).row,
)  # fmt: skip
_FRICTION: dict[str, Kind] = {
    "joint": words, "strength": expression, "creep": optional(expression),
    "along": position_scalar, "contacts": _LOADS, "unit": unit,
}  # fmt: skip
_HOLD: dict[str, Kind] = {"slip": _slip, "static": optional(expression), "gap": position_scalar}


def effect_expressions(effect: Effect, bodies: tuple[Body, ...]) -> list[sympy.Basic]:
    """All expressions that an effect returns, and the coordinates on which it acts."""
    forces, potential = forces_of(effect, bodies), potential_of(effect, bodies)
    expressions: list[sympy.Basic | None] = [*forces, *forces.values(), potential]
    law, hold, pulls, reported = optional_terms(effect, bodies)
    expressions += chain.from_iterable(pulls)
    expressions += [value for _, _, value in reported]
    for measure in measures_of(effect, bodies) or ():
        expressions += (measure.value, measure.along)
    expressions += vars(hold).values() if hold else ()
    if law:
        loads = (f for load in law.contacts for entry in load for _, f in entry)
        expressions += (law.strength, law.creep, law.along, *loads)
    expressions += chain.from_iterable(rest for _, *rest in weights_of(effect, bodies))
    return [e for e in expressions if e is not None]
