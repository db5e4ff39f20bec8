"""Joints and drivers against Haug's formulas (chapter 3) written out by hand."""

import cmath
from collections.abc import Callable

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.workbench import A, B, Interpreted, State, complex_gamma, complex_step

SI, SJ = np.array([0.7, -0.4]), np.array([-1.1, 0.3])
AXIS = np.array([2.0, -1.5])
ANGLE, LENGTH, VALUE = 0.35, 1.7, 0.6
TOLERANCE = {"rtol": 1e-12, "atol": 1e-13}

Rows = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Φ, Φ_q of body i (m × 3), Φ_q of body j (m × 3), γ."""


def span(s: State, i: int | None, j: int) -> tuple[np.ndarray, ...]:
    """d, ḋ, and d̈ without accelerations."""
    (ri, pi, vi, wi), (rj, pj, vj, wj) = s.body(i), s.body(j)
    d = rj + A(pj) @ SJ - ri - A(pi) @ SI
    rate = vj + wj * B(pj) @ SJ - vi - wi * B(pi) @ SI
    return d, rate, wi**2 * A(pi) @ SI - wj**2 * A(pj) @ SJ


def columns(r: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.column_stack([np.atleast_2d(r), np.atleast_1d(phi)])


def revolute(s: State, i: int | None, j: int) -> Rows:
    d, _, quadratic = span(s, i, j)
    return (
        -d,
        columns(np.eye(2), B(s.body(i)[1]) @ SI),
        columns(-np.eye(2), -B(s.body(j)[1]) @ SJ),
        quadratic,
    )


def translational(s: State, i: int | None, j: int) -> Rows:
    d, rate, quadratic = span(s, i, j)
    (_, pi, _, wi), (_, pj, _, _) = s.body(i), s.body(j)
    normal = np.array([-AXIS[1], AXIS[0]]) / np.linalg.norm(AXIS)
    n, turned = A(pi) @ normal, B(pi) @ normal
    phi = np.array([n @ d, pj - pi - ANGLE])
    on_i = np.array([[*-n, turned @ d - n @ B(pi) @ SI], [0, 0, -1]])
    on_j = np.array([[*n, n @ B(pj) @ SJ], [0, 0, 1]])
    gamma = np.array([-(n @ quadratic + 2 * wi * turned @ rate - wi**2 * n @ d), 0.0])
    return phi, on_i, on_j, gamma


def revolute_revolute(s: State, i: int | None, j: int) -> Rows:
    d, rate, quadratic = span(s, i, j)
    on_i = columns(-2 * d, -2 * d @ B(s.body(i)[1]) @ SI)
    on_j = columns(2 * d, 2 * d @ B(s.body(j)[1]) @ SJ)
    gamma = np.array([-2 * rate @ rate - 2 * d @ quadratic])
    return np.array([d @ d - LENGTH**2]), on_i, on_j, gamma


def declare(kind: str, model: Model, i: object, j: object) -> None:
    a, b = i.at(*SI), j.at(*SJ)
    if kind == "revolute":
        model.revolute("joint", a, b)
    elif kind == "translational":
        model.translational("joint", a, b, axis=tuple(AXIS), angle=ANGLE)
    else:
        model.revolute_revolute("joint", a, b, LENGTH)


def two_bodies(ground: bool) -> tuple[Model, object, object]:
    model = Model("pair")
    first = model.body("first", mass=2.0, inertia=0.5)
    second = model.body("second", mass=3.0, inertia=0.7)
    return model, model.ground if ground else first, second


PAIRS: dict[str, Callable[[State, int | None, int], Rows]] = {
    "revolute": revolute,
    "translational": translational,
    "revolute_revolute": revolute_revolute,
}


@pytest.mark.parametrize("ground", [False, True], ids=["bodies", "ground"])
@pytest.mark.parametrize("kind", PAIRS)
def test_joint_is_haugs(kind: str, ground: bool) -> None:
    model, i, j = two_bodies(ground)
    declare(kind, model, i, j)
    machine = Interpreted(model)
    for seed in range(5):
        s = machine.state(seed)
        phi, on_i, on_j, gamma = PAIRS[kind](s, None if ground else 0, 1)
        jacobian = machine.jacobian(s)
        assert_allclose(machine.vector("constraints", s), phi, **TOLERANCE)
        assert_allclose(jacobian[:, :3], 0 * on_i if ground else on_i, **TOLERANCE)
        assert_allclose(jacobian[:, 3:], on_j, **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), gamma, **TOLERANCE)
        assert_allclose(machine.vector("velocity_rhs", s), 0 * gamma, atol=0)


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


def everything() -> Model:
    """One machine with a joint of every kind, some of them moved by the time."""
    model, i, j = two_bodies(ground=False)
    third = model.body("third", mass=1.0, inertia=1.0)
    length = model.parameter("length", 1.7, unit="m", sign="positive")
    model.revolute("pin", i.at(*SI), j.at(length / 2, 0.2))
    model.translational("slot", j.at(*SJ), third.at(0.1, 0.2), axis=(1, 2), angle=0.3)
    model.revolute_revolute("link", model.ground.at(1, 1), third.at(*SI), length)
    model.absolute("height", i.at(*SJ), "y", 0.5)
    model.constraint("own", i.x * j.x - sympy.exp(-t) * sympy.cosh(third.phi), i.x**3 - t * j.y)
    model.driver("drive", i.phi - third.phi, sympy.tanh(t) + t**2)
    return model


def test_jacobian_is_the_derivative_of_the_compiled_constraints() -> None:
    machine = Interpreted(everything())
    assert machine.m == 9
    for seed in range(3):
        s = machine.state(seed)

        def phi(q: np.ndarray, s: State = s) -> np.ndarray:
            return machine.vector("constraints", State(t=s.t, q=q, v=s.v), cmath)

        assert_allclose(machine.jacobian(s), complex_step(phi, s.q), **TOLERANCE)


def test_right_sides_are_the_derivatives_of_the_compiled_constraints() -> None:
    machine = Interpreted(everything())
    for seed in range(3):
        s = machine.state(seed)

        def phi(x: np.ndarray, s: State = s) -> np.ndarray:
            return machine.vector("constraints", State(t=x[0], q=s.q, v=s.v), cmath)

        nu = -complex_step(phi, np.array([s.t]))[:, 0]
        assert np.abs(nu).max() > 0.1
        assert_allclose(machine.vector("velocity_rhs", s), nu, **TOLERANCE)
        gamma = machine.vector("acceleration_rhs", s)
        assert_allclose(gamma, complex_gamma(machine, s), rtol=1e-12, atol=1e-12)
