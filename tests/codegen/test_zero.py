"""What is zero is told from what is small, and nothing is said of what is not known."""

import pytest
import sympy

from codegen.derive.constraint_terms import is_zero

a, b, phi = sympy.symbols("a b phi")


@pytest.mark.parametrize(
    "expr",
    [
        sympy.S.Zero,
        (a + b) ** 2 - a**2 - 2 * a * b - b**2,
        sympy.sin(phi) ** 2 + sympy.cos(phi) ** 2 - 1,
        sympy.sin(a + b) - sympy.sin(a) * sympy.cos(b) - sympy.cos(a) * sympy.sin(b),
        (a - b) / (a**2 - b**2) - 1 / (a + b),
    ],
)
def test_what_cancels_is_zero(expr: sympy.Expr) -> None:
    assert is_zero(expr)


@pytest.mark.parametrize(
    "expr",
    [
        a,
        1e-9 * a,
        (a + b) ** 2 - a**2 - b**2,
        (a + b) ** 2 - (a + b * (1 + 1e-9)) ** 2,
        sympy.sin(phi) ** 2 + sympy.cos(phi) ** 2,
        sympy.Float(1e-200) * sympy.cos(phi),
    ],
)
def test_what_is_small_is_not(expr: sympy.Expr) -> None:
    assert not is_zero(expr)


def test_of_what_has_no_number_nothing_is_said() -> None:
    f = sympy.Function("f")
    hidden = sympy.Mul(f(a), b + 1, evaluate=False) - f(a) * b - f(a)
    assert sympy.expand(hidden) == 0
    assert not is_zero(hidden)
    assert not is_zero(sympy.sqrt(-1 - a**2) * (a + b))
