"""Conditions that start on their boundary and stay there hold as they are written."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Abs, Heaviside, Max, Piecewise, cos, sign, sin

from codegen import Model, t
from codegen.declare.body import Body
from codegen.derive.equations import derive
from codegen.derive.piecewise_conditions import (
    Boundary,
    as_pieces,
    boundary,
    conditions,
    switching_function,
)
from codegen.derive.switching_functions import Switch, find_switch
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

Force = Callable[[Body], Any]


def holds(condition: Any) -> Any:
    """1 where it holds, else 0."""
    return Piecewise((1, condition), (0, True))


RESTING: dict[str, tuple[Force, float]] = {
    "at_least": (lambda p: Piecewise((1, p.y >= 0), (0, True)), 1.0),
    "above": (lambda p: Piecewise((1, p.y > 0), (0, True)), 0.0),
    "at_most": (lambda p: Piecewise((1, p.y <= 0), (0, True)), 1.0),
    "below": (lambda p: Piecewise((1, p.y < 0), (0, True)), 0.0),
    "neither": (lambda p: Piecewise((1, p.y > 0), (2, p.y < 0), (3, True)), 3.0),
    "speed": (lambda p: Piecewise((1, p.vy >= 0), (0, True)), 1.0),
    "side": (lambda p: 5 * sign(p.y), 0.0),
    "half": (lambda p: 5 * Heaviside(p.y), 2.5),
    "upper": (lambda p: 5 * Heaviside(p.y, 1), 5.0),
    "lower": (lambda p: 5 * Heaviside(p.y, 0), 0.0),
    "kink": (lambda p: 4 + Abs(p.y) + Max(p.y, 0), 4.0),
    "odd": (lambda p: 4 + sign(p.y) * Abs(p.y) ** 1.5, 4.0),
    "speed_sign": (lambda p: 3 * (1 + sign(p.vy)), 3.0),
    "speed_half": (lambda p: 3 * Heaviside(p.vy), 1.5),
    "speed_above": (lambda p: Piecewise((1, p.vy > 0), (0, True)), 0.0),
    "speed_both": (lambda p: holds(p.vy >= 0) + 2 * holds(p.vy > 0), 1.0),
    "speed_either": (lambda p: 4 + holds(p.vy >= 0) - holds(p.vy <= 0), 4.0),
    "speed_third": (lambda p: holds(p.vy > 0) + 2 * holds(p.vy < 0) + sign(p.vy), 0.0),
    "speed_sides": (lambda p: 3 * holds(p.vy > 0) - 2 * holds(p.vy < 0), 0.0),
    "speed_order": (lambda p: -2 * holds(p.vy < 0) + 3 * holds(p.vy > 0), 0.0),
    "from_now_on": (lambda p: Piecewise((1, t >= 0), (0, True)), 1.0),
    "after_now": (lambda p: Piecewise((1, t > 0), (0, True)), 1.0),
    "until_now": (lambda p: Piecewise((1, t <= 0), (0, True)), 0.0),
}
"""Name of a particle at y = 0 → the force along x on it, and its value from t = 0 on."""

FIRST = {"after_now": 0.0, "until_now": 1.0}
"""Of a condition that changes in the first instant: the value there, where t is 0 as written."""


@pytest.fixture(scope="module")
def resting(workshop: Path) -> Machine:
    model = Model("resting")
    for name, (force, _) in RESTING.items():
        bead = model.particle(name, mass=1.0)
        model.force(f"on_{name}", bead, fx=force(bead))
        if len(name) % 2:  # half of them by a joint, half by nothing
            model.absolute(f"rail_{name}", bead, "y", 0)
    return load(model, folder=workshop)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_every_sample_has_the_forces_of_the_boundary(resting: Machine, method: Any) -> None:
    instants = np.linspace(0, 1, 5)
    run = resting.simulate(1.0, instants, method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert not run.events
    for name, (_, value) in RESTING.items():
        expected = [FIRST.get(name, value), *[value] * 4]
        assert_allclose(run.a(f"{name}.x"), expected, rtol=1e-12, err_msg=name)
        assert_allclose(run.q(f"{name}.x"), value / 2 * instants**2, rtol=1e-9, err_msg=name)


def slider_crank(name: str, force: Callable[[Body, Body, Body], Any]) -> Model:
    """A crank that runs free, and a bead with a force that the crank's state switches."""
    model = Model(name)
    crank, rod, slider = (model.body(n, mass=1.0, inertia=0.1) for n in ("crank", "rod", "slider"))
    bead = model.particle("bead", mass=1.0)
    model.revolute("A", model.ground.at(0, 0), crank.at(-0.5, 0))
    model.revolute("B", crank.at(0.5, 0), rod.at(-1, 0))
    model.revolute("C", rod.at(1, 0), slider.at(0, 0))
    model.translational("rail", model.ground.at(0, 0), slider.at(0, 0), axis=(1, 0))
    model.force("push", bead, fx=force(crank, rod, slider))
    still = {bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 0}
    start = {crank.phi: 0.7, crank.omega: 2.0, **still}
    model.scene("run", ["push"], start=start, guess={rod.phi: -0.3, slider.x: 2.5})
    return model


