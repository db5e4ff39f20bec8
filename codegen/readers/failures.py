"""Exceptions that are not ours: of SymPy, of a user's function, in our messages or on their way."""

import re
import traceback
from collections.abc import Iterator
from contextlib import contextmanager

from codegen.errors import LinkwrightError, ModelError
from codegen.readers.values import one_line

_CALL = re.compile(r"\b(math|np|numpy)\.(\w+)\(")
_UFUNC = re.compile(r"has no callable (\w+) method|ufunc '(\w+)'")
_SAME = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh",
    "atanh", "exp", "log", "sqrt", "sign", "floor", "erf", "gamma", "factorial",
)  # fmt: skip
_IN_SYMPY = {
    **{name: f"sympy.{name}" for name in _SAME},
    **{f"arc{name[1:]}": f"sympy.{name}" for name in _SAME if name.startswith("a")},
    **dict.fromkeys(("fabs", "abs", "absolute"), "sympy.Abs"),
    "maximum": "sympy.Max",
    "minimum": "sympy.Min",
    "where": "sympy.Piecewise",
    "heaviside": "sympy.Heaviside",
    **dict.fromkeys(("fmod", "mod", "remainder"), "sympy.Mod"),
    "ceil": "sympy.ceiling",
    **dict.fromkeys(("pow", "power"), "x**y"),
    "square": "x**2",
    "hypot": "sympy.sqrt(x**2 + y**2)",
    "log10": "sympy.log(x, 10)",
    "log2": "sympy.log(x, 2)",
    **dict.fromkeys(("radians", "deg2rad"), "sympy.rad"),
    **dict.fromkeys(("degrees", "rad2deg"), "sympy.deg"),
    "clip": "sympy.Max and sympy.Min",
}
"""Functions of math and NumPy → what an expression is written with."""


def sympy_remedy(error: BaseException) -> str:
    """A sentence for an exception that an expression of coordinates caused; empty for others.

    SymPy says that it cannot convert an expression to a number, NumPy that an object has no method,
    and neither says what to write.
    """
    text = one_line(error) if type(error) in {AttributeError, TypeError} else ""
    if "truth value of Relational" in text:
        return (
            "Python's if, and, or, max and min need numbers: use sympy.Piecewise, And, Or, Max and "
            "Min of coordinates and parameters"
        )
    lines = [frame.line or "" for frame in traceback.extract_tb(error.__traceback__)]
    calls = [call for line in lines for call in _CALL.findall(line)]
    ufunc = _UFUNC.search(text)
    if type(error) is AttributeError:  # NumPy asks an expression for methods of its names
        calls = [call for call in calls if f"object has no attribute '{call[1]}'" in text]
        if not calls:
            return ""
    elif ufunc is not None and "NoneType" not in text:  # NumPy names its function
        name = ufunc[1] or ufunc[2]
        calls = [call for call in calls if call[1] == name] or [("numpy", name)]
    elif "Cannot convert" not in text:
        return ""
    package, name = calls[-1] if calls else ("", "")
    if name not in _IN_SYMPY:
        return "math, NumPy and float() need numbers: use functions of sympy, such as sympy.sin"
    return f"math and NumPy need numbers: use {_IN_SYMPY[name]} in place of {package}.{name}"


def failure(error: BaseException) -> str:
    """An exception of somebody else's in a message."""
    if isinstance(error, RecursionError):
        return "RecursionError: functions of functions are too deep for Python's stack"
    said = f"{type(error).__name__}: {one_line(error)}".removesuffix(": ").rstrip(".")
    remedy = sympy_remedy(error)
    return f"{said} ({remedy})" if remedy else said


def unreadable(error: BaseException) -> str:
    """What to do about an expression at which SymPy fails."""
    if isinstance(error, RecursionError):
        return (
            "an expression is too deep for Python's stack: functions of functions, some hundred "
            "one in another; write it in fewer, or as a table of its values (model.table)."
        )
    return (
        f"an expression is beyond SymPy, which fails with {failure(error)}; write it in another "
        "form, of powers, sines and the other functions that are compiled."
    )


@contextmanager
def errors_at(where: str) -> Iterator[None]:
    """Errors in the block that are not ours say where they come from."""
    try:
        yield
    except LinkwrightError:
        raise
    except Exception as error:  # of an expression too deep, of SymPy
        raise ModelError(f"{where}: {unreadable(error)}") from error


@contextmanager
def note_user_error(what: str) -> Iterator[None]:
    """A block that calls a user's function: its exception passes on, and says whose it is."""
    try:
        yield
    except BaseException as error:
        error.add_note(f"{what} raised this: it is the caller's own.")
        raise
