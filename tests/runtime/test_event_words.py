"""Events in words, labels of conditions, and numbers that are rounding."""

from pathlib import Path

import numpy as np
import pytest
from sympy import And, Piecewise, cos, pi, sin

from codegen import Model, build, t
from codegen.errors import ModelError
from codegen.object_display import without_rounding
from runtime import load
from runtime.machine_facade import Machine
from runtime.results.event_text import event_text
from runtime.results.result import Result


def words(result: Result) -> list[str]:
    return [event.text for event in result.events]


def test_a_ball_touches_leaves_and_rests(workshop: Path) -> None:
    model = Model("bouncing_words", gravity=(0, -9.81))
    ball = model.particle("ball", 1.0)
    model.contact("plate", gap=ball.y, restitution=0.5)
    model.scene("falls", ["gravity", "plate"], start={
        ball.x: 0.0, ball.y: 1.0, ball.vx: 0.0, ball.vy: 0.0
    })  # fmt: skip
    r = load(model, folder=workshop).simulate(3.0)
    found = words(r)
    assert found[0] == "plate touches"
    assert found[-1] == "plate rests"
    assert {event.element for event in r.events} == {"plate"}
    assert all(event.name == "plate: ball_y > 0" for event in r.events)


def block(name: str) -> tuple[Model, object]:
    model = Model(name)
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    return model, mass


@pytest.fixture(scope="module")
def labelled(workshop: Path) -> Machine:
    model, mass = block("labelled_words")
    model.force("push", mass, fx=2.0, when=mass.x > 0.3, label="the block passes the mark")
    model.scene("runs", ["push"], start={mass.x: 0.0, mass.vx: 1.0})
    return load(model, folder=workshop)


def test_a_label_names_the_events_of_a_condition(labelled: Machine) -> None:
    r = labelled.simulate(1.0)
    assert words(r) == ["the block passes the mark"]
    assert set(r.mode("push: the block passes the mark")) == {0, 1}


@pytest.mark.parametrize(
    ("name", "direction", "text"),
    [
        ("gas: slider_x <= 5", -1, "gas: x of slider passes 5 m"),
        ("gas: slider_x <= 5", 1, "gas: x of slider falls below 5 m"),
        ("gas: 2*pi > left_arm_phi", 1, "gas: phi of left_arm falls below 2*pi"),
        ("gas: slider_vx > 0", -1, "gas: vx of slider becomes negative"),
        ("gas: slider_vx > 0", 0, "gas: the motion stays on vx of slider = 0 m/s"),
        ("motor: t >= 0.25", 1, "motor: t passes 0.25 s"),
        ("valve: p_low > p_high", -1, "valve: p_low > p_high ceases to hold"),
        ("valve: opens / closes", 1, "opens"),
        ("valve: opens / closes", -1, "closes"),
        ("valve: opens / closes", 0, "valve: the motion stays on the boundary of opens"),
        ("valve: opens", -1, "no longer: opens"),
        (
            "cloth: pierces / turns (part: bar_y < -0.045)", 1,
            "cloth: y of bar falls below -0.045 m (part of pierces)",
        ),
        (
            "cloth: pierces / turns (part: bar_vy < 0)", -1,
            "cloth: vy of bar becomes positive (part of pierces)",
        ),
        ("push: in range / out of range (phi < -0.5)", -1, "out of range (phi < -0.5)"),
        ("push: in range (phi > -0.5)", 1, "push: in range (phi > -0.5) begins to hold"),
        ("singular: drive, A", 3, "drive, A: a singular position is crossed"),
    ],
)  # fmt: skip
def test_a_condition_is_told_in_words(name: str, direction: int, text: str) -> None:
    assert event_text(name, direction) == text


def test_a_condition_of_a_law_and_its_opposite_have_the_words_of_a_label(workshop: Path) -> None:
    model, mass = block("valve_words")
    model.force("gas", mass, fx=Piecewise((-8.0, mass.x <= 0.3), (-9.0, True)))
    model.label(mass.x > 0.3, "valve opens / valve closes")
    model.scene("runs", ["gas"], start={mass.x: 0.0, mass.vx: 3.0})
    assert words(load(model, folder=workshop).simulate(0.8)) == ["valve opens", "valve closes"]


def test_each_part_of_a_condition_tells_of_which_label_it_is(workshop: Path) -> None:
    model, mass = block("two_parts")
    both = And(mass.x > 0.3, mass.x < 0.6)
    model.force("push", mass, fx=2.0, when=both, label="in range (x > 0.3) / out of range")
    model.scene("runs", ["push"], start={mass.x: 0.0, mass.vx: 1.0})
    assert words(load(model, folder=workshop).simulate(1.0)) == [
        "push: x of mass passes 0.3 m (part of in range (x > 0.3))",
        "push: x of mass passes 0.6 m (part of in range (x > 0.3))",
    ]


def test_a_label_without_a_condition_is_refused() -> None:
    model, mass = block("wrong_labels")
    model.force("push", mass, fx=2.0, label="never")
    model.scene("runs", ["push"])
    with pytest.raises(ModelError, match="label='never' names the events of when="):
        build(model, compile=False)


