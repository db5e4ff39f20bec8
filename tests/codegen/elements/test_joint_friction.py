"""Friction from the joint's own reaction: against equations by hand, closed forms, and balances."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from runtime import load
from tests.codegen.elements.rubbing_slider_crank import BEARING, MU, RADIUS, rubbing_slider_crank
from tests.codegen.workbench import A, Interpreted, State, python_functions

CREEP = 0.2


def closed(seed: int, machine: Interpreted) -> State:
    """A state on the constraints."""
    random = np.random.default_rng(seed)
    phi = random.uniform(0, 2 * np.pi)
    q = np.zeros(9)
    q[2], q[6] = phi, 0.5 * np.cos(phi) + 1.5
    for _ in range(40):
        s = State(t=0.0, q=q, v=np.zeros(9))
        weights = np.ones(9)
        weights[2] = 0.0
        q = machine.corrected(s, w=weights).q
    v = np.zeros(9)
    v[2] = random.uniform(-5, 5)
    s = State(t=0.0, q=q, v=v)
    weights = np.ones(9)
    weights[2] = 0.0
    s.v = machine.corrected(s, w=weights).v
    return s


def by_hand(machine: Interpreted, s: State, lam: np.ndarray) -> np.ndarray:
    """Generalized forces of all four frictions for given multipliers."""
    jacobian = machine.jacobian(s)
    push = -jacobian.T @ np.where(np.arange(machine.m) < 2, lam, 0.0)
    across, moment = push[7], push[8]
    ends = abs(across / 2 + moment / BEARING) + abs(across / 2 - moment / BEARING)
    force = np.zeros(9)
    force[6] = -MU * ends * np.tanh(s.v[6] / CREEP)
    for row, (i, j) in ((2, (None, 0)), (4, (0, 1)), (6, (1, 2))):
        slip = s.v[3 * j + 2] - (0.0 if i is None else s.v[3 * i + 2])
        torque = -MU * RADIUS * np.hypot(*lam[row : row + 2]) * np.tanh(slip / CREEP)
        force[3 * j + 2] += torque
        if i is not None:
            force[3 * i + 2] -= torque
    return force


@pytest.mark.parametrize("seed", range(6))
def test_reactions_and_friction_agree_with_each_other(seed: int) -> None:
    machine = Interpreted(rubbing_slider_crank(CREEP))
    s = closed(seed, machine)
    assert_allclose(machine.vector("constraints", s), 0, atol=1e-13)
    a, lam = machine.solution(s)
    applied = machine.vector("applied_forces", s) + by_hand(machine, s, lam)
    rest = machine.mass(s) @ a + machine.jacobian(s).T @ lam - applied
    assert_allclose(rest, 0, atol=1e-9 * abs(lam).max())
    assert_allclose(
        machine.jacobian(s) @ a, machine.vector("acceleration_rhs", s), rtol=1e-11, atol=1e-10
    )


def test_reported_friction_and_its_power_are_those_of_the_multipliers() -> None:
    machine = Interpreted(rubbing_slider_crank(CREEP))
    s = closed(1, machine)
    _, lam = machine.solution(s)
    told = machine.lowered.description
    values = machine.vector("reactions", s, lam=lam)
    found = {row[:2]: x for row, x in zip(told.reactions, values, strict=True)}
    force = by_hand(machine, s, lam)
    assert_allclose(found["rub_guide", "force"], force[6], rtol=1e-12)
    assert_allclose(found["rub_c", "torque"], force[8], rtol=1e-12)
    powers = machine.vector("powers", s, lam=lam)
    names = [name for name, _ in told.powers]
    rubbed = sum(p for name, p in zip(names, powers, strict=True) if name.startswith("rub"))
    assert_allclose(rubbed, force @ s.v, rtol=1e-12)
    assert rubbed < 0


def test_single_friction_is_solved_outright() -> None:
    model = Model("slope", gravity=(0, -9.81))
    block = model.body("block", mass=2.0, inertia=0.1)
    slope = 0.3
    guide = model.translational(
        "guide", model.ground, block, axis=(np.cos(slope), np.sin(slope)), angle=slope
    )
    model.friction("rub", guide, 0.25, 1e-3)
    machine = Interpreted(model)
    along = np.array([np.cos(slope), np.sin(slope)])
    for speed in (-2.0, -1e-3, 0.0, 3e-4, 1.0):
        s = State(t=0.0, q=np.array([*(1.7 * along), slope]), v=np.array([*(speed * along), 0.0]))
        a, _ = machine.solution(s)
        grip = 0.25 * np.tanh(speed / 1e-3)
        expected = -9.81 * (np.sin(slope) + grip * np.cos(slope))
        assert_allclose(a[:2], expected * along, rtol=1e-12)


def drawer(height: float, offset: float) -> tuple[Interpreted, State]:
    """A drawer on a guide `height` below its centre, pushed `offset` above the guide."""
    model = Model("drawer", gravity=(0, -9.81))
    box = model.body("box", mass=2.0, inertia=0.3)
    guide = model.translational("guide", model.ground, box.at(0, -height))
    model.friction("rub", guide, 0.3, 1e-3, length=BEARING)
    model.force("push", box.at(0, offset - height), fx=50.0)
    state = State(t=0.0, q=np.array([0.0, height, 0.0]), v=np.array([1.0, 0.0, 0.0]))
    return Interpreted(model), state


def held(height: float, offset: float) -> list[float]:
    """Friction forces that agree with the loads at both ends, by trying their signs."""
    weight, found = 2.0 * 9.81, []
    for one in (1, -1):
        for other in (1, -1):
            turn = (offset - height) * 50.0
            fixed = MU * ((one + other) * weight / 2 + (one - other) * turn / BEARING)
            force = fixed / (1 - MU * height / BEARING * (one - other))
            moment = turn + height * force
            ends = one * (weight / 2 + moment / BEARING), other * (weight / 2 - moment / BEARING)
            if min(*ends, force) >= 0:
                found.append(force)
    return found


@pytest.mark.parametrize("height", [0.3, 0.5, 0.65])
@pytest.mark.parametrize("offset", [-2.0, 0.0, 0.5, 1.0, 4.0])
def test_long_bearing_presses_at_both_ends(height: float, offset: float) -> None:
    machine, s = drawer(height, offset)
    a, _ = machine.solution(s)
    assert_allclose(a[0], (50.0 - min(held(height, offset))) / 2.0, rtol=1e-9)


def test_joint_that_jams_has_no_answer() -> None:
    assert held(0.7, 4.0) == []
    machine, s = drawer(0.7, 4.0)
    functions = python_functions(machine.text())
    p = np.zeros(len(functions["PARAMETERS"]) + len(functions["CONSTANTS"]))
    functions["constants"](p)
    a, lam = np.zeros(3), np.zeros(2)
    with pytest.raises(ValueError, match="math domain error"):  # the root that compiles to nan
        functions["accelerations"](0.0, s.q, s.v, p, np.zeros(0, np.int64), a, lam)


def test_run_into_a_jam_ends(tmp_path: Path) -> None:
    """Painlevé's rod: dragged along with μ = 1, no force at its tip agrees with its friction."""
    model = Model("rod", gravity=(0, -9.81))
    rod = model.body("rod", mass=1.0, inertia=0.1)
    slide = model.revolute_translational("slide", model.ground, rod.at(-1, 0), axis=(1, 0))
    model.friction("rub", slide, 1.0, 1e-3)
    model.scene(
        "drag", ["gravity", "rub"], start={rod.phi: 1.2, rod.x: 0.0, rod.vx: -3.0, rod.omega: 0.0},
        guess={rod.y: 0.93},
    )  # fmt: skip
    run = load(model, folder=tmp_path).simulate(0.02)
    assert run.failed
    assert run.t[-1] < 0.02


