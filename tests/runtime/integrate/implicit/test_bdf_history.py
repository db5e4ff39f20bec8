"""The past of BDF: dense output through its states, in the nested form."""

from fractions import Fraction

import pytest

from runtime.integrate.implicit.bdf_history import newton_form


@pytest.mark.parametrize("degree", range(6))
def test_nested_form_is_the_polynomial(degree):
    powers = [Fraction(3 * i * i - 7, i + 2) for i in range(degree + 1)]
    found = newton_form(powers)
    for x in (Fraction(0), Fraction(1), Fraction(1, 3), Fraction(-5, 7)):
        value = found[-1]
        for i in range(degree - 1, -1, -1):
            value = found[i] + (x if i % 2 == 0 else 1 - x) * value
        assert value == sum(c * x**i for i, c in enumerate(powers))
