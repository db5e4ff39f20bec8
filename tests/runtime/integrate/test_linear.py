"""Polynomials in the nested form of dense output."""

from fractions import Fraction

import numpy as np
import pytest

from runtime.integrate.explicit.newton_form import newton_form, newton_form_matrix


@pytest.mark.parametrize("degree", range(6))
def test_nested_form_is_the_polynomial(degree):
    powers = [Fraction(3 * i * i - 7, i + 2) for i in range(degree + 1)]
    found = newton_form(powers)
    for x in (Fraction(0), Fraction(1), Fraction(1, 3), Fraction(-5, 7)):
        value = found[-1]
        for i in range(degree - 1, -1, -1):
            value = found[i] + (x if i % 2 == 0 else 1 - x) * value
        assert value == sum(c * x**i for i, c in enumerate(powers))


def test_nesting_is_linear():
    p, q = [Fraction(1), Fraction(2)], [Fraction(0), Fraction(1), Fraction(-4)]
    table = newton_form_matrix([p, q])
    both = [float(a) for a in newton_form([3 * Fraction(1), Fraction(6 + 5), Fraction(-20)])]
    np.testing.assert_allclose(table @ [3.0, 5.0], [*both, 0.0, 0.0, 0.0], rtol=1e-15)
