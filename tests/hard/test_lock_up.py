"""Driven machines that lock up, and such as only come close: each told for what it is.

Every motion is compared with its closed form; the parallelograms are those of `five_bar`.
"""

import numpy as np
import pytest

from codegen.errors import AnalysisError, AssemblyError
from runtime import Outcome, load
from tests.hard.driven import (
    NAMES,
    OMEGA,
    STANDING,
    UPRIGHT,
    assert_close,
    equal_rods,
    only,
    turning,
)


@pytest.mark.parametrize("count", [9, 37, 201])
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


CHANGE_POINTS = [(1.5, 1.5), (1.499, 1.501), (1.399, 1.601)]
NEAR_THEM = [(b + d, c + e) for b, c in CHANGE_POINTS for d, e in [(1e-3, 0), (1e-8, 1e-10)]]
BEYOND = [(b - d, c) for b, c in CHANGE_POINTS for d in (1e-3, 1e-8)]


@pytest.mark.parametrize(("coupler", "rocker"), [*CHANGE_POINTS, *NEAR_THEM, *BEYOND])
def test_four_bars_at_their_change_point_however_sampled(coupler: float, rocker: float) -> None:
    """Grashof: with a crank of 1 m and a frame of 2 m the coupler and the rocker must reach 3 m.

    With just that, all bars fall into one line when the crank points away; the rocker passes on.
    """
    bars = {"BC": coupler, "CD": rocker}
    machine = load("four_bar", "kinematics")
    runs = [machine.kinematics(np.linspace(0, 2, n), parameters=bars) for n in (7, 91, 1441)]
    short = coupler + rocker < 3.0 - 1e-12
    even = abs(coupler + rocker - 3.0) < 1e-12
    kinds = ["lock-up"] if short else ["crossing"] * 2 if even else []
    for run, every in zip(runs, (1, 15, 240), strict=True):
        assert [row.kind for row in run.singular] == kinds
        shared = np.isin(runs[0].t, run.t[::every])
        angles = run.q("rocker.phi")[::every][: shared.sum()]
        assert_close(angles, runs[0].q("rocker.phi")[: shared.sum()], 1e-9)
        if short:
            # The law of cosines in the triangle of frame, crank and both bars in line.
            locks = np.arccos((5.0 - (coupler + rocker) ** 2) / 4.0) / OMEGA
            assert run.t[-1] == pytest.approx(locks, abs=1e-9)
    if even:
        assert [row.time for row in runs[0].singular] == pytest.approx([0.5, 1.5], abs=1e-9)


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
    [(1e-6, Outcome.LOCKED, ["lock-up"]), (0.0, Outcome.OK, ["crossing"]), (-1e-6, Outcome.OK, [])],
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


def test_a_driven_distance_of_0_is_named(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """A cylinder that shrinks to nothing: where its ends meet it has no direction."""
    from codegen import Model, t

    model = Model("short_cylinder")
    rod = model.body("rod", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, rod)
    model.distance_driver("cylinder", model.ground.at(0, 0), rod, 1 - t**2)
    model.scene("pull", drivers=["cylinder"], guess={"rod.x": 0.8})
    result = load(model, folder=tmp_path).kinematics([0.0, 0.5, 1.5])
    assert result.outcome is Outcome.DISCONTINUOUS
    assert "Stopped before t = 1 s. In driver 'cylinder'" in result.message
    assert result.events == ()


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
