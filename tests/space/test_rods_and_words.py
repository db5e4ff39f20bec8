"""Rods between two balls, drag by the angular velocity, and words that people try."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.errors import AnalysisError, NoAttributeError
from runtime import load
from tests.space.machines import DOWN, X, Y, Z


def test_a_rod_bears_the_tension_of_a_conical_pendulum(workshop: Path) -> None:
    """m g / cos 60° pulls, and a bob above the pivot presses with m g."""
    model: Any = Model("conical", space=True, gravity=DOWN)
    height, radius = 0.5, np.sqrt(0.75)
    bob = model.body("bob", 2.0, (1, 1, 1), at=(radius, 0, -height))
    model.distance("rope", model.ground, bob, 1.0)
    model.distance("prop", model.ground, model.body("top", 3.0, (1, 1, 1), at=(0, 0, 0.4)), 0.4)
    start = {"bob.vy": np.sqrt(9.81 * radius**2 / height)}
    outputs = ["default", {"pull": model.series("rope.axial")}]
    model.scene("run", ["gravity"], start=start, outputs=outputs)
    r = load(model, folder=workshop).simulate(0.1, 11, rtol=1e-11)
    assert_allclose(r.reaction("rope", "axial"), 2.0 * 9.81 / 0.5, rtol=1e-8)
    assert_allclose(r["pull"], r.reaction("rope", "axial"))
    assert_allclose(r.reaction("prop", "axial"), -3.0 * 9.81, rtol=1e-8)
    assert r.series("pull")[1] == "N"
    pull = np.linalg.norm(r.wrench("rope", "bob")[:, :3], axis=1)
    assert_allclose(pull, r.reaction("rope", "axial"), rtol=1e-12)


def test_drag_by_the_column_of_the_angular_velocity(workshop: Path) -> None:
    model: Any = Model("drag", space=True)
    ball = model.body("ball", 1.0, (0.5, 0.5, 0.5))
    model.torque("drag", ball, -0.25 * ball.omega, frame="body")
    omega = (1.0, -2.0, 3.0)
    start = {f"ball.omega_{c}": value for c, value in zip("xyz", omega, strict=True)}
    model.scene("run", ["drag"], start=start)
    r = load(model, folder=workshop).simulate(1.0, 11, rtol=1e-11)
    for letter, value in zip("xyz", omega, strict=True):
        assert_allclose(r.v(f"ball.omega_{letter}"), value * np.exp(-0.5 * r.t), rtol=1e-8)


def crank_and_rocker(second: str) -> Any:
    model: Any = Model("rssr", space=True)
    inertia = (0.1, 0.1, 0.1)
    crank, rod = model.body("crank", 1.0, inertia), model.body("rod", 1.0, inertia, at=X)
    rocker = model.body("rocker", 1.0, inertia, at=(2, 0, 0))
    model.revolute("A", model.ground, crank, at=(0, 0, 0), axis=Z)
    model.revolute("D", model.ground, rocker, at=(2, 0, 0), axis=Y)
    model.spherical("B", crank, rod, at=(0.3, 0, 0))
    words = {"axes": ((0, 1, 0), Z)} if second == "universal" else {}
    getattr(model, second)("C", rod, rocker, at=(2, 0, 0.8), **words)
    model.rotation_driver("drive", model.joints["A"], t)
    model.scene("run", drivers=["drive"])
    return model


def test_a_rod_that_spins_between_its_balls_is_named(workshop: Path) -> None:
    with pytest.raises(AnalysisError) as refusal:
        load(crank_and_rocker("spherical"), folder=workshop).kinematics([0.0, 0.1])
    said = str(refusal.value)
    assert "1 degree of freedom is left" in said
    assert "; rod alone moves. Add" in said
    assert "Between two ball joints, rod may spin about the line of these: make one end" in said
    load(crank_and_rocker("universal"), folder=workshop).kinematics([0.0, 0.1])
    undriven = crank_and_rocker("universal")
    undriven.scene("free")
    with pytest.raises(AnalysisError, match="1 degree of freedom is left") as refusal:
        load(undriven, "free", folder=workshop).kinematics([0.0, 0.1])
    assert "; most of all move crank, rod. Add" in str(refusal.value)
    assert "ball joints" not in str(refusal.value)


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("hinge", "revolute"), ("hinge_joint", "revolute"), ("add_hinge", "revolute"),
        ("ball_joint", "spherical"), ("rod_end", "spherical"), ("prismatic", "translational"),
        ("rod", "body or distance or revolute_revolute"), ("differential", "gear"),
        ("sphericl", "spherical or revolute_spherical"),
    ],
)  # fmt: skip
def test_words_of_others_lead_to_those_of_space(word: str, meant: str) -> None:
    with pytest.raises(NoAttributeError, match=rf"'{word}'; did you mean {meant}\?"):
        getattr(Model("m", space=True), word)


def test_a_word_like_none_lists_what_declares_in_space() -> None:
    with pytest.raises(NoAttributeError) as refusal:
        Model("m", space=True).zzz  # noqa: B018
    listed = {*str(refusal.value).partition("it has ")[2].removesuffix(".").split(", ")}
    assert {"revolute", "spherical", "gear", "scene", "track", "draw"} <= listed
    assert not {"acting", "token", "noted", "recompose", "belt", "coupler", "bodies"} & listed
    with pytest.raises(NoAttributeError, match="'hinge'; did you mean revolute"):
        Model("m").hinge  # noqa: B018
