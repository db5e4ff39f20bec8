"""Numbers with units, read with pint: quantities of a declaration, and texts of a file.

``"41450 N m"`` and ``"body.x > 3 mm"``: nothing is run. A number is converted to SI where it is
given, and nowhere else. SymPy is not imported, so that the runtime reads values of a file as
declarations read quantities.
"""

import math
import re
import sys
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from codegen.errors import InputError, ModelError
from codegen.readers.values import KindError, finite_float, one_line, plain_float, shown

if TYPE_CHECKING:
    import pint

COHERENT = frozenset(("m", "kg", "s", "rad", "N", "J", "W", "Pa", "Hz"))
"""SI units whose products of powers have the factor 1: they are known without pint.

To import pint and read its table of units is a sixth of the build of a small scene.
"""
QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)?", re.ASCII | re.DOTALL
)
FORM = r"^\s*[^<>\s][^<>]*[<>]\s*[^<>\s][^<>]*$"
"""The form of a condition for schemas; no two ways of it fit one text, so it is read in one go."""

_LONGEST = 80  # safety: characters of a unit
_SI_UNITS = ("1", "m", "kg", "s", "rad", "(rad/s)", "N", "J", "W", "Pa", "Hz", "A", "V", "K")
_BEGINS_UNIT = re.compile(r"[\w%°(]")
_NAME = r"[^\W\d]\w*|%|°"
_EXPONENT = r"[+-]?(?:1?\d|20)(?:\.\d{1,4})?"
_POWER = rf"(?:\^|\*\*) ?(?:{_EXPONENT}|[(] ?{_EXPONENT}(?: ?/ ?0?[1-9]\d?)? ?[)])"
_TOKENS = re.compile(rf"(?:(?:{_NAME}|\b1\b|[)])(?: ?{_POWER})?(?![\d.]| ?\^| ?\*\*)|[ */·⋅(])+")
# products of powers on both sides of strokes, what stands below one perhaps in brackets
_FACTORS = rf"(?:{_NAME}|1)(?: ?{_POWER})?(?:(?: | ?[*·⋅] ?)(?:{_NAME})(?: ?{_POWER})?)*"
_MISREAD = re.compile(r"\w*(?:Nm|number_meter|enzyme_unit)|\w?U|PS|petasiemens")  # not as meant
_PLAIN = re.compile(rf"{_FACTORS}(?: ?/ ?(?:{_FACTORS}|[(]{_FACTORS}[)]))*")


class UnitError(KindError, ValueError):
    """A quantity or its text does not fit the unit that is needed; its text says why."""


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
    """`unit` as pint reads it; ValueError where it has anything but names and small powers.

    Products may be written with spaces, ``kg m^2``, and all behind a stroke is divided by, up to
    the next one: ``N/m s`` is ``N/(m s)``. Each side of a stroke gets brackets, and each bracket a
    second one, so that they bind first.
    """
    text = " ".join(unit.split())
    misread = any(map(_MISREAD.fullmatch, re.findall(_NAME, text)))
    if misread or not text or len(unit) > _LONGEST or not _TOKENS.fullmatch(text):
        raise ValueError(unit)
    for mark, form in (("·", "*"), ("⋅", "*"), ("(", "(("), (")", "))"), ("/", ")/(")):
        text = text.replace(mark, form)
    return f"({text})"


def _is_coherent(unit: str) -> bool:
    """Whether `unit` is a sound product of powers of coherent units alone."""
    text = " ".join(unit.split())
    known = COHERENT.issuperset(re.findall(_NAME, text)) and len(text) <= _LONGEST
    return known and _PLAIN.fullmatch(text) is not None and _TOKENS.fullmatch(text) is not None


def known_unit(unit: object) -> bool:
    """Whether `unit` is a unit (the empty text means a pure number)."""
    if not isinstance(unit, str):
        return False
    try:
        si_factor(unit)
    except Exception:  # pint raises several kinds, among them tokenizer errors
        return False
    return True


def si_factor(unit: str) -> float:
    """One `unit` in SI units; 1 for SI units themselves."""
    if not unit or _is_coherent(unit):
        return 1.0
    one, none = (
        registry().Quantity(size, pint_form(unit)).to_base_units().magnitude for size in (1.0, 0.0)
    )
    return float(one) if none == 0.0 else math.nan


def si_unit(unit: str) -> str:
    """The same product of powers in SI units: ``"N m/rad"`` for ``"N mm/deg"``."""
    if si_factor(unit) == 1.0:
        return unit
    if re.fullmatch(_NAME, unit):
        return _si_name(unit).strip("()").removeprefix("1")
    return re.sub(_NAME, lambda name: _si_name(name[0]), unit)


def _si_name(name: str) -> str:
    """The SI unit that takes the place of one factor of a unit."""
    one = registry().Quantity(1.0, pint_form(name))
    turns = _exponent(one.to_root_units(), "radian")
    for unit in _SI_UNITS:
        other = measured(1.0, unit)
        if one.is_compatible_with(other) and _exponent(other.to_root_units(), "radian") == turns:
            return unit
    return f"({one.to_base_units().units:~C})".replace("**", "^")