def height(crank: Body, rod: Body) -> Any:
    """Of the pin of rod and slider above the rail, which the joints keep at 0."""
    return sin(crank.phi) + 2 * sin(rod.phi)


def climb(crank: Body, rod: Body) -> Any:
    """Its velocity."""
    return cos(crank.phi) * crank.omega + 2 * cos(rod.phi) * rod.omega


KEPT: dict[str, tuple[Callable[[Body, Body, Body], Any], float]] = {
    "above": (lambda a, b, s: holds(height(a, b) > 0), 0.0),
    "at_least": (lambda a, b, s: holds(height(a, b) >= 0), 1.0),
    "below": (lambda a, b, s: holds(height(a, b) < 0), 0.0),
    "half": (lambda a, b, s: 3 * Heaviside(height(a, b)), 1.5),
    "pins": (lambda a, b, s: holds(a.y + sin(a.phi) / 2 - b.y + sin(b.phi) > 0), 0.0),
    "climbing": (lambda a, b, s: holds(climb(a, b) > 0), 0.0),
    "not_sinking": (lambda a, b, s: holds(climb(a, b) >= 0), 1.0),
    "climb_sign": (lambda a, b, s: 1 + sign(climb(a, b)), 1.0),
    "rail_sign": (lambda a, b, s: 1 + sign(s.vy), 1.0),
    "climb_mixed": (
        lambda a, b, s: (
            3 + sign(climb(a, b)) + holds(climb(a, b) >= 0) - 2 * holds(climb(a, b) > 0)
        ),
        4.0,
    ),
}
"""Name → a force that switches where the loop keeps a function at 0 to rounding, and its value."""


@pytest.mark.parametrize("name", KEPT)
def test_what_joints_keep_at_zero_is_on_its_boundary(workshop: Path, name: str) -> None:
    force, value = KEPT[name]
    machine = load(slider_crank(f"kept_{name}", force), folder=workshop)
    for method in (
        ("dop853", "radau5") if name in {"above", "climb_sign", "climb_mixed"} else ("dop853",)
    ):
        plain = machine.simulate(2.0, method=method, progress=False)
        assert plain.outcome is Outcome.OK
        assert not plain.events
        assert_allclose(plain.a("bead.x"), value, atol=1e-12)
        assert_allclose(plain.q("bead.x")[-1], 2 * value, rtol=1e-9, atol=1e-12)
        assert plain.stats["steps"] < (40 if method == "dop853" else 250)  # 1650 and 1500 once


@pytest.mark.parametrize("rtol", [1e-8, 5.6e-10, 1.15e-10])
def test_rounding_of_what_joints_keep_shortens_no_steps(workshop: Path, rtol: float) -> None:
    """Margins of a resting function are parts of the rounding that it is kept within."""
    machine = load(slider_crank("kept_climb_mixed", KEPT["climb_mixed"][0]), folder=workshop)
    run = machine.simulate(2.0, method="radau5", rtol=rtol, progress=False)
    assert run.outcome is Outcome.OK
    assert not run.events
    assert run.stats["steps"] < 700  # 2500 and more once


LEAVING = {"up": (1, 5.0), "down": (-1, -5.0)}


@pytest.mark.parametrize("way", [1, -1])
def test_a_velocity_that_leaves_zero_takes_its_side(workshop: Path, way: int) -> None:
    model = Model(f"sets_off_{way + 1}")
    bead = model.particle("bead", mass=1.0)
    model.force("side", bead, fx=5 * sign(bead.vy), fy=way * Max(t - 0.5, 0))
    run = load(model, folder=workshop).simulate(1.0, np.linspace(0, 1, 11), progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.a("bead.x"), np.where(run.t < 0.55, 0.0, 5.0 * way))


