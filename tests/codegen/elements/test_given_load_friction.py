"""Friction at a slip that is given, and who shares a switch with it."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.elements.hand.modes import reported
from tests.codegen.workbench import A, Interpreted, State


def sliding(**more: Any) -> Model:
    model = Model("sliding")
    i, j = model.body("i", 2.0, 0.5), model.body("j", 3.0, 0.7)
    model.dry_friction("rub", i.at(0.2, 0.1), j.at(-0.1, 0.3), axis=(3, 4), coefficient=0.5,
                       **{"normal": 8.0, **more})  # fmt: skip
    return model


@pytest.mark.parametrize("seed", range(3))
def test_slip_of_two_points_is_seen_from_the_first_body(seed: int) -> None:
    machine = Interpreted(sliding())
    s = machine.state(seed)
    (r_i, phi_i, v_i, w_i), (r_j, phi_j, v_j, w_j) = s.body(0), s.body(1)
    u = A(phi_i) @ [0.6, 0.8]
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    at = r_j + A(phi_j) @ [-0.1, 0.3]
    speed = v_j + w_j * turned @ (at - r_j) - (v_i + w_i * turned @ (at - r_i))
    assert_allclose(machine.vector("switching", s), [u @ speed], rtol=1e-12)
    for mode, side in ((0, -1.0), (1, 1.0)):
        f = -0.5 * 8.0 * side * u
        arms = [turned @ (at - r) @ f for r in (r_i, r_j)]
        expected = [*-f, -arms[0], *f, arms[1]]
        assert_allclose(machine.vector("applied_forces", s, modes=[mode]), expected, rtol=1e-12)


def test_normal_force_that_varies_never_pulls() -> None:
    model = Model("brake")
    drum = model.body("drum", 1.0, 0.1)
    model.dry_friction("brake", slip=drum.vx - t, normal=10 * drum.y, coefficient=0.5)
    machine = Interpreted(model)
    told = machine.lowered.description.switches
    off = "brake ceases to press / brake presses"
    assert told == (("brake", "-t + drum_vx > 0", "friction"), ("brake", off))
    s = State(t=0.4, q=np.array([0.0, 0.3, 0.0]), v=np.array([1.0, 0.0, 0.0]))
    assert_allclose(machine.vector("applied_forces", s, modes=[1, 0])[0], -0.5 * 3.0)
    assert_allclose(machine.vector("applied_forces", s, modes=[0, 0])[0], 0.5 * 3.0)
    assert machine.vector("applied_forces", s, modes=[1, 1])[0] == 0.0


def test_condition_on_the_same_slip_shares_its_switch() -> None:
    model = Model("press", gravity=(0, -9.81))
    ram = model.body("ram", 2.0, 0.1)
    guide = model.translational("guide", model.ground, ram, axis=(-1, 0))
    model.force("gas", ram, fx=-7.0, when=ram.vx > 0)
    model.friction("rub", guide, 0.25)
    machine = Interpreted(model)
    (switch,) = machine.equations.switches
    assert (switch.kind, switch.effect) == ("friction", "rub")
    s = State(t=0.0, q=np.zeros(3), v=np.array([1.0, 0.0, 0.0]))
    up = int(machine.vector("switching", s)[0] > 0)
    grip = 0.25 * 2.0 * 9.81
    assert_allclose(machine.solution(s, modes=[up])[0][0], (-7.0 - grip) / 2, rtol=1e-13)
    assert_allclose(machine.solution(s, modes=[1 - up])[0][0], grip / 2, rtol=1e-13)


def test_two_frictions_on_one_slip_turn_together() -> None:
    model = Model("pads")
    block = model.body("block", 2.0, 0.1)
    model.dry_friction("over", slip=block.vx - 1, normal=4.0, coefficient=0.5, static=0.75)
    model.dry_friction("under", slip=1 - block.vx, normal=6.0, coefficient=0.2, static=0.3)
    machine = Interpreted(model)
    assert machine.s == 1
    s = State(t=0.0, q=np.zeros(3), v=np.zeros(3))
    for mode, way in ((0, 1.0), (1, -1.0)):
        q = machine.vector("applied_forces", s, modes=[mode])
        assert_allclose(q[0], way * (0.5 * 4 + 0.2 * 6))
        told = reported(machine, s, np.zeros(0), mode)
        assert_allclose([told["over.force"], told["under.force"]], [way * 2.0, -way * 1.2])


def test_friction_that_creeps_has_no_mode() -> None:
    machine = Interpreted(sliding(creep=0.01))
    assert machine.s == 0
    s = machine.state(1)
    slip = Interpreted(sliding()).vector("switching", s)[0]
    told = reported(machine, s, np.zeros(0), 0)
    assert_allclose(told["rub.force"], -0.5 * 8.0 * np.tanh(slip / 0.01), rtol=1e-12)
