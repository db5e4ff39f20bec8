"""Reactions: whose force on whom, in which axes; bodies in balance; power and energy."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.workbench import A, Interpreted, State, random_machine


def hanging(ground_first: bool) -> Interpreted:
    model = Model("hanging", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.3)
    ends = (model.ground.at(0, 0), bob.at(0, 1.5))
    model.revolute("hinge", *(ends if ground_first else ends[::-1]))
    return Interpreted(model)


def reactions(machine: Interpreted, s: State) -> dict[tuple[str, str], float]:
    _, lam = machine.solution(s)
    values = machine.vector("reactions", s, lam=lam)
    return {
        row[:2]: x for row, x in zip(machine.lowered.description.reactions, values, strict=True)
    }


def test_hinge_holds_a_hanging_mass_up() -> None:
    at_rest = State(t=0.0, q=np.array([0.0, -1.5, 0.0]), v=np.zeros(3))
    found = reactions(hanging(ground_first=True), at_rest)
    assert_allclose(found["hinge", "fy"], 2.0 * 9.81, rtol=1e-14)
    assert_allclose([found["hinge", "fx"], found["hinge", "torque"]], 0, atol=1e-14)
    found = reactions(hanging(ground_first=False), at_rest)
    assert_allclose(found["hinge", "fy"], -2.0 * 9.81, rtol=1e-14)


def test_axes_are_those_of_the_first_body() -> None:
    turned = State(t=0.0, q=np.array([1.5, 0.0, np.pi / 2]), v=np.array([0.0, 0.0, 0.0]))
    ground, own = (reactions(hanging(g), turned) for g in (True, False))
    force = np.array([ground["hinge", "fx"], ground["hinge", "fy"]])
    assert abs(force[1]) > 0.1
    opposite = A(np.pi / 2) @ np.array([own["hinge", "fx"], own["hinge", "fy"]])
    assert_allclose(opposite, -force, atol=1e-13)


def test_driver_shows_the_torque_that_it_exerts() -> None:
    model = Model("flywheel")
    wheel = model.body("wheel", mass=2.0, inertia=3.0)
    model.revolute("axle", model.ground.at(0, 0), wheel.at(0, 0))
    model.driver("drive", wheel.phi, t**2)
    machine = Interpreted(model)
    s = State(t=2.0, q=np.array([0.0, 0.0, 4.0]), v=np.array([0.0, 0.0, 4.0]))
    assert machine.lowered.description.reactions[-1] == ("drive", "torque", "N m")
    assert_allclose(reactions(machine, s)["drive", "torque"], 3.0 * 2.0, rtol=1e-14)
    _, lam = machine.solution(s)
    assert machine.lowered.description.powers == (("drive", "driver"),)
    assert_allclose(machine.vector("powers", s, lam=lam), [6.0 * 4.0], rtol=1e-14)


def test_guide_pushes_along_its_normal() -> None:
    model = Model("inclined", gravity=(0, -10.0))
    block = model.body("block", mass=3.0, inertia=1.0)
    model.translational("guide", model.ground, block, axis=(sympy.sqrt(3), 1))
    found = reactions(Interpreted(model), State(t=0.0, q=np.zeros(3), v=np.zeros(3)))
    assert_allclose(found["guide", "fx"], 0.0, atol=1e-13)
    assert_allclose(found["guide", "fy"], 30.0 * np.cos(np.pi / 6), rtol=1e-13)
    assert_allclose(found["guide", "torque"], 0.0, atol=1e-13)


def test_link_pulls_along_itself() -> None:
    model = Model("rope", gravity=(0, -10.0))
    ball = model.body("ball", mass=3.0, inertia=1.0)
    model.revolute_revolute("link", model.ground.at(0, 0), ball.at(0, 0), 2.0)
    found = reactions(Interpreted(model), State(t=0.0, q=np.array([0.0, -2, 0]), v=np.zeros(3)))
    assert_allclose(found["link", "fx"], -30.0, rtol=1e-13)  # along the link is downwards
    assert_allclose([found["link", "fy"], found["link", "torque"]], 0.0, atol=1e-13)


def joint_force(machine: Interpreted, name: str, s: State) -> tuple[np.ndarray, np.ndarray, float]:
    """Point, force (both in global axes) and torque of a joint on its second body."""
    found = reactions(machine, s)
    (joint,) = (c for c in machine.equations.constraints if c.name == name)
    place = {str(k): v for k, v in joint.statement.bindings.items()}
    numbers = dict(zip(machine.equations.coordinates, s.q, strict=True))

    def value(key: str) -> float:
        return float(sympy.sympify(place[key]).subs(numbers))

    r, phi = np.array([value("j_x"), value("j_y")]), value("j_phi")
    point = r + A(phi) @ [value("j_sx"), value("j_sy")]
    turn = value("i_phi")
    if joint.kind == "translational":
        turn += np.arctan2(value("i_uy"), value("i_ux"))
    if joint.kind == "revolute-revolute":
        start = np.array([value("i_x"), value("i_y")])
        start = start + A(turn) @ [value("i_sx"), value("i_sy")]
        turn = float(np.arctan2(*(point - start)[::-1]))
    force = A(turn) @ [found[name, "fx"], found[name, "fy"]]
    return point, force, found[name, "torque"]


@pytest.mark.parametrize("seed", range(12))
def test_every_body_is_in_balance(seed: int) -> None:
    model, s = random_machine(seed)
    machine = Interpreted(model)
    a, _ = machine.solution(s)
    needed = machine.mass(s) @ a - machine.vector("applied_forces", s)
    given = np.zeros(machine.n)
    for name, joint in model.joints.items():
        point, force, torque = joint_force(machine, name, s)
        for body, sign in zip(joint.bodies, (-1, 1), strict=True):
            if not body.fixed:
                k = 3 * list(model.bodies).index(body.name)
                arm = point - s.q[k : k + 2]
                moment = arm[0] * force[1] - arm[1] * force[0] + torque
                given[k : k + 3] += sign * np.array([*force, moment])
    scale = np.abs(needed).max()
    assert_allclose(given, needed, rtol=1e-9, atol=1e-10 * max(scale, 1))


@pytest.mark.parametrize("seed", range(4))
def test_powers_are_the_rate_of_energy(seed: int) -> None:
    model, s = random_machine(seed, closed=False)
    body = model.bodies["b1"]
    model.driver("drive", body.x, 0.2 * t**2 + sympy.sin(t) + float(s.q[3]))
    machine = Interpreted(model)
    s = State(t=s.t, q=s.q, v=machine.corrected(s).v)
    nu = machine.vector("velocity_rhs", s)
    assert_allclose(machine.jacobian(s) @ s.v, nu, atol=1e-12)
    a, lam = machine.solution(s)
    rate = s.v @ machine.mass(s) @ a + machine.vector("potential_gradient", s) @ s.v
    powers = machine.vector("powers", s, lam=lam)
    assert [name for name, _ in machine.lowered.description.powers] == ["motor", "push", "drive"]
    assert_allclose(powers.sum(), rate, rtol=1e-10, atol=1e-10)


def test_equation_with_time_in_it_does_work_too() -> None:
    model = Model("moved")
    cart = model.body("cart", mass=3.0, inertia=1.0)
    model.constraint("belt", cart.x - sympy.sin(t))
    machine = Interpreted(model)
    s = State(t=0.4, q=np.zeros(3), v=np.array([np.cos(0.4), 0.0, 0.0]))
    a, lam = machine.solution(s)
    assert machine.lowered.description.powers == (("belt", "driver"),)
    assert_allclose(machine.vector("powers", s, lam=lam), [3.0 * a[0] * s.v[0]], rtol=1e-13)


def test_kinetic_energy() -> None:
    model, s = random_machine(3)
    machine = Interpreted(model)
    expected = 0.5 * s.v @ machine.mass(s) @ s.v
    assert_allclose(machine.vector("kinetic_energy", s), expected, rtol=1e-14)
