"""Rigid contacts: their two modes, the reaction that keeps a gap closed, impacts, powers."""

import cmath
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.elements.hand.modes import hard
from tests.codegen.workbench import A, Interpreted, State, complex_step


def both(machine: Interpreted, s: State) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """q̈ and λ with the gap closed and open."""
    return tuple(machine.solution(s, modes=[mode]) for mode in (0, 1))


def share(machine: Interpreted, s: State) -> float:
    """The multiple α' of the reaction with which the gap's acceleration vanishes."""
    closed, open_ = (machine.vector("gap_accelerations", s, a=a)[0] for a, _ in both(machine, s))
    return -open_ / (closed - open_)


def struck(machine: Interpreted, s: State) -> np.ndarray:
    """v⁺ = v - (1 + e) ġ/(g_q Δq̈) Δq̈."""
    (closed, _), (open_, _) = both(machine, s)
    rates = [machine.vector("gap_accelerations", s, a=a)[0] for a in (closed, open_)]
    speed = machine.vector("switching_rates", s, a=open_)[0]
    e = machine.vector("restitution", s)[0]
    return s.v - (1 + e) * speed / (rates[0] - rates[1]) * (closed - open_)


def test_ball_rests_on_its_weight_and_rebounds(root: Path) -> None:
    machine = hard(root, "bouncing_ball", "dropped")
    told = machine.lowered.description
    assert told.rigid == (("plate", 0),)
    assert told.switches[0][2] == "contact"
    assert "plate" not in [name for name, _ in told.powers]
    s = State(t=0.0, q=np.array([0.2, 0.1]), v=np.array([0.3, -2.0]))
    assert_allclose(machine.vector("switching", s), [0.0], atol=1e-17)
    assert_allclose(machine.solution(s, modes=[1])[0], [0, -9.81])
    scale = machine.vector("contact_scale", s)[0]
    assert_allclose(scale, 0.4 * 9.81)
    assert_allclose(machine.solution(s, modes=[0])[0], [0, scale / 0.4 - 9.81])
    assert_allclose(share(machine, s) * scale, 0.4 * 9.81, rtol=1e-14)
    assert_allclose(struck(machine, s), [0.3, 1.0], rtol=1e-14)
    bounds = machine.flat("holds", s)
    assert bounds["low"][0] < -1e300
    assert bounds["high"][0] == 1.0
    for mode in (0, 1):
        force = machine.slots("switched_reactions", s, lam=np.zeros(0), modes=[mode])
        assert_allclose(force[0], scale * (1 - mode))


def test_table_that_shakes_carries_the_ball_and_works_on_it(root: Path) -> None:
    machine = hard(root, "bouncing_ball", "shaken")
    stroke, frequency, when = 0.02, 30.0, 0.047
    lift = stroke * np.sin(frequency * when)
    rate = stroke * frequency * np.cos(frequency * when)
    s = State(t=when, q=np.array([0.0, 0.1 + lift]), v=np.array([0.0, rate]))
    a_open = machine.solution(s, modes=[1])[0]
    assert_allclose(machine.vector("switching_rates", s, a=a_open), [0.0], atol=1e-15)
    scale = machine.vector("contact_scale", s)[0]
    force = 0.4 * (9.81 - frequency**2 * lift)
    assert_allclose(share(machine, s) * scale, force, rtol=1e-13)
    power = machine.vector("powers", s, lam=np.zeros(0), modes=[0])
    assert_allclose(share(machine, s) * power, [force * rate], rtol=1e-13)
    s.v = np.array([0.0, -1.3])
    assert_allclose(struck(machine, s)[1] - rate, 0.5 * (1.3 + rate), rtol=1e-13)


@pytest.mark.parametrize("phi", [-0.6, 1.2, 2.9])
def test_cam_drives_the_pushrod_by_its_acceleration(root: Path, phi: float) -> None:
    machine = hard(root, "contact_follower", "touching")
    omega, e, m = 150.0, 0.0025, 0.2
    when = (phi + np.pi / 2) / omega
    y = 0.0125 + e * np.sin(phi) + 0.075
    s = State(t=when, q=np.array([0, 0, phi, 0, y, 0]), v=np.zeros(6))
    s.v[2], s.v[4] = omega, e * omega * np.cos(phi)
    assert_allclose(machine.vector("constraints", s), 0, atol=1e-15)
    # The gap is a sum of lengths up to y, each of them rounded to its last digit.
    assert_allclose(machine.vector("switching", s), [0.0], atol=np.spacing(y))
    spring = 20.0 + 1000.0 * e * (1 + np.sin(phi))
    force = spring + m * (9.81 - e * omega**2 * np.sin(phi))
    assert_allclose(share(machine, s) * machine.vector("contact_scale", s)[0], force, rtol=1e-12)
    s.v[4] -= 0.4
    after = struck(machine, s)
    gap = 0.4 * 0.4  # e of the impact times the speed before it
    assert_allclose(after, [0, 0, omega, 0, e * omega * np.cos(phi) + gap, 0], atol=1e-12)


