"""Machines in space by the dense equations against references and closed forms."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.random_mechanisms.spatial_constraints import SpatialState
from tests.random_mechanisms.spatial_dynamics import SpatialDense, moved
from tests.random_mechanisms.spatial_motion import motion
from tests.space.closed_forms import (
    FlyballGovernor,
    SpatialSliderCrank,
    universal_joint_angle,
    universal_joint_ratio,
)
from tests.space.dense_machines import (
    bricard,
    flyball_governor,
    governor,
    heavy_top,
    slider_crank,
    universal_shafts,
)
from tests.space.heavy_top import HeavyTop


def turning(dense: SpatialDense, omega: Any) -> SpatialState:
    """The drawing, turning as one body about the origin."""
    w = np.tile(np.array(omega, float), (dense.n, 1))
    return replace(dense.at_drawing, v=np.cross(w, dense.at_drawing.r), w=w)


def reference(root: Path, name: str) -> Any:
    return np.loadtxt(root / "tests/data" / f"{name}.csv", delimiter=",", skiprows=1)


def test_the_heavy_top_moves_as_in_closed_form() -> None:
    dense, omega = SpatialDense(heavy_top()), (0.0, 150.0, -4.61538)
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # the top's z′ along y
    form = HeavyTop(15.0, 1.0, 0.234375, 0.46875, axes.T @ omega, axes)
    end = motion(dense, turning(dense, omega), [0.0, 0.1], 1e-10)[-1]
    np.testing.assert_allclose(end.r[0], form.attitude(0.1)[:, 2], atol=1e-9)


def test_bricards_mechanism_agrees_with_its_reference(root: Path) -> None:
    dense, rows = SpatialDense(bricard()), reference(root, "bricard")[:101:20]
    assert dense.freedoms(dense.at_drawing) == (1, 1)
    for state, row in zip(motion(dense, dense.at_drawing, rows[:, 0].tolist()), rows, strict=True):
        np.testing.assert_allclose(state.r[1] + state.R[1] @ [0, -0.5, 0], row[4:7], atol=1e-11)
        np.testing.assert_allclose(state.r[2] + state.R[2] @ [0, 0, 0.5], row[7:10], atol=1e-11)
        np.testing.assert_allclose(state.r[3] + state.R[3] @ [0.5, 0, 0], row[7:10], atol=1e-11)


def test_the_flyball_governor_agrees_with_its_reference(root: Path) -> None:
    dense, rows = SpatialDense(flyball_governor()), reference(root, "flyball_governor")[:2]
    start = turning(dense, (0, 0, 2 * np.pi))
    assert dense.freedoms(start) == (4, 0)
    for state, row in zip(motion(dense, start, rows[:, 0].tolist()), rows, strict=True):
        _, height, tilt, rise, _, angle, speed = row
        assert state.r[1, 2] == pytest.approx(height, abs=1e-12)
        assert state.v[1, 2] == pytest.approx(rise, abs=1e-11)
        assert -np.arcsin(state.R[2:, 2, 0]) == pytest.approx([tilt, tilt], abs=1e-12)
        assert np.arctan2(state.R[0, 1, 0], state.R[0, 0, 0]) == pytest.approx(angle, abs=1e-12)
        assert state.w[0, 2] == pytest.approx(speed, abs=1e-11)


@pytest.mark.parametrize("bend", [0.5, 1.2])
def test_shafts_of_a_universal_joint_turn_as_in_closed_form(bend: float) -> None:
    dense = SpatialDense(universal_shafts(bend))
    start = dense.closed(dense.at_drawing, 0.0)
    assert dense.freedoms(start) == (0, 3)
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    instants = np.linspace(0.0, 4.0, 5).tolist()
    for t, state in zip(instants, motion(dense, start, instants, 1e-10), strict=True):
        ratio = universal_joint_ratio(2 * t, bend)
        assert state.w[1] / 2.0 == pytest.approx(ratio * along, abs=1e-12)
        arm = state.R[1, :, 2]  # along z at the drawing
        angle = universal_joint_angle(2 * t, bend)
        away = np.cross(along, [0, 0, 1])
        expected = np.cos(angle) * np.array([0, 0, 1]) + np.sin(angle) * away
        np.testing.assert_allclose(arm, expected, atol=1e-12)


@pytest.mark.parametrize("gain", [7500, 12500, 17500])
def test_the_governor_stays_as_virtual_work_says(gain: float) -> None:
    height, speed = FlyballGovernor().steady(gain)
    dense = SpatialDense(governor(height))
    state = turning(dense, (0, speed, 0))
    assert dense.freedoms(state) == (2, 0)
    solved = dense.solve(state)
    np.testing.assert_allclose(solved.r[1], 0.0, atol=1e-11)
    np.testing.assert_allclose(solved.w, 0.0, atol=1e-11)
    np.testing.assert_allclose(solved.r[2:], -(speed**2) * state.r[2:] * [1, 0, 1], atol=1e-11)


@pytest.mark.parametrize(
    ("rod", "moments", "least", "most"),
    [
        (0.3, (4e-4, 4e-3, 4e-3), -0.298, 0.203),
        (0.24, (4e-4, 4e-3, 4e-3), -0.741, 0.987),
        (0.24, (4e-3, 4e-4, 4e-3), -0.715, 0.961),
    ],
)
def test_the_slider_crank_needs_the_torques_that_energy_gives(
    rod: float, moments: Any, least: float, most: float
) -> None:
    """The extremes are those of d(T + V)/dt over the speed; the slider's motion is exact."""
    form, speed, count = SpatialSliderCrank(rod), -2 * np.pi, 400
    dense = SpatialDense(slider_crank(rod, moments, speed))
    state, torques = dense.closed(dense.at_drawing, 0.0), []
    for k in range(count + 1):
        t = k / count
        if k:
            velocity = np.concatenate([state.v, state.w], axis=1).ravel()
            state = dense.closed(moved(state, velocity / count), t)
        solved = dense.solve(state, t)
        torques.append(dense.effort("drive", solved))
        if k % 40 == 0:
            exact = form.motion(np.pi / 2 + speed * t, speed)
            found = state.r[2, 0], state.v[2, 0], solved.r[2, 0]
            assert found == pytest.approx(exact, abs=1e-10)
    assert (min(torques), max(torques)) == pytest.approx((least, most), abs=1.5e-3)
