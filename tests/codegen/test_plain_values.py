"""Units, ranges of expressions and numbers, as the boundary of a declaration reads them."""

import math
import time
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
import sympy

from codegen import Model
from codegen.declare.units import known_unit
from codegen.plain_values import InvalidName, genuine, one_line, plain_float, shown
from codegen.quantities import pint_form
from codegen.real_range import unreal_part


def test_units_are_read_by_a_grammar_of_their_own() -> None:
    assert pint_form("N s/m") == "N*s/(m)"
    assert pint_form("kg m^-2/s") == "kg*m**-2/(s)"
    started = time.perf_counter()
    for unit in (
        "9**9**9**9",
        "m**9**9",
        "m^(2^99)",
        "(" * 99,
        "m" * 999,
        "__import__('os')",
        "m^999",
    ):
        assert not known_unit(unit)
    assert time.perf_counter() - started < 5


X, Y = sympy.symbols("x y", real=True)


@pytest.mark.parametrize(
    "never",
    [
        sympy.sqrt(-1 - X**2),
        sympy.log(-(X**2)),
        sympy.acos(2 + sympy.Abs(X)),
        sympy.asin(2),
        1 + sympy.I,
        sympy.sqrt(sympy.sin(X) - 2),
        (-1 - sympy.exp(X)) ** sympy.Rational(1, 3),
        sympy.exp(1000),
        sympy.oo * X,
        sympy.Piecewise((sympy.sqrt(-1 - X**2), X > 0), (0, True)),
        sympy.Pow(9, sympy.Pow(9, 9**9, evaluate=False), evaluate=False),
    ],
)
def test_what_is_real_nowhere_is_found(never: sympy.Expr) -> None:
    assert unreal_part(never) is not None


@pytest.mark.parametrize(
    "real",
    [
        sympy.sqrt(1 - X**2),
        X**1.5,
        sympy.log(X),
        sympy.asin(X / 1000),
        sympy.sqrt(sympy.sin(X)),
        1 / X,
        sympy.sqrt(X - 1e9),
        sympy.exp(-1000 * X),
        sympy.sqrt(1 - sympy.cos(X)),
        X ** sympy.Symbol("e", real=True),
        sympy.acos(1 + sympy.sin(X)),
        sympy.atan2(X, Y),
        sympy.Rational(1, 3) ** X,
    ],
)
def test_what_is_real_somewhere_is_let_alone(real: sympy.Expr) -> None:
    assert unreal_part(real) is None


@pytest.mark.parametrize(
    "value", [2, 2.0, np.float64(2), np.int64(2), np.array(2.0), sympy.Integer(2)]
)
def test_a_number_of_any_kind_is_a_number(value: Any) -> None:
    model = Model("m")
    model.parameter("k", value)
    body = model.body("a", mass=value, inertia=value)
    assert model.problems == ()
    assert model.parameters["k"].value == 2.0
    assert float(body.mass or math.nan) == 2.0


class OwnText(str):
    """A text whose methods fail."""

    __slots__ = ()

    def _fail(self, *_: object) -> Any:
        raise RuntimeError("of the user's own")

    __eq__ = __hash__ = __str__ = __repr__ = __format__ = __len__ = _fail  # type: ignore[assignment]


def test_text_of_a_class_of_its_own_is_read_as_plain_text() -> None:
    invalid = InvalidName("<nothing>")
    assert genuine([OwnText("a"), {"b": (OwnText("c"),)}]) == ["a", {"b": ("c",)}]
    assert type(genuine(OwnText("a"))) is str
    assert genuine(invalid) is invalid


def test_what_is_honest_is_the_same_object() -> None:
    loop: list[Any] = [1.0]
    loop.append(loop)
    for value in (loop, {"a": [1, 2]}, (1, "a", None), {1}, np.ones(3), object(), 2.0):
        assert genuine(value) is value


def test_a_value_whose_text_ends_all_is_shown_by_its_class() -> None:
    class End(BaseException):
        """An exception of the user's own."""

    class Silent:
        def __repr__(self) -> str:
            raise End

    assert shown(Silent()) == one_line(Silent()) == "a Silent"


@pytest.mark.parametrize("zero", [0.0, -0.0, sympy.Float(0.0), sympy.S.Zero, Decimal("0.00")])
def test_zero_is_a_number(zero: Any) -> None:
    """SymPy's `Float(0.0)` is not equal to 0."""
    assert plain_float(zero) == 0.0
    expression = sympy.Piecewise((sympy.Float(0.0), sympy.Symbol("x") < 1), (1.0, True))
    assert unreal_part(expression) is None


@pytest.mark.parametrize(
    "zero",
    [
        sympy.log(6) - sympy.log(2) - sympy.log(3),
        sympy.cos(1) ** 2 + sympy.sin(1) ** 2 - 1,
        sympy.sqrt(2) + sympy.sqrt(3) - sympy.sqrt(5 + 2 * sympy.sqrt(6)),
    ],
    ids=str,
)
def test_a_sum_that_is_zero_is_a_number(zero: sympy.Expr) -> None:
    """SymPy finds no digit of it, and cannot tell it from a number that is very small."""
    assert plain_float(zero) == 0.0
