"""Limits, dead centres and change points, against closed forms."""

from math import acos, asin, pi
from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.errors import AnalysisError, UnknownNameError
from runtime import load

from . import linkages


def angle_at(a: float, b: float, c: float) -> float:
    """Between the sides a and b of a triangle, opposite to c."""
    return acos((a * a + b * b - c * c) / (2.0 * a * b))


def test_rocker_of_a_crank_rocker(library) -> None:
    found = library("four_bar", "kinematics").limits("rocker.phi")  # AB 1, BC 2.5, CD 2.5, AD 2
    expected = [pi - angle_at(2.0, 2.5, reach) for reach in (1.5, 3.5)]
    np.testing.assert_allclose(found.range, sorted(expected), atol=1e-10)
    assert not found.turns
    for limit in found.limits:  # crank and coupler in one line
        turned = (limit["crank.phi"] - limit["coupler.phi"]) % pi
        assert min(turned, pi - turned) < 1e-8


def test_crank_of_a_crank_rocker_turns_and_names_dead_centres(library) -> None:
    found = library("four_bar", "kinematics").limits("crank.phi")
    assert found.turns == 1
    assert found.limits == found.change_points == ()
    assert found.range[1] == np.inf
    assert found.dead_centres.keys() == {"coupler.phi", "rocker.phi"}


def test_crank_of_a_triple_rocker(library) -> None:
    sizes = {"BC": 1.4, "CD": 1.4}
    found = library("four_bar", "kinematics").limits("crank.phi", parameters=sizes)
    most = angle_at(1.0, 2.0, 2.8)
    np.testing.assert_allclose(found.range, [-most, most], atol=1e-10)


def test_dead_centres_of_a_slider_crank(library) -> None:
    machine = library("slider_crank", "kinematics")
    rod = machine.parameters["rod_length"].default
    found = machine.limits("slider.x")
    np.testing.assert_allclose(found.range, [rod - 2.0, rod + 2.0], atol=1e-10)
    limits = sorted(found.limits, key=lambda limit: limit["slider.x"])
    for limit, turned in zip(limits, (pi, 0.0), strict=True):
        assert abs(np.angle(np.exp(1j * (limit["crank.phi"] - turned)))) < 1e-8
    steepest = [abs(point["rod.phi"]) for point in found.dead_centres["rod.phi"]]
    np.testing.assert_allclose(steepest, asin(2.0 / rod), atol=1e-10)


def test_change_points_of_a_parallelogram(library) -> None:
    found = library("four_bar", "constant_torque").limits(
        "crank.phi", parameters={"BC": 2.0, "CD": 1.0}, start={"crank.phi": 0.5, "rocker.phi": 0.5}
    )
    assert (found.turns, found.limits) == (1, ())
    at = np.sort([state["crank.phi"] % (2.0 * pi) for state in found.change_points])
    np.testing.assert_allclose(np.sin(at), 0.0, atol=1e-10)
    assert len(at) == 2
    places = [state["coupler.x"] for state in found.dead_centres["coupler.x"]]
    np.testing.assert_allclose(sorted(places), [1.0, 3.0], atol=1e-10)  # at the change points


def test_one_of_two_drivers_is_released(workshop: Path) -> None:
    machine = load(linkages.seven_bar(), folder=workshop)
    found = machine.limits("first.phi", parameters={"second_angle": 0.0})
    dead = [state["second.phi"] for states in found.dead_centres.values() for state in states]
    assert dead
    assert max(map(abs, dead)) < 1e-12
    with pytest.raises(AnalysisError, match=r"first_drive, second_drive released this one has 2"):
        machine.limits("coupler.phi")


def test_limits_separate_angles_with_modes_from_those_without(workshop: Path) -> None:
    """The input of the six-bar swings between the angles at which its modes meet."""
    machine = load(linkages.six_bar(), folder=workshop)
    found = machine.limits("input.phi")
    assert found.limits
    for limit in found.limits:
        inside, outside = (
            len(machine.assembly_modes(parameters={"angle": limit["input.phi"] + way}))
            for way in (-1e-4, 1e-4)
        )
        assert abs(inside - outside) == 2


def test_what_is_refused(library, workshop: Path) -> None:
    machine = library("four_bar", "kinematics")
    with pytest.raises(UnknownNameError, match=r"nearest: rocker\.phi"):
        machine.limits("rocker.ph")
    flat = {"BC": 2.0, "CD": 1.0}
    with pytest.raises(AnalysisError, match="motions meet"):
        library("four_bar", "constant_torque").limits(
            "crank.phi", parameters=flat, start={"crank.phi": 0.0, "rocker.phi": 0.0}
        )
    model = Model("rail")
    block = model.body("block", mass=1.0, inertia=1.0)
    model.translational("guide", model.ground, block)
    model.scene("free")
    with pytest.raises(AnalysisError, match="does not return to its start"):
        load(model, folder=workshop).limits("block.x")