def test_a_velocity_that_both_sides_drive_slides_as_filippov_says(workshop: Path) -> None:
    """A law of friction with a sign, and with two conditions: both stick, and slip alike."""
    runs = []
    for name in ("sign", "pair"):
        model = Model(f"rubs_{name}")
        bead = model.particle("bead", mass=2.0)
        law = sign(bead.vy) if name == "sign" else holds(bead.vy >= 0) - holds(bead.vy <= 0)
        model.force("rub", bead, fy=7 * sin(7 * t) - 5 * law, fx=law)
        model.scene("run", ["rub"], start={bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 1})
        runs.append(load(model, folder=workshop).simulate(2.0, [0, 0.9, 1.4, 2.0], progress=False))
    assert runs[0].outcome is runs[1].outcome is Outcome.OK
    assert_allclose(runs[0].q("bead.y"), runs[1].q("bead.y"), rtol=1e-8)
    assert_allclose(runs[0].q("bead.x"), runs[1].q("bead.x"), rtol=1e-8)
    assert runs[0].v("bead.y")[1] == 0.0  # it sticks, as it does not at 1.4 s
    held = load(model_that_sticks(), folder=workshop).simulate(1.0, progress=False)
    assert_allclose(held.a("bead.x"), 1.5 * (1 + 2 / 5), rtol=1e-12)


def model_that_sticks() -> Model:
    """A bead on which 2 N pull against a friction of 5 N, and what goes with its share."""
    model = Model("rubs_at_rest")
    bead = model.particle("bead", mass=2.0)
    model.force("rub", bead, fx=3 * (1 + sign(bead.vy)), fy=2 - 5 * sign(bead.vy))
    return model


@pytest.mark.parametrize("word", LEAVING)
def test_what_leaves_its_boundary_takes_its_side(workshop: Path, word: str) -> None:
    way, value = LEAVING[word]
    model = Model(f"leaving_{word}")
    bead = model.particle("bead", mass=1.0)
    model.force("side", bead, fx=5 * sign(bead.y), fy=way * Max(t - 0.5, 0))
    run = load(model, folder=workshop).simulate(1.0, np.linspace(0, 1, 11), progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.a("bead.x"), np.where(run.t < 0.55, 0.0, value))
    (event,) = (event for event in run.events if "bead_y" in event.name)
    assert event.what == ("began" if way > 0 else "ceased")
    assert 0.5 < event.time < 0.5002


def test_a_restoring_force_that_jumps_has_its_rest_in_the_middle(workshop: Path) -> None:
    model = Model("middle")
    bead = model.particle("bead", mass=1.0)
    model.force("home", bead, fx=-5 * sign(bead.x))
    machine = load(model, folder=workshop)
    run = machine.simulate(1.0, progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.q("bead.x"), 0.0)
    run = machine.simulate(0.5, start={"bead.x": 0.1}, progress=False)
    assert [event.what for event in run.events] == ["ceased"]
    assert_allclose(run.events[0].time, 0.2, rtol=1e-9)


@pytest.mark.parametrize("condition", [t > 0, t >= 0, t < 0, t <= 0])
def test_all_analyses_agree_on_the_first_instant(workshop: Path, condition: Any) -> None:
    names = {t > 0: "after", t >= 0: "from", t < 0: "before", t <= 0: "until"}
    machines = []
    for which in ("driven", "both"):
        model = Model(f"first_{names[condition]}_{which}")
        bead = model.particle("bead", mass=1.0)
        model.absolute("rail", bead, "y", 0)
        model.driver("drive", bead.x, t)
        model.force("push", bead, fx=2.0, when=condition)
        if which == "both":
            free = model.particle("free", mass=1.0)
            model.force("same", free, fx=2.0, when=condition)
        machines.append(load(model, folder=workshop))
    driven = machines[0].inverse_dynamics([0.0, 0.5], progress=False)
    run = machines[1].simulate(0.5, [0.0, 0.5], progress=False)
    assert_allclose(driven.reaction("drive", "fx"), -run.a("free.x"))
    assert_allclose(run.reaction("drive", "fx"), -run.a("free.x"))
    assert run.a("free.x")[1] == (2.0 if names[condition] in {"after", "from"} else 0.0)


@pytest.mark.parametrize("forward", [True, False])
def test_a_velocity_driven_off_to_either_side_stays_where_neither_condition_holds(
    workshop: Path, forward: bool
) -> None:
    model = Model(f"stays_{forward}")
    bead = model.particle("bead", mass=1.0)
    model.force("up", bead, fy=3.0, when=bead.vy > 0)
    model.force("down", bead, fy=-2.0, when=bead.vy < 0)
    model.force("load", bead, fy=(1 if forward else -1) * Max(t - 0.5, 0))
    order = ["up", "down", "load"] if forward else ["down", "up", "load"]
    model.scene("run", order, start={bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 0})
    run = load(model, folder=workshop).simulate(1.0, [0.0, 0.4, 1.0], progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.v("bead.y"), [0, 0, 1.5 + 0.125 if forward else -1.0 - 0.125], rtol=2e-5)


