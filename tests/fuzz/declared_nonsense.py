"""Values that mean nothing where a kind of argument is needed, by kind, and hostile objects."""

import datetime
import itertools
import math
import os
import tempfile
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import sympy
import xarray as xr
from pint import UnitRegistry, get_application_registry
from sympy.physics.units import meter

from codegen.declare.element import I, J
from codegen.declare.symbols import SPEED, Acceleration, Multiplier, alpha, given, side, t
from tests.fuzz.hostile_objects import SELDOM

MARK = Path(tempfile.gettempdir()) / f"linkwright_fuzz_was_here_{os.getpid()}"
CODE = f"__import__('pathlib').Path({str(MARK)!r}).touch()"
u = get_application_registry()
x = sympy.Symbol("a_x", real=True)


class Raises:
    """Whatever is done with it fails."""

    def _fail(self, *_: object) -> Any:
        raise RuntimeError("of the user's own")

    __float__ = __int__ = __len__ = __iter__ = __repr__ = __str__ = __eq__ = __bool__ = _fail
    __hash__ = __index__ = __array__ = __lt__ = __getitem__ = __contains__ = __call__ = _fail


class Evaluated(float):
    """A number whose texts are code."""

    def __repr__(self) -> str:
        return f"0.0\n{CODE}\n"

    __str__ = __repr__


class Endless:
    """A list without an end."""

    def __iter__(self) -> Any:
        return itertools.count()


@cache
def another_registry() -> Any:
    """A registry of units that is not the application's."""
    return UnitRegistry()


def _loop() -> list[Any]:
    loop: list[Any] = []
    loop.append(loop)
    return loop


def _deep() -> sympy.Expr:
    deep = sympy.Symbol("a_x", real=True)
    for _ in range(230):
        deep = sympy.sin(deep, evaluate=False)
    return deep


OBJECTS: list[Callable[[], Any]] = [
    *(lambda v=v: v for v in (True, False, "", "5", "abc", "a.x", "nan", "1/0", b"5", 1j, 2 + 3j)),
    *(lambda v=v: v for v in (..., NotImplemented, int, print, len, math, object, Exception("e"))),
    *(
        lambda v=v: v
        for v in (datetime.date(2020, 1, 1), Path("a"), range(3), slice(1), np.bool_(1))
    ),
    *(lambda v=v: v for v in (np.str_("5"), np.complex128(1j), np.datetime64("2020-01-01"))),
    *(
        lambda v=v: v
        for v in (sympy.true, sympy.false, sympy.Eq(x, 1), x > 0, sympy.Interval(0, 1))
    ),
    *(lambda v=v: v for v in (sympy.FiniteSet(1), sympy.Matrix([1]), sympy.Matrix([[x, 1]]))),
    *(lambda v=v: v for v in (sympy.ImmutableMatrix([1]), sympy.MatrixSymbol("M", 1, 1))),
    object,
    lambda: lambda: 1,
    lambda: [1, 2, 3, 4, 5],
    lambda: [[1, 2], [3]],
    lambda: [CODE],
    lambda: (CODE, CODE),
    lambda: {CODE},
    lambda: {CODE: CODE},
    lambda: [[CODE], 0],
    lambda: CODE,
    lambda: f"a\n{CODE}",
    lambda: np.array([CODE, "1"]),
    lambda: np.array([CODE], dtype=object),
    lambda: {1.0},
    lambda: frozenset((0, 1)),
    dict,
    lambda: {"a": 1},
    list,
    lambda: (),
    lambda: np.array([]),
    lambda: np.array([1.0, 2.0, 3.0]),
    lambda: np.eye(2),
    lambda: np.ma.masked,
    lambda: np.ma.masked_array([1.0, 2.0], [True, False]),
    lambda: np.rec.array([(1, 2.0)], dtype=[("a", int), ("b", float)]),
    lambda: xr.DataArray([1.0, 2.0, 3.0]),
    xr.Dataset,
    lambda: (k for k in range(3)),
    Endless,
    Raises,
    lambda: [Raises()],
    _loop,
    lambda: [None],
    lambda: "x" * 100_000,
    lambda: "\ud800",
    lambda: u.Quantity(np.array([1.0, 2.0]), "m"),
    lambda: u.Quantity(np.array([1.0, 2.0]), "m")[:0],
    lambda: another_registry().Quantity(1.0, "m") * [1, 2],
    *SELDOM,
    lambda: u.m,
]
"""What is neither a number nor an expression, of any kind that Python has."""

