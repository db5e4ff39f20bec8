"""Driven machines where motions cross: the branch of continuous velocity, told as what it is.

Every motion is compared with its closed form.
"""

import json

import numpy as np
import pytest

from codegen.errors import AnalysisError
from runtime import Outcome, load
from tests.hard.driven import NAMES, OMEGA, STANDING, UPRIGHT, FloatArray, angle, equal_rods, only


@pytest.mark.parametrize("count", [8, 37, 201, 2001])
def test_equal_rods_go_on_through_the_upright_position(count: int) -> None:
    """However far apart the instants: from 2 cos φ the slider never changes to 0, nor back."""
    t = np.linspace(0.0, 1.0, count)
    result = equal_rods().kinematics(t)
    assert result.outcome is Outcome.OK
    phi = angle(t)
    np.testing.assert_allclose(result.q("slider.x"), 2 * np.cos(phi), rtol=0, atol=1e-11)
    np.testing.assert_allclose(result.v("slider.x"), -2 * OMEGA * np.sin(phi), rtol=0, atol=1e-8)
    assert [row.time for row in result.singular] == pytest.approx([0.125, 0.625], abs=1e-11)
    assert result.stats["singular_crossings"] == 2


def test_a_crossing_is_an_event_with_its_facts() -> None:
    result = equal_rods().kinematics([0.0, 0.3])
    found = only(result, "crossing")
    assert found.time == pytest.approx(UPRIGHT, abs=1e-11)
    assert (found.lost, found.drivers) == (1, ())
    assert set(found.joints) == {"A", "B", "C", "guide"}
    assert found.singular_value < 1e-10
    assert found.drift < 1e-10
    (free,) = found.null_directions
    assert {name for name, share in free.items() if abs(share) > 1e-9} == NAMES
    # The rod turns about its upper end: its centre goes half as far as the slider.
    assert free["rod.x"] == pytest.approx(0.5 * free["slider.x"], rel=1e-9)
    (event,) = result.events
    assert (event.what, event.time, event.name) == ("crossed", found.time, found.title)
    assert event.element == ""
    columns = [row.name for row in result.description.coordinates]
    assert event.q[columns.index("crank.phi")] == pytest.approx(np.pi / 2, abs=1e-10)
    assert event.v[columns.index("slider.x")] == pytest.approx(-2 * OMEGA, abs=1e-9)
    (kept,) = json.loads(result.data.attrs["singular"])
    assert (kept["kind"], kept["time"], kept["lost"]) == ("crossing", found.time, 1)
    assert kept["null_directions"] == [free]
    assert "Crossed 1 singular position(s) at t = 0.125 s on the branch" in result.message
    assert "left the machine free to move by slider.x" in result.message


@pytest.mark.parametrize(
    ("instants", "crossed"),
    [
        ([0.0, 0.1249], []),
        ([0.125], []),
        ([0.1249, 0.125, 0.1251], [0.125]),
        ([0.125, 0.125 + 1e-9, 0.125 + 1e-6], [0.125]),
        (np.linspace(0.12, 0.13, 1001), [0.125]),
        ([-3.3, -1.1, -0.3], [-0.375, -0.875, -1.375, -1.875, -2.375, -2.875]),
    ],
)
def test_instants_wherever_they_lie(instants: FloatArray, crossed: list[float]) -> None:
    """At the crossing, about it, short of it; and before the start, where time goes back first."""
    t = np.asarray(instants)
    result = equal_rods().kinematics(t)
    np.testing.assert_allclose(result.q("slider.x"), 2 * np.cos(angle(t)), rtol=0, atol=1e-11)
    exact = -2 * OMEGA * np.sin(angle(t))
    np.testing.assert_allclose(result.v("slider.x"), exact, rtol=0, atol=1e-8)
    times = [row.time for row in result.singular]
    assert times[: len(crossed)] == pytest.approx(crossed, abs=1e-10)
    assert bool(times) == bool(crossed)


@pytest.mark.parametrize("count", [21, 401])
def test_parallelograms_stay_parallelograms(count: int) -> None:
    """Two loops are level at one time: two constraints are lost, and four ways lead on."""
    t = np.linspace(0.0, 1.0, count)
    result = load("hard/n_four_bar", "driven").kinematics(t)
    phi = np.pi / 2 - OMEGA * t
    for k in range(3):
        np.testing.assert_allclose(result.q(f"crank_{k}.phi"), phi, rtol=0, atol=1e-10)
    for k in (1, 2):
        np.testing.assert_allclose(result.q(f"coupler_{k}.phi"), 0.0, atol=1e-10)
    assert [row.time for row in result.singular] == pytest.approx([0.25, 0.75], abs=1e-10)
    assert [row.lost for row in result.singular] == [2, 2]
    assert all(len(row.null_directions) == 2 for row in result.singular)