def test_flywheel_runs_down_by_coulombs_law(tmp_path: Path) -> None:
    model = Model("flywheel", gravity=(0, -9.81))
    wheel = model.body("wheel", mass=5.0, inertia=0.5)
    axle = model.revolute("axle", model.ground.at(0, 0), wheel)
    model.friction("rub", axle, 0.2, 1e-3, radius=0.05)
    model.scene("run_down", ["gravity", "rub"], start={wheel.omega: 1.0, wheel.phi: 0.0})
    machine = load(model, folder=tmp_path)
    slowing = 0.2 * 0.05 * 5.0 * 9.81 / 0.5
    stop = 1.0 / slowing
    run = machine.simulate(1.5 * stop, np.linspace(0, 1.5 * stop, 61), rtol=1e-9, atol=1e-12)
    moving = run.t < 0.99 * stop
    assert_allclose(run.v("wheel.phi")[moving], 1 - slowing * run.t[moving], atol=1e-8)
    assert abs(run.v("wheel.phi")[-1]) < 1e-6  # nothing drives it: the creep dies out
    assert_allclose(run.q("wheel.phi")[-1], stop / 2, atol=1e-3 * stop)
    assert_allclose(run.reaction("rub", "torque")[0], -0.2 * 0.05 * 5 * 9.81, rtol=1e-9)