def test_friction_slips_sticks_and_reverses(workshop: Path) -> None:
    model, mass = block("rubbing_words")
    model.force("shake", mass, fx=1.5 * sin(2 * pi * t))
    model.dry_friction("rub", coefficient=1.0, normal=1.0, slip=mass.vx)
    model.scene("runs", ["shake", "rub"], start={mass.x: 0.0, mass.vx: 0.0})
    r = load(model, folder=workshop).simulate(3.0)
    assert {"rub slips", "rub sticks"} <= {*words(r)}
    assert {event.element for event in r.events} == {"rub"}


def test_a_normal_force_that_ceases_and_a_belt_that_slackens(workshop: Path) -> None:
    model, mass = block("pressing_words")
    model.dry_friction("rub", coefficient=0.3, normal=5 * cos(7 * mass.x) + 1, slip=mass.vx)
    model.scene("slides", ["rub"], start={mass.x: 0.0, mass.vx: 2.0})
    i, j = (model.body(name, 1.0, 0.1) for name in "ij")
    for body, x in ((i, 0), (j, 1)):
        model.revolute(f"pin_{body.name}", model.ground.at(x, 0), body.at(0, 0))
    model.elastic_belt("belt", i, j, 0.1, 0.3, stiffness=1e3, pretension=1.0)
    model.torque("shake", j, value=5 * sin(6 * t))
    model.scene("turns", ["belt", "shake"], start={i.phi: 0.0, j.phi: 0.0})
    slides = words(load(model, "slides", folder=workshop).simulate(1.0))
    assert slides == ["rub ceases to press", "rub presses"] * 2
    turns = words(load(model, "turns", folder=workshop).simulate(0.6))
    assert turns == ["belt slackens", "belt tightens", "belt slackens"]


def stopped(name: str, **stop: float) -> Result:
    """A slider that runs into a damped stop; its springs push from 0.5 m on, and never pull."""
    model, mass = block(name)
    model.stop("limit", mass.x, lower=-0.5, upper=0.5, stiffness=100.0, **stop)
    model.scene("runs", ["limit"], start={mass.x: 0.0, mass.vx: 1.0}, outputs=["forces"])
    return load(model).simulate(2.0)


@pytest.mark.parametrize("damping", [0.0, 4.0])
def test_a_stop_touches_where_it_pushes_and_leaves_where_it_ceases_to(
    workshop: Path, monkeypatch: pytest.MonkeyPatch, damping: float
) -> None:
    """With a damper the push ends before the gap opens, and its sign may change in flight."""
    monkeypatch.chdir(workshop)
    r = stopped(f"stopped_words_{damping:g}", damping=damping)
    named = [event for event in r.events if event.word not in ("approaches", "recedes")]
    assert [event.word for event in named][:3] == (
        ["touches", "leaves", "opens"] if damping else ["touches", "leaves", "touches"]
    )
    push = {event.time: r.at(event.time + 1e-6).force("limit", "second")[0] for event in named}
    for event, force in zip(named, push.values(), strict=True):
        if r.at(event.time).q("mass.x")[0] > 0.0:
            assert (force > 1e-6) == (event.word == "touches"), event


def test_long_conditions_are_cut(workshop: Path) -> None:
    model, mass = block("long_words")
    long = sum(sin(k * mass.x) for k in range(1, 20))
    model.force("push", mass, fx=2.0, when=mass.x + 0 * long + 1e-9 * long > 0.3)
    model.scene("runs", ["push"], start={mass.x: 0.0, mass.vx: 1.0})
    (text,) = words(load(model, folder=workshop).simulate(1.0))
    assert len(text) < 80


def test_rounding_is_shown_as_zero() -> None:
    assert without_rounding([-2.76e-76, 1.0, -0.0, 2e-9]) == [0.0, 1.0, 0.0, 2e-9]
    assert without_rounding([3e-20, 1e-20]) == [3e-20, 1e-20]
    assert np.isnan(without_rounding([np.nan, 1.0])[0])


def test_no_event_of_a_damped_stop_or_a_clutch_with_a_capacity_is_a_formula(workshop: Path) -> None:
    model, mass = block("plain_words")
    disc = model.body("disc", mass=1.0, inertia=0.1)
    model.revolute("hub", model.ground.at(0, 0), disc.at(0, 0))
    model.stop("limit", mass.x, lower=-0.5, upper=0.5, stiffness=100.0, damping=4.0)
    model.one_way_clutch("freewheel", driver=model.ground, driven=disc, capacity=1.0)
    model.torque("shake", disc, value=2.0 * sin(2 * pi * t))
    model.scene("runs", ["limit", "freewheel", "shake"], start={
        mass.x: 0.0, mass.vx: 1.0, disc.phi: 0.0, disc.omega: -1.0
    })  # fmt: skip
    found = {*words(load(model, folder=workshop).simulate(3.0))}
    assert {"limit approaches", "limit touches", "limit leaves", "freewheel overruns"} <= found
    assert not [text for text in found if "hold" in text or "boundary" in text]


def test_a_label_returns_its_condition_and_needs_words() -> None:
    model, mass = block("returned_labels")
    opens = mass.x > 0.3
    assert model.label(opens, "valve opens") is opens
    for words in ("", " / valve closes"):
        model.label(opens, words)
        assert "give both, in words" in model.problems[-1]
    assert len(model.problems) == 2
