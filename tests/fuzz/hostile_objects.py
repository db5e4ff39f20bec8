"""Objects whose own methods raise, lie or never end, and values of kinds that are seldom met."""

import asyncio
import datetime
import functools
import itertools
import types
import uuid
from collections import ChainMap, Counter, OrderedDict, UserDict, UserList, UserString, deque
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from enum import Enum, IntEnum
from fractions import Fraction
from functools import cache
from typing import Any
from unittest.mock import Mock

import mpmath
import numpy as np
import pandas as pd
import sympy
import xarray as xr
from pint import UnitRegistry, get_application_registry
from sympy.abc import q, z

u = get_application_registry()
DUNDERS = (
    *("__float__", "__int__", "__index__", "__complex__", "__len__", "__iter__", "__next__"),
    *("__repr__", "__str__", "__format__", "__bytes__", "__eq__", "__ne__", "__bool__", "__hash__"),
    *("__lt__", "__gt__", "__le__", "__ge__", "__getitem__", "__contains__", "__call__", "__add__"),
    *("__radd__", "__mul__", "__rmul__", "__sub__", "__neg__", "__abs__", "__pow__", "__array__"),
    *("__getattr__", "__fspath__", "__sympy__", "_sympy_", "__reversed__", "__round__", "keys"),
)
LIES: tuple[Any, ...] = (None, "5", -1, 10**9, 1.5, True, NotImplemented, [], "__import__('os')")
ENDS = (RuntimeError, KeyError, RecursionError, MemoryError, SystemExit, GeneratorExit, OSError)


class End(BaseException):
    """An exception of the user's own that ends all."""


@cache
def raising(word: str, kind: type[BaseException] = RuntimeError) -> type[Any]:
    """A class one of whose methods raises."""

    def fail(self: Any, *_: Any) -> Any:
        raise kind("of the user's own")

    return type("Raising", (), {word: fail})


@cache
def lying(word: str, at: int) -> type[Any]:
    """A class one of whose methods answers nonsense."""
    return type("Lying", (), {word: lambda self, *_: LIES[at]})


class Disguised:
    """An object that says it is a float."""

    __class__ = float  # type: ignore[assignment]


class Hidden:
    """An object whose class is not to be had."""

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        raise RuntimeError("of the user's own")


class Meta(type):
    """A class whose text fails."""

    def __repr__(cls) -> str:
        raise RuntimeError("of the user's own")


class Mute(type):
    """A class of classes that say nothing of themselves."""

    def __getattribute__(cls, word: str) -> Any:
        if word in ("__name__", "__mro__"):
            raise RuntimeError("of the user's own")
        return type.__getattribute__(cls, word)


class Nameless(metaclass=Mute):
    """An object of such a class."""