# -- starts --------------------------------------------------------------------------------------


@pytest.mark.parametrize("instants", [[0.125, 0.2, 0.7], [0.05, 0.2], [0.125]])
def test_start_velocities_choose_the_branch(instants: list[float]) -> None:
    t = np.array(instants)
    rates = {"slider.vx": -2 * OMEGA, "rod.omega": -OMEGA, "rod.vx": -1.5 * OMEGA}
    moving = equal_rods().kinematics(t, t_start=UPRIGHT, guess=STANDING | rates)
    np.testing.assert_allclose(moving.q("slider.x"), 2 * np.cos(angle(t)), rtol=0, atol=1e-10)
    rates = {"rod.omega": OMEGA, "rod.vx": -0.5 * OMEGA}
    still = equal_rods().kinematics(t, t_start=UPRIGHT, guess=STANDING | rates)
    np.testing.assert_allclose(still.q("slider.x"), 0.0, atol=1e-10)
    np.testing.assert_allclose(still.q("rod.phi"), angle(t) - np.pi, rtol=0, atol=1e-10)
    for run in (moving, still):
        assert run.singular[0].kind == "start"
        assert run.singular[0].time == UPRIGHT
        assert "Started in a singular position at t = 0.125 s" in run.message


def test_a_start_that_is_as_near_to_one_as_to_the_other_lists_them() -> None:
    between = {"slider.vx": -OMEGA, "rod.vx": -OMEGA, "crank.vx": -0.5 * OMEGA}
    between |= {"crank.omega": OMEGA}
    with pytest.raises(AnalysisError) as caught:
        equal_rods().kinematics([0.2], t_start=UPRIGHT, guess=STANDING | between)
    text = str(caught.value)
    assert "2 motions meet" in text
    assert "free to move: slider.x +1" in text
    assert f"slider.vx = {-2 * OMEGA:.6g} m/s" in text
    assert f"rod.omega = {-OMEGA:.6g} rad/s" in text
    assert f"rod.omega = {OMEGA:.6g} rad/s" in text
    assert "Give start velocities of the one that is meant" in text


# -- inverse dynamics and simulations ------------------------------------------------------------


def test_torque_is_finite_and_continuous_across() -> None:
    """By the rate of the energy, rod and slider of 1 kg, the torque is 6 ω² sin φ cos φ."""
    near = np.array([-1e-2, -1e-3, -1e-4, 0.0, 1e-4, 1e-3, 1e-2])
    t = np.concatenate([np.linspace(0.0, 0.1, 5), UPRIGHT + near, np.linspace(0.15, 0.6, 10)])
    result = equal_rods().inverse_dynamics(t)
    assert result.outcome is Outcome.OK
    phi = angle(t)
    exact = 6.0 * OMEGA**2 * np.sin(phi) * np.cos(phi)
    torque = result.reaction("crank_drive", "torque")
    at = t == UPRIGHT
    assert np.isnan(torque).tolist() == at.tolist()
    np.testing.assert_allclose(torque[~at], exact[~at], rtol=0, atol=1e-3)
    far = np.abs(t - UPRIGHT) > 5e-4
    np.testing.assert_allclose(torque[far], exact[far], rtol=0, atol=1e-6)
    assert only(result, "crossing").time == pytest.approx(UPRIGHT, abs=1e-11)
    assert result.stats["singular_instants"] == 1
    assert "(t = 0.125 s) the position is singular" in result.message


def test_torque_of_the_parallelograms_carries_the_weight() -> None:
    """At constant speed only the weights ask for a torque: three half cranks and two couplers."""
    t = np.linspace(0.0, 1.0, 201)
    result = load("hard/n_four_bar", "driven").inverse_dynamics(t)
    at = np.isclose(t % 0.5, 0.25)
    assert at.sum() == 2
    torque = result.reaction("crank_drive", "torque")
    exact = 9.81 * 3.5 * np.cos(np.pi / 2 - OMEGA * t)
    np.testing.assert_allclose(torque[~at], exact[~at], rtol=0, atol=1e-7)


def test_a_simulation_names_what_it_crossed() -> None:
    result = load("hard/n_four_bar", "fall").simulate(1.0, rtol=1e-8)
    assert result.stats["singular_crossings"] == len(result.singular) == 1
    found = only(result, "crossing")
    assert 0.7 < found.time < 0.72
    assert found.lost == 2
    assert found.joints
    assert found.null_directions[0]
