"""Powers with exponents that are not whole, where their base is zero: finite what is finite."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from sympy import Rational

from codegen import Model, t
from codegen.lower.differentiation.program_tangents import tangent_program
from codegen.lower.interpreter import evaluate
from tests.codegen.workbench import Interpreted, State

Expression = Callable[[sympy.Symbol, sympy.Symbol], sympy.Expr]
EXPONENTS = (Rational(5, 2), 3.5, 2.3, 1.5, Rational(4, 3), 16.5)
BASES: dict[str, Expression] = {
    "x": lambda x, y: x,
    "-y": lambda x, y: -y,
    "3 x": lambda x, y: 3 * x,
    "x² + y²": lambda x, y: x**2 + y**2,
    "x² + y⁴": lambda x, y: x**2 + y**4,
    "1 + x - y": lambda x, y: 1 + x - y,
}


def bead(expression: Expression, as_constraint: bool) -> Interpreted:
    model = Model("bead")
    bead = model.particle("bead", mass=1.0)
    if as_constraint:
        model.constraint("c", expression(bead.x, bead.y) - bead.x - bead.y)
    else:
        model.potential("v", expression(bead.x, bead.y))
    return Interpreted(model)


def power(base: str, exponent: float) -> Expression:
    return lambda x, y: (2 + sympy.cos(y)) * BASES[base](x, y) ** exponent


def limits(expression: Expression, x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    """Gradient and Hessian, as limits towards (x, y) from where the base is positive."""
    symbols = sympy.symbols("x y", real=True)
    value, step = expression(*symbols), Rational(1, 10**60)
    at = dict(zip(symbols, (x + step, y - step / 3), strict=True))
    gradient = [float(sympy.diff(value, a).evalf(100, subs=at)) for a in symbols]
    hessian = [
        [float(sympy.diff(value, a, b).evalf(100, subs=at)) for b in symbols] for a in symbols
    ]
    return np.array(gradient), np.array(hessian)


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("exponent", EXPONENTS)
def test_derivatives_at_zero_are_finite_where_they_are(base: str, exponent: float) -> None:
    expression = power(base, exponent)
    gradient, hessian = limits(expression, 0.0, 0.0)
    v = np.array([0.4, -0.7])
    for velocity in (v, 0 * v):
        state = State(t=0.0, q=np.zeros(2), v=velocity)
        held = bead(expression, as_constraint=True)
        assert_allclose(held.jacobian(state)[0] + 1, gradient, atol=1e-12)
        assert_allclose(held.vector("velocity_rhs", state), 0.0, atol=0)
        bend = -(velocity @ hessian @ velocity)
        found = held.vector("acceleration_rhs", state)
        if abs(bend) < 1e12:
            assert_allclose(found, [bend], rtol=1e-9, atol=1e-9)
        else:  # an infinite one comes out so
            assert np.isinf(found).all()
    free = bead(expression, as_constraint=False)
    assert_allclose(free.vector("potential_gradient", state), gradient, atol=1e-12)
    program = tangent_program(free.program)
    for k in range(2):
        inputs = {"t": 0.0, "q": [0.0, 0.0], "v": [0.0, 0.0], "p": free.p, "modes": []}
        inputs |= {"dq": [1.0 - k, float(k)], "dv": [0.0, 0.0]}
        da = evaluate(program, "accelerations_tangent", inputs, math)["da"]
        if np.abs(hessian).max() < 1e12:
            assert_allclose([da[0], da[1]], -hessian[k], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_laws_of_time_start_at_zero(exponent: float) -> None:
    model = Model("law")
    bead = model.particle("bead", mass=1.0)
    model.absolute("rail", bead, "y", 0)
    model.driver("drive", bead.x, t**exponent)
    machine = Interpreted(model)
    e = float(exponent)
    for time in (0.0, 0.3):
        state = State(t=time, q=np.zeros(2), v=np.zeros(2))
        nu = machine.vector("velocity_rhs", state)[1]
        gamma = machine.vector("acceleration_rhs", state)[1]
        assert nu == pytest.approx(e * time ** (e - 1), rel=1e-14)
        if time > 0.0 or e > 2.0:
            assert gamma == pytest.approx(e * (e - 1) * time ** (e - 2), rel=1e-13)
        else:
            assert gamma == math.inf


def test_a_root_of_a_negative_number_is_not_complex() -> None:
    model = Model("root")
    bead = model.particle("bead", mass=1.0)
    model.driver("drive", sympy.sin(bead.x ** Rational(1, 3)), t)
    machine = Interpreted(model)
    state = State(t=0.0, q=np.array([-1.0, 0.0]), v=np.zeros(2))
    assert np.isnan(machine.vector("constraints", state)).all()
