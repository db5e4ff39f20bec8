"""Belts, screws, rolling discs, gears with backlash: formulas by hand, motions in closed form."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from codegen import Body, Model
from runtime import Outcome, Result, load
from tests.codegen.elements.hand.joints import LENGTH, OFFSET, component, rack_and_pinion
from tests.codegen.elements.hand.pair import AXIS, SI, SJ, UNIT
from tests.codegen.elements.test_library_forces import balanced, slopes_agree
from tests.codegen.workbench import Interpreted

TOLERANCE = {"rtol": 1e-12, "atol": 1e-12}
R_I, R_J, PLAY = 0.5, 1.2, 0.1
SEEDS = range(5)


def three() -> tuple[Model, Body, Body, Body]:
    """Two wheels and the body that carries them."""
    model = Model("three")
    i, j = (model.body(name, mass=m, inertia=m / 4) for name, m in (("i", 2.0), ("j", 3.0)))
    return model, i, j, model.body("arm", mass=1.0, inertia=0.7)


def simulated(model: Model, folder: Path, t_end: float = 2.0) -> Result:
    instants = np.linspace(0, t_end, 101)
    run = load(model, folder=folder).simulate(t_end, instants, rtol=1e-11, atol=1e-12)
    assert run.outcome is Outcome.OK, run.message
    return run


# -- constraints ----------------------------------------------------------------------------------


@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("carried", [False, True])
def test_belt_by_hand(crossed: bool, carried: bool) -> None:
    model, i, j, arm = three()
    model.belt("belt", i, j, R_I, R_J, crossed=crossed, carrier=arm if carried else None,
               offset=OFFSET)  # fmt: skip
    machine = Interpreted(model)
    first = R_I if crossed else -R_I
    slopes = np.array([0, 0, first, 0, 0, R_J, 0, 0, -(first + R_J) * carried])
    for seed in SEEDS:
        s = machine.state(seed)
        assert_allclose(machine.vector("constraints", s), [slopes @ s.q - OFFSET], **TOLERANCE)
        assert_allclose(machine.jacobian(s), [slopes], **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), [0], atol=0)
        assert_allclose(machine.vector("reactions", s, lam=np.array([2.5])), [-2.5], **TOLERANCE)


def test_screw_by_hand() -> None:
    model, i, j, arm = three()
    model.screw("screw", i.at(*SI), j.at(*SJ), arm, LENGTH, axis=tuple(AXIS), offset=OFFSET)
    machine = Interpreted(model)
    pitch = LENGTH / (2 * np.pi)
    for seed in SEEDS:
        s = machine.state(seed)
        along, on_i, on_j, gamma = component(s, 0, 1, UNIT, SI, SJ)
        turned = np.array([0, 0, pitch])
        phi = along - pitch * (s.q[8] - s.q[2]) - OFFSET
        assert_allclose(machine.vector("constraints", s), [phi], **TOLERANCE)
        rows = [np.concatenate([on_i + turned, on_j, -turned])]
        assert_allclose(machine.jacobian(s), rows, **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), [gamma], **TOLERANCE)


def test_rolling_disc_by_hand() -> None:
    """The equations of a rack and pinion; the reaction acts on the disc, where it touches."""
    model, i, j, _ = three()
    model.rolling_disc("roll", i.at(*SI), j.at(*SJ), LENGTH, axis=tuple(AXIS), offset=OFFSET)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        phi, on_i, on_j, gamma = rack_and_pinion(s, 0, 1)
        assert_allclose(machine.vector("constraints", s), phi, **TOLERANCE)
        rows = np.hstack([on_i, on_j, np.zeros((2, 3))])
        assert_allclose(machine.jacobian(s), rows, **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), gamma, **TOLERANCE)
        told = machine.vector("reactions", s, lam=np.array([1.5, -0.5]))
        assert_allclose(told, [0.5, -1.5, 0.0], **TOLERANCE)


# -- forces ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [-3.0, 0.02, 3.0])
@pytest.mark.parametrize("stretch", [-0.3, -0.05, 0.05, 0.3])
@pytest.mark.parametrize("kind", ["open belt", "crossed belt", "gear"])
def test_strands_and_flanks_by_hand(kind: str, stretch: float, speed: float) -> None:
    """Each side alone, k = 40 N/m, c = 6 N s/m, and never on the other side of 0."""
    model, i, j, arm = three()
    if kind == "gear":
        model.gear_with_backlash("e", i, j, R_I, R_J, backlash=2 * PLAY, stiffness=40.0,
                                 damping=6.0, carrier=arm, offset=OFFSET)  # fmt: skip
    else:
        model.elastic_belt("e", i, j, R_I, R_J, stiffness=40.0, damping=6.0, pretension=40 * PLAY,
                           carrier=arm, crossed=kind[0] == "c", offset=OFFSET)  # fmt: skip
    machine = Interpreted(model)
    first = -R_I if kind == "open belt" else R_I
    slopes = np.array([0, 0, first, 0, 0, R_J, 0, 0, -first - R_J])
    s = machine.state(4)
    s.q[5] += (stretch + OFFSET - slopes @ s.q) / R_J
    s.v[5] += (speed - slopes @ s.v) / R_J
    play = PLAY if kind == "gear" else -PLAY  # teeth bear beyond it, strands are slack beyond it

    def side(u: float, rate: float) -> float:
        return max(40 * (u - play) + 6 * rate, 0.0) if u > play else 0.0

    force = side(stretch, speed) - side(-stretch, -speed)
    modes = [int(g > 0) for g in machine.vector("switching", s)]
    found = machine.vector("applied_forces", s, modes=modes)
    assert_allclose(found, -force * slopes, rtol=1e-11, atol=1e-12)
    deep = [max(u - play, 0.0) for u in (stretch, -stretch)]
    stored = 20 * np.square(deep).sum()
    assert_allclose(machine.vector("potential", s, modes=modes), stored, rtol=1e-11, atol=1e-12)
    slopes_agree(machine, s, modes=modes)
    balanced(machine, s, modes=modes)


# -- motions --------------------------------------------------------------------------------------


def wheels(model: Model, i: float = 0.5, j: float = 0.2) -> tuple[Body, Body]:
    """Two wheels on the ground with these moments of inertia."""
    first, second = (model.body(n, mass=1.0, inertia=size) for n, size in (("one", i), ("two", j)))
    model.revolute("A", model.ground.at(0, 0), first)
    model.revolute("B", model.ground.at(2, 0), second)
    return first, second


@pytest.mark.parametrize("crossed", [False, True])
def test_belt_drive_runs_up(tmp_path: Path, crossed: bool) -> None:
    model = Model("drive")
    one, two = wheels(model)
    model.belt("belt", one, two, 0.3, 0.1, crossed=crossed)
    model.torque("motor", one, 4.0)
    model.scene("run", ["motor"], start={one.phi: 0.0, one.omega: 0.0})
    run = simulated(model, tmp_path)
    ratio = -3.0 if crossed else 3.0
    alpha = 4.0 / (0.5 + 0.2 * ratio**2)
    assert_allclose(run.q("two.phi"), ratio * alpha * run.t**2 / 2, atol=1e-8)
    assert_allclose(run.reaction("belt", "force"), 0.2 * ratio * alpha / 0.1, rtol=1e-8)


def test_belt_on_an_arm_keeps_an_equal_pulley_parallel(tmp_path: Path) -> None:
    """A fixed pulley 0.2 m, one on the arm of 0.2 or 0.1 m: φ_j = φ_arm (1 - R_i/R_j)."""
    model = Model("arm")
    fixed, arm, same, half = (model.body(n, mass=1.0, inertia=0.1) for n in "fash")
    model.weld("base", model.ground, fixed)
    model.revolute("A", model.ground.at(0, 0), arm)
    model.revolute("B", arm.at(1, 0), same)
    model.revolute("C", arm.at(0, 1), half)
    model.belt("first", fixed, same, 0.2, 0.2, carrier=arm)
    model.belt("second", fixed, half, 0.2, 0.1, carrier=arm)
    model.torque("motor", arm, 2.0)
    start = {arm.phi: 0.0, arm.omega: 1.0}
    model.scene("run", ["motor"], start=start, guess={same.x: 1.0, half.y: 1.0})
    run = simulated(model, tmp_path, 3.0)
    inertia = 0.1 + 2 * 1.0 * 1.0**2 + 0.1 * 1.0
    angle = run.t + 2.0 / inertia * run.t**2 / 2
    assert_allclose(run.q("a.phi"), angle, rtol=1e-9, atol=1e-9)
    assert_allclose(run.q("s.phi"), 0, atol=1e-9)
    assert_allclose(run.q("h.phi"), -angle, rtol=1e-9, atol=1e-9)


def test_screw_drives_its_nut(tmp_path: Path) -> None:
    model = Model("press")
    nut, spindle = (model.body(n, mass=3.0, inertia=0.002) for n in ("nut", "spindle"))
    model.translational("guide", model.ground, nut, axis=(0, 1))
    model.revolute("bearing", model.ground.at(1, 0), spindle)
    model.screw("thread", model.ground.at(0, 0), nut, spindle, 0.05, axis=(0, 1))
    model.torque("motor", spindle, 0.4)
    model.force("load", nut, fy=-7.0)
    model.scene("run", ["motor", "load"], start={nut.y: 0.0, nut.vy: 0.0})
    run = simulated(model, tmp_path)
    pitch = 0.05 / (2 * np.pi)
    a = (0.4 * pitch - 7.0 * pitch**2) / (0.002 + 3.0 * pitch**2)
    assert_allclose(run.q("nut.y"), a * run.t**2 / 2, atol=1e-8)
    assert_allclose(run.q("spindle.phi"), a / pitch * run.t**2 / 2, rtol=1e-8, atol=1e-8)
    assert_allclose(run.reaction("thread", "force"), 3.0 * a + 7.0, rtol=1e-9)


def test_disc_rolls_down_a_slope(tmp_path: Path) -> None:
    """g sin β/(1 + J/(m R²)), with the traction that this takes."""
    model = Model("slope", gravity=(0, -9.81))
    disc = model.body("disc", mass=2.0, inertia=0.03)
    beta, radius = -0.3, 0.15
    axis = np.array([np.cos(beta), np.sin(beta)])
    model.rolling_disc("roll", disc, model.ground.at(0.4, 0.1), radius, axis=tuple(axis))
    guess = {disc.x: 0.4, disc.y: 0.3}
    model.scene("run", ["gravity"], start={disc.phi: 0.0, disc.omega: 0.0}, guess=guess)
    run = simulated(model, tmp_path)
    a = 9.81 * np.sin(-beta) / (1 + 0.03 / (2.0 * radius**2))
    way = a * run.t**2 / 2
    assert_allclose(run.q("disc.phi"), -way / radius, rtol=1e-9, atol=1e-9)
    assert_allclose(run.q("disc.x"), 0.4 + axis[0] * way - radius * axis[1], atol=1e-9)
    assert_allclose(run.reaction("roll", "fx"), 2.0 * a - 2.0 * 9.81 * np.sin(-beta), rtol=1e-8)
    assert_allclose(run.reaction("roll", "fy"), 2.0 * 9.81 * np.cos(beta), rtol=1e-9)
    assert_allclose(run.reaction("roll", "torque"), 0, atol=1e-12)


@pytest.mark.parametrize("amplitude", [0.02, 0.2])
def test_elastic_belt_swings_taut_and_slack(tmp_path: Path, amplitude: float) -> None:
    """Both strands while the stretch is below T0/k = 0.05 m, one beyond: u = R_2 φ_2 - R_1 φ_1."""
    model = Model("swing")
    one, two = wheels(model)
    model.elastic_belt("belt", one, two, 0.3, 0.1, stiffness=200.0, pretension=10.0)
    start = {one.phi: 0.0, one.omega: 0.0, two.phi: amplitude / 0.1, two.omega: 0.0}
    model.scene("run", ["belt"], start=start)
    run = simulated(model, tmp_path)
    inverse = 0.3**2 / 0.5 + 0.1**2 / 0.2  # of the mass that u moves
    stretch = 0.1 * run.q("two.phi") - 0.3 * run.q("one.phi")
    assert_allclose(run.energy(), run.energy()[0], rtol=1e-9)
    assert_allclose(0.1 * 0.5 * run.v("one.phi") + 0.3 * 0.2 * run.v("two.phi"), 0, atol=1e-9)
    if amplitude < 0.05:
        frequency = np.sqrt(2 * 200.0 * inverse)
        assert_allclose(stretch, amplitude * np.cos(frequency * run.t), atol=1e-9)
        return

    def rates(_: float, state: np.ndarray) -> list[float]:
        tensions = [max(10.0 + sign * 200.0 * state[0], 0.0) for sign in (1, -1)]
        return [state[1], -inverse * (tensions[0] - tensions[1])]

    other = solve_ivp(rates, (0, 2.0), [amplitude, 0.0], "DOP853", run.t, rtol=1e-12, atol=1e-13,
                      max_step=1e-3)  # fmt: skip
    assert_allclose(stretch, other.y[0], atol=1e-8)


def test_teeth_rattle_in_their_backlash(tmp_path: Path) -> None:
    """Free for b/v, then half a swing at a flank: the play and back, in closed form."""
    model = Model("rattle")
    one, two = wheels(model)
    model.gear_with_backlash("mesh", one, two, 0.3, 0.1, backlash=0.04, stiffness=900.0)
    start = {one.phi: 0.0, one.omega: 0.0, two.phi: 0.0, two.omega: 2.0}
    model.scene("run", ["mesh"], start=start)
    run = simulated(model, tmp_path)
    inverse = 0.3**2 / 0.5 + 0.1**2 / 0.2
    frequency, speed = np.sqrt(900.0 * inverse), 0.1 * 2.0
    play, half = 0.04 / speed, np.pi / frequency
    moved = 0.1 * run.q("two.phi") + 0.3 * run.q("one.phi")
    time = (run.t + play / 2) % (2 * (play + half))
    sign = np.where(time < play + half, 1.0, -1.0)
    time = time % (play + half)
    free = -0.02 + speed * time
    flank = 0.02 + speed / frequency * np.sin(frequency * (time - play))
    assert_allclose(moved, sign * np.where(time < play, free, flank), atol=1e-8)
    assert len(run.events) >= 4
