"""Places that move by themselves and jump: the impulse of a damper there is not lost silently."""

from pathlib import Path

import pytest
from sympy import Expr, Heaviside, Max, Mod, Piecewise, cos, floor, sqrt, tanh

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome


@pytest.mark.parametrize(
    ("name", "place", "instant"),
    [
        ("stepped", 0.1 * Heaviside(t - 1), 1.0),
        ("floored", 0.1 * floor(t / 1.5), 1.5),
        ("in_pieces", Piecewise((0.0, t < 1), (0.1, True)), 1.0),
        ("back", 0.1 * Mod(t, 1.0), 1.0),
        ("bent", Max(0.1 * t, 0.1), None),
        ("bent_in_pieces", Piecewise((0.1 * t, t < 1), (0.2 * t - 0.1, True)), None),
    ],
)
@pytest.mark.parametrize("kind", ["damper", "law", "bushing", "contact"])
def test_no_place_jumps_whose_rate_acts(
    workshop: Path, name: str, place: Expr, instant: float | None, kind: str
) -> None:
    """The impulse c Δℓ of a damper whose end jumps would be lost, as no force has it."""
    model = Model(f"place_{name}_{kind}")
    block = model.body("block", mass=2.0, inertia=1.0)
    for letter in "y", "phi":
        model.absolute(f"guide_{letter}", block, letter, 0.0)
    end = model.ground.at(place - (0.0 if kind == "bushing" else 5.0), 0)
    if kind == "damper":
        model.spring("link", end, block, damping=2.0)
    elif kind == "law":
        model.spring("link", end, block, force=lambda length, speed: 2.0 * speed)
    elif kind == "bushing":
        model.bushing("link", end, block, damping=(2.0, 0.0, 0.0))
    else:
        model.contact("link", gap=block.x - place - 5.0, stiffness=1e-3, damping=2.0)
    model.scene("run", ["link"], start={block.x: 0.0, block.vx: 0.0})
    result = load(model, "run", folder=workshop).simulate(3.0)
    if instant is None:
        assert result.outcome is Outcome.OK
    else:
        assert result.outcome is Outcome.DISCONTINUOUS
        assert result.t[-1] == pytest.approx(instant)
        assert f"in 'link' jumps by 0.1 at t = {instant:g} s, where its rate acts" in result.message


def test_a_spring_without_a_damper_has_ends_that_jump(workshop: Path) -> None:
    model = Model("place_of_a_spring")
    block = model.particle("block", mass=2.0)
    model.absolute("guide", block, "y", 0.0)
    model.spring("link", model.ground.at(0.1 * Heaviside(t - 1), 0), block, 8.0, free_length=0.0)
    model.scene("run", ["link"], start={block.x: 0.0, block.vx: 0.0})
    result = load(model, "run", folder=workshop).simulate(3.0)
    assert result.outcome is Outcome.OK
    assert result.q("block.x")[-1] == pytest.approx(0.1 * (1 - cos(4.0)), abs=1e-7)


@pytest.mark.parametrize("kind", ["open contact", "no damping", "own speed"])
def test_places_may_jump_where_no_rate_acts(workshop: Path, kind: str) -> None:
    model = Model(f"place_{kind.replace(' ', '_')}")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    end = Piecewise((-1.0, t < 1), (-1.1, True))
    if kind == "open contact":
        gap = block.x - Piecewise((-1.0, t < 1), (-100.0, True))
        model.contact("link", gap=gap, stiffness=1e3, damping=2.0)
    elif kind == "no damping":
        damping = model.parameter("damping", 0.0, unit="N s/m")
        model.spring("link", model.ground.at(end, 0), block, 8.0, free_length=1.0, damping=damping)
    else:
        model.spring(
            "link", model.ground.at(end, 0), block, force=lambda s, _: 8 * (s - 1) - block.vx
        )
    model.scene("run", ["link"], start={block.x: 0.0, block.vx: 0.0})
    result = load(model, "run", folder=workshop).simulate(3.0)
    assert result.outcome is Outcome.OK
    stretched = {"open contact": 0.0, "no damping": -0.1 * (1 - cos(2 * sqrt(8.0)))}
    if kind in stretched:
        assert result.q("block.x")[-1] == pytest.approx(float(stretched[kind]), abs=1e-6)


