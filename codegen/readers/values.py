"""Any object → a plain number, text or list, by its kind; names, and hints for unknown ones.

Nothing is parsed or evaluated: text is never a number. What is of another kind raises `KindError`.
SymPy is imported for a number that is one of its expressions, and for nothing else.
"""

import difflib
import keyword
import math
import re
import reprlib
from collections.abc import Iterable, Mapping, Set
from decimal import Decimal
from fractions import Fraction
from numbers import Real
from typing import Any

WIDEST = 160  # layout: characters of a value in a message

_SHORT = reprlib.Repr()
_SHORT.maxlevel = 4
_SHORT.maxtuple = _SHORT.maxlist = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxfrozenset = 12
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = WIDEST


class KindError(Exception):
    """A value is not of the kind that is needed; its text says why or what is, if there is more."""


def shown(value: object, widest: int = WIDEST) -> str:
    """`value` in a message: on one line, printable, cut where it is long."""
    try:
        text = repr(value) if hasattr(value, "free_symbols") else _SHORT.repr(value)
    except ValueError:  # of a number of too many digits
        text = f"a {type(value).__name__}"
    return one_line(text, widest)


def one_line(text: object, widest: int = WIDEST) -> str:
    """Text without line ends and other characters that do not print, cut where it is long."""
    words = " ".join(str(text).split())
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in words)
    return line if len(line) <= widest else f"{line[: widest - 3]}..."


def label_sides(label: str) -> tuple[str, str]:
    """What a label says where its condition begins to hold, and where it ceases to.

    Such as ``"valve opens / valve closes"``; one without a slash ends as ``"no longer: …"``.
    """
    begin, _, end = label.partition(" / ")
    return begin, end or f"no longer: {begin}"


def is_flag(value: Any) -> bool:
    """Whether it is True or False, of Python or numpy."""
    return type(value).__name__ in {"bool_", "bool"}


def plain_number(value: Any) -> int | float | Fraction:
    """A real number as one of Python's own: numpy's, Decimal, and arrays without axes too."""
    if is_flag(value):
        raise KindError
    if isinstance(value, Fraction):
        return value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, Real | Decimal) or hasattr(value, "_mpf_"):
        return float(value)
    if getattr(value, "dimensionless", False) is True and hasattr(value, "magnitude"):
        return plain_number(value.to("").magnitude)
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        if getattr(value, "mask", False):
            raise KindError("it is masked")
        return plain_number(value.item())
    raise KindError


def plain_float(value: Any) -> float:
    """The same as a float; SymPy's real numbers too. It may be infinite or nan."""
    if hasattr(type(value), "free_symbols"):
        from codegen.readers.expressions import sympy_float

        return sympy_float(value)
    number = plain_number(value)
    try:
        return float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf


def finite_float(value: Any) -> float | None:
    """A finite real number as a float; None for all else."""
    try:
        number = plain_float(value)
    except KindError:
        return None
    return number if math.isfinite(number) else None


def members(value: Any, count: int | None = None) -> list[Any]:
    """The members of a list, in its order; of as many as `count` if given.

    A set has no order, the members of a mapping are its keys, and text is one thing.
    """
    if getattr(type(value), "is_Matrix", False) is True:
        value = value.flat()
    if isinstance(value, str | bytes | bytearray | memoryview | Set | Mapping):
        raise KindError
    masked: Any = getattr(value, "mask", False)
    if hasattr(masked, "any") and masked.any():
        raise KindError("it has masked entries")
    read = entries(value)
    if count is not None and len(read) != count:
        raise KindError
    return read


def entries(value: Any) -> list[Any]:
    """All that anything with an order or without one lists."""
    try:
        return list(value)
    except TypeError as error:  # also of an array or quantity without axes
        raise KindError from error


LONGEST = 32  # safety: characters of a name in formulas
_LONGEST_OF_FILES = 80  # safety: of a model's or a scene's; file systems allow 255 for all parts
IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")


def name_problem(kind: str, name: object) -> str | None:
    """Why `name` cannot be the name of a `kind`, or None if it can."""
    text = name if isinstance(name, str) else ""
    if keyword.iskeyword(text):
        reason = "is no identifier, but a word of Python's own; put an underscore behind it"
    elif not IDENTIFIER.match(text):
        reason = "is no identifier: use ASCII letters, digits and underscores, a letter first"
    elif "__" in text:
        reason = "has two underscores in a row, which separate model and scene in file names"
    elif len(text) > LONGEST and kind not in ("model", "scene"):
        reason = f"has {len(text)} characters; formulas stay readable with up to {LONGEST}"
    elif len(text) > _LONGEST_OF_FILES:
        reason = f"has {len(text)} characters; names of files may have up to {_LONGEST_OF_FILES}"
    else:
        return None
    return f"{kind} name {shown(name)} {reason}."


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint that ends a message about an unknown name."""
    names = sorted(known)
    close = difflib.get_close_matches(name[:WIDEST], names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(repr(c) for c in close)}?"
    return f"there are: {', '.join(names)}." if names else "there are none."


def nearest_quantity(name: str, known: Iterable[str]) -> str:
    """A hint about an unknown ``owner.letter``: the nearest letters of the owner, else all."""
    names = list(known)
    owner, _, letter = name[:WIDEST].rpartition(".")
    own = {k.rpartition(".")[2]: k for k in names if k.rpartition(".")[0] == owner}
    if not own:
        return nearest(name, names)
    close = difflib.get_close_matches(letter, own, n=3, cutoff=0.5) or own
    return f"did you mean {' or '.join(own[c] for c in close)}?"
