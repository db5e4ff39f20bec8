"""Forces and torques between two bodies, along a line and of a motor, against formulas by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import sin

from codegen import Model, t
from codegen.declare.symbols import rate
from tests.codegen.elements.test_library_forces import (
    S_I,
    S_J,
    SEEDS,
    TOLERANCE,
    balanced,
    ends,
    momenta,
    pair,
    tsda,
)
from tests.codegen.workbench import A, B, Interpreted

TABLE = ([0.0, 1.0, 2.0, 4.0, 8.0], [3.0, 7.0, 2.0, -1.0, 4.0])


def test_torque_turns_the_other_body_back() -> None:
    model, first, second = pair()
    model.torque("motor", on=second, from_=first, value=4 - 2 * second.omega + t)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        n = 4 - 2 * s.v[5] + s.t
        assert_allclose(machine.vector("applied_forces", s), [0, 0, -n, 0, 0, n], **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [n * (s.v[5] - s.v[2])], **TOLERANCE)


def test_torque_from_the_ground_is_one_from_nowhere() -> None:
    texts = set()
    for words in ((), ("from_",)):
        model, first, _ = pair()
        model.torque("motor", on=first, value=3 * t, **dict.fromkeys(words, model.ground))
        texts.add(Interpreted(model).text())
    assert len(texts) == 1


@pytest.mark.parametrize("frame", ["ground", "body"])
def test_force_pushes_the_other_body_back_at_the_same_place(frame: str) -> None:
    model, first, second = pair()
    model.force("push", on=second.at(*S_J), fx=3 + second.vy, fy=-t, frame=frame, from_=first)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        (r_i, _, _, _), (r_j, phi, v_j, _) = s.body(0), s.body(1)
        force = np.array([3 + v_j[1], -s.t])
        force = A(phi) @ force if frame == "body" else force
        arm = r_j + A(phi) @ S_J - r_i
        back = [*-force, arm[1] * force[0] - arm[0] * force[1]]
        expected = [*back, *force, (B(phi) @ S_J) @ force]
        assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [np.dot(expected, s.v)], **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-11)


def test_line_force_is_haugs() -> None:
    model, first, second = pair()
    law = model.table("law", *TABLE)
    model.line_force(
        "strut", first.at(*S_I), second.at(*S_J), lambda length, rate: law(length) - 2 * rate + t
    )
    machine = Interpreted(model)
    plain, one, other = pair()
    plain.line_force("strut", one.at(*S_I), other.at(*S_J), 5 * t)
    constant = Interpreted(plain)
    for seed in SEEDS:
        s = machine.on_its_sides(machine.state(seed))
        d, v = ends(s)
        length = np.linalg.norm(d)
        speed = d @ v / length
        f = float(law(length)) - 2 * speed + s.t
        assert_allclose(machine.vector("applied_forces", s), tsda(s, f), **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [-f * speed], **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-11)
        balanced(machine, s)
        assert_allclose(constant.vector("applied_forces", s), tsda(s, 5 * s.t), **TOLERANCE)


def test_lengths_and_angles_stand_in_other_expressions() -> None:
    """A length times its rate, in the force on another body, by numbers."""
    model, first, second = pair()
    strut = model.line_force("strut", first.at(*S_I), second.at(*S_J), 1.0)
    coil = model.torsion_spring("coil", first, second, 3.0)
    spring = model.spring("spring", first.at(*S_I), second.at(*S_J), 2.0, 0.0)
    motor = model.motor("motor", second, first, stall_torque=1, no_load_speed=2)
    assert (spring.length, spring.rate) == (strut.length, strut.rate)
    assert (motor.angle, motor.rate) == (coil.angle, coil.rate)
    assert coil.rate == rate(coil.angle)
    third = model.body("third", mass=1.0, inertia=1.0)
    model.generalized_force("own", {third.x: strut.length * strut.rate + coil.angle * coil.rate})
    model.scene("alone", ["own"])
    machine = Interpreted(model, "alone")
    for seed in SEEDS:
        s = machine.state(seed)
        d, v = ends(s)
        angle, speed = s.q[5] - s.q[2], s.v[5] - s.v[2]
        force = machine.vector("applied_forces", s)[6]
        assert_allclose(force, d @ v + angle * speed, **TOLERANCE)


def test_motor_falls_in_a_line_with_its_speed() -> None:
    model, first, second = pair()
    model.motor("drive", second, first, stall_torque=6.0, no_load_speed=1.5, voltage=sin(t))
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        speed = s.v[5] - s.v[2]
        n = 6.0 * (np.sin(s.t) - speed / 1.5)
        assert_allclose(machine.vector("applied_forces", s), [0, 0, -n, 0, 0, n], **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [n * speed], **TOLERANCE)


def test_tables_of_any_coordinate_are_forces() -> None:
    """The expression of a table stands where a force, a torque or a share of it is asked for."""
    model = Model("tabled")
    body = model.body("body", mass=1.0, inertia=1.0)
    wheel = model.body("wheel", mass=1.0, inertia=1.0)
    law = model.table("law", *TABLE)
    model.force("push", body, fx=law(wheel.phi), fy=law(body.vx))
    model.torque("turn", wheel, law(body.y), from_=body)
    model.motor("drive", wheel, stall_torque=2, no_load_speed=1, voltage=law(t))
    machine = Interpreted(model)
    s = machine.state(3)
    s.q[:], s.v[:] = np.abs(s.q), np.abs(s.v)
    machine.on_its_sides(s)
    n = float(law(s.q[1]))
    drive = 2 * (float(law(s.t)) - s.v[5])
    expected = [float(law(s.q[5])), float(law(s.v[0])), -n, 0, 0, n + drive]
    assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
