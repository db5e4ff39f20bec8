"""Units as texts, read with pint; numbers with a unit, and conditions, as texts.

``"41450 N m"`` and ``"body.x > 3 mm"``: nothing is run. SymPy is not imported, so that the runtime
reads values of a file as declarations read quantities.
"""

import math
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from codegen.errors import ModelError
from codegen.readers.values import one_line, shown

if TYPE_CHECKING:
    import pint

LONGEST, DEEPEST, STEEPEST = 80, 4, 20  # characters of a unit, brackets in brackets, exponent
NAME = r"[^\W\d]\w*|%|°"
EXPONENT = r"[+-]?\d+(?:\.\d+)?"
PART = re.compile(rf"\s*(?:(\*\*|[\^*/·⋅()])|({NAME})|({EXPONENT}))")
QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)?", re.ASCII | re.DOTALL
)
FRACTION = re.compile(rf"(\^|\*\*)\s*\(\s*({EXPONENT})\s*(?:/\s*(\d{{1,2}})\s*)?\)")


@lru_cache(maxsize=1)
def registry() -> "pint.UnitRegistry[Any]":
    """The unit registry (pint's application registry, so that a user's quantities fit)."""
    try:
        import pint
    except ImportError as error:
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
    if below and not int(below):
        raise ValueError(exponent.group())
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


def cycles_for_radians(value: Any, target: Any, unit: str) -> str | None:
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


class QuantityError(ValueError):
    """A text is no number with a unit that fits; its text says why."""


def number_in(text: str, unit: str) -> float:
    """The number of ``"1200 mm"`` in a unit, such as ``"m"``; without a unit, it is in that one.

    The number is the nearest float, and of the same unit it is exactly that of the text. Raises
    `QuantityError`.
    """
    parts = QUANTITY.fullmatch(text)
    if parts is None:
        raise QuantityError(
            f"{shown(text)} is no number; write 1.2, or a number with its unit, such as "
            f'"1.2 {unit or "m"}".'
        )
    value, given = float(parts[1]), (parts[2] or "").strip()
    if given and given != unit:
        value = _converted(value, given, unit)
    if not math.isfinite(value):
        raise QuantityError(f"{shown(text)} is not finite.")
    return value


def converted(values: Any, given: str, unit: str) -> Any:
    """An array of numbers in a unit, ``"mm"``, as an array in another one, such as ``"m"``.

    Raises `QuantityError` where the units do not fit.
    """
    number_in(f"1 {given}", unit)
    if given == unit:
        return values
    quantity: Any = registry().Quantity
    wanted = quantity(1.0, pint_form(unit) if unit else "").units
    return quantity(values, pint_form(given)).to(wanted).magnitude


def _converted(value: float, given: str, unit: str) -> float:
    quantity: Any = registry().Quantity
    try:
        measured = quantity(value, pint_form(given))
        wanted = quantity(1.0, pint_form(unit) if unit else "").units
        if not measured.is_compatible_with(wanted):
            raise QuantityError(
                f"{value:g} {given} has the dimension {measured.dimensionality}, and "
                f"{unit or 'a pure number'} is needed."
            )
        if problem := cycles_for_radians(measured, wanted, unit):
            raise QuantityError(f"{value:g} {given} {problem}")
        return float(measured.to(wanted).magnitude)
    except (QuantityError, ModelError):
        raise
    except Exception as error:  # pint raises several kinds
        raise QuantityError(
            f"{shown(given)} is no unit; write products of powers, such as kg m^2 or N m/rad."
        ) from error


FORM = r"^\s*[^<>\s][^<>]*[<>]\s*[^<>\s][^<>]*$"
"""The form of a condition for schemas; no two ways of it fit one text, so it is read in one go."""


class ConditionText(NamedTuple):
    """A condition that holds where a series is on one side of a number."""

    series: str
    sign: str  # "<" or ">"
    value: str  # a number, perhaps with its unit

    def number(self, unit: str) -> float:
        """The number in the unit of the series; `QuantityError` where its own does not fit."""
        return number_in(self.value, unit)


def read_condition(text: str) -> ConditionText:
    """The parts of a condition; `QuantityError` where it has none."""
    sign = "<" if "<" in text else ">"
    series, *values = (part.strip() for part in text.split(sign))
    if len(values) != 1 or not series or not values[0] or ("<" in text and ">" in text):
        raise QuantityError(
            f'{shown(text)} is no condition; write "SERIES > VALUE", or with <, such as '
            '"body.x > 3".'
        )
    return ConditionText(series, sign, values[0])
