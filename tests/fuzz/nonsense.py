"""Values of every kind that an argument may wrongly have, each with the name of its kind."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy
import xarray as xr

NUMBERS = {"one", "minus", "zero", "float", "array of no dimension", "data array", "decimal"}
NUMBERS |= {"fraction", "sympy number"}
"""Kinds that are finite real numbers."""
POSITIVE = NUMBERS - {"minus", "zero"}
TEXTS = {"text", "empty", "number as text", "newline", "code", "path-like text"}
KINDS: dict[str, Callable[[], Any]] = {
    "none": lambda: None,
    "true": lambda: True,
    "one": lambda: 1,
    "minus": lambda: -1,
    "zero": lambda: 0,
    "float": lambda: 0.25,
    "nan": lambda: float("nan"),
    "infinity": lambda: float("inf"),
    "beyond floats": lambda: 10**400,
    "text": lambda: "abc",
    "empty": lambda: "",
    "number as text": lambda: "5",
    "newline": lambda: "a\nb",
    "code": lambda: "__import__('os').abort()",
    "path-like text": lambda: "../../abc",
    "very long text": lambda: "x" * 5000,
    "bytes": lambda: b"abc",
    "list": lambda: [1.0, 2.0],
    "empty list": list,
    "ragged list": lambda: [[1, 2], [3]],
    "list of text": lambda: ["abc", "de"],
    "list of code": lambda: ["__import__('os').abort()"],
    "tuple": lambda: (0.1, 0.2),
    "set": lambda: {1, 2},
    "mapping": lambda: {"abc": 1.0},
    "mapping of numbers": lambda: {7: 1.0},
    "mapping to none": lambda: {"abc": None},
    "read-only mapping": lambda: MappingProxyType({None: 1.0}),
    "array": lambda: np.array([0.1, 0.2]),
    "array of no dimension": lambda: np.array(0.25),
    "matrix": lambda: np.ones((2, 2)),
    "array of objects": lambda: np.array([None, "x"], dtype=object),
    "array of texts": lambda: np.array(["a", "b"]),
    "masked array": lambda: np.ma.masked_array([0.1, 0.2], [True, False]),
    "masked number": lambda: np.ma.masked,
    "data array": lambda: xr.DataArray(2.0),
    "decimal": lambda: Decimal("0.25"),
    "fraction": lambda: Fraction(1, 4),
    "sympy number": lambda: sympy.Rational(1, 3),
    "symbol": lambda: sympy.Symbol("x"),
    "infinite symbol": lambda: sympy.zoo,
    "complex": lambda: 1j,
    "complex of numpy": lambda: np.complex128(1j),
    "date": lambda: np.datetime64("2020-01-01"),
    "generator": lambda: (k for k in range(3)),
    "range": lambda: range(3),
    "function": lambda: lambda *_: None,
    "class": lambda: dict,
    "object": object,
    "path": lambda: Path("abc"),
    "module": lambda: np,
}
"""Kind → a new value of it."""
