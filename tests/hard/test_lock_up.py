"""Singular positions of driven machines: crossed, missed, or the end, each told for what it is.

Every motion is compared with its closed form. The slider-crank has a crank of 1 m and a rod of
1 + excess; the parallelograms are those of `n_four_bar` and `five_bar`.
"""

import json

import numpy as np
import numpy.typing as npt
import pytest

from codegen.errors import AnalysisError, AssemblyError
from runtime import Outcome, Result, load
from runtime.machine import Machine
from runtime.results.singular import SingularPosition

FloatArray = npt.NDArray[np.float64]
OMEGA = 2.0 * np.pi
UPRIGHT = 0.125  # s: the crank starts at 45 degrees
NAMES = {"rod.x", "rod.phi", "slider.x"}  # what can move while the crank stands upright
STANDING = {
    "crank.phi": np.pi / 2, "crank.x": 0.0, "crank.y": 0.5, "rod.x": 0.0, "rod.y": 0.5,
    "rod.phi": -np.pi / 2, "slider.x": 0.0,
}  # fmt: skip


def equal_rods() -> Machine:
    return load("hard/equal_rods", "driven")


def angle(t: FloatArray) -> FloatArray:
    return np.pi / 4 + OMEGA * t


def turning(t: FloatArray, excess: float) -> tuple[FloatArray, FloatArray]:
    """x of the slider and its rate, on the assembly on which it starts, for a rod that differs."""
    phi, rod = angle(t), 1.0 + excess
    root = np.sqrt(rod**2 - np.sin(phi) ** 2)
    x = np.cos(phi) + root
    return x, -OMEGA * np.sin(phi) * (1.0 + np.cos(phi) / root)


def only(result: Result, kind: str) -> SingularPosition:
    (found,) = result.singular
    assert found.kind == kind
    return found


# -- crossings -----------------------------------------------------------------------------------


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


# -- near misses and lock-ups --------------------------------------------------------------------


@pytest.mark.parametrize("count", [9, 201])
@pytest.mark.parametrize("excess", [1e-1, 1e-3, 1e-6, 1e-9, 1e-12])
def test_a_longer_rod_turns_round(excess: float, count: int) -> None:
    """The slider turns within a time of √excess; what rounding makes there grows with 1/√excess."""
    t = np.linspace(0.0, 2.0, count)
    result = equal_rods().kinematics(t, parameters={"rod_length": 1.0 + excess})
    assert result.outcome is Outcome.OK
    assert result.singular == ()
    x, _ = turning(t, excess)
    rounding = 1e-15 / np.sqrt(excess)
    np.testing.assert_allclose(result.q("slider.x"), x, rtol=0, atol=1e-12 + rounding)