NUMBERS: list[Callable[[], Any]] = [
    *(lambda v=v: v for v in (math.nan, math.inf, -math.inf, 10**400, -(10**5000), Decimal("NaN"))),
    *(lambda v=v: v for v in (Decimal("Infinity"), np.float64("nan"), np.float32("inf"))),
    *(lambda v=v: v for v in (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo, sympy.I, sympy.asin(2))),
    *(lambda v=v: v for v in (sympy.sqrt(-1), sympy.log(0), sympy.log(-1), sympy.acos(-3))),
    *(lambda v=v: v for v in (sympy.Float("1e500"), sympy.Integer(10) ** 400, 1 + sympy.I)),
    lambda: sympy.Pow(0, -1, evaluate=False),
    lambda: sympy.Pow(
        9, sympy.Pow(9, sympy.Pow(9, 9, evaluate=False), evaluate=False), evaluate=False
    ),
    *(lambda v=v: v for v in (sympy.Rational(10**5000 + 1, 10**5000), Fraction(1, 10**5000 + 1))),
    lambda: sympy.Pow(sympy.Rational(10**9 + 1, 10**9), sympy.Integer(10**9), evaluate=False),
    lambda: sympy.Pow(sympy.Rational(2, 3), sympy.Integer(10**9), evaluate=False),
    lambda: sympy.binomial(10**9, 5 * 10**8, evaluate=False),
    lambda: sympy.besselj(10**6, 10**6),
    lambda: sympy.totient(sympy.Integer(10**40 + 7), evaluate=False),
    lambda: Fraction(10**400),
    lambda: xr.DataArray(math.nan),
    lambda: u.Quantity(1.0, "furlong * kelvin"),
    lambda: u.Quantity(math.nan, "m"),
]
"""What is a number, and none that a machine can have."""

EXPRESSIONS: list[Callable[[], Any]] = [
    *(lambda v=v: v for v in (sympy.sqrt(-1 - x**2), sympy.log(-1 - x**2), sympy.acos(2 + x**2))),
    *(
        lambda v=v: v
        for v in (alpha, 1 + alpha, given("value"), I.s[0], SPEED, side("e"), 2 * SPEED)
    ),
    *(
        lambda v=v: v
        for v in (Multiplier("lambda_0", real=True), Acceleration("a_vx_rate", real=True))
    ),
    *(lambda v=v: v for v in (sympy.Symbol("unknown"), sympy.Dummy("d"), sympy.Wild("w"))),
    *(lambda v=v: v for v in (sympy.Symbol("A", commutative=False), sympy.Symbol("t"), J.s[1] * x)),
    *(
        lambda v=v: v
        for v in (sympy.Function("f")(t), sympy.Function("f")(x).diff(x), sympy.gamma(x))
    ),
    *(
        lambda v=v: v
        for v in (sympy.Integral(x, x), sympy.Sum(x, (x, 1, 3)), sympy.Order(x), x + sympy.I)
    ),
    *(
        lambda v=v: v
        for v in (sympy.zoo * x, x / sympy.Integer(0), sympy.Symbol("zz_x", real=True))
    ),
    *(
        lambda v=v: v
        for v in (sympy.DiracDelta(x), sympy.floor(x), sympy.ceiling(x), sympy.Mod(x, 2))
    ),
    lambda: sympy.Piecewise((sympy.sqrt(-1 - x**2), x > 0), (0, True)),
    lambda: sympy.Piecewise((1, x > 0)),
    lambda: sympy.Symbol(f"a\n{CODE}"),
    lambda: x * meter,
    _deep,
]
"""What is an expression, and means nothing in any declaration."""


def of_scalar(random: Random, *more: Callable[[], Any]) -> Any:
    """Nonsense where a number or an expression is needed."""
    return random.choice([*OBJECTS, *NUMBERS, *EXPRESSIONS, *more])()


def of_number(random: Random) -> Any:
    """Nonsense where a plain number is needed."""
    return random.choice([*OBJECTS, *NUMBERS, *EXPRESSIONS, lambda: x, lambda: None])()


def of_object(random: Random) -> Any:
    """Nonsense where an object of ours, a list or a word is needed."""
    plain = [lambda: None, lambda: 7, lambda: 1.5, lambda: x, lambda: t, lambda: Evaluated(2.0)]
    return random.choice([*OBJECTS, *NUMBERS, *EXPRESSIONS, *plain])()