class Odd(str):
    """A text that cannot be compared."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("of the user's own")

    __hash__ = str.__hash__


class Faceless(metaclass=Meta):
    """An object of it."""


class AlwaysEqual:
    """An object that equals all."""

    def __eq__(self, other: object) -> bool:
        return True

    def __hash__(self) -> int:
        return 0


class ArrayEqual:
    """An object whose comparison has no truth value."""

    def __eq__(self, other: object) -> Any:
        return np.array([True, False])

    def __hash__(self) -> int:
        return 1


class EndlessMapping(Mapping[Any, Any]):
    """A mapping without an end, each of whose entries is there."""

    def __getitem__(self, key: Any) -> Any:
        return 1.0

    def __len__(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Any]:
        raise RuntimeError("of the user's own")


class Text(str):
    """A text that says another one."""

    __slots__ = ()

    def __str__(self) -> str:
        raise RuntimeError("of the user's own")

    __repr__ = __format__ = __str__  # type: ignore[assignment]


class Number(float):
    """A number whose methods fail."""

    def _fail(self, *_: Any) -> Any:
        raise RuntimeError("of the user's own")

    __float__ = __repr__ = __str__ = __eq__ = __bool__ = __neg__ = __mul__ = __hash__ = _fail  # type: ignore[assignment]


class Whole(int):
    """The same of whole numbers."""

    def __repr__(self) -> str:
        raise RuntimeError("of the user's own")

    __str__ = __format__ = __float__ = __repr__  # type: ignore[assignment]


class Colour(Enum):
    """Words."""

    RED = "red"


class Level(IntEnum):
    """Whole numbers with names."""

    LOW = 1


class OwnExpression(sympy.Expr):  # type: ignore[misc]
    """An expression that SymPy does not know."""

    def _sympystr(self, _: Any) -> str:
        raise RuntimeError("of the user's own")


def _raises_at(end: int) -> Iterator[float]:
    yield from range(end)
    raise RuntimeError("of the user's own")


def _cycle() -> dict[Any, Any]:
    loop: dict[Any, Any] = {}
    loop["a"] = loop
    return loop


@cache
def _another_registry() -> Any:
    return UnitRegistry()


def _coroutine() -> Any:
    async def run() -> None:
        await asyncio.sleep(0)

    made = run()
    made.close()
    return made


f = sympy.Function("f")
A = sympy.MatrixSymbol("A", 2, 2)
SELDOM: list[Callable[[], Any]] = [
    *(raising(word) for word in DUNDERS if word != "__getattr__"),
    *(lying(w, k % len(LIES)) for k, w in enumerate(DUNDERS) if w != "__hash__"),
    *(raising("__float__", kind) for kind in ENDS),
    *(raising("__iter__", kind) for kind in ENDS),
    *(raising("__repr__", kind) for kind in (*ENDS, End)),
    *(Nameless, lambda: Mock(spec=sympy.Expr), lambda: Mock(spec=str), lambda: Odd("a.x")),
    *(Disguised, Hidden, Faceless, lambda: Faceless, AlwaysEqual, ArrayEqual, EndlessMapping),
    *(lambda: Text("a.x"), lambda: Colour.RED, lambda: Colour, OwnExpression),
    *(lambda: _raises_at(0), lambda: _raises_at(2), lambda: itertools.repeat(1), _cycle),
    *(lambda: deque([1, 2, 3, 4, 5]), lambda: UserList([1]), lambda: UserDict(a=1), Counter),
    *(lambda: UserString("5"), lambda: OrderedDict(a=1), lambda: ChainMap({"a": 1}, {})),
    *(lambda: types.SimpleNamespace(name="a"), lambda: types.SimpleNamespace(name=7)),
    *(lambda: types.MappingProxyType({"b": 2}), lambda: functools.partial(max, 1), _coroutine),
    *(lambda: memoryview(b"ab"), lambda: bytearray(b"5"), lambda: array_of("U5"), uuid.uuid4),
    *(lambda: array_of(object), lambda: np.array(["2020"], "M8"), lambda: np.timedelta64(1, "s")),
    *(lambda: datetime.timedelta(1), lambda: datetime.datetime(2020, 1, 1), lambda: np.void(b"a")),
    *(
        lambda: np.array(1j),
        lambda: np.array("5"),
        lambda: np.array(None),
        lambda: np.empty((0, 3)),
    ),
    *(lambda: np.ma.masked_all(3), lambda: np.dtype(float), lambda: np),
    *(lambda: pd.Series([1.0, 2.0], index=["a", "b"]), lambda: pd.DataFrame({"a": [1]})),
    *(lambda: pd.NA, lambda: pd.NaT, lambda: pd.Timestamp(0), lambda: mpmath.mpc(1, 1)),
    *(lambda: xr.DataArray([1j]), lambda: xr.DataArray("a"), lambda: xr.DataArray(None)),
    *(lambda: u.Quantity("5 m").u, lambda: u.Quantity([1, 2], "m"), lambda: u.Quantity(1j, "m")),
    *(lambda: u.Quantity("a", ""), lambda: u.Quantity(20, "degC")),
    *(lambda: u, lambda: u.Quantity(sympy.I, "m")),
    lambda: u.Quantity(3, "delta_degC"),
    *(lambda v=v: v for v in (sympy.Lambda(z, z), sympy.Poly(z), sympy.Tuple(1, 2), f, f(q), A)),
    *(lambda v=v: v for v in (A[0, 0], A * A, sympy.Determinant(A), sympy.Indexed("B", 1))),
    *(lambda v=v: v for v in (sympy.Dict({1: 2}), sympy.AccumBounds(0, 1), sympy.O(z), sympy.S)),
    *(lambda v=v: v for v in (sympy.Derivative(f(q), q), sympy.Subs(f(q), q, 1), sympy.EmptySet)),
    *(
        lambda v=v: v
        for v in (sympy.Dummy(), sympy.Wild("w"), sympy.core.symbol.Str("a"), sympy.Q.real(z))
    ),
    *(lambda v=v: v for v in (sympy.symbols("n", commutative=False), sympy.Idx("i"), z > q)),
    *(
        lambda v=v: v
        for v in (sympy.Xor(z > 0, q > 0), sympy.Contains(z, sympy.Reals), sympy.Not(z))
    ),
    *(lambda v=v: v for v in (sympy.factorial(z), sympy.re(z), sympy.conjugate(z), z**z * sympy.I)),
    *(lambda v=v: v for v in (sympy.UnevaluatedExpr(z), sympy.Sum(z, (z, 1, q)), sympy.Rational)),
    *(lambda v=v: v for v in (Decimal("sNaN"), Decimal("1e999999"), Decimal("-Infinity"))),
    *(lambda v=v: v for v in (sympy.Limit(z, z, 0), sympy.zeta(z))),
    *(lambda v=v: v for v in (Fraction, complex("nan+infj"), super, property(), classmethod(len))),
]
"""What is no number, expression, name or part of a machine."""

ODD_NUMBERS: list[Callable[[], Any]] = [
    *(lambda: Number(2.0), lambda: Whole(2), lambda: Level.LOW, lambda: mpmath.mpf(2)),
    *(lambda: np.longdouble(2), lambda: np.float16(2), lambda: np.uint8(2), lambda: np.array(2)),
    *(lambda: Decimal(2), lambda: Fraction(2), lambda: xr.DataArray(2.0), lambda: sympy.pi),
]
"""What is a number all the same."""


def array_of(kind: Any) -> Any:
    """An array of no numbers."""
    return np.array(["a", "b"], dtype=kind)
