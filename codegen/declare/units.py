"""Numbers with units: converted to SI where they are declared, and nowhere else."""

import re
import sys
from typing import Any

import sympy

from codegen.errors import FAILURES
from codegen.plain_values import KindError, one_line, plain_float
from codegen.quantities import NAME, cycles_for_radians, pint_form, registry
from codegen.real_range import unreal_part

COHERENT = frozenset(("m", "kg", "s", "rad", "N", "J", "W", "Pa", "Hz"))
"""SI units whose products of powers have the factor 1: they are known without pint.

To import pint and read its table of units is a sixth of the build of a small scene.
"""


def _is_coherent(unit: str) -> bool:
    """Whether `unit` is a sound product of powers of coherent units alone."""
    if not COHERENT.issuperset(re.findall(NAME, unit)):
        return False
    try:
        pint_form(unit)
    except ValueError:
        return False
    return True


def known_unit(unit: str) -> bool:
    """Whether `unit` is a unit (the empty text means a pure number)."""
    if not unit or _is_coherent(unit):
        return True
    shared = registry()
    try:
        shared.parse_units(pint_form(unit))
        si_factor(unit)
    except FAILURES:  # pint raises several kinds, among them tokenizer errors
        return False
    return True


def si_factor(unit: str) -> float:
    """One `unit` in SI units; 1 for SI units themselves."""
    if not unit or _is_coherent(unit):
        return 1.0
    one: Any = registry().Quantity(1.0, pint_form(unit)).to_base_units().magnitude
    none: Any = registry().Quantity(0.0, pint_form(unit)).to_base_units().magnitude
    return float(one) if none == 0.0 else float("nan")


def is_quantity(value: object) -> bool:
    """Whether `value` is a pint quantity."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def in_unit(value: Any, unit: str, where: str, problems: list[str]) -> Any:
    """A number, expression or quantity in the SI unit `unit`, empty for a pure number.

    A wrong dimension, and a frequency for an angular velocity or the other way round, is added to
    `problems`, in a sentence that begins with `where`, the role of the number: ``"mass of body
    'crank'"``. All but quantities are taken to be in `unit`.
    """
    if not is_quantity(value):
        if problem := _table_of_another_unit(value, unit):
            problems.append(f"{where}: {problem}")
        return value
    if _is_refused(value):
        return value.magnitude  # SymPy would multiply it out
    target = registry().parse_units(pint_form(unit)) if unit else registry().dimensionless
    try:
        fits = value.is_compatible_with(target)
    except FAILURES:
        problems.append(
            f"{where}: {one_line(value)} is a quantity of a unit registry of its own; take those "
            "of pint.get_application_registry()."
        )
        return 1.0
    if not fits:
        needed = unit or "a pure number"
        problems.append(
            f"{where}: {value} has the dimension {value.dimensionality}, but {needed} is needed; "
            f"give a quantity that converts to {needed}."
        )
        return 1.0
    if problem := cycles_for_radians(value, target, unit):
        problems.append(f"{where}: {value} {problem}")
        return 1.0
    return _magnitude(value, target)


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


def plain_length(value: Any) -> Any:
    """A length in metres; any other value is returned unchanged and reported where it is used."""
    try:
        if is_quantity(value):
            return value.magnitude if _is_refused(value) else _magnitude(value, "m")
        return value
    except FAILURES:
        return value


def _is_refused(quantity: Any) -> bool:
    """Whether the magnitude is an expression that is refused for a part of it."""
    given = quantity.magnitude
    return isinstance(given, sympy.Basic) and unreal_part(given) is not None


def _magnitude(value: Any, target: Any) -> Any:
    """The number or expression of a quantity in a unit; what is neither is returned as it is."""
    magnitude = value.to(target).magnitude
    try:
        return magnitude if isinstance(magnitude, sympy.Basic) else plain_float(magnitude)
    except KindError:
        return magnitude
