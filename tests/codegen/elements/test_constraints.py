"""Constraints and drivers of coordinates and of expressions, against formulas by hand."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.elements.hand.joints import VALUE
from tests.codegen.elements.hand.pair import SJ
from tests.codegen.workbench import A, B, Interpreted

TOLERANCE = {"rtol": 1e-12, "atol": 1e-13}


@pytest.mark.parametrize("letter", ["x", "y", "phi"])
def test_absolute_is_haugs(letter: str) -> None:
    model = Model("held")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.absolute("hold", body.at(*SJ), letter, VALUE)
    machine = Interpreted(model)
    for seed in range(5):
        s = machine.state(seed)
        r, phi, _, omega = s.body(0)
        if letter == "phi":
            expected, row, gamma = phi, [0, 0, 1], 0.0
        else:
            k = "xy".index(letter)
            expected, gamma = (r + A(phi) @ SJ)[k], (A(phi) @ SJ)[k] * omega**2
            row = [*np.eye(2)[k], (B(phi) @ SJ)[k]]
        assert_allclose(machine.vector("constraints", s), [expected - VALUE], **TOLERANCE)
        assert_allclose(machine.jacobian(s), [row], **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), [gamma], **TOLERANCE)


def test_driver_of_a_coordinate() -> None:
    model = Model("driven")
    body = model.body("body", mass=1.0, inertia=1.0)
    speed = model.parameter("speed", 3.0, unit="rad/s")
    model.driver("drive", body.phi, 0.4 + sympy.sin(speed * t))
    machine = Interpreted(model)
    s = machine.state(1)
    angle = 3.0 * s.t
    assert_allclose(machine.vector("constraints", s), [s.q[2] - 0.4 - np.sin(angle)], **TOLERANCE)
    assert_allclose(machine.jacobian(s), [[0, 0, 1]], atol=0)
    assert_allclose(machine.vector("velocity_rhs", s), [3 * np.cos(angle)], **TOLERANCE)
    assert_allclose(machine.vector("acceleration_rhs", s), [-9 * np.sin(angle)], **TOLERANCE)


def test_driver_of_an_expression() -> None:
    model = Model("driven")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.driver("drive", body.x * body.y, t**3)
    machine = Interpreted(model)
    s = machine.state(2)
    (x, y, _), (vx, vy, _) = s.q, s.v
    assert_allclose(machine.vector("constraints", s), [x * y - s.t**3], **TOLERANCE)
    assert_allclose(machine.jacobian(s), [[y, x, 0]], **TOLERANCE)
    assert_allclose(machine.vector("velocity_rhs", s), [3 * s.t**2], **TOLERANCE)
    assert_allclose(machine.vector("acceleration_rhs", s), [6 * s.t - 2 * vx * vy], **TOLERANCE)


def test_constraint_of_ones_own() -> None:
    model = Model("own")
    body = model.body("body", mass=1.0, inertia=1.0)
    p = model.parameter("p", 1.3)
    model.constraint("own", body.x**2 + p * body.y * sympy.cos(body.phi) - sympy.sin(t) * body.x)
    machine = Interpreted(model)
    for seed in range(5):
        s = machine.state(seed)
        (x, y, phi), (vx, vy, w) = s.q, s.v
        c, d, st, ct = np.cos(phi), np.sin(phi), np.sin(s.t), np.cos(s.t)
        assert_allclose(
            machine.vector("constraints", s), [x * x + 1.3 * y * c - st * x], **TOLERANCE
        )
        assert_allclose(machine.jacobian(s), [[2 * x - st, 1.3 * c, -1.3 * y * d]], **TOLERANCE)
        assert_allclose(machine.vector("velocity_rhs", s), [ct * x], **TOLERANCE)
        gamma = -(2 * vx**2 - 2.6 * d * vy * w - 1.3 * y * c * w**2) + 2 * ct * vx - st * x
        assert_allclose(machine.vector("acceleration_rhs", s), [gamma], **TOLERANCE)