@pytest.mark.parametrize("kind", ["one-sided", "oblique"])
def test_dampers_that_rest_or_lie_across_are_seen(workshop: Path, kind: str) -> None:
    model = Model(f"place_{kind.replace('-', '_')}")
    block = model.particle("block", mass=1.0)
    jump = Piecewise((0.0, t < 1), (0.1, True))
    if kind == "one-sided":
        model.absolute("guide", block, "y", 0.0)
        end, law = (
            model.ground.at(-1.0 - jump, 0),
            lambda s, v: Piecewise((20 * v, v > 0), (0, True)),
        )
        model.spring("link", end, block, force=law)
    else:
        end = model.ground.at(-2.0 - 2 * jump, 1.0 + jump)
        model.spring("link", end, block, 8.0, free_length=5**0.5, damping=2.0)
    across = () if kind == "one-sided" else (block.y, block.vy)
    model.scene("run", ["link"], start=dict.fromkeys((block.x, block.vx, *across), 0.0))
    assert load(model, "run", folder=workshop).simulate(1.5).outcome is Outcome.DISCONTINUOUS


@pytest.mark.parametrize(
    ("kind", "right"), [("elsewhere", -0.1 * 1.5), ("one way", 0.0), ("bounded", None)]
)
def test_only_the_force_along_the_place_that_jumps_counts(
    workshop: Path, kind: str, right: float | None
) -> None:
    """A damper elsewhere, one that the jump slackens, and a force that has a bound."""
    model = Model(f"jump_beside_{kind.replace(' ', '_')}")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    speed = -0.1 if kind == "elsewhere" else 0.0
    if kind == "elsewhere":
        gap = block.x - Piecewise((-1.0, t < 1), (-100.0, True))
        model.contact("link", gap=gap, stiffness=1e3, damping=2.0)
        model.force("drag", block, fx=-0.1 * (block.vx - speed))
    else:
        end = model.ground.at(Piecewise((-1.0, t < 1), (-0.9, True)), 0)
        laws = {
            "one way": lambda _, v: Piecewise((20 * v, v > 0), (0, True)),
            "bounded": lambda s, v: s - 1 + tanh(10 * v),
        }
        model.spring("link", end, block, force=laws[kind])
    drag = ["drag"] if kind == "elsewhere" else []
    model.scene("run", ["link", *drag], start={block.x: 0.0, block.vx: speed})
    result = load(model, "run", folder=workshop).simulate(1.5)
    assert result.outcome is Outcome.OK
    if right is not None:
        assert result.q("block.x")[-1] == pytest.approx(right, abs=1e-9)
    else:
        assert result.v("block.x")[-1] > 1e-3  # the spring of 1 N/m pushes from then on


@pytest.mark.parametrize("may_pull", [False, True])
def test_a_floor_that_is_taken_away(workshop: Path, may_pull: bool) -> None:
    """A damper that cannot pull lets the block fall; one that can would draw it along."""
    model = Model(f"floor_taken_away_{may_pull}")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "x", 0.0)
    model.gravity("weight", (0, -10))
    gap = block.y - Piecewise((0.0, t < 1), (-1.0, True))
    model.contact("floor", gap=gap, stiffness=1e3, damping=20.0, may_pull=may_pull)
    model.scene("run", ["weight", "floor"], start={block.y: -0.01, block.vy: 0.0})
    result = load(model, "run", folder=workshop).simulate(1.25)
    if may_pull:
        assert result.outcome is Outcome.DISCONTINUOUS
        assert "in 'floor' jumps by 1 at t = 1 s, where its rate acts" in result.message
    else:
        assert result.outcome is Outcome.OK
        assert result.q("block.y")[-1] == pytest.approx(-0.01 - 10 * 0.25**2 / 2, abs=1e-7)


def test_every_place_that_jumps_at_an_instant_is_judged(workshop: Path) -> None:
    model = Model("two_places_that_jump")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    gap = block.x - Piecewise((-1.0, t < 1), (-100.0, True))
    model.contact("open", gap=gap, stiffness=1e3, damping=2.0)
    end = model.ground.at(Piecewise((-1.0, t < 1), (-1.1, True)), 0)
    model.spring("link", end, block, damping=2.0)
    model.scene("run", ["open", "link"], start={block.x: 0.0, block.vx: 0.0})
    result = load(model, "run", folder=workshop).simulate(1.5)
    assert result.outcome is Outcome.DISCONTINUOUS
    assert "in 'link' jumps by 0.1 at t = 1 s, where its rate acts" in result.message


def test_a_place_without_a_value_at_the_start_is_named(workshop: Path) -> None:
    model = Model("place_of_a_pole")
    block = model.body("block", mass=2.0, inertia=1.0)
    model.force("push", block.at(1 / t, 0), 1, 1)
    model.scene("run", ["push"])
    run = load(model, "run", folder=workshop).simulate(0.1)
    assert run.outcome is Outcome.NOT_FINITE
    assert "The force of 'push' along block.phi is not finite at t = 0 s" in run.message
    assert "''" not in run.message
