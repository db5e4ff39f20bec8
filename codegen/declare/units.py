"""Numbers with units: converted to SI where they are declared, and nowhere else."""

import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy

if TYPE_CHECKING:
    import pint


UNIT = re.compile(r"[\w%°^*/ .()+-]*")


@lru_cache(maxsize=1)
def registry() -> "pint.UnitRegistry[Any]":
    """The unit registry (pint's application registry, so that a user's quantities fit)."""
    import pint

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
    try:
        registry().parse_units(pint_form(unit)) if unit else None
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

    A wrong dimension, and a frequency for an angular velocity or the other way round, is added to
    `problems`, in a sentence that begins with `where`, the role of the number: ``"mass of body
    'crank'"``. All but quantities are taken to be in `unit`.
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
    if problem := _cycles_for_radians(value, target, unit):
        problems.append(f"{where}: {value} {problem}")
        return 1.0
    magnitude = value.to(target).magnitude
    return magnitude if isinstance(magnitude, sympy.Basic) else float(magnitude)


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
    fits = is_quantity(value) and value.is_compatible_with("m")
    return value.to("m").magnitude if fits else value


def expression(value: Any) -> sympy.Expr:
    """`value` as a SymPy expression; TypeError for text, a truth value, a condition, a matrix.

    A unit of SymPy's is no number either: it would have to be converted where it stands. A zero is
    SymPy's own, which equals 0; that of a float, 0.0, does not.
    """
    if isinstance(value, bool | str):
        raise TypeError(f"{value!r} is no number or expression")
    read = sympy.sympify(value)
    if not isinstance(read, sympy.Expr) or read.is_Matrix:
        raise TypeError(f"{value!r} is no number or expression")
    if foreign := [a for a in read.atoms(sympy.AtomicExpr) if hasattr(a, "scale_factor")]:
        raise TypeError(f"{foreign[0]} is a unit of SymPy")
    return sympy.S.Zero if read.is_Float and read.is_zero else read