def bars() -> Interpreted:
    """A hinged bar whose tip meets the face of a free body."""
    model = Model("bars", gravity=(0.5, -9.81))
    bar, block = model.body("bar", 1.5, 0.2), model.body("block", 2.0, 0.3)
    model.revolute("hinge", model.ground.at(0, 0), bar.at(-0.6, 0))
    e = model.parameter("bounce", 0.8)
    model.contact("touch", block.at(0.1, 0.2), bar.at(0.6, 0), direction=(1, 2), free_length=0.05,
                  restitution=e, typical_force=30.0)  # fmt: skip
    return Interpreted(model)


@pytest.mark.parametrize("seed", range(4))
def test_reaction_acts_along_the_gap_on_both_bodies(seed: int) -> None:
    machine = bars()
    s = machine.state(seed)
    pushed = machine.vector("applied_forces", s, modes=[0])
    pushed -= machine.vector("applied_forces", s, modes=[1])

    def gap(q: np.ndarray) -> np.ndarray:
        return machine.vector("switching", State(t=s.t, q=q, v=s.v), cmath)

    assert_allclose(pushed, 30.0 * complex_step(gap, s.q)[0], rtol=1e-11, atol=1e-11)
    u = A(s.q[5]) @ np.array([1, 2]) / np.sqrt(5)
    assert_allclose(pushed[:2], 30 * u, rtol=1e-12)
    assert_allclose(pushed[3:5], -30 * u, rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_gap_accelerations_are_second_derivatives_of_the_gap(seed: int) -> None:
    machine = bars()
    s = machine.state(seed)
    a = np.random.default_rng(50 + seed).uniform(-3, 3, 6)
    h = 1e-4
    gaps = [
        machine.vector("switching", State(t=0, q=s.q + d * s.v + d * d / 2 * a, v=s.v))[0]
        for d in (-h, 0, h)
    ]
    second = (gaps[0] - 2 * gaps[1] + gaps[2]) / h**2
    assert_allclose(machine.vector("gap_accelerations", s, a=a)[0], second, rtol=1e-5, atol=1e-5)


def test_impact_keeps_the_joints_and_loses_what_newton_says() -> None:
    machine = bars()
    s = machine.state(2)
    s.q[:2] = A(s.q[2]) @ np.array([0.6, 0.0])
    s.v = machine.corrected(s).v
    closed = machine.solution(s, modes=[0])[0]
    speed = machine.vector("switching_rates", s, a=closed)[0]
    after = State(t=s.t, q=s.q, v=struck(machine, s))
    assert_allclose(machine.jacobian(s) @ after.v, machine.vector("velocity_rhs", s), atol=1e-12)
    later = machine.vector("switching_rates", after, a=closed)[0]
    assert_allclose(later, -0.8 * speed, rtol=1e-12)
    energies = [machine.vector("kinetic_energy", x) for x in (s, after)]
    inverse = (closed - machine.solution(s, modes=[1])[0]) / 30.0  # M̂⁻¹ g_qᵀ
    direction = machine.vector("gap_accelerations", s, a=closed)[0]
    direction -= machine.vector("gap_accelerations", s, a=closed - 30.0 * inverse)[0]
    loss = (1 - 0.8**2) * speed**2 / 2 / (direction / 30.0)
    assert_allclose(energies[0] - energies[1], loss, rtol=1e-11)


def test_contact_has_a_switch_of_its_own() -> None:
    model = Model("pad")
    ball = model.particle("ball", 1.0)
    model.force("wind", ball, fx=3.0, when=ball.y < 0)
    model.contact("floor", gap=ball.y, restitution=0)
    machine = Interpreted(model)
    assert [s.kind for s in machine.equations.switches] == ["contact", "condition"]
    s = State(t=0.0, q=np.zeros(2), v=np.zeros(2))
    for closed in (0, 1):
        for wind in (0, 1):
            a, _ = machine.solution(s, modes=[1 - closed, wind])
            assert_allclose(a, [3.0 * wind, 9.81 * closed])


def test_contact_whose_mass_is_a_parameter_has_its_weight_as_scale() -> None:
    model = Model("weight")
    mass = model.parameter("mass", 2.0, "kg")
    ball = model.particle("ball", mass)
    model.contact("floor", gap=ball.y - t, restitution=0)
    machine = Interpreted(model)
    machine.p = [5.0]
    s = State(t=0.0, q=np.zeros(2), v=np.zeros(2))
    assert_allclose(machine.vector("contact_scale", s), [5.0 * 9.81])
