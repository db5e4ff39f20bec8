"""Units, ranges of expressions and numbers, as the boundary of a declaration reads them."""

import math
import time
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
import sympy

from codegen import Model
from codegen.readers.expressions import unreal_part
from codegen.readers.quantities import known_unit, pint_form
from codegen.readers.values import plain_float


def test_units_are_read_by_a_grammar_of_their_own() -> None:
    assert pint_form("N s/m") == "(N s)/(m)"
    assert pint_form("kg m^-2/s") == "(kg m^-2)/(s)"
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
        sympy.asin(2),
        1 + sympy.I,
        sympy.exp(1000),
        sympy.oo * X,
        sympy.Piecewise((sympy.sqrt(-1 - sympy.pi), X > 0), (0, True)),
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
