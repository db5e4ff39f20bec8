"""Numbers with units: converted to SI where they are declared, and nowhere else."""

import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy

from codegen.errors import InputError

if TYPE_CHECKING:
    import pint


UNIT = re.compile(r"[\w%°^*/ .()+-]*")


@lru_cache(maxsize=1)
def registry() -> "pint.UnitRegistry[Any]":
    """The unit registry (pint's application registry, so that a user's quantities fit).

    Raises InputError if pint, or what it stands on, does not load.
    """
    try:
        import pint
    except Exception as error:
        raise InputError(
            f"units cannot be read: the library pint fails to load with {type(error).__name__}: "
            f"{error}. Install it anew: pip install --force-reinstall pint"
        ) from error

    shared: pint.UnitRegistry[Any] = pint.application_registry.get()  # type: ignore[no-untyped-call]
    return shared


def pint_form(unit: str) -> str:
    """`unit` as pint reads it: products may be written with spaces (``kg m^2``)."""
    factors, *divisors = ("*".join(part.split()) for part in unit.split("/"))
    return "/".join([factors or "1", *(f"({divisor})" for divisor in divisors)])


def known_unit(unit: str) -> bool:
    """Whether `unit` is a unit (the empty text means a pure number)."""
    if not UNIT.fullmatch(unit):
        return False
    units = registry()  # that pint fails to load says nothing about the unit
    try:
        units.parse_units(pint_form(unit)) if unit else None
    except Exception:  # pint raises several kinds, among them tokenizer errors
        return False
    return True


def si_factor(unit: str) -> float:
    """One `unit` in SI units; 1 for SI units themselves."""
    if not unit:
        return 1.0
    one: Any = registry().Quantity(1.0, pint_form(unit)).to_base_units().magnitude
    none: Any = registry().Quantity(0.0, pint_form(unit)).to_base_units().magnitude
    return float(one) if none == 0.0 else float("nan")


def is_quantity(value: object) -> bool:
    """Whether `value` is a pint quantity."""
    return hasattr(value, "magnitude") and hasattr(value, "dimensionality")


def in_unit(value: Any, unit: str, where: str, problems: list[str]) -> Any:
    """A number, expression or quantity in the SI unit `unit`, empty for a pure number.

    A wrong dimension is added to `problems`, in a sentence that begins with `where`, the role of
    the number: ``"mass of body 'crank'"``. All but quantities are taken to be in `unit`.
    """
    if not is_quantity(value):
        return value
    target = registry().parse_units(pint_form(unit)) if unit else registry().dimensionless
    if not value.is_compatible_with(target):
        needed = unit or "a pure number"
        problems.append(
            f"{where}: {value} has the dimension {value.dimensionality}, but {needed} is needed; "
            f"give a quantity that converts to {needed}."
        )
        return 1.0
    magnitude = value.to(target).magnitude
    return magnitude if isinstance(magnitude, sympy.Basic) else float(magnitude)


def plain_length(value: Any) -> Any:
    """A length in metres; any other value is returned unchanged and reported where it is used."""
    fits = is_quantity(value) and value.is_compatible_with("m")
    return value.to("m").magnitude if fits else value


def expression(value: Any) -> sympy.Expr:
    """`value` as a SymPy expression; TypeError for text, a truth value, a condition, a matrix."""
    if isinstance(value, bool | str):
        raise TypeError(f"{value!r} is no number or expression")
    read = sympy.sympify(value)
    if not isinstance(read, sympy.Expr) or read.is_Matrix:
        raise TypeError(f"{value!r} is no number or expression")
    return read
