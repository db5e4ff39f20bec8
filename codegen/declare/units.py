"""Numbers with units: converted to SI where they are declared, and nowhere else."""

import re
import sys
from typing import Any

import sympy

from codegen.readers.quantities import NAME, cycles_for_radians, pint_form, registry
from codegen.readers.values import KindError, one_line, plain_float

COHERENT = frozenset(("m", "kg", "s", "rad", "N", "J", "W", "Pa", "Hz"))
"""SI units whose products of powers have the factor 1: they are known without pint.

To import pint and read its table of units is a sixth of the build of a small scene.
"""


class UnitError(KindError):
    """A quantity is of another dimension than is needed; its text is all that is to be said."""


def _is_coherent(unit: str) -> bool:
    """Whether `unit` is a sound product of powers of coherent units alone."""
    if not COHERENT.issuperset(re.findall(NAME, unit)):
        return False
    try:
        pint_form(unit)
    except ValueError:
        return False
    return True


def known_unit(unit: object) -> bool:
    """Whether `unit` is a unit (the empty text means a pure number)."""
    if not isinstance(unit, str):
        return False
    if not unit or _is_coherent(unit):
        return True
    try:
        registry().parse_units(pint_form(unit))
        si_factor(unit)
    except Exception:  # pint raises several kinds, among them tokenizer errors
        return False
    return True


def si_factor(unit: str) -> float:
    """One `unit` in SI units; 1 for SI units themselves."""
    if not unit or _is_coherent(unit):
        return 1.0
    one: Any = registry().Quantity(1.0, pint_form(unit)).to_base_units().magnitude
    none: Any = registry().Quantity(0.0, pint_form(unit)).to_base_units().magnitude
    return float(one) if none == 0.0 else float("nan")


def is_si_unit(unit: object) -> bool:
    """Whether `unit` is a unit of SI, such as ``"kg m^2"``; the empty text is that of numbers."""
    return known_unit(unit) and si_factor(str(unit)) == 1.0


def is_quantity(value: object) -> bool:
    """Whether `value` is a pint quantity."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def in_unit(value: Any, unit: str) -> Any:
    """A number, expression or quantity in the SI unit `unit`, empty for a pure number.

    All but quantities are taken to be in `unit`. Raises `UnitError` for a wrong dimension, and for
    a frequency in the place of an angular velocity or the other way round.
    """
    if not is_quantity(value):
        if problem := _table_of_another_unit(value, unit):
            raise UnitError(problem)
        return value
    target = registry().parse_units(pint_form(unit)) if unit else registry().dimensionless
    try:
        fits = value.is_compatible_with(target)
    except ValueError:
        raise UnitError(
            f"{one_line(value)} is a quantity of a unit registry of its own; take those of "
            "pint.get_application_registry()."
        ) from None
    if not fits:
        needed = unit or "a pure number"
        raise UnitError(
            f"{value} has the dimension {value.dimensionality}, but {needed} is needed; give a "
            f"quantity that converts to {needed}."
        )
    try:
        problem = cycles_for_radians(value, target, unit)
        magnitude = value.to(target).magnitude
    except TypeError as error:  # of a text
        raise KindError(one_line(error)) from error
    if problem:
        raise UnitError(f"{value} {problem}")
    return magnitude if isinstance(magnitude, sympy.Basic) else plain_float(magnitude)


def metres(length: Any) -> Any:
    """A quantity of a length in m; what is none is returned as it is, and told where it is used."""
    try:
        return in_unit(length, "m") if is_quantity(length) else length
    except KindError:
        return length


def same_dimension(one: str, other: str) -> bool:
    """Whether two units convert into each other; the empty text is that of a pure number."""
    quantities = (
        registry().Quantity(1.0, pint_form(unit) if unit else "") for unit in (one, other)
    )
    return bool(next(quantities).is_compatible_with(next(quantities)))


def _table_of_another_unit(value: Any, unit: str) -> str | None:
    """Why a table alone, or its negative, does not stand for a value in `unit`, or None."""
    if not isinstance(value, sympy.Expr):
        return None
    factor, table = value.as_coeff_Mul()
    measured = getattr(table, "table_unit", "")
    if not measured or abs(factor) != 1 or same_dimension(measured, unit):
        return None
    needed = unit or "a pure number"
    return (
        f"table '{table.table.name}' has values in {measured}, but {needed} is needed; give the "
        "table other units=, or write the factor between both."
    )
