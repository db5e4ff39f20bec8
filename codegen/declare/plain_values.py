"""What a modeller gives, of any type → plain numbers, text, expressions and lists, by type alone.

Nothing is parsed, evaluated or called for: text is never a number, and a subclass of `float` is the
number that it holds, whatever its methods say. What is of another kind raises `KindError`.
"""

import math
import reprlib
from collections.abc import Iterable, Mapping, Set
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from itertools import islice
from numbers import Real
from typing import Any

import numpy as np
import sympy

from codegen.declare.real_range import unreal_part

MOST = 1_000_000  # safety: members of a list that are read; an iterator may have no end
WIDEST = 160  # characters of a value in a message

_SHORT = reprlib.Repr()
_SHORT.maxlevel = 4
_SHORT.maxtuple = _SHORT.maxlist = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxfrozenset = 12
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = WIDEST


class KindError(Exception):
    """A value is not of the kind that is needed; its text says why, if there is more to say."""


class NotText(str):
    """A printable stand-in for what was given as a name and is no name."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def shown(value: object) -> str:
    """`value` in a message: on one line, printable, cut where it is long; never an error."""
    try:
        text = repr(value) if isinstance(value, sympy.Basic) else _SHORT.repr(value)
    except Exception:  # a user's __repr__, a number of too many digits
        text = f"a {type(value).__name__}"
    return one_line(text)


def one_line(text: object, widest: int = WIDEST) -> str:
    """Text without line ends and other characters that do not print, cut where it is long."""
    try:
        words = " ".join(str(text).split())
    except Exception:
        words = f"a {type(text).__name__}"
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in words)
    return line if len(line) <= widest else f"{line[: widest - 3]}..."


def plain_name(value: object) -> str:
    """Text as it is; `NotText` in place of all that cannot stand in a message as a name."""
    if isinstance(value, str):
        text = str.__str__(value)
        if len(text) <= WIDEST and text.isprintable() and not isinstance(value, NotText):
            return text
    return value if isinstance(value, NotText) else NotText(shown(value))


def plain_number(value: Any) -> int | float | Fraction:
    """A real number as one of Python's own: numpy's, Decimal, and arrays without axes too."""
    if isinstance(value, bool | np.bool_):
        raise KindError
    if isinstance(value, int):
        return int.__pos__(value)
    if isinstance(value, float):
        return float.__pos__(value)
    if isinstance(value, Fraction):
        return value
    if isinstance(value, Real | Decimal) or hasattr(value, "_mpf_"):
        return float(value)
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        if np.any(getattr(value, "mask", False)):
            raise KindError("it is masked")
        return plain_number(value.item())
    raise KindError


def plain_float(value: Any) -> float:
    """The same as a float; SymPy's real numbers too. It may be infinite or nan."""
    if isinstance(value, sympy.Expr) and not value.is_Matrix:
        if not value.is_number:
            raise KindError("it is an expression, and a number is needed")
        if value in (sympy.nan, sympy.oo, -sympy.oo):
            return float(value)
        if found := unreal_part(value):  # also what is too large to be evaluated
            raise KindError(f"it {found[1]}")
        both = complex(value.evalf(17, maxn=400))
        if both.imag:
            raise KindError("it is not real")
        return both.real
    number = plain_number(value)
    try:
        return float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf


@lru_cache(maxsize=4096)
def _unit_of_sympy(expression: sympy.Expr) -> sympy.Basic | None:
    units = (a for a in expression.atoms(sympy.AtomicExpr) if hasattr(a, "scale_factor"))
    return next(units, None)


def plain_expression(value: Any) -> sympy.Expr:
    """A number or an expression as an expression."""
    if isinstance(value, sympy.Expr):
        if value.is_Matrix or (not value.is_commutative and value.is_commutative is not None):
            raise KindError
        if unit := _unit_of_sympy(value):
            raise KindError(f"{unit} is a unit of SymPy; give a quantity of pint")
        return sympy.S.Zero if value.is_Float and value.is_zero else value
    number = plain_number(value)
    if number == 0:
        return sympy.S.Zero  # also 0.0, which SymPy tells from 0
    if isinstance(number, int):
        return sympy.Integer(number)
    if isinstance(number, Fraction):
        return sympy.Rational(number.numerator, number.denominator)
    return sympy.Float(number)


def members(value: Any, count: int | None = None) -> list[Any]:
    """The members of a list, in its order; of as many as `count` if given.

    A set has no order, the members of a mapping are its keys, and text is one thing.
    """
    if isinstance(value, sympy.MatrixBase):
        value = value.flat()
    if isinstance(value, str | bytes | bytearray | Set | Mapping) or not isinstance(
        value, Iterable
    ):
        raise KindError
    if np.ma.is_masked(value):
        raise KindError("it has masked entries")
    return bounded(value, count)


def bounded(value: Iterable[Any], count: int | None = None) -> list[Any]:
    """The members of anything that has some."""
    read = list(islice(iter(value), MOST + 1 if count is None else count + 1))
    if count is None and len(read) > MOST:
        raise KindError(f"it has more than {MOST} entries")
    if count is not None and len(read) != count:
        raise KindError
    return read
