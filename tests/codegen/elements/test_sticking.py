"""Frictions that stick, on a belt and in joints: their two modes, and what holds between them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from tests.codegen.elements.hand.modes import hard, held, mixed, reported
from tests.codegen.elements.rubbing_slider_crank import BEARING, MU, RADIUS, rubbing_slider_crank
from tests.codegen.workbench import A, Interpreted, State

# -- a block on a belt ---------------------------------------------------------------------


def test_belt_pulls_by_the_side_of_its_mode(root: Path) -> None:
    machine = hard(root, "belt_block", "riding")
    s = State(t=0.0, q=np.array([0.12, 0.0, 0.0]), v=np.array([0.3, 0.0, 0.0]))
    assert machine.lowered.description.switches == (("belt", "-speed + block_vx > 0", "friction"),)
    assert_allclose(machine.vector("switching", s), [0.3 - 0.1], rtol=1e-15)
    for mode, way in ((0, 1.0), (1, -1.0)):
        a, lam = machine.solution(s, modes=[mode])
        pull = way * 0.2 * 9.81
        assert_allclose(a, [pull - 100 * 0.12, 0, 0], rtol=1e-13, atol=1e-13)
        assert_allclose(machine.vector("powers", s, lam=lam, modes=[mode]), [pull * 0.3])
        assert_allclose(reported(machine, s, lam, mode)["belt.force"], pull)


def test_belt_holds_as_far_as_its_static_coefficient(root: Path) -> None:
    machine = hard(root, "belt_block", "riding")
    bounds = machine.flat("holds", State(t=0, q=[], v=[]))
    assert_allclose([bounds["low"][0], bounds["high"][0]], [-0.25, 1.25], rtol=1e-15)
    # Where the belt pulls with all that it can, it lets go.
    last = 0.3 * 9.81 / 100
    s = State(t=0.0, q=np.array([last, 0.0, 0.0]), v=np.array([0.1, 0.0, 0.0]))
    assert_allclose(held(machine, s), bounds["low"][0], rtol=1e-12)
    s.q[0] = last / 3
    a, _ = mixed(machine, s, held(machine, s))
    assert_allclose(a, 0, atol=1e-14)


# -- friction in joints --------------------------------------------------------------------


def test_guide_holds_with_the_friction_of_statics(root: Path) -> None:
    """At rest: the torque on the crank and the rod's weight against the guide's friction."""
    machine = hard(root, "guide_friction", "rocking")
    r, l = 0.3, 0.9  # noqa: E741
    phi = 1.1
    theta = -np.arcsin(r * np.sin(phi) / l)
    pin = r * np.array([np.cos(phi), np.sin(phi)])
    along = np.array([np.cos(theta), np.sin(theta)])
    q = np.array([0, 0, phi, *(pin + l / 2 * along), theta, pin[0] + l * along[0], 0, 0])
    s = State(t=0.25, q=q, v=np.zeros(9))
    torque = 4.0 * np.sin(3.0 * s.t)
    # The rod's own weight on both pins, halves; the rest of its force is along it.
    weight = 1.5 * 9.81 / 2
    push = (torque - weight * pin[0]) / (pin[0] * along[1] - pin[1] * along[0])
    friction = -push * along[0]
    normal = 2.0 * 9.81 + weight - push * along[1]
    assert 0 < abs(friction) < 0.3 * normal
    alpha = held(machine, s)
    a, _ = mixed(machine, s, alpha)
    assert 0 < alpha < 1
    assert_allclose(a, 0, atol=1e-12)
    sides = [reported(machine, s, machine.solution(s, modes=[m])[1], m) for m in (0, 1)]
    told = {key: x + alpha * (sides[1][key] - x) for key, x in sides[0].items()}
    assert_allclose(told["rub.force"], friction, rtol=1e-12)
    assert_allclose(abs(told["guide.fy"]), normal, rtol=1e-12)
    assert_allclose(told["rub.normal"], normal, rtol=1e-12)
    assert "holds" not in {k.name for k in machine.program.kernels}


def test_limit_of_a_joint_is_that_of_the_reaction_at_break_away() -> None:
    """A block with a bar that leans on a wall: the pull that just moves it, by statics."""
    model = Model("sledge", gravity=(0, -9.81))
    block = model.body("block", 2.0, 0.1)
    guide = model.translational("guide", model.ground, block, axis=(1, 0))
    bar = model.body("bar", 0.5, 0.1)
    model.revolute("pin", block.at(0, 0), bar.at(-0.5, 0))
    model.revolute_translational("wall", model.ground.at(1, 0), bar.at(0.5, 0), axis=(1, 3))
    model.force("pull", bar.at(0.5, 0.4), fx=model.parameter("draw", 10.0, "N"), fy=1.0)
    model.friction("rub", guide, 0.3, static=0.45)
    machine = Interpreted(model)
    q = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.0])
    s = State(t=0.0, q=q, v=np.zeros(6))
    assert_allclose(machine.vector("constraints", s), 0, atol=1e-15)
    found = []
    for draw in (0.0, 1.0):
        machine.p = [draw, *machine.p[1:]]
        alpha = held(machine, s)
        a, lam = mixed(machine, s, alpha)
        assert_allclose(a, 0, atol=1e-12)
        zero, one = (reported(machine, s, machine.solution(s, modes=[m])[1], m) for m in (0, 1))
        assert abs(zero["rub.normal"] - one["rub.normal"]) > 0.1
        held_by = zero["rub.force"] + alpha * (one["rub.force"] - zero["rub.force"])
        found.append((held_by, reported(machine, s, lam, 0)["rub.limit"]))
    # Both are linear in the pull.
    (f0, limit0), (f1, limit1) = found
    least = (f0 - limit0) / (limit1 - limit0 - (f1 - f0))
    # The moment about the pin gives the force of the wall, which is along (-3, 1).
    wall = 0.5 * 0.5 * 9.81 - 1.0 + 0.4 * least
    normal = 2.5 * 9.81 - 1.0 - wall
    assert_allclose(3 * wall - least, 0.45 * normal, rtol=1e-10)


def test_joint_that_is_held_exerts_the_force_that_it_is_given(root: Path) -> None:
    machine = hard(root, "guide_friction", "rocking")
    assert machine.lowered.description.stiction == (("rub", 0),)
    s = machine.state(3)
    found = {}
    for force in (0.0, 1.0, -7.0, 40.0):
        for mode in (0, 1, 2):
            a, lam = machine.solution(s, modes=[mode], stiction=[force])
            found[force, mode] = np.append(a, lam)
        told = reported(machine, s, lam, 2, force)
        assert told["rub.force"] == force
        push = machine.vector("applied_forces", s) + force * np.eye(9)[6]
        rest = machine.mass(s) @ a + machine.jacobian(s).T @ lam - push
        assert_allclose(rest, 0, atol=1e-11)
        for mode in (0, 1):
            assert_allclose(found[force, mode], found[0.0, mode], rtol=0)
    assert not np.allclose(found[0.0, 2], found[0.0, 0])


def test_condition_on_the_slip_leaves_the_friction_between_its_modes() -> None:
    """What has one switch for both is moved by one share."""
    model = Model("shared")
    block = model.body("block", 2.0, 0.1)
    guide = model.translational("guide", model.ground, block, axis=(1, 0))
    model.friction("rub", guide, 0.3)
    model.force("gate", block, fx=1.0, when=block.vx > 0)
    machine = Interpreted(model)
    assert [s.kind for s in machine.equations.switches] == ["friction"]
    assert machine.lowered.description.stiction == ()


@pytest.mark.parametrize("modes", [(0, 0, 0, 0), (1, 1, 1, 1), (1, 0, 0, 1)])
def test_friction_in_every_joint_agrees_with_its_reaction(modes: tuple[int, ...]) -> None:
    machine = Interpreted(rubbing_slider_crank())
    assert [s.kind for s in machine.equations.switches] == ["friction"] * 4
    phi = 0.8
    q = np.zeros(9)
    q[2], q[6] = phi, 1.9
    weights = np.ones(9)
    weights[2] = 0.0
    for _ in range(40):
        q = machine.corrected(State(t=0.0, q=q, v=np.zeros(9)), w=weights).q
    s = State(t=0.0, q=q, v=np.zeros(9))
    a, lam = machine.solution(s, modes=modes)
    jacobian = machine.jacobian(s)
    force = np.zeros(9)
    push = -jacobian.T @ np.where(np.arange(machine.m) < 2, lam, 0.0)
    ends = sum(abs(push[7] / 2 + way * push[8] / BEARING) for way in (1, -1))
    side = [2 * mode - 1 for mode in modes]
    force[6] = -MU * ends * side[0]
    for k, (row, (i, j)) in enumerate(((2, (None, 0)), (4, (0, 1)), (6, (1, 2)))):
        torque = -MU * RADIUS * np.hypot(*lam[row : row + 2]) * side[k + 1]
        force[3 * j + 2] += torque
        if i is not None:
            force[3 * i + 2] -= torque
    applied = machine.vector("applied_forces", s) + force
    rest = machine.mass(s) @ a + jacobian.T @ lam - applied
    assert_allclose(rest, 0, atol=1e-9 * abs(lam).max())


@pytest.mark.parametrize("seed", range(5))
def test_between_the_modes_friction_never_exceeds_its_limit(seed: int) -> None:
    """Mixed reactions of a pin whose load changes its direction: |f| ≤ μ R |F| throughout."""
    random = np.random.default_rng(seed)
    model = Model("pins", gravity=(0, -9.81))
    one, other = model.body("one", 1.0, 0.1), model.body("other", 2.0, 0.2)
    model.revolute("hinge", model.ground.at(0, 0), one.at(-0.5, 0))
    pin = model.revolute("pin", one.at(0.5, 0), other.at(-0.4, 0.1))
    model.friction("rub", pin, 0.8, radius=0.3)
    machine = Interpreted(model)
    q = random.uniform(-3, 3, 6)
    q[:2] = A(q[2]) @ [0.5, 0]
    q[3:5] = A(q[2]) @ [1.0, 0] - A(q[5]) @ [-0.4, 0.1]
    s = State(t=0.0, q=q, v=np.zeros(6))
    s.v = machine.corrected(State(t=0.0, q=q, v=random.uniform(-6, 6, 6))).v
    sides = [reported(machine, s, machine.solution(s, modes=[m])[1], m) for m in (0, 1)]
    for alpha in np.linspace(0, 1, 21):
        _, lam = mixed(machine, s, alpha)
        torque = (1 - alpha) * sides[0]["rub.torque"] + alpha * sides[1]["rub.torque"]
        limit = 0.8 * 0.3 * reported(machine, s, lam, 0)["rub.normal"]
        assert abs(torque) <= limit * (1 + 1e-9)
        if alpha in (0.0, 1.0):
            assert_allclose(abs(torque), limit, rtol=1e-9)


def test_power_of_friction_in_a_joint_vanishes_where_it_sticks(root: Path) -> None:
    machine = hard(root, "guide_friction", "rocking")
    s = machine.state(3)
    lam = np.linspace(-3, 3, machine.m)
    for mode in (0, 1):
        names = [name for name, _ in machine.lowered.description.powers]
        power = dict(zip(names, machine.vector("powers", s, lam=lam, modes=[mode]), strict=True))
        force = reported(machine, s, lam, mode)["rub.force"]
        assert_allclose(power["rub"], force * machine.vector("switching", s)[0], rtol=1e-14)
