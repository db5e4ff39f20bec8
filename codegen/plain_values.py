"""Any object → a plain number, name or list, by type alone: for declarations and for runs.

Nothing is parsed, evaluated or called for: text is never a number, and a subclass of `float` is the
number that it holds, whatever its methods say. What is of another kind raises `KindError`. SymPy
is not imported but for a number that is one of its expressions.
"""

import math
import reprlib
from collections.abc import Iterable, Mapping, Set
from decimal import Decimal
from fractions import Fraction
from itertools import islice
from numbers import Real
from operator import is_
from typing import Any, TypeGuard, TypeVar

from codegen.errors import FAILURES

Kind = TypeVar("Kind")
MOST = 1_000_000  # safety: members of a list that are read; an iterator may have no end
TINY = "nearer to 0 than any float"
WIDEST = 160  # layout: characters of a value in a message


# what a class says of itself, and no metaclass of a user's can change
class_name, _bases = (type.__dict__[word].__get__ for word in ("__name__", "__mro__"))


class _Short(reprlib.Repr):
    """Short texts of values; SymPy would compare powers of powers of numbers to sort a sum."""

    def repr_instance(self, value: Any, level: int) -> str:
        """The text of any object that is no list, number or text."""
        if hasattr(type(value), "free_symbols"):
            waiting = [value]
            while waiting:
                node = waiting.pop()
                if node.is_Pow and node.exp.is_Pow and node.exp.is_number:
                    return "an expression with powers of powers of numbers"
                waiting += [a for a in node.args if hasattr(a, "args")]
            return repr(value)
        return super().repr_instance(value, level)


_SHORT = _Short()
_SHORT.maxlevel = 4
_SHORT.maxtuple = _SHORT.maxlist = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxfrozenset = 12
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = WIDEST


class KindError(Exception):
    """A value is not of the kind that is needed; its text says why or what is, if there is more."""


class Impostor:
    """It stands for an object that hides its class or claims another one."""

    def __init__(self, value: object) -> None:
        self.text = f"an object of {class_name(type(value))} that hides its class or claims another"

    def __repr__(self) -> str:
        return self.text


class InvalidName(str):
    """A printable stand-in for what was given as a name and is no name."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def shown(value: object, widest: int = WIDEST) -> str:
    """`value` in a message: on one line, printable, cut where it is long; never an error."""
    try:
        text = _SHORT.repr(value)
    except KeyboardInterrupt:
        raise
    except BaseException:  # of a user's __repr__, of a number of too many digits
        text = f"a {class_name(type(value))}"
    return one_line(text, widest)


def one_line(text: object, widest: int = WIDEST) -> str:
    """Text without line ends and other characters that do not print, cut where it is long."""
    try:
        words = " ".join(str(text).split())
    except KeyboardInterrupt:
        raise
    except BaseException:
        words = f"a {class_name(type(text))}"
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in words)
    return line if len(line) <= widest else f"{line[: widest - 3]}..."


def plain_name(value: object) -> str:
    """Text as it is; `InvalidName` in place of all that cannot stand in a message as a name."""
    if is_a(value, InvalidName):
        return value
    if is_a(value, str):
        text = str.__str__(value)
        if len(text) <= WIDEST and text.isprintable():
            return text
    return InvalidName(shown(value))


def plain_number(value: Any) -> int | float | Fraction:
    """A real number as one of Python's own: numpy's, Decimal, and arrays without axes too."""
    if is_flag(value):
        raise KindError
    if isinstance(value, int):
        return int.__pos__(value)
    if isinstance(value, float):
        return float.__pos__(value)
    if isinstance(value, Fraction):
        return value
    if isinstance(value, Real | Decimal) or hasattr(value, "_mpf_"):
        try:
            number = float(value)
            is_lost = number == 0.0 and bool(value)
        except (ValueError, OverflowError) as error:  # of a signaling nan, of a user's own number
            raise KindError(f"it is no float: {error}") from error
        if is_lost:
            raise KindError(f"it is {TINY}")
        return number
    if getattr(value, "dimensionless", False) is True and hasattr(value, "magnitude"):
        return plain_number(value.to("").magnitude)
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        if bool(getattr(value, "mask", False)):
            raise KindError("it is masked")
        return plain_number(value.item())
    raise KindError


def plain_float(value: Any) -> float:
    """The same as a float; SymPy's real numbers too. It may be infinite or nan."""
    if hasattr(type(value), "free_symbols") and hasattr(value, "is_number"):
        from codegen.real_range import sympy_float

        return sympy_float(value)
    number = plain_number(value)
    try:
        found = float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf
    if found == 0.0 and number:
        raise KindError(f"it is {TINY}")
    return found


def finite_float(value: Any) -> float | None:
    """A finite real number as a float; None for all else."""
    try:
        number = plain_float(value)
    except FAILURES:  # of the user's own object
        return None
    return number if math.isfinite(number) else None


def is_a(value: object, kind: type[Kind]) -> TypeGuard[Kind]:
    """Whether its class is, or derives from, `kind`; what it says of itself is not asked."""
    return any(base is kind for base in _bases(type(value)))


def genuine(value: Any, depth: int = 3) -> Any:
    """The value; text as plain text, what hides its class or claims another as an `Impostor`.

    So are members of plain lists and mappings, in a copy. ``isinstance`` asks an object for its
    class: it would raise, or answer a lie; and a class of text of its own compares as it likes.
    """
    kind: Any = type(value)
    try:
        honest = value.__class__ is kind and kind.__name__ == class_name(kind)
        honest = honest and kind.__mro__ is _bases(kind)
    except KeyboardInterrupt:
        raise
    except BaseException:
        honest = False
    if not honest:
        return Impostor(value)
    if kind is not str and kind is not InvalidName and issubclass(kind, str):
        return str.__str__(value)
    if depth == 0 or kind not in (list, tuple, dict, set, frozenset) or len(value) > MOST:
        return value
    entries = value.items() if kind is dict else value
    deeper = depth - (kind is not dict)
    read: list[Any] = [e if type(e) is float else genuine(e, deeper) for e in entries]
    if kind is dict:
        same = all(k is a and v is b for (k, v), (a, b) in zip(read, value.items(), strict=True))
    else:
        same = all(map(is_, read, value))
    return value if same else kind(read)


def is_flag(value: Any) -> bool:
    """Whether it is True or False, of Python or numpy."""
    return class_name(type(value)) in {"bool_", "bool"}


def members(value: Any, count: int | None = None) -> list[Any]:
    """The members of a list, in its order; of as many as `count` if given.

    A set has no order, the members of a mapping are its keys, and text is one thing.
    """
    if getattr(type(value), "is_Matrix", False) is True and hasattr(value, "flat"):
        flat = value.flat
        value = flat() if callable(flat) else value
    if isinstance(value, str | bytes | bytearray | memoryview | Set | Mapping) or not isinstance(
        value, Iterable
    ):
        raise KindError
    masks: Any = getattr(value, "mask", False)
    if hasattr(masks, "any") and masks.any():
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
