"""Actuators in place of drivers where joints rub, arms fold, and laws jump."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Piecewise, pi

from codegen import Model, t
from runtime import load

G = 9.81


def slider(
    mu: float, angle: float, scale: float, along: Callable[[Any], Any]
) -> tuple[Model, list[str]]:
    """A block on a rough guide, pulled along it and by a far point at an angle."""
    model = Model("rough_slider", gravity=(0, -G))
    block = model.body("block", mass=scale, inertia=0.1 * scale)
    guide = model.translational("guide", model.ground.at(0, 0), block, axis=(1, 0))
    far = model.ground.at(1e9 * np.cos(angle), 1e9 * np.sin(angle))
    model.friction("rub", guide, mu)
    model.force("push", on=block, fx=1.0)
    model.line_force("rope", block, far, 1.0)
    model.driver("pace", block.x, along(t))
    return model, ["push", "rope"]


@pytest.mark.parametrize("instants", [[0.0, 1.0], [0.0, 1.0, 8.0]])
def test_of_more_unknowns_with_friction_each_instant_has_its_least_sum(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, instants: list[float]
) -> None:
    """H + F cos θ - μ |g - F sin θ| = a: by one line at first, where |N| has its kink later."""
    monkeypatch.chdir(tmp_path)
    angle = np.radians(80)
    model, names = slider(0.5, angle, 1.0, lambda t: t + 2.5 * t**2 + t**4)
    model.scene("pulled", ["gravity", "rub", *names], ["pace"])
    r = load(model).inverse_dynamics(instants, unknown=names)
    slope, rope = np.cos(angle) + 0.5 * np.sin(angle), G / np.sin(angle)
    push = (5 + 0.5 * G) / (1 + slope**2)
    assert push * slope < rope  # N is positive
    assert_allclose([r.force("push", "fx")[0], r.force("rope")[0]], [push, push * slope], rtol=1e-8)
    expected = [17 - rope * np.cos(angle), rope]
    assert_allclose([r.force("push", "fx")[1], r.force("rope")[1]], expected, rtol=1e-6)
    assert_allclose(r.reaction("pace", "fx"), 0.0, atol=1e-9 * (64 * 12 + 5))


def test_of_more_unknowns_the_least_sum_is_that_of_one_sign_of_the_normal_force(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where N stays positive, the condition is linear: H + F (cos θ + μ sin θ) = a + μ g."""
    monkeypatch.chdir(tmp_path)
    angle = np.radians(30)
    model, names = slider(0.2, angle, 1.0, lambda t: t + 1.5 * t**2)
    model.scene("pulled", ["gravity", "rub", *names], ["pace"])
    r = load(model).inverse_dynamics([0.0, 0.5], unknown=names, weights={"rope": 2.0})
    slope, need = np.cos(angle) + 0.2 * np.sin(angle), 3.0 + 0.2 * G
    share = need / (1 + slope**2 / 4)
    assert_allclose(r.force("push", "fx"), share, rtol=1e-8)
    assert_allclose(r.force("rope"), share * slope / 4, rtol=1e-8)


@pytest.mark.parametrize("scale", [1e-3, 1e-9, 1e-15])
def test_small_forces_with_friction_are_found_as_large_ones_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scale: float
) -> None:
    monkeypatch.chdir(tmp_path)
    angle = np.radians(60)
    model, _ = slider(0.5, angle, scale, lambda t: t)
    model.scene("pulled", ["gravity", "rub", "rope"], ["pace"])
    r = load(model).inverse_dynamics([0.1, 0.2], unknown=["rope"])
    expected = 0.5 * G * scale / (np.cos(angle) + 0.5 * np.sin(angle))
    assert_allclose(r.force("rope"), expected, rtol=1e-9)


def test_beside_a_dead_centre_the_force_grows_as_the_arm_falls(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A torque of -3 N m on the crank: F y' = 3 N m, but for what inertia and weight add."""
    monkeypatch.chdir(tmp_path)
    model = Model("loaded_crank", gravity=(0, -G))
    ground = model.ground
    crank, rod = model.body("crank", mass=2.0, inertia=0.05), model.body("rod", 3.0, 0.2)
    ram = model.body("ram", mass=5.0, inertia=0.3)
    model.revolute("A", ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(0.1, 0), rod.at(-0.2, 0))
    model.revolute("C", rod.at(0.2, 0), ram)
    model.translational("guide", ground.at(0, 0), ram, axis=(0, 1))
    model.force("push", on=ram, fy=1.0)
    model.torque("load", on=crank, value=-3.0)
    model.driver("turn", crank.phi, pi / 2 + t)
    guess = {crank.phi: 1.57, rod.phi: 1.57, ram.y: 0.5, rod.y: 0.3}
    model.scene("run", ["gravity", "push", "load"], ["turn"], guess=guess)
    turned = np.array([1e-9, 1e-8, 3e-8, 1e-7, 3e-7, 1e-6, 1e-4])
    r = load(model).inverse_dynamics(turned, unknown=["push"])
    rod_up = np.sqrt(0.16 - 0.01 * np.sin(turned) ** 2)
    slope = -0.1 * np.sin(turned) - 0.01 * np.sin(turned) * np.cos(turned) / rod_up
    assert_allclose(r.force("push", "fy") * slope, 3.0, rtol=1e-3)


def test_jump_of_a_rate_has_impulses_of_joints_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model = Model("sudden_stop", gravity=(0, -G))
    block = model.body("block", mass=1.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), block, axis=(1, 0))
    model.force("push", on=block, fx=1.0)
    model.force("wind", on=block, fx=2.0)
    model.track("guide", block.at(3, 0))
    model.driver("pace", block.x, Piecewise((t, t < 1), (1, True)))
    named = ["default", "force(wind)", "points"]
    model.scene("run", ["gravity", "push", "wind"], ["pace"], outputs=named)
    machine = load(model)
    for words in ({}, {"unknown": ["push"], "weights": {"push": 7.0}}):
        (event,) = machine.inverse_dynamics(np.linspace(0, 2, 5), **words).events
        assert event.impulse == pytest.approx({"pace.fx": -1.0})
