"""Polygons: hulls, bars, poses, and what lies inside."""

import numpy as np
import pytest

from codegen.drawing import polygons


def test_hull_of_a_square_leaves_out_what_lies_inside_and_on_its_edges() -> None:
    points = np.array([[0, 0], [2, 0], [1, 1], [2, 2], [1, 0], [0, 2], [2, 1]], dtype=float)
    hull = polygons.convex_hull(points)
    assert [tuple(p) for p in hull] == [(0, 0), (2, 0), (2, 2), (0, 2)]
    assert polygons.area(hull) == 4.0


@pytest.mark.parametrize(
    ("points", "length", "inside"),
    [
        ([[1.0, 1.0]], 0.0, 0.0),
        ([[0.0, 0.0], [3.0, 4.0]], 10.0, 0.0),
        ([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]], 6.0, 0.0),
        ([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]], 12.0, 6.0),
    ],
)
def test_rounded_hull_has_the_area_of_steiners_formula(
    points: list[list[float]], length: float, inside: float
) -> None:
    radius = 0.25
    polygon = polygons.rounded_hull(np.array(points), radius)
    exact = inside + length * radius + np.pi * radius**2
    corners = np.pi * radius**2 * 0.01  # a polygon of 32 corners lies inside its circle
    assert exact - corners < polygons.area(polygon) < exact
    distance = min(np.hypot(*(p - points[0])) for p in polygon)
    assert distance == pytest.approx(radius)


def test_pose_and_its_inverse() -> None:
    points = np.array([[1.0, 0.0], [0.0, 2.0]])
    pose = np.array([3.0, -1.0, np.pi / 2])
    there = polygons.placed(points, pose)
    assert there == pytest.approx(np.array([[3.0, 0.0], [1.0, -1.0]]))
    assert polygons.in_frame(there, pose) == pytest.approx(points)


def test_points_inside_and_outside_of_a_polygon_that_is_not_convex() -> None:
    angle = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
    assert polygons.contains(angle, np.array([0.5, 2.0]))
    assert polygons.contains(angle, np.array([2.0, 0.5]))
    assert not polygons.contains(angle, np.array([2.0, 2.0]))
    assert not polygons.contains(angle, np.array([-1.0, 0.5]))


def test_points_that_are_one_are_taken_once() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1e-4, 0.0]])
    assert len(polygons.distinct(points, 1e-3)) == 2
    assert len(polygons.distinct(points, 1e-5)) == 3
