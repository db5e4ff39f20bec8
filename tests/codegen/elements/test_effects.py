"""Forces against Haug's generalized forces (6.1), potentials against their derivatives."""

import cmath

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.workbench import A, B, Interpreted, State, complex_step

POINT = np.array([0.8, -0.3])
TOLERANCE = {"rtol": 1e-12, "atol": 1e-13}


def one_body() -> tuple[Model, object]:
    model = Model("thing")
    return model, model.body("body", mass=2.5, inertia=0.4)


@pytest.mark.parametrize("frame", ["ground", "body"])
def test_force_at_a_point(frame: str) -> None:
    model, body = one_body()
    model.force("push", on=body.at(*POINT), fx=3 + body.vy, fy=-body.x * t, frame=frame)
    machine = Interpreted(model)
    for seed in range(5):
        s = machine.state(seed)
        _, phi, v, _ = s.body(0)
        force = np.array([3 + v[1], -s.q[0] * s.t])
        force = A(phi) @ force if frame == "body" else force
        expected = [*force, (B(phi) @ POINT) @ force]
        assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [np.dot(expected, s.v)], **TOLERANCE)
        assert machine.vector("potential", s) == 0


def test_force_at_the_centre_has_no_moment() -> None:
    model, body = one_body()
    model.force("push", on=body, fx=3.0, fy=4.0)
    machine = Interpreted(model)
    assert_allclose(machine.vector("applied_forces", machine.state(0)), [3, 4, 0], atol=0)


def test_torque() -> None:
    model, body = one_body()
    model.torque("turn", on=body, value=5 - 2 * body.omega)
    machine = Interpreted(model)
    s = machine.state(0)
    assert_allclose(machine.vector("applied_forces", s), [0, 0, 5 - 2 * s.v[2]], **TOLERANCE)


def test_generalized_force() -> None:
    model, body = one_body()
    model.generalized_force("own", {body.x: -7 * body.vx, body.phi: sympy.sin(body.y)})
    machine = Interpreted(model)
    s = machine.state(0)
    expected = [-7 * s.v[0], 0, np.sin(s.q[1])]
    assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
    assert_allclose(machine.vector("powers", s), [np.dot(expected, s.v)], **TOLERANCE)


def test_gravity_acts_on_every_body_of_the_scene() -> None:
    model = Model("two", gravity=(1.5, -9.81))
    light = model.body("light", mass=2.0, inertia=1.0)
    model.body("heavy", mass=30.0, inertia=1.0)
    model.scene("both", ["gravity"])
    model.scene("alone", ["gravity"], without=[light])
    both, alone = Interpreted(model, "both"), Interpreted(model, "alone")
    s = both.state(0)
    weights = [3.0, -19.62, 0, 45.0, -294.3, 0]
    assert_allclose(both.vector("applied_forces", s), weights, **TOLERANCE)
    assert_allclose(both.vector("potential_gradient", s), np.negative(weights), **TOLERANCE)
    assert_allclose(both.vector("potential", s), -np.dot(weights, s.q), **TOLERANCE)
    assert_allclose(alone.vector("applied_forces", alone.state(0)), weights[3:], **TOLERANCE)
    assert both.lowered.description.powers == ()


def spring() -> tuple[Model, object, object]:
    model = Model("sprung", gravity=(0, -9.81))
    first = model.body("first", mass=2.0, inertia=1.0)
    second = model.body("second", mass=3.0, inertia=1.0)
    k = model.parameter("k", 70.0, unit="N/m")
    one, other = first.at(0.5, 0.1), second.at(-0.4, 0.2)
    length = sympy.sqrt((one.x - other.x) ** 2 + (one.y - other.y) ** 2)
    model.potential("spring", k * (length - 0.8) ** 2 / 2)
    return model, first, second


def test_forces_of_a_potential_are_its_slopes() -> None:
    machine = Interpreted(spring()[0])
    for seed in range(3):
        s = machine.state(seed)

        def energy(q: np.ndarray, s: State = s) -> np.ndarray:
            return machine.vector("potential", State(t=s.t, q=q, v=s.v), cmath)

        slopes = complex_step(energy, s.q)
        assert_allclose(machine.vector("potential_gradient", s), slopes, **TOLERANCE)
        assert_allclose(machine.vector("applied_forces", s), -slopes, **TOLERANCE)


def test_spring_pulls_its_ends_together() -> None:
    machine = Interpreted(spring()[0], None)
    s = State(t=0.0, q=np.zeros(6), v=np.zeros(6))
    s.q[3] = 5.0  # the second body five metres to the right
    pull = 70 * (np.hypot(5 - 0.9, 0.1) - 0.8) * (5 - 0.9) / np.hypot(5 - 0.9, 0.1)
    assert_allclose(machine.vector("applied_forces", s)[[0, 3]], [pull, -pull], **TOLERANCE)


def test_condition_switches_a_force_by_its_mode_alone() -> None:
    model, body = one_body()
    model.force("push", on=body, fx=3.0, when=body.vx > 0)
    machine = Interpreted(model)
    s = machine.state(0)
    for vx, mode in ((1.0, 1), (1.0, 0), (-1.0, 1), (-1.0, 0)):
        s.v[0] = vx
        assert machine.vector("applied_forces", s, modes=[mode])[0] == 3.0 * mode
        assert machine.vector("switching", s)[0] == vx


def test_potential_with_pieces_has_the_slopes_of_its_pieces() -> None:
    model, body = one_body()
    model.potential("stop", 50 * sympy.Max(body.x - 1, 0) ** 2)
    machine = Interpreted(model)
    assert machine.s == 1
    s = machine.state(0)
    s.q[0] = 1.5
    inside = float(np.sign(machine.vector("switching", s)[0]) > 0)
    touching = machine.vector("applied_forces", s, modes=[int(inside)])
    free = machine.vector("applied_forces", s, modes=[int(not inside)])
    assert_allclose(touching, [-50, 0, 0], **TOLERANCE)
    assert_allclose(free, [0, 0, 0], atol=0)
