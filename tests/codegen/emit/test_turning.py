"""Sine and cosine at once, as generated modules take them."""

import math
from collections.abc import Callable

import numba
import numpy as np
import pytest

from codegen.emit.module_functions import SIN_COS, SIN_COS_FUNCTION

Pair = Callable[[float], tuple[float, float]]


@pytest.fixture(scope="module", params=["Python", "machine code"])
def sin_cos(request: pytest.FixtureRequest) -> Pair:
    options = {"error_model": "numpy", "fastmath": {"contract"}}
    names = {"math": math, "numba": numba, "OPTIONS": options}
    exec(SIN_COS_FUNCTION, names)
    compiled = names[SIN_COS]
    return compiled if request.param == "machine code" else compiled.py_func


@pytest.mark.parametrize("size", [1e-8, 1.0, 7.0, 1e3, 9.9e5])
def test_two_units_of_the_last_digit(sin_cos: Pair, size: float) -> None:
    for x in np.random.default_rng(5).uniform(-size, size, 4000).tolist():
        for found, exact in zip(sin_cos(x), (math.sin(x), math.cos(x)), strict=True):
            assert abs(found - exact) <= 2 * math.ulp(exact) + 1e-16 * 1e-3


@pytest.mark.parametrize("quarters", range(-9, 10))
def test_multiples_of_a_right_angle(sin_cos: Pair, quarters: int) -> None:
    x = quarters * math.pi / 2
    assert sin_cos(x) == pytest.approx((math.sin(x), math.cos(x)), rel=0.0, abs=1e-16)


def test_zero_and_what_is_beyond(sin_cos: Pair) -> None:
    assert sin_cos(0.0) == (0.0, 1.0)
    assert sin_cos(3e7) == (math.sin(3e7), math.cos(3e7))
    assert all(map(math.isnan, sin_cos(math.nan)))