def whole_unit(quantity: Any) -> str:
    """The unit of a quantity by whole powers of its units, else of base units; empty: by none."""
    for one in quantity, quantity.to_base_units():
        powers = {registry().get_symbol(name): round(p, 6) for name, p in one.unit_items()}
        if all(p == int(p) for p in powers.values()):
            names = sorted(powers, key=lambda name: (name in ("m", "s", "rad"), name))
            texts = [(powers[n], f"{n}^{abs(powers[n]):g}".removesuffix("^1")) for n in names]
            above, below = (" ".join(x for p, x in texts if s * p > 0) for s in (1, -1))
            return f"{above or 1}/{below}" if below else above or "1"
    return ""


def same_dimension(one: str, other: str) -> bool:
    """Whether two units convert into each other; the empty text is that of a pure number."""
    return bool(measured(1.0, one).is_compatible_with(measured(1.0, other)))


def is_quantity(value: object) -> bool:
    """Whether `value` is a pint quantity."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def in_unit(value: Any, unit: str) -> Any:
    """A number, expression, quantity or text such as ``"45 mm"`` in `unit`, empty: a pure number.

    All but quantities and texts are taken to be in `unit`. Raises `UnitError` for a wrong
    dimension, and for a frequency in the place of an angular velocity or the other way round, and
    `KindError` for a text that is no number with a unit.
    """
    if isinstance(value, str):
        parts = QUANTITY.fullmatch(value)
        if parts is None or not _BEGINS_UNIT.match(parts[2] or ""):
            raise KindError(
                "text is never evaluated, so write it without quotes, or as a number and its unit, "
                '"5 mm"'
            )
        return number_in(value, unit)
    if not is_quantity(value):
        if problem := _table_of_another_unit(value, unit):
            raise UnitError(problem)
        return value
    magnitude = _converted(value, unit)
    return magnitude if hasattr(magnitude, "free_symbols") else plain_float(magnitude)


def each_in_unit(values: Any, unit: str) -> Any:
    """`in_unit` of one value, or of each in a list or an array."""
    array = values.magnitude if is_quantity(values) else values
    if array is values and getattr(getattr(array, "dtype", None), "kind", "") in {*"iuf"}:
        return values
    several = getattr(array, "ndim", int(isinstance(array, list | tuple))) == 1
    return [in_unit(one, unit) for one in values] if several else in_unit(values, unit)


def unit_text(unit: Any) -> Any:
    """The text of a unit of pint; all else as it is."""
    pint = sys.modules.get("pint")
    return str(unit) if pint is not None and isinstance(unit, pint.Unit) else unit


def finite_in_unit(value: Any, unit: str) -> float | None:
    """The same as a finite float; None for what is none. Raises `UnitError`."""
    try:
        return finite_float(in_unit(value, unit))
    except UnitError:
        raise
    except KindError:
        return None


def metres(length: Any) -> Any:
    """A quantity of a length, or its text, in m; all else as it is, and told where it is used."""
    try:
        return in_unit(length, "m") if isinstance(length, str) or is_quantity(length) else length
    except KindError:
        return length


def number_in(text: str, unit: str) -> float:
    """The number of ``"1200 mm"`` in a unit, such as ``"m"``; without a unit, it is in that one.

    The number is the nearest float, and of the same unit it is exactly that of the text. Raises
    `UnitError`.
    """
    parts = QUANTITY.fullmatch(text)
    if parts is None:
        raise UnitError(
            f"{shown(text)} is no number; write 1.2, or a number with its unit, such as "
            f'"1.2 {unit or "m"}".'
        )
    value, given = float(parts[1]), (parts[2] or "").strip()
    if given and given != unit:
        value = float(converted(value, given, unit))
    if not math.isfinite(value):
        raise UnitError(f"{shown(text)} is not finite.")
    return value


def converted(values: Any, given: str, unit: str) -> Any:
    """A number or an array of them in a unit, ``"mm"``, in another one, such as ``"m"``.

    Raises `UnitError` where the units do not fit.
    """
    if given == unit:
        return values
    asked = given
    try:
        quantity = measured(values, given)
        asked = unit
        measured(1.0, unit)
    except ModelError:
        raise
    except Exception as error:  # pint raises several kinds
        raise UnitError(
            f"{shown(asked)} is no unit; write products of powers, such as N m or kg m^2/s."
        ) from error
    return _converted(quantity, unit)


def converts(given: str, unit: str) -> bool:
    """Whether `unit` is one into which numbers of another can be converted."""
    try:
        converted(1.0, given, unit)
    except UnitError:
        return False
    return True


def fitting_units(own: dict[str, str], unit: Any) -> dict[str, str]:
    """The first unit asked for that fits each series, by name, or else its own; InputError."""
    units = [unit_text(one) for one in (unit if isinstance(unit, list | tuple) else [unit])]
    shown = {n: next((u for u in units if converts(of, u)), of) for n, of in own.items()}
    for wanted in units:
        if wanted not in shown.values():
            known = ", ".join(f"{name} ({of or 1})" for name, of in own.items())
            fits = any(converts(of, wanted) for of in own.values())
            why = "comes after another that fits the same of" if fits else "fits none of"
            raise InputError(f"unit {wanted!r} {why} {known}; leave it out.")
    return shown


def measured(values: Any, unit: str) -> Any:
    """Numbers as a quantity of a unit; the empty text is that of pure numbers."""
    return registry().Quantity(values, pint_form(unit) if unit else "")


def _text(quantity: Any) -> str:
    """A quantity in a sentence; of several numbers the first."""
    number = getattr(quantity.magnitude, "flat", (quantity.magnitude,))[0]
    return f"{number:g} {quantity.units}" if isinstance(number, int | float) else str(quantity)


def _converted(quantity: Any, unit: str) -> Any:
    """The magnitude of a quantity in a unit."""
    target = measured(1.0, unit).units
    needed = unit or "a pure number"
    try:
        if not quantity.is_compatible_with(target):
            raise UnitError(
                f"{_text(quantity)} has the dimension {quantity.dimensionality}, but {needed} is "
                f"needed; give a quantity that converts to {needed}."
            )
        if problem := _cycles_for_radians(quantity, target, unit):
            raise UnitError(f"{_text(quantity)} {problem}")
        return quantity.to(target).magnitude
    except UnitError:
        raise
    except ValueError:
        raise UnitError(
            f"{one_line(quantity)} is a quantity of a unit registry of its own; take those of "
            "pint.get_application_registry()."
        ) from None
    except TypeError as error:  # of a text
        raise KindError(one_line(error)) from error


def _cycles_for_radians(value: Any, target: Any, unit: str) -> str | None:
    """Why a quantity of cycles does not stand for one of radians, or one for each angle, or None.

    SI calls both 1/s, and pint converts hertz to rad/s by the factor 1, and rpm to hertz by 2π/60.
    """
    roots = value.to_root_units()
    given = _exponent(roots, "radian")
    wanted = _exponent(registry().Quantity(1, target).to_root_units(), "radian")
    names = {registry().parse_unit_name(name)[0][1] for name, _ in value.unit_items()}
    if given < 0 == wanted and value.check("[length]"):
        return "is a length for each angle; give the length alone, of a lead that of one turn."
    if value.dimensionless and given == 1 and not wanted:
        return "is an angle, but a pure number is needed; give the number alone."
    if wanted and not given and names & {"percent", "permille", "ppm"}:
        return f"is a share, but {unit} is needed; give a number in {unit}."
    is_rate = [*value.dimensionality] == ["[time]"]  # of which 1/min may mean revolutions
    per_cycle = {"hertz", "minute", "hour"} if is_rate else {"hertz"}
    counts = not names.isdisjoint(per_cycle) or _exponent(roots, "count")
    if wanted and given != wanted and counts:
        return (
            f"counts cycles, but {unit} counts radians, and a cycle is 2π of them; give a quantity "
            f"in rad/s or rpm, or 2*pi*rad times the frequency."
        )
    if given and not wanted and is_rate:
        return (
            f"counts an angle, but {unit} does not, and a cycle may be meant or a radian; give the "
            f"unit rad/s to an angular velocity, and divide by 2*pi*rad for a frequency in {unit}."
        )
    return None


def _exponent(quantity: Any, root: str) -> float:
    """The power of a root unit, ``"radian"`` or ``"count"``, in a quantity in root units."""
    return float(dict(quantity.unit_items()).get(root, 0))


def _table_of_another_unit(value: Any, unit: str) -> str | None:
    """Why a table alone, or its negative, does not stand for a value in `unit`, or None."""
    if not hasattr(type(value), "as_coeff_Mul"):
        return None
    factor, table = value.as_coeff_Mul()
    own = getattr(table, "table_unit", "")
    if not own or abs(factor) != 1 or same_dimension(own, unit):
        return None
    needed = unit or "a pure number"
    return (
        f"table '{table.table.name}' has values in {own}, but {needed} is needed; give the "
        "table other units=, or write the factor between both."
    )


class ConditionText(NamedTuple):
    """A condition that holds where a series is on one side of a number."""

    series: str
    sign: str  # "<" or ">"
    value: str  # a number, perhaps with its unit


def read_condition(text: str) -> ConditionText:
    """The parts of a condition; `UnitError` where it has none."""
    sign = "<" if "<" in text else ">"
    series, *values = (part.strip() for part in text.replace(f"{sign}=", sign).split(sign))
    if len(values) != 1 or not series or not values[0] or ("<" in text and ">" in text):
        raise UnitError(
            f'{shown(text)} is no condition; write "SERIES > VALUE", or with <, such as '
            '"body.x > 3".'
        )
    return ConditionText(series, sign, values[0])
