"""Several frictions that hold one freedom, and many surfaces at one instant."""

from pathlib import Path

import numpy as np
import pytest

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

REACH = (2.0, 3.0)  # N: what the two frictions bear


def particle(folder: Path, slips: tuple[float, float], static: float = 1.0) -> Machine:
    """A particle of 1 kg under a force that grows from F at W a second, on two frictions."""
    m = Model("doubly_held")
    p = m.particle("p", mass=1.0)
    force, growth = m.parameter("F", 0.0), m.parameter("W", 0.0)
    for k, (slip, reach) in enumerate(zip(slips, REACH, strict=True)):
        excess = {} if static == 1.0 else {"static": static * reach / 10.0}
        m.dry_friction(f"f{k}", slip=slip * p.vx, normal=10.0, coefficient=reach / 10.0, **excess)
    m.force("pull", p, force + growth * t, 0)
    m.scene("s", ["f0", "f1", "pull"], start={p.x: 0, p.vx: 0, p.y: 0, p.vy: 0})
    return load(m, "s", folder=folder)


@pytest.mark.parametrize("slips", [(1.0, 1.0), (1.0, -1.0), (3.0, 1.0), (1.0, 3.0)])
def test_two_frictions_bear_together_what_they_can(
    tmp_path: Path, slips: tuple[float, float]
) -> None:
    machine = particle(tmp_path, slips)
    most = sum(abs(slip) * reach for slip, reach in zip(slips, REACH, strict=True))
    for part in (0.0, 0.3, 0.75, 0.99, -0.75, -0.99):
        run = machine.simulate(2.0, [0.0, 2.0], parameters={"F": part * most}, progress=False)
        assert run.outcome is Outcome.OK
        assert abs(run.q("p.x")).max() == 0.0
        forces = [run.reaction(f"f{k}", "force")[-1] for k in range(2)]
        assert np.dot(slips, forces) == pytest.approx(-part * most, abs=1e-12)
        assert np.all(np.abs(forces) <= REACH)
    for part in (1.01, -1.01):
        run = machine.simulate(2.0, parameters={"F": part * most}, progress=False)
        assert run.q("p.x")[-1] == pytest.approx(np.sign(part) * 0.01 * most * 2.0, rel=1e-9)


@pytest.mark.parametrize("static", [1.0, 1.5])
@pytest.mark.parametrize("growth", [4.0, -4.0])
def test_two_frictions_let_go_together(tmp_path: Path, static: float, growth: float) -> None:
    machine = particle(tmp_path, (3.0, 1.0), static)
    run = machine.simulate(4.0, parameters={"W": growth}, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK
    due = 9.0 * static / 4.0
    assert [e.name[:2] for e in run.events] == ["f0", "f1"]
    np.testing.assert_allclose([e.time for e in run.events], due, rtol=1e-12)
    slid = 4.0 - due
    moved = 0.5 * (4.0 * due - 9.0) * slid**2 + 4.0 * slid**3 / 6.0
    assert run.q("p.x")[-1] == pytest.approx(np.sign(growth) * moved, rel=1e-9)


def test_crank_with_a_brake_rests_on_the_friction_of_its_guide(tmp_path: Path) -> None:
    m = Model("braked_crank", gravity=(0, -9.81))
    mu = m.parameter("mu", 0.05, sign="nonnegative")
    r, length = 0.3, 0.9
    crank = m.body("crank", mass=1.0, inertia=0.05)
    rod = m.body("rod", mass=1.5, inertia=1.5 * length**2 / 12)
    slider = m.body("slider", mass=2.0, inertia=0.01)
    m.revolute("bearing", m.ground.at(0, 0), crank)
    m.revolute("pin", crank.at(r, 0), rod.at(-length / 2, 0))
    m.revolute("wrist", rod.at(length / 2, 0), slider)
    guide = m.translational("guide", m.ground, slider, axis=(1, 0))
    m.friction("rub", guide, mu)
    m.dry_friction("brake", slip=crank.omega, normal=5.0, coefficient=0.1)
    m.scene(
        "s",
        ["gravity", "rub", "brake"],
        start={crank.phi: 4.5, crank.omega: 0.0},
        guess={rod.x: 0.33, rod.y: -0.147, rod.phi: 0.33, slider.x: 0.78},
    )
    machine = load(m, "s", folder=tmp_path)
    run = machine.simulate(2.0, [0.0, 2.0], progress=False)
    assert run.outcome is Outcome.OK
    phi = 4.5
    # Gravity's torque on the crank: its own weight rests in the bearing, half the rod's on the pin.
    due = 1.5 * 9.81 * 0.5 * r * np.cos(phi)
    sine = -r / length * np.sin(phi)
    speed = -r * np.sin(phi) + length * sine * r * np.cos(phi) / (length * np.sqrt(1.0 - sine**2))
    brake, rub = run.reaction("brake", "force")[-1], run.reaction("rub", "force")[-1]
    assert brake + speed * rub == pytest.approx(due, rel=1e-8)
    assert abs(brake) <= 0.5
    assert abs(rub) <= 0.05 * run.reaction("rub", "normal")[-1] + 1e-12
    np.testing.assert_allclose(run.q("crank.phi"), phi, atol=1e-12)


def test_many_blocks_settle_each_on_its_own(tmp_path: Path) -> None:
    """The first two stick at the start, the third is at its limit, the others slide."""
    count = 12
    m = Model("row_of_blocks")
    start, effects = {}, []
    for k in range(count):
        p = m.particle(f"p{k}", mass=1.0)
        m.dry_friction(f"r{k}", slip=p.vx, normal=10.0, coefficient=0.2)
        m.force(f"pull{k}", p, (t + k) * (-1) ** k, 0)
        effects += [f"r{k}", f"pull{k}"]
        start |= {p.x: 0, p.vx: 0, p.y: k, p.vy: 0}
    m.scene("s", effects, start=start)
    run = load(m, "s", folder=tmp_path).simulate(5.0, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK
    for k in range(count):
        slid = 5.0 - max(0.0, 2.0 - k)
        moved = 0.5 * max(k - 2.0, 0.0) * slid**2 + slid**3 / 6.0
        assert run.q(f"p{k}.x")[-1] == pytest.approx((-1) ** k * moved, rel=1e-8)