SETTLED: dict[str, tuple[Force, float]] = {
    "above": (lambda p: 3 * holds(p.vy > 0), 0.0),
    "at_most": (lambda p: 3 * holds(p.vy <= 0), 3.0),
    "sign": (lambda p: 2 + sign(p.vy), 2.0),
    "sides": (lambda p: 3 * holds(p.vy > 0) - 2 * holds(p.vy < 0), 0.0),
}


@pytest.mark.parametrize("name", SETTLED)
def test_a_velocity_that_bouncing_ends_is_on_its_boundary(workshop: Path, name: str) -> None:
    law, value = SETTLED[name]
    model = Model(f"settles_{name}")
    ball = model.particle("ball", mass=1.0)
    model.contact("floor", gap=ball.y, restitution=0.5)
    model.force("weight", ball, fx=law(ball), fy=-10.0)
    start = {ball.x: 0, ball.y: 1, ball.vx: 0, ball.vy: 0}
    model.scene("run", ["floor", "weight"], start=start)
    run = load(model, folder=workshop).simulate(2.0, [1.5, 2.0], rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.a("ball.x"), value)
    assert_allclose(run.v("ball.y"), 0.0)


BEAD = Body("bead", None, None, None)
X, V = BEAD.x, BEAD.vx
SHARED = [
    (X > 0, X <= 0), (X >= 0, X < 0), (Abs(X), X >= 0), (Abs(X), X < 0), (sign(X), Heaviside(-X)),
    (V > 0, V <= 0), (sign(V), Heaviside(-V)), (Abs(V), sign(V)), (Max(X, 0), sign(X)),
    (V > 0, V >= 0), (V > 0, V < 0), (V > 0, sign(V)), (sign(V), V <= 0),
]  # fmt: skip
APART = [(X > 0, X >= 0), (X > 0, X < 0), (sign(X), X > 0), (Heaviside(X, 1), Heaviside(X, 0))]


@pytest.mark.parametrize("pair", SHARED + APART)
def test_conditions_share_a_switch_where_they_agree(pair: tuple[Any, Any]) -> None:
    first, second = (
        conditions([as_pieces(Piecewise((1, e), (0, True)) if e.is_Relational else e)])[0]
        for e in pair
    )
    g = switching_function(first)
    switch = Switch("f", str(first), g, g, boundary=boundary(first))
    found = find_switch(switching_function(second), boundary(second), [switch])
    assert (found is not None) is (pair in SHARED)


JOINED = {
    "closed": ((V >= 0, V < 0, Abs(V)), Boundary.CLOSED),
    "open": ((Abs(V), V > 0, V <= 0), Boundary.OPEN),
    "balanced": ((sign(V), Abs(V), Heaviside(-V)), Boundary.BALANCED),
    "kink": ((Abs(V), Max(V, 0)), Boundary.INDIFFERENT),
    "strict": ((V >= 0, V > 0, V >= 0), Boundary.MIXED),
    "mixed": ((sign(V), V > 0), Boundary.MIXED),
    "third": ((sign(V), V >= 0, sign(-V)), Boundary.MIXED),
}


@pytest.mark.parametrize("name", JOINED)
def test_the_switch_of_a_velocity_rests_as_its_conditions_agree(name: str) -> None:
    functions, expected = JOINED[name]
    model = Model(f"joined_{name}")
    bead = model.particle("bead", mass=1.0)
    forces = []
    for k, e in enumerate(functions):
        law = (holds(e) if e.is_Relational else e).subs(V, bead.vx)
        forces.append(model.force(f"f{k}", bead, fx=law).name)
    (switch,) = derive(model, model.scene("run", forces)).switches
    assert switch.boundary is expected


def test_a_force_that_holds_by_another_share_of_its_jump_says_so(workshop: Path) -> None:
    model = Model("tip")
    bead = model.particle("bead", mass=1.0)
    model.force("F", bead, fx=-5 * sign(bead.x) + 2)
    model.scene("run", ["F"], start={bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 0})
    result = load(model, "run", folder=workshop).simulate(1.0, progress=False)
    assert result.outcome is Outcome.INCONSISTENT
    assert "a body that rests where a force jumps with its position" in result.message
