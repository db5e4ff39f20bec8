"""Limits, dead centres and change points, against closed forms."""

from math import acos, asin, pi
from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.errors import AnalysisError, InputError, UnknownNameError
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
    with pytest.raises(AnalysisError, match=r"moves on without end\. After \d{3,4} steps"):
        load(model, folder=workshop).limits("block.x")


def cranks(name: str, feet: list[complex], bars: list[tuple[int, int]]) -> Model:
    """Cranks of 0.5 m at `feet`, parallel, and each bar between the pins of some of them."""
    model = Model(name)
    pins = [model.body(f"crank_{k}", mass=1.0, inertia=1.0) for k in range(len(feet))]
    for k, (crank, foot) in enumerate(zip(pins, feet, strict=True)):
        model.revolute(f"A{k}", model.ground.at(foot.real, foot.imag), crank.at(0, 0))
    for n, ends in enumerate(bars):
        bar = model.body(f"bar_{n}", mass=1.0, inertia=1.0)
        for k in ends:
            apart = feet[k] - feet[ends[0]]
            model.revolute(f"B{n}{k}", pins[k].at(0.5, 0), bar.at(apart.real, apart.imag))
    model.driver("drive", pins[0].phi, 0.7)
    guess = {crank.phi: 0.7 for crank in pins}
    model.scene("driven", drivers=["drive"], analysis="kinematics", guess=guess)
    return model


def test_joints_that_repeat_each_other_are_refused(workshop: Path) -> None:
    """Rows that are independent at the start are not so where three cranks and a bar are flat."""
    model = cranks("three_cranks", [0j, 1 + 0j, 0.5 + 0.8j], [(0, 1, 2)])
    with pytest.raises(AnalysisError, match=r"B02\.y is redundant .* leave one of these joints"):
        load(model, folder=workshop).limits("bar_0.x")


@pytest.mark.parametrize("loops", [2, 3])
def test_places_at_which_several_motions_meet_are_refused(workshop: Path, loops: int) -> None:
    """In line, parallelograms in series lose a rank each; two leave the determinant its sign."""
    feet, bars = [complex(k) for k in range(loops + 1)], [(k, k + 1) for k in range(loops)]
    machine = load(cranks(f"series_{loops}", feet, bars), folder=workshop)
    with pytest.raises(AnalysisError, match=r"several motions meet near crank_0\.phi = 3\.14159"):
        machine.limits("crank_0.phi")


def test_a_start_beside_an_almost_change_point(library) -> None:
    """The first step is halved as others are."""
    sizes, start = {"AB": 1.0, "BC": 2.0, "CD": 1.5, "AD": 2.5 - 1e-5}, {"crank.phi": 3.1415}
    machine = library("four_bar", "constant_torque")
    for mode in machine.assembly_modes(start=start, parameters=sizes):
        found = machine.limits("rocker.phi", start=mode, parameters=sizes)
        expected = np.array([pi - angle_at(sizes["AD"], 1.5, reach) for reach in (1.0, 3.0)])
        expected = expected if mode["rocker.phi"] < pi else 2.0 * pi - expected
        np.testing.assert_allclose(found.range, np.sort(expected), atol=1e-6)


def test_limits_begin_at_a_mode_and_its_instant(library) -> None:
    machine = library("four_bar", "kinematics")
    up, down = (machine.limits("rocker.phi", start=mode) for mode in machine.assembly_modes(0.1))
    mirrored = np.sort([-angle % (2.0 * pi) for angle in up.range])
    np.testing.assert_allclose(np.mod(down.range, 2.0 * pi), mirrored, atol=1e-10)
    assert {state.t for state in down.limits} == {0.1}
    with pytest.raises(InputError, match=r"t = 0\.2 s are both given"):
        machine.limits("rocker.phi", start=down.limits[0], t=0.2)
