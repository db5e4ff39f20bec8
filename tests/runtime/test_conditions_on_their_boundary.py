"""Conditions that start on their boundary and stay there hold as they are written."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Abs, Heaviside, Max, Piecewise, sign

from codegen import Model, t
from codegen.declare.body import Body
from codegen.derive.piecewise_conditions import (
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


LEAVING = {"up": (1, 5.0), "down": (-1, -5.0)}


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
    run = machine.simulate(0.5, guess={"bead.x": 0.1}, progress=False)
    assert [event.what for event in run.events] == ["ceased"]
    assert_allclose(run.events[0].time, 0.2, rtol=1e-9)


def test_inverse_dynamics_and_equilibrium_agree(workshop: Path) -> None:
    model = Model("analyses")
    bead = model.particle("bead", mass=1.0)
    model.absolute("rail", bead, "y", 0)
    model.driver("drive", bead.x, t)
    model.force("push", bead, fx=2.0, when=bead.y >= 0)
    model.force("pull", bead, fx=8 * Heaviside(bead.y))
    model.spring("back", model.ground.at(-1, 0), bead, 4.0, free_length=0.5)
    model.scene("driven", effects=["push", "pull"], drivers=["drive"])
    model.scene("hung", effects=["push", "back"])
    run = load(model, "driven", folder=workshop).inverse_dynamics([0.0, 0.5])
    assert_allclose(run.reaction("drive", "fx"), -6.0)
    rest = load(model, "hung", folder=workshop).equilibrium()
    assert_allclose(rest.q("bead.x")[-1], 0.0, atol=1e-8)


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


def test_equilibrium_has_the_mean_of_both_sides(workshop: Path) -> None:
    """On y = 0 the sign is 0 and Heaviside's function 1/2: springs alone hold x and z."""
    model = Model("balanced")
    bead, other = model.particle("bead", mass=1.0), model.particle("other", mass=1.0)
    for p in (bead, other):
        model.absolute(f"rail_{p.name}", p, "y", 0)
        model.spring(f"back_{p.name}", model.ground.at(-1, 0), p, 4.0, free_length=1.0)
    model.force("side", bead, fx=5 * sign(bead.y))
    model.force("half", other, fx=8 * Heaviside(other.y))
    rest = load(model, folder=workshop).equilibrium()
    assert_allclose(rest.q("bead.x")[-1], 0.0, atol=1e-8)
    assert_allclose(rest.q("other.x")[-1], 1.0, rtol=1e-7)


BEAD = Body("bead", None, None, None)
X, V = BEAD.x, BEAD.vx
SHARED = [
    (X > 0, X <= 0), (X >= 0, X < 0), (Abs(X), X >= 0), (Abs(X), X < 0), (sign(X), Heaviside(-X)),
    (V > 0, V >= 0), (V > 0, sign(V)), (Max(X, 0), sign(X)),
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


def test_a_force_that_holds_by_another_share_of_its_jump_says_so(workshop: Path) -> None:
    model = Model("tip")
    bead = model.particle("bead", mass=1.0)
    model.force("F", bead, fx=-5 * sign(bead.x) + 2)
    model.scene("run", ["F"], start={bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 0})
    result = load(model, "run", folder=workshop).simulate(1.0, progress=False)
    assert result.outcome is Outcome.INCONSISTENT
    assert "a body that rests where a force jumps with its position" in result.message
