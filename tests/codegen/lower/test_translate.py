"""Conditions become modes and switching functions; SymPy expressions keep their values."""

import math

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from sympy import Abs, And, Heaviside, Max, Min, Not, Or, Piecewise, sign

from codegen import Model, t
from tests.codegen.workbench import Interpreted, State


def machine_with(force: object, body_name: str = "body") -> Interpreted:
    model = Model("one")
    body = model.body(body_name, mass=1.0, inertia=1.0)
    model.parameter("p", 1.5)
    model.force("push", on=body, fx=force(body))
    return Interpreted(model)


def pushes(machine: Interpreted, x: float, vx: float) -> float:
    """The force at a state, its modes set as the switching functions say."""
    s = State(t=0.3, q=np.array([x, 0.2, 0.1]), v=np.array([vx, 0.0, 0.4]))
    modes = [int(g > 0) for g in machine.vector("switching", s)] if machine.s else []
    return machine.vector("applied_forces", s, modes=modes)[0]


GRID = [(x, vx) for x in (-2.3, -0.4, 0.7, 1.9) for vx in (-1.2, 0.6)]


@pytest.mark.parametrize(
    ("force", "count", "expected"),
    [
        (lambda b: Abs(b.x), 1, lambda x, v: abs(x)),
        (lambda b: sign(b.vx), 1, lambda x, v: math.copysign(1, v)),
        (lambda b: Max(b.x, b.vx), 1, max),
        (lambda b: Min(b.x, b.vx), 1, min),
        (lambda b: Max(b.x, b.vx, 0.1), 3, lambda x, v: max(x, v, 0.1)),
        (lambda b: Piecewise((5, Abs(b.x) < 1), (3, True)), 3, lambda x, v: 5 if abs(x) < 1 else 3),
        (
            lambda b: Piecewise((5, Max(b.x, b.vx) < 1), (3, True)),
            3,
            lambda x, v: 5 if x < 1 and v < 1 else 3,
        ),
        (lambda b: Heaviside(b.x), 1, lambda x, v: float(x > 0)),
        (lambda b: Abs(b.x) * sign(b.x), 1, lambda x, v: x),
        (
            lambda b: Piecewise((1, And(b.x > 0, b.vx > 0)), (2, True)),
            2,
            lambda x, v: 1 if x > 0 and v > 0 else 2,
        ),
        (
            lambda b: Piecewise((1, Or(b.x > 0, b.vx > 0)), (2, True)),
            2,
            lambda x, v: 1 if x > 0 or v > 0 else 2,
        ),
        (
            lambda b: Piecewise((1, Not(And(b.x > 0, b.vx > 0))), (2, True)),
            2,
            lambda x, v: 2 if x > 0 and v > 0 else 1,
        ),
        (
            lambda b: Piecewise((b.x, b.x < 1), (b.x**2, b.x < 1.5), (7, True)),
            2,
            lambda x, v: x if x < 1 else x * x if x < 1.5 else 7,
        ),
        (
            lambda b: Piecewise((1, b.x > 0), (0, True)) + Piecewise((2, b.x <= 0), (0, True)),
            1,
            lambda x, v: 1 if x > 0 else 2,
        ),
        (
            lambda b: (
                Piecewise((1, b.x - b.vx > 0), (0, True)) * Piecewise((5, b.x < b.vx), (3, True))
            ),
            1,
            lambda x, v: 3 if x > v else 0,
        ),
        (
            lambda b: Piecewise((Abs(b.x) + 1, b.vx > 0), (0, True)),
            2,
            lambda x, v: abs(x) + 1 if v > 0 else 0,
        ),
    ],
)
def test_pieces(force: object, count: int, expected: object) -> None:
    machine = machine_with(force)
    assert machine.s == count
    for x, vx in GRID:
        assert pushes(machine, x, vx) == pytest.approx(expected(x, vx), rel=1e-14, abs=1e-14)


def test_condition_and_its_negation_share_a_switching_function() -> None:
    model = Model("one")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.force("out", on=body, fx=1.0, when=body.vx > 0)
    model.force("back", on=body, fx=-2.0, when=body.vx <= 0)
    model.force("either", on=body, fy=5.0, when=Or(body.vx > 0, body.x > 1))
    machine = Interpreted(model)
    assert [(s.effect, s.text) for s in machine.equations.switches] == [
        ("out", "body_vx > 0"),
        ("either", "body_x > 1"),
    ]
    s = machine.state(0)
    assert list(machine.vector("applied_forces", s, modes=[1, 0])) == [1, 5, 0]
    assert list(machine.vector("applied_forces", s, modes=[0, 0])) == [-2, 0, 0]
    assert list(machine.vector("applied_forces", s, modes=[0, 1])) == [-2, 5, 0]


def test_rates_of_switching_functions_follow_the_motion() -> None:
    model = Model("one")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.force("push", on=body, fx=1.0, when=body.vx * body.x > sympy.sin(3 * t))
    machine = Interpreted(model)
    s, a = machine.state(0), np.array([0.7, 0.1, 0.2])
    rate = machine.vector("switching_rates", s, a=a)
    expected = a[0] * s.q[0] + s.v[0] ** 2 - 3 * np.cos(3 * s.t)
    assert_allclose(rate, [expected], rtol=1e-14)


@pytest.mark.parametrize(
    "force",
    [
        lambda b: sympy.sin(b.x) * sympy.cos(b.x) + sympy.tan(b.x / 5),
        lambda b: sympy.asin(b.x / 5) + sympy.acos(b.x / 5) * sympy.atan(b.vx),
        lambda b: sympy.atan2(b.x, b.vx),
        lambda b: sympy.sinh(b.x) + sympy.cosh(b.vx) * sympy.tanh(b.phi),
        lambda b: sympy.exp(-b.x) + sympy.log(b.x**2 + 1) + 1 / sympy.exp(2 * b.vx),
        lambda b: sympy.sqrt(b.x**2 + 1) + (b.x**2 + 1) ** sympy.Rational(1, 3),
        lambda b: (b.x**2 + 2) ** b.vx + b.x**7 - b.x**-3 + 2**b.x,
        lambda b: sympy.pi * b.x + sympy.E * sympy.Rational(1, 3) + t**2,
        lambda b: b.x / (b.vx * (b.x - 3)) - (b.vx - b.x) / 7,
        lambda b: 0.1 * b.x + sympy.Float("0.1"),
    ],
)
def test_functions_keep_their_values(force: object) -> None:
    model = Model("one")
    body = model.body("body", mass=1.0, inertia=1.0)
    expression = force(body)
    model.force("push", on=body, fx=expression)
    machine = Interpreted(model)
    symbols = (t, *body.coordinates, *(q.rate for q in body.coordinates))
    function = sympy.lambdify(symbols, expression, "math")
    for seed in range(5):
        s = machine.state(seed)
        expected = function(s.t, *s.q.tolist(), *s.v.tolist())
        got = machine.vector("applied_forces", s)[0]
        assert got == pytest.approx(expected, rel=1e-13)
