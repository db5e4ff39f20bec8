"""Bodies that rest on rigid contacts from the first instant on, near the origin and far from it."""

from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from runtime import load

G = 9.81
EVERYWHERE = pytest.mark.parametrize(
    ("formulation", "height"),
    [(form, y) for form in ("cartesian", "reduced") for y in (0.0, 1e-3, 1e3, 1e5)],
)


@EVERYWHERE
def test_floor_bears_a_weight_from_the_first_row_on(
    workshop: Path, formulation: str, height: float
) -> None:
    model = Model("resting_weight", gravity=(0, -G))
    level, push = model.parameter("level", 0.0), model.parameter("push", 0.0)
    weight = model.particle("weight", mass=2.0)
    model.absolute("guide", weight, "x", 0)
    model.contact("floor", gap=weight.y - level, restitution=0)
    model.force("pull", weight, fy=push)
    model.scene("lies", ["gravity", "floor", "pull"], start={weight.y: 0, weight.vy: 0})
    for pull in (0.0, 2.0 * G - 1e-3, 2.0 * G + 1.0):
        run = load(model, folder=workshop).simulate(
            0.1, 3, formulation=formulation, start={"weight.y": height},
            parameters={"level": height, "push": pull},
        )  # fmt: skip
        assert not run.events
        due = max(2.0 * G - pull, 0.0)
        np.testing.assert_allclose(run.reaction("floor", "force"), due, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(run.a("weight.y"), max(pull / 2.0 - G, 0.0), atol=1e-12)


@EVERYWHERE
def test_beam_on_one_of_its_ends_tips_about_it(
    workshop: Path, formulation: str, height: float
) -> None:
    model = Model("tipping_beam", gravity=(0, -G))
    level = model.parameter("level", 0.0)
    beam = model.body("beam", mass=2.0, inertia=0.5)
    model.absolute("guide", beam, "x", 0)
    for name, x in (("left", -1), ("right", 1)):
        model.contact(name, gap=beam.at(x, 0).y - level, restitution=0)
    start = {beam.y: 0, beam.vy: 0, beam.phi: 0, beam.omega: 0}
    model.scene("lies", ["gravity", "left", "right"], start=start)
    model.scene("tips", ["gravity", "left"], start=start)
    settings = {"formulation": formulation, "parameters": {"level": height},
                "start": {"beam.y": height}}  # fmt: skip
    lies = load(model, "lies", folder=workshop).simulate(0.1, 3, **settings)
    for end in ("left", "right"):
        np.testing.assert_allclose(lies.reaction(end, "force"), G, rtol=1e-9)
    tips = load(model, "tips", folder=workshop).simulate(0.1, 3, **settings)
    # I α = -F l, m a = F - m g, and a = -α l where the end stays: F = m g I/(I + m l²).
    assert tips.reaction("left", "force")[0] == pytest.approx(2.0 * G * 0.5 / 2.5, rel=1e-9)
    assert tips.a("beam.phi")[0] == pytest.approx(-2.0 * G / 2.5, rel=1e-9)
    assert not tips.events


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("speed", [0.0, 0.7, 40.0])
def test_gap_that_a_rod_keeps_closed_is_not_moved_by_rounding(
    workshop: Path, formulation: str, speed: float
) -> None:
    model = Model("ring_of_a_rod", gravity=(0, -G))
    bob = model.particle("bob", mass=1.5)
    length = bob.x**2 + bob.y**2
    model.constraint("rod", length - 1)
    model.contact("ring", gap=length**0.5 - 1, restitution=0)
    model.scene("swings", ["gravity", "ring"], start={bob.x: 0.6, bob.vx: 0}, guess={bob.y: -1})
    run = load(model, folder=workshop).simulate(
        0.5, 11, formulation=formulation, start={"bob.vx": speed}
    )
    assert run.outcome.name == "OK"
    assert not run.events
    assert np.abs(run.reaction("ring", "force")).max() == 0.0
