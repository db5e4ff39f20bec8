"""Statics and inverse dynamics where conditions are on their boundary: each is as written."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Heaviside, sign

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from tests.runtime.test_conditions_on_their_boundary import KEPT, holds, slider_crank


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


@pytest.mark.parametrize("method", ["energy", "settling"])
def test_conditions_of_different_kinds_on_a_velocity_are_as_written_at_rest(
    workshop: Path, method: Any
) -> None:
    """At v = 0 sign is 0 and neither v > 0 nor v < 0 holds: the springs alone hold both beads."""
    model = Model(f"kinds_at_rest_{method}")
    bead, other = model.particle("bead", mass=1.0), model.particle("other", mass=1.0)
    for p in (bead, other):
        model.absolute(f"rail_{p.name}", p, "y", 0)
        model.spring(f"back_{p.name}", model.ground.at(-1, 0), p, 10.0, free_length=1.0)
    model.force("rub", bead, fx=-5 * sign(bead.vx))
    model.force("assist", bead, fx=2.0, when=bead.vx > 0)
    model.force("forth", other, fx=2.0, when=other.vx > 0)
    model.force("back", other, fx=-1.0, when=other.vx < 0)
    model.force("steady", other, fx=3.0, when=other.vx >= 0)
    machine = load(model, folder=workshop)
    rest = machine.equilibrium(method=method)
    assert rest.outcome is Outcome.OK
    assert_allclose(rest.q("bead.x")[-1], 0.0, atol=1e-8)
    assert_allclose(rest.q("other.x")[-1], 0.3, rtol=1e-7)


def test_inverse_dynamics_at_a_turning_point_has_each_condition_as_written(workshop: Path) -> None:
    model = Model("turns")
    bead = model.particle("bead", mass=1.0)
    model.absolute("rail", bead, "y", 0)
    model.driver("drive", bead.x, 0.1 * t**2)
    model.force("F", bead, fx=-5 * sign(bead.vx) + 2 * holds(bead.vx > 0) + 7 * holds(bead.vx >= 0))
    run = load(model, folder=workshop).inverse_dynamics([0.0, 0.5], progress=False)
    assert_allclose(run.reaction("drive", "fx"), [0.2 - 7.0, 0.2 - 4.0])


KEPT_AT_REST = [
    ("above", "energy"), ("above", "settling"), ("at_least", "energy"), ("at_least", "settling"),
    ("below", "energy"), ("below", "settling"), ("half", "energy"), ("climb_mixed", "settling"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "method"), KEPT_AT_REST)
def test_equilibrium_has_what_joints_keep_at_zero_on_its_boundary(
    workshop: Path, name: str, method: Any
) -> None:
    force, value = KEPT[name]
    model = slider_crank(f"kept_at_rest_{name}", force)
    crank, bead = model.bodies["crank"], model.bodies["bead"]
    model.absolute("guide", bead, "y", 0)
    model.spring("back", model.ground.at(-1, 0), bead, 10.0, free_length=1.0)
    model.torque("coil", on=crank, value=-2.0 * (crank.phi - 0.9))
    model.scene("hung", ["push", "back", "coil"], start={crank.phi: 0.7, bead.x: 0.0})
    rest = load(model, "hung", folder=workshop).equilibrium(
        method=method, guess={"rod.phi": -0.3, "slider.x": 2.5}
    )
    assert rest.outcome is Outcome.OK
    assert_allclose(rest["bead.x"], value / 10, atol=1e-8)
    assert_allclose(rest["crank.phi"], 0.9, rtol=1e-7)


@pytest.mark.parametrize("name", ["above", "at_least", "half", "climbing", "climb_mixed"])
def test_inverse_dynamics_has_what_joints_keep_at_zero_on_its_boundary(
    workshop: Path, name: str
) -> None:
    force, value = KEPT[name]
    model = slider_crank(f"kept_driven_{name}", force)
    crank, bead = model.bodies["crank"], model.bodies["bead"]
    model.absolute("guide", bead, "y", 0)
    model.driver("turn", crank.phi, 0.7 + 2 * t)
    model.driver("move", bead.x, t)
    model.scene("driven", ["push"], drivers=["turn", "move"])
    guess = {"rod.phi": -0.3, "slider.x": 2.5}
    run = load(model, "driven", folder=workshop).inverse_dynamics(
        np.linspace(0, 1, 21), guess=guess, progress=False
    )
    assert_allclose(run.reaction("move", "fx"), -value, atol=1e-12)
