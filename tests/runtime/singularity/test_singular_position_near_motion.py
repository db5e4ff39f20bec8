"""A singular position as its users see it: of a saddle by hand, and of two parallelograms."""

import numpy as np
import pytest

from runtime.singularity.singular_position_near_motion import SingularPositions
from tests.runtime.singularity.crossing import branch_slopes, closed, mechanism
from tests.runtime.singularity.test_singular_root_search import on_branch


@pytest.mark.parametrize("speed", [1.0, 20.0])
def test_a_motion_on_its_branch(speed):
    scaled = mechanism(scale=(1.0, 1.0, 2.0))
    motion = on_branch(-0.01, speed=speed)
    found = SingularPositions(scaled).find(motion, 0.011 / speed, branch=True)
    assert found is not None
    assert found.t == pytest.approx(2.0 + 0.01 / speed, abs=1e-8)
    np.testing.assert_allclose(found.q, 0.0, atol=1e-10)
    assert found.lost == 1
    assert found.gap < 1e-13
    assert found.astray < 1e-6
    assert found.speed == pytest.approx(np.linalg.norm(motion.velocity / [1.0, 1.0, 2.0]))
    assert found.miss < 1e-9
    assert np.isnan(found.due)
    s = branch_slopes(0.5)[0]
    values = []
    for step in (-1e-4, 1e-4):
        q = closed(step * speed, s * step * speed)
        values.append(np.linalg.svd(scaled.all_rows(0.0, q), compute_uv=False)[-1])
    assert found.rate == pytest.approx(sum(values) / 2e-4, rel=1e-2)
    assert abs(found.direction[2]) < 1e-9
    assert np.linalg.norm(found.direction) == pytest.approx(1.0)


def test_a_motion_beside_its_branch_is_told_the_way_to_it():
    motion = on_branch(-1e-6)
    motion.series[1, 1] += 1e-3
    found = SingularPositions(mechanism()).find(motion, 1e-6, branch=True)
    assert found is not None
    v = motion.velocity + found.veer
    assert v[1] / v[0] == pytest.approx(branch_slopes(0.5)[0], abs=1e-5)
    length = 1e-3 / np.sqrt(1.0 + branch_slopes(0.5)[0] ** 2)
    assert np.linalg.norm(found.veer) == pytest.approx(length, rel=0.01)
    assert found.astray == pytest.approx(length / found.speed, rel=0.01)


@pytest.mark.parametrize("gap", [1e-4, -1e-6])
def test_a_motion_that_misses_it_is_told_by_what(gap):
    found = SingularPositions(mechanism(gap=gap)).find(on_branch(-0.1), 0.1)
    assert found is not None
    assert 0.1 * abs(gap) < found.gap < 10.0 * abs(gap)
    np.testing.assert_allclose(found.q, 0.0, atol=1e-9)


def test_a_position_once_found_is_seen_again_from_nearer():
    positions = SingularPositions(mechanism())
    first = positions.find(on_branch(-0.1), 0.1)
    assert first is not None
    later = on_branch(-0.02, speed=2.0, t=2.04)
    again = positions.find_again(later, first)
    assert again is not None
    assert again.q is first.q
    assert again.t == pytest.approx(2.05, abs=1e-9)
    assert again.rate / again.speed == pytest.approx(first.rate / first.speed)
    assert again.speed == pytest.approx(np.linalg.norm(later.velocity))
    assert positions.passing_time(later, first) == pytest.approx(2.05, abs=1e-9)


@pytest.mark.parametrize("speed", [0.0, np.nan])
def test_a_machine_at_rest_meets_nothing(speed):
    positions = SingularPositions(mechanism())
    assert positions.find(on_branch(-0.1, speed=speed), 0.1) is None


def test_time_takes_part_in_what_is_lost():
    """With a term x t the saddle is one in time too, and lies at t = 0."""
    scaled = mechanism(d=0.7)
    found = SingularPositions(scaled).find(on_branch(-0.01, t=-0.01), 0.01)
    assert found is not None
    np.testing.assert_allclose(found.q, 0.0, atol=1e-9)
    assert found.t == pytest.approx(0.0, abs=1e-3)
