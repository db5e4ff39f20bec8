"""What effects return: potential, forces, laws of friction and contact, reported quantities."""

from dataclasses import replace
from itertools import chain
from typing import Any

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.element import Effect
from codegen.declare.return_values.calls import (
    by_coordinate,
    call_method,
    call_optional_method,
    expression,
    name,
    position_scalar,
    refusal,
    refuse_duplicates,
    rows,
    unit,
)
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.errors import ModelError
from codegen.plain_values import plain_name, shown

Weights = tuple[tuple[str, sympy.Expr, sympy.Expr], ...]
"""(body, mass, acceleration) of the products that stand in a potential as one number."""


def forces_of(effect: Any, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
    """The generalized forces of an effect."""
    return by_coordinate(effect, "forces()", call_method(effect, "forces", bodies))


def potential_of(effect: Any, bodies: tuple[Body, ...]) -> sympy.Expr | None:
    """The potential energy of an effect."""
    value = call_method(effect, "potential", bodies)
    return None if value is None else expression(effect, "potential()", value)


def weights_of(effect: Any, bodies: tuple[Body, ...]) -> Weights:
    """The weights in the potential of an effect."""
    value = call_optional_method(effect, "weights", (), bodies)
    return tuple(
        (
            name(effect, "weights()", body),
            expression(effect, "weights()", mass),
            expression(effect, "weights()", acceleration),
        )
        for body, mass, acceleration in rows(
            effect, "weights()", value, 3, "a tuple of rows (body, mass, acceleration)"
        )
    )


def optional_terms(effect: Any, bodies: tuple[Body, ...]) -> el.OptionalTerms:
    """What the methods return that not every effect has."""
    law, hold = friction_law(effect), _hold(effect, bodies)
    if law and law.creep is None and not isinstance(hold, el.Sticking):
        raise ModelError(
            f"{el.label(effect)}: its friction() has no creep speed, so that it sticks, but "
            "hold() returns no Sticking; return one, or give creep=."
        )
    return el.OptionalTerms(law, hold, _pulls(effect, bodies), _reported(effect, bodies))


def friction_law(effect: Any) -> el.FrictionLaw | None:
    """The law of an effect that follows from a joint's reaction; None for others."""
    law = call_optional_method(effect, "friction", None)
    if law is None:
        return None
    if not isinstance(law, el.FrictionLaw):
        raise refusal(effect, "friction()", law, "a FrictionLaw or None")
    name(effect, "joint of friction()", law.joint)
    unit(effect, "unit of friction()", law.unit)
    needed = "a tuple of loads, each of sums of (component, factor)"
    contacts = vars(law)["contacts"]
    if not (isinstance(contacts, tuple | list) and contacts) or not all(
        isinstance(load, tuple | list) and load for load in contacts
    ):
        raise refusal(effect, "contacts of friction()", contacts, needed)
    creep = None if law.creep is None else expression(effect, "friction()", law.creep)
    if creep is not None and creep.is_number and not creep.is_positive:
        raise refusal(effect, "creep of friction()", creep, "a positive speed, or None")
    return replace(
        law,
        strength=expression(effect, "friction()", law.strength),
        along=position_scalar(
            effect, "along of friction()", expression(effect, "friction()", law.along)
        ),
        creep=creep,
        contacts=tuple(
            tuple(_sum(effect, "contacts of friction()", entry, needed) for entry in load)
            for load in contacts
        ),
    )


def _sum(effect: Any, word: str, value: Any, needed: str) -> tuple[tuple[str, sympy.Expr], ...]:
    """(component, factor) of a sum."""
    pairs = rows(effect, word, value, 2, needed)
    return tuple((name(effect, word, c), expression(effect, word, f)) for c, f in pairs)


def _hold(effect: Any, bodies: tuple[Body, ...]) -> el.Hold | None:
    hold: el.Hold | None = call_optional_method(effect, "hold", None, bodies)
    if hold is None:
        return None
    if not isinstance(hold, el.Hold):
        raise refusal(effect, "hold()", hold, "a Sticking, a Rigid, a OneWay or None")
    values: dict[str, Any] = {
        word: None if value is None and word == "static" else expression(effect, "hold()", value)
        for word, value in vars(hold).items()
    }
    if isinstance(hold, el.Rigid):
        position_scalar(effect, "gap of hold()", values["gap"])
    elif not kinds(values["slip"], Velocity):
        raise ModelError(
            f"{el.label(effect)}: the slip of its hold() is {shown(values['slip'])}, without a "
            "velocity; give the rate at which the surfaces slip."
        )
    elif isinstance(hold, el.OneWay):
        _linear_slip(effect, values["slip"])
    elif values["static"] is not None and values["kinetic"].is_nonpositive:
        raise ModelError(
            f"{el.label(effect)}: the coefficient of its hold() is {values['kinetic']}, beside a "
            "static one; give a positive number."
        )
    return type(hold)(**values)


def _linear_slip(effect: Any, slip: sympy.Expr) -> None:
    """Refuse a slip whose change in an impact does not follow from impulses alone."""
    velocities = kinds(slip, Velocity)
    if any(kinds(slip.diff(v), Velocity) for v in velocities):
        raise ModelError(
            f"{el.label(effect)}: the slip of its hold() is {shown(slip)}, no linear function of "
            "velocities; give the rate of a scalar."
        )


def _pulls(effect: Any, bodies: tuple[Body, ...]) -> el.Pulls:
    value = call_optional_method(effect, "pulls", (), bodies)
    pairs = rows(effect, "pulls()", value, 2, "a tuple of pairs (scalar, force)")
    pulls = ((expression(effect, "pulls()", s), expression(effect, "pulls()", f)) for s, f in pairs)
    return tuple((position_scalar(effect, "scalar of pulls()", s), f) for s, f in pulls)


def measures_of(effect: Any, bodies: tuple[Body, ...]) -> tuple[el.Measure, ...] | None:
    """The quantities that an effect says it has; None of one that says nothing."""
    value = call_optional_method(effect, "measures", None, bodies)
    if value is None:
        return None
    word, needed = "measures()", "a tuple of Measure(quantity, component, unit, value, along)"
    measures = []
    for quantity, component, given, number, along in rows(effect, word, value, 5, needed):
        if plain_name(quantity) not in el.QUANTITIES:
            raise refusal(effect, word, quantity, f"one of {', '.join(el.QUANTITIES)}")
        scalar = None
        if along is not None:
            scalar = expression(effect, word, along)
            scalar = position_scalar(effect, "scalar of measures()", scalar)
        measures.append(
            el.Measure(
                plain_name(quantity),
                name(effect, word, component) if component != "" else "",
                unit(effect, word, given),
                expression(effect, word, number),
                scalar,
            )
        )
    refuse_duplicates(effect, word, [measure.row for measure in measures])
    return tuple(measures)


def _reported(effect: Any, bodies: tuple[Body, ...]) -> el.Reported:
    value = call_optional_method(effect, "reported", (), bodies)
    reported = tuple(
        (
            name(effect, "reported()", component),
            unit(effect, "reported()", measure),
            expression(effect, "reported()", force),
        )
        for component, measure, force in rows(
            effect, "reported()", value, 3, "a tuple of rows (component, unit, value)"
        )
    )
    refuse_duplicates(effect, "reported()", [component for component, *_ in reported])
    return reported


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
