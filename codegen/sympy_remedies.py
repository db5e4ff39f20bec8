"""What to write where Python, `math` or NumPy is given an expression and needs a number."""

import re
import traceback

from codegen.plain_values import one_line

_CALLED = re.compile(r"\b(math|np|numpy)\.(\w+)\(")
_UFUNC = re.compile(r"has no callable (\w+) method|ufunc '(\w+)'")
_SPELLED = {
    **{f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "tan2")},
    "fabs": "Abs",
    "abs": "Abs",
    "absolute": "Abs",
    "maximum": "Max",
    "minimum": "Min",
    "where": "Piecewise",
    "heaviside": "Heaviside",
    "fmod": "Mod",
    "mod": "Mod",
    "ceil": "ceiling",
}
"""Functions of math and NumPy that SymPy spells in another way."""


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
    called = [found.groups() for line in lines if (found := _CALLED.search(line))]
    package, name = called[-1] if called else ("", "")
    if type(error) is AttributeError:  # NumPy asks an expression for methods of its names
        if not name or f"object has no attribute '{name}'" not in text:
            return ""
    elif "Cannot convert" not in text and "ufunc" not in text:
        return ""
    elif not name and (asked := _UFUNC.search(text)):
        package, name = "numpy", asked[1] or asked[2]
    if not name:
        return "math, NumPy and float() need numbers: use functions of sympy, such as sympy.sin"
    return (
        f"math and NumPy need numbers: use sympy.{_SPELLED.get(name, name)} in place of "
        f"{package}.{name}"
    )
