"""Several things at one instant, and instants at the end of a run, against closed forms."""

from pathlib import Path

import numpy as np
import pytest
from sympy import pi

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import METHODS

WEIGHT, KINETIC = 10.0, 0.2


def torn(directions: tuple[int, ...], static: float) -> Model:
    """Blocks of 1 kg on a rough floor, each pulled by a force of 1 N/s in its direction."""
    model = Model(
        "torn_" + "".join("n" if d < 0 else "p" for d in directions) + f"{static:.1f}"[2:]
    )
    start, effects = {}, []
    for k, direction in enumerate(directions):
        block = model.particle(f"block{k}", mass=1.0)
        model.dry_friction(
            f"rub{k}", slip=block.vx, normal=WEIGHT, coefficient=KINETIC, static=static
        )
        model.force(f"pull{k}", block, direction * t, 0)
        effects += [f"rub{k}", f"pull{k}"]
        start |= {block.x: 0, block.vx: 0, block.y: k, block.vy: 0}
    model.scene("pulled", effects, start=start)
    return model


@pytest.mark.parametrize(
    ("directions", "static"), [((1, 1), 0.2), ((1, -1, 1, -1), 0.2), ((1, -1, 1, -1), 0.3)]
)
def test_blocks_that_break_loose_together(
    directions: tuple[int, ...], static: float, tmp_path: Path
) -> None:
    run = load(torn(directions, static), "pulled", folder=tmp_path).simulate(5.0, max_steps=1000)
    assert run.outcome is Outcome.OK
    loose = static * WEIGHT
    assert len(run.events) == len(directions)
    np.testing.assert_allclose([e.time for e in run.events], loose, rtol=0, atol=1e-12)
    # v' = t - 2 from the instant at which the block is let go.
    due = ((5.0 - 2.0) ** 3 - (loose - 2.0) ** 3) / 6.0 - (loose - 2.0) ** 2 / 2.0 * (5.0 - loose)
    for k, direction in enumerate(directions):
        assert run.q(f"block{k}.x")[-1] == pytest.approx(direction * due, abs=1e-7)


def test_block_breaks_loose_where_another_is_caught(tmp_path: Path) -> None:
    """One slows down at 2 m/s² from 4 m/s and is caught at 2 s, when the other is torn loose."""
    model = Model("torn_and_caught")
    fast, slow = model.particle("fast", mass=1.0), model.particle("slow", mass=1.0)
    for name, block in (("stop", fast), ("rub", slow)):
        model.dry_friction(name, slip=block.vx, normal=WEIGHT, coefficient=KINETIC)
    model.force("pull", slow, t, 0)
    start = {fast.x: 0, fast.vx: 4, fast.y: 0, fast.vy: 0}
    start |= {slow.x: 0, slow.vx: 0, slow.y: 1, slow.vy: 0}
    model.scene("both", ["stop", "rub", "pull"], start=start)
    run = load(model, "both", folder=tmp_path).simulate(5.0, max_steps=1000)
    assert run.outcome is Outcome.OK
    assert sorted(e.name.split(":")[0] for e in run.events) == ["rub", "stop"]
    np.testing.assert_allclose([e.time for e in run.events], 2.0, rtol=0, atol=1e-10)
    assert run.q("fast.x")[-1] == pytest.approx(4.0, abs=1e-7)
    assert run.v("fast.x")[-1] == 0.0
    assert run.q("slow.x")[-1] == pytest.approx(4.5, abs=1e-7)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_impact_that_a_driver_refuses_is_logged_where_the_run_ends(
    restitution: float, tmp_path: Path
) -> None:
    model = Model("driven_onto_a_stop")
    e = model.parameter("e", 0.5)
    arm = model.body("arm", mass=2.0, inertia=1.0)
    model.revolute("pin", model.ground.at(0, 0), arm.at(-0.5, 0))
    model.driver("turn", arm.phi, pi / 3 + 2 * pi * t)
    model.contact("stop", gap=arm.y - 0.1, restitution=e)
    guess = {arm.x: 0.25, arm.y: 0.433, arm.phi: 1.047}
    model.scene("turned", ["stop"], ["turn"], guess=guess)
    machine = load(model, "turned", folder=tmp_path)
    run = machine.simulate(3.0, parameters={"e": restitution})
    assert run.outcome is Outcome.INCONSISTENT
    # y = 1/2 sin φ meets 0.1 at φ = π - arcsin 0.2.
    due = (np.pi - np.arcsin(0.2) - np.pi / 3) / (2 * np.pi)
    assert run.t[-1] == pytest.approx(due, abs=1e-9)
    assert [event.time for event in run.events] == [run.t[-1]]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ulps", range(-1, 3))
def test_impact_at_the_very_end(method: str, ulps: int) -> None:
    """What the clock cannot tell from the end of the run has happened."""
    impact = np.sqrt(2.0 / 9.81)
    end = float(impact + ulps * np.spacing(impact))
    run = load("hard/bouncing_ball", "dropped").simulate(end, method=method)
    assert run.outcome is Outcome.OK
    assert len(run.events) == 1
    assert run.t[-1] == end
    assert run.v("ball.y")[-1] == pytest.approx(0.5 * 9.81 * impact, rel=1e-9)
