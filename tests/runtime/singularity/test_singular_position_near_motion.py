"""A singular position as its users see it: of a saddle by hand, and of two parallelograms."""

import numpy as np
import pytest

from runtime.singularity.motion_polynomial import Motion
from runtime.singularity.singular_position_near_motion import Singularity, SingularPositions
from tests.runtime.singularity.crossing import GAP, C, branch_slopes, closed, mechanism
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
        values.append(scaled.weakest(0.0, q)[1])
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


def searches(positions: SingularPositions, motion: Motion, s: float) -> tuple[Singularity, int]:
    """What is found, and after how many searches for a root."""
    count, search = [], positions.search

    class Counted(search):
        def find(self, s, weak):
            count.append(weak)
            return super().find(s, weak)

    positions.search = Counted
    found = positions.find(motion, s)
    positions.search = search
    assert found is not None
    return found, len(count)


def test_a_point_that_was_passed_is_known_on_the_way_back_and_after_whole_turns():
    positions = SingularPositions(mechanism())
    first, searched = searches(positions, on_branch(-0.01), 0.01)
    assert searched == 1
    back = on_branch(0.008, speed=-2.0, t=9.0)
    again, searched = searches(positions, back, 0.004)
    assert searched == 0
    fresh = SingularPositions(mechanism()).find(back, 0.004)
    assert again.t == pytest.approx(fresh.t, abs=1e-12)
    np.testing.assert_allclose(again.q, fresh.q, atol=1e-12)
    assert again.rate == pytest.approx(fresh.rate, rel=0.01)
    assert again.speed == fresh.speed
    assert (again.lost, again.gap) == (first.lost, first.gap)


def test_a_point_is_not_known_to_another_motion_nor_where_constraints_have_changed():
    scaled = mechanism(k=0.3)
    positions = SingularPositions(scaled)
    assert searches(positions, on_branch(-0.01), 0.01)[1] == 1
    other = on_branch(-0.01)
    s = branch_slopes(0.5)[1]
    other.series[0, 1] = -0.01 * s
    other.series[1, 1] = s
    assert searches(positions, other, 0.01)[1] == 1
    assert searches(positions, on_branch(-0.01), 0.01)[1] == 0
    scaled.p[GAP] = 1e-9
    found, searched = searches(positions, on_branch(-0.01), 0.01)
    assert searched == 1
    assert found.gap > 1e-11
    scaled.p[GAP], scaled.p[C] = 0.0, 0.6
    assert searches(positions, on_branch(-0.01, c=0.6), 0.01)[1] == 1


def test_a_length_does_not_turn():
    """The same motion, but for 2π in a coordinate that the constraints do not take the sine of."""
    positions = SingularPositions(mechanism())
    assert searches(positions, on_branch(-0.01), 0.01)[1] == 1
    away = on_branch(-0.01)
    away.series[0, 2] += 2.0 * np.pi
    assert (
        positions._find_passed(
            positions.search(positions.constraints, positions.orders, away, 1.0), 0.01, 1
        )
        is None
    )


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
