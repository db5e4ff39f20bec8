"""Linear equations and polynomials inside compiled code, against numpy."""

from fractions import Fraction

import numpy as np
import pytest
from numba import njit

from runtime.integrate.explicit.newton_form import nested, nesting
from runtime.linalg.lu import factor, solve


@njit
def solved(a, f, b):
    pivots = np.zeros(f, np.int64)
    if factor(a, f, pivots) != 0:
        return 1
    solve(a, f, pivots, b)
    return 0


@pytest.mark.parametrize("f", [1, 2, 3, 7, 20])
def test_solution(f):
    random = np.random.default_rng(f)
    a, b = random.standard_normal((f, f)), random.standard_normal(f)
    a[0, 0] = 0.0 if f > 1 else a[0, 0]  # rows have to be exchanged
    x = b.copy()
    assert solved(a.ravel().copy(), f, x) == 0
    np.testing.assert_allclose(x, np.linalg.solve(a, b), rtol=1e-10)


@pytest.mark.parametrize("a", [[[0.0]], [[1.0, 2.0], [2.0, 4.0]], [[np.nan]]])
def test_singular_matrices_are_told(a):
    a = np.array(a)
    assert solved(a.ravel().copy(), len(a), np.ones(len(a))) == 1


@pytest.mark.parametrize("degree", range(6))
def test_nested_form_is_the_polynomial(degree):
    powers = [Fraction(3 * i * i - 7, i + 2) for i in range(degree + 1)]
    found = nested(powers)
    for x in (Fraction(0), Fraction(1), Fraction(1, 3), Fraction(-5, 7)):
        value = found[-1]
        for i in range(degree - 1, -1, -1):
            value = found[i] + (x if i % 2 == 0 else 1 - x) * value
        assert value == sum(c * x**i for i, c in enumerate(powers))


def test_nesting_is_linear():
    p, q = [Fraction(1), Fraction(2)], [Fraction(0), Fraction(1), Fraction(-4)]
    table = nesting([p, q])
    both = [float(a) for a in nested([3 * Fraction(1), Fraction(6 + 5), Fraction(-20)])]
    np.testing.assert_allclose(table @ [3.0, 5.0], [*both, 0.0, 0.0, 0.0], rtol=1e-15)
