"""Messages that say what was probably meant."""

import math

import pytest

from codegen import LinkwrightError, Model


def test_a_word_that_is_nearly_one_is_answered_with_it() -> None:
    with pytest.raises(LinkwrightError, match=r"\. gravty: did you mean gravity\?$"):
        Model("m", gravty=(0, -9.81))  # type: ignore[call-arg]


def test_functions_that_need_numbers_name_the_symbol_and_the_remedy() -> None:
    body = Model("m").body("b", mass=1.0, inertia=1.0)
    for call in (math.sin, float):
        with pytest.raises(TypeError, match=r"'b_phi' has no value .* functions of sympy: sin"):
            call(body.phi)