def test_energy_falls_by_what_friction_takes(tmp_path: Path) -> None:
    model = rubbing_slider_crank(CREEP)
    model.scene(
        "run", ["gravity", "motor", "rub_guide", "rub_a", "rub_b", "rub_c"],
        start={"crank.phi": 0.4, "crank.omega": 12.0}, guess={"slider.x": 2.0, "rod.x": 1.2},
    )  # fmt: skip
    machine = load(model, folder=tmp_path)
    run = machine.simulate(0.5, np.linspace(0, 0.5, 16001), rtol=1e-11, atol=1e-11)
    total = run.data["energy"].sel(part="total").to_numpy()
    power = run.data["power"].sum("source").to_numpy()
    spent = (run.t[1] - run.t[0]) / 3 * np.array([power[:-2:2], 4 * power[1::2], power[2::2]]).sum()
    assert_allclose(total[-1] - total[0], spent, rtol=1e-7)


def test_axes_of_a_guide_that_turns() -> None:
    model = Model("turning")
    arm, bead = model.body("arm", 1.0, 0.5), model.body("bead", 0.3, 0.01)
    model.revolute("pin", model.ground.at(0, 0), arm)
    slot = model.revolute_translational("slot", arm, bead, axis=(2, 1))
    model.friction("rub", slot, 0.4, 1e-2)
    machine = Interpreted(model)
    along = np.array([2.0, 1.0]) / np.sqrt(5)
    left = np.array([-along[1], along[0]])
    phi, omega, reach, speed = 0.7, 3.0, 1.3, 0.8
    u = A(phi) @ along
    v = speed * u + reach * omega * A(phi) @ left
    s = State(t=0.0, q=np.array([0, 0, phi, *(reach * u), 0.2]), v=np.array([0, 0, omega, *v, 0.0]))
    a, lam = machine.solution(s)
    push = -machine.jacobian(s).T @ lam
    across = push[3:5] @ A(phi) @ left
    drag = 0.3 * a[3:5] @ u
    assert_allclose(drag, -0.4 * abs(across) * np.tanh(speed / 1e-2), rtol=1e-11)


def test_parameters_of_friction_have_a_sign() -> None:
    model = Model("signed")
    mu, creep = model.parameter("mu", 0.2), model.parameter("creep", 1e-3, "m/s")
    block = model.body("block", 1.0, 1.0)
    model.friction("rub", model.translational("g", model.ground, block), mu, creep)
    assert (model.parameters["mu"].sign, model.parameters["creep"].sign) == (
        "nonnegative",
        "positive",
    )
