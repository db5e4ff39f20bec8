"""Numbers with units: converted to SI where they are declared, and nowhere else."""

import re
import sys
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy

from codegen.errors import FAILURES, ModelError
from codegen.plain_values import KindError, one_line, plain_float
from codegen.real_range import unreal_part

if TYPE_CHECKING:
    import pint


LONGEST, DEEPEST, STEEPEST = 80, 4, 20  # characters of a unit, brackets in brackets, exponent
NAME = r"[^\W\d]\w*|%|°"
EXPONENT = r"[+-]?\d+(?:\.\d+)?"
PART = re.compile(rf"\s*(?:(\*\*|[\^*/·⋅()])|({NAME})|({EXPONENT}))")
FRACTION = re.compile(rf"(\^|\*\*)\s*\(\s*({EXPONENT})\s*(?:/\s*(\d{{1,2}})\s*)?\)")


@lru_cache(maxsize=1)
def registry() -> "pint.UnitRegistry[Any]":
    """The unit registry (pint's application registry, so that a user's quantities fit)."""
    try:
        import pint
    except FAILURES as error:
        raise ModelError(
            f"units are read with the package pint, which does not import: {one_line(error)}; "
            "install it anew."
        ) from error
    shared: pint.UnitRegistry[Any] = pint.application_registry.get()  # type: ignore[no-untyped-call]
    return shared


def pint_form(unit: str) -> str:
    """`unit` as pint reads it; ValueError where it is no product of powers of names.

    Products may be written with spaces, ``kg m^2``, and all behind a stroke is divided by, up to
    the next one: ``N/m s`` is ``N/(m s)``. An exponent is a small number.
    """
    parts: list[str] = []
    at = 0
    unit = FRACTION.sub(_decimal, unit[: LONGEST + 1])
    while unit[at:].strip():
        found = PART.match(unit, at)
        if found is None or len(unit) > LONGEST:
            raise ValueError(unit)
        parts.append(found.group().strip())
        at = found.end()
    form = _quotient(parts, 0)
    if parts:
        raise ValueError(unit)
    return form


def _decimal(exponent: re.Match[str]) -> str:
    """``^(1/2)`` as ``^0.5``."""
    power, above, below = exponent.groups()
    return f"{power}{float(above) / float(below or 1):.4g}"


def _quotient(parts: list[str], depth: int) -> str:
    """Products between strokes, taken from the front of `parts`."""
    terms = [_product(parts, depth) if parts and parts[0] != "/" else "1"]
    while parts and parts[0] == "/":
        del parts[0]
        terms.append(f"({_product(parts, depth)})")
    return "/".join(terms)


def _product(parts: list[str], depth: int) -> str:
    factors = [_power(parts, depth)]
    while parts and parts[0] not in ("/", ")"):
        if parts[0] in ("*", "·", "⋅"):
            del parts[0]
        factors.append(_power(parts, depth))
    return "*".join(factors)


def _power(parts: list[str], depth: int) -> str:
    """A name, 1 or a unit in brackets, with its exponent."""
    base = parts.pop(0) if parts else ""
    if base == "(" and depth < DEEPEST:
        base = f"({_quotient(parts, depth + 1)})"
        if not parts or parts.pop(0) != ")":
            raise ValueError(base)
    elif base != "1" and not re.fullmatch(NAME, base):
        raise ValueError(base)
    if not parts or parts[0] not in ("^", "**"):
        return base
    del parts[0]
    exponent = parts.pop(0) if parts else ""
    if not re.fullmatch(r"[+-]?[\d.]{1,6}", exponent) or abs(float(exponent)) > STEEPEST:
        raise ValueError(exponent)
    return f"{base}**{exponent}"


def known_unit(unit: str) -> bool:
    """Whether `unit` is a unit (the empty text means a pure number)."""
    if not unit:
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
    if not unit:
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
    if problem := _cycles_for_radians(value, target, unit):
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


def _cycles_for_radians(value: Any, target: Any, unit: str) -> str | None:
    """Why a quantity that counts cycles does not stand for one that counts radians, or None.

    SI calls both 1/s, and pint converts hertz to rad/s by the factor 1, and rpm to hertz by 2π/60.
    """
    quantity: Any = registry().Quantity
    given, wanted = (_exponent(q.to_root_units(), "radian") for q in (value, quantity(1, target)))
    counts = any(
        registry().parse_unit_name(name)[0][1] == "hertz" for name, _ in value.unit_items()
    ) or _exponent(value.to_root_units(), "count")
    if wanted and given != wanted and counts:
        return (
            f"counts cycles, but {unit} counts radians, and a cycle is 2π of them; give a quantity "
            f"in rad/s or rpm, or 2*pi*rad times the frequency."
        )
    if given and not wanted and [*value.dimensionality] == ["[time]"]:
        return (
            f"counts an angle, but {unit} does not, and a cycle may be meant or a radian; give the "
            f"unit rad/s to an angular velocity, and divide by 2*pi*rad for a frequency in {unit}."
        )
    return None


def _exponent(quantity: Any, root: str) -> float:
    """The power of a root unit, ``"radian"`` or ``"count"``, in a quantity in root units."""
    return float(dict(quantity.unit_items()).get(root, 0))


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
