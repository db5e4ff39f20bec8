"""Plane geometry: hulls, bars, poses, what lies inside, arrows and hatchings."""

import numpy as np
import pytest

from codegen.drawing import plane_geometry as plane


def test_hull_of_a_square_leaves_out_what_lies_inside_and_on_its_edges() -> None:
    hull = plane.convex_hull(np.array([0, 2, 1 + 1j, 2 + 2j, 1, 2j, 2 + 1j]))
    assert hull.tolist() == [0, 2, 2 + 2j, 2j]
    assert plane.area(hull) == 4.0
    for line in ([1j], [0, 1j], [0, 1, 2, 3], [0, np.nan, 1, 1j]):
        assert plane.convex_hull(np.array(line, dtype=complex)) == pytest.approx(line, nan_ok=True)


@pytest.mark.parametrize(
    ("points", "length", "inside"),
    [([1 + 1j], 0, 0), ([0, 3 + 4j], 10, 0), ([0, 1, 3], 6, 0), ([0, 4, 3j], 12, 6)],
)
def test_rounded_hull_has_the_area_of_steiners_formula(
    points: list[complex], length: float, inside: float
) -> None:
    radius = 0.25
    polygon = plane.rounded_hull(np.array(points, dtype=complex), radius)
    exact = inside + length * radius + np.pi * radius**2
    corners = np.pi * radius**2 * 0.01  # a polygon of 32 corners lies inside its circle
    assert exact - corners < plane.area(polygon) < exact
    assert abs(polygon - points[0]).min() == pytest.approx(radius)


def test_pose_and_its_inverse() -> None:
    points, pose = np.array([1, 2j]), np.array([3.0, -1.0, np.pi / 2])
    there = plane.placed(points, pose)
    assert there == pytest.approx(np.array([3, 1 - 1j]))
    assert plane.in_frame(there, pose) == pytest.approx(points)
    assert plane.placed(1, np.array([pose, [0, 0, 0]])) == pytest.approx(np.array([3, 1]))


@pytest.mark.parametrize(
    ("point", "inside"), [(0.5 + 2j, True), (2 + 0.5j, True), (2 + 2j, False), (-1 + 0.5j, False)]
)
def test_inside_and_outside_of_a_polygon_that_is_not_convex(point: complex, inside: bool) -> None:
    angle = np.array([0, 3, 3 + 1j, 1 + 1j, 1 + 3j, 3j])
    assert plane.contains(angle, point) is inside


def test_points_that_are_one_are_taken_once() -> None:
    points = np.array([0, 1, 1e-4], dtype=complex)
    assert [len(plane.distinct(points, tolerance)) for tolerance in (1e-3, 1e-5)] == [2, 3]


def test_arrows_end_at_their_tips() -> None:
    shaft, head = plane.straight_arrow(0j, 3 + 4j, 0.5)
    assert [shaft[0], head[0]] == pytest.approx([0, 3 + 4j])
    arc, tip = plane.round_arrow(0j, 1.0, 0.0, -np.pi / 2, 0.2)
    assert [arc[0], tip[0]] == pytest.approx([1, -1j])


def test_the_hatchings_of_lines_that_lie_on_one_another_coincide() -> None:
    def feet(first: float, last: float) -> set[float]:
        strokes = plane.hatching(first + 2j, last + 2j, -1.0, 0.1)
        return {round(float(stroke[0].real), 9) for stroke in strokes}

    one, other = feet(-0.234, 0.5), feet(0.03, 1.07)
    assert {x for x in one if x > 0.03} == {x for x in other if x <= 0.5}
    assert len(one | other) == 13
    assert len(feet(0.01, 0.02)) == 1
    assert len(feet(0.0, 1.0)) == 10