def test_within_the_bend_velocities_are_those_of_the_closed_form() -> None:
    t = np.sort(np.append(np.linspace(0.0, 0.3, 7), UPRIGHT + np.linspace(-3e-4, 3e-4, 25)))
    result = equal_rods().kinematics(t, parameters={"rod_length": 1.0 + 1e-6})
    x, v = turning(t, 1e-6)
    np.testing.assert_allclose(result.q("slider.x"), x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(result.v("slider.x"), v, rtol=0, atol=1e-6)


@pytest.mark.parametrize("count", [9, 201, 2001])
@pytest.mark.parametrize("excess", [-1e-1, -1e-3, -1e-6, -1e-9])
def test_a_shorter_rod_locks_at_the_exact_angle(excess: float, count: int) -> None:
    t = np.linspace(0.0, 1.0, count)
    result = equal_rods().kinematics(t, parameters={"rod_length": 1.0 + excess})
    exact = np.arcsin(1.0 + excess)
    locks = (exact - np.pi / 4) / OMEGA
    assert result.outcome is Outcome.LOCKED
    assert result.q("crank.phi")[-1] == pytest.approx(exact, abs=1e-9)
    assert result.t[-1] == pytest.approx(locks, abs=1e-10)
    np.testing.assert_array_equal(result.t[:-1], t[t < locks])
    np.testing.assert_allclose(
        result.q("slider.x")[:-1], turning(result.t[:-1], excess)[0], rtol=0, atol=1e-10
    )
    # The rod hangs straight down; the velocities there have no bound.
    assert result.q("rod.phi")[-1] == pytest.approx(-np.pi / 2, abs=1e-7)
    assert np.isnan(result.v("slider.x")[-1])
    assert np.isfinite(result.v("slider.x")[:-1]).all()


def test_a_lock_up_names_driver_joints_instant_and_what_could_move() -> None:
    result = equal_rods().kinematics(np.linspace(0, 1, 11), parameters={"rod_length": 0.9})
    found = only(result, "lock-up")
    locks = (np.arcsin(0.9) - np.pi / 4) / OMEGA
    assert found.time == pytest.approx(locks, abs=1e-12)
    assert found.drivers == ("crank_drive",)
    assert set(found.joints) == {"A", "B", "C", "guide"}
    assert found.singular_value < 1e-12
    assert found.drift > 0.1  # of the drive nothing can be given: the test of second order
    (free,) = found.null_directions
    assert {name for name, share in free.items() if abs(share) > 1e-9} == NAMES
    (event,) = result.events
    assert (event.what, event.time) == ("locked", found.time)
    assert f"Locked up at t = {locks:.12g} s" in result.message
    assert "driver crank_drive cannot go on" in result.message
    assert "could move by slider.x +1" in result.message
    assert "Change the dimensions or the range of the driver" in result.message


@pytest.mark.parametrize("excess", [1e-3, -1e-3, 1e-6])
def test_a_parallelogram_with_one_other_crank_locks(excess: float) -> None:
    """Its pins come as near to each other as the bars' lengths differ: 2 sin(φ/2) = |excess|."""
    result = load("hard/five_bar", "driven").kinematics(
        np.linspace(0.0, 1.0, 41), parameters={"excess": excess}
    )
    assert result.outcome is Outcome.LOCKED
    locks = 0.25 - 2.0 * np.arcsin(0.5 * abs(excess)) / OMEGA
    assert only(result, "lock-up").time == pytest.approx(locks, abs=1e-9)
    phi = np.pi / 2 - OMEGA * result.t
    np.testing.assert_allclose(result.q("crank_1.phi"), phi, rtol=0, atol=1e-9)


def test_a_pinion_swung_too_far_locks_in_the_dead_centre() -> None:
    result = load("rack_and_pinion", "kinematics").kinematics(
        np.linspace(0.0, 1.0, 101), parameters={"swing": 3.5}
    )
    found = only(result, "lock-up")
    assert found.drivers == ("pinion_drive",)
    assert "mesh" in found.joints
    assert result.q("pinion.phi")[-1] == pytest.approx(-3.0, abs=1e-11)


@pytest.mark.parametrize(
    ("beyond", "outcome", "kinds"),
    [
        (1e-6, Outcome.LOCKED, ["lock-up"]),
        (0.0, Outcome.OK, ["crossing"]),
        (-1e-6, Outcome.OK, []),
    ],
)
def test_a_driver_that_turns_at_the_dead_centre(
    beyond: float, outcome: Outcome, kinds: list[str]
) -> None:
    """Where it comes to rest in the dead centre the machine passes it; beyond it is a lock-up.

    About there φ = -3 + 4.8 δθ² by the coupler's angle, which passes with a velocity of its own.
    """
    t = np.linspace(0.0, 1.0, 101)
    swing = 3.0 + beyond
    result = load("rack_and_pinion", "kinematics").kinematics(t, parameters={"swing": swing})
    assert result.outcome is outcome
    assert [row.kind for row in result.singular] == kinds
    if outcome is Outcome.LOCKED:
        locks = 0.5 + np.arcsin(3.0 / swing) / OMEGA
        assert result.t[-1] == pytest.approx(locks, abs=1e-9)
        return
    np.testing.assert_allclose(
        result.q("pinion.phi"), swing * np.sin(OMEGA * t), rtol=0, atol=1e-12
    )
    theta = result.q("coupler.phi")
    if kinds:
        assert result.singular[0].time == pytest.approx(0.75, abs=1e-9)
        rate = result.v("coupler.phi")[t == 0.75]
        assert abs(rate) == pytest.approx(np.sqrt(0.5 * 3.0 / 4.8) * OMEGA, rel=0.01)
        assert (theta[-1] - theta[75]) * (theta[75] - theta[50]) > 0.0
    else:
        assert (theta[-1] - theta[75]) * (theta[75] - theta[50]) < 0.0


def test_an_end_that_is_a_corner_is_told_as_unclear(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """A cylinder that shrinks to nothing: where its ends meet it has no direction."""
    from codegen import Model, t

    model = Model("short_cylinder")
    rod = model.body("rod", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, rod)
    model.distance_driver("cylinder", model.ground.at(0, 0), rod, 1 - t**2)
    model.scene("pull", drivers=["cylinder"], guess={"rod.x": 0.8})
    result = load(model, folder=tmp_path).kinematics([0.0, 0.5, 1.5])
    assert result.outcome is Outcome.LOCKED
    assert only(result, "unclear").time == pytest.approx(1.0, abs=1e-6)
    assert result.events == ()


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


@pytest.mark.parametrize(
    ("lean", "error", "message"),
    [
        (0.0, AssemblyError, r"no velocities satisfy joints and drivers at t = 0\.0532"),
        (5e-8, AnalysisError, r"starts in a singular position at t = 0\.0532.*\(a lock-up: no"),
    ],
)
def test_a_start_in_a_lock_up_is_told_from_a_crossing(
    lean: float, error: type[Exception], message: str
) -> None:
    """The rod upright, where the crank is at its last, or as near as rounding can tell."""
    rod = 0.9
    exact = np.arcsin(rod * np.cos(lean))
    reach = np.cos(exact) + 0.5 * rod * np.sin(lean)
    there = {
        "crank.phi": exact, "crank.x": np.cos(exact) / 2, "crank.y": np.sin(exact) / 2,
        "rod.x": reach, "rod.y": np.sin(exact) / 2, "rod.phi": lean - np.pi / 2,
        "slider.x": reach + 0.5 * rod * np.sin(lean),
    }  # fmt: skip
    with pytest.raises(error, match=message):
        equal_rods().kinematics(
            [0.2],
            t_start=(exact - np.pi / 4) / OMEGA,
            parameters={"rod_length": rod},
            guess=STANDING | there,
        )


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
