"""Lines of elements: springs between their ends, teeth that mesh, belts that touch, hatching."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from codegen.drawing import arrow_lines, spring_lines, wheel_lines
from codegen.drawing.gear_meshing import meshing
from codegen.drawing.moving_strokes import moving_strokes
from codegen.drawing.outlines import complete_picture
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import placed
from codegen.drawing.rigid_strokes import rigid_strokes
from codegen.drawing.shapes import Belt, Force, Pin, Place, Rack, Rod, Spring, Wheel
from tests.codegen.drawing.hand_drawn_pictures import picture, slider_crank

START, END = np.array([1.0, 1.0]), np.array([4.0, 5.0])  # 5 m apart


@pytest.mark.parametrize(
    ("elastic", "damper", "actuator", "styles"),
    [
        (True, False, False, {"spring": 1}),
        (False, True, False, {"damper": 4}),
        (False, False, True, {"actuator": 4}),
        (True, True, False, {"spring": 5, "damper": 4}),
        (True, True, True, {"spring": 5, "damper": 4, "actuator": 4}),
    ],
)
def test_springs_dampers_and_actuators_reach_from_end_to_end(
    elastic: bool, damper: bool, actuator: bool, styles: dict[str, int]
) -> None:
    lines = spring_lines.spring_lines(START, END, 0.1, elastic, damper, actuator)
    assert Counter(style for style, _ in lines) == styles
    ends = np.concatenate([line[[0, -1]] for _, line in lines])
    for end in (START, END):
        assert min(np.hypot(*(ends - end).T)) < 1e-12
    across = (np.concatenate([line for _, line in lines]) - START) @ np.array([-0.8, 0.6])
    assert np.max(np.abs(across)) == pytest.approx({1: 0.1, 2: 0.22, 3: 0.34}[len(styles)])


def test_a_torsion_spring_winds_up() -> None:
    ((style, points),) = spring_lines.torsion_parts(True, False, False)
    assert style == "spring"
    ends = (0.0, 1.0, 2 * np.pi)
    turned = [spring_lines.torsion_lines(np.zeros(2), 0.1, 0.0, end, points) for end in ends]
    inner, outer = (0.1 * pins for pins in spring_lines.SPIRAL)
    for line, end in zip(turned, ends, strict=True):
        assert line[0] == pytest.approx([inner, 0.0])
        angle = end + 2 * np.pi * spring_lines.SPIRAL_TURNS
        assert line[-1] == pytest.approx([outer * np.cos(angle), outer * np.sin(angle)])
    turns = [np.sum(np.hypot(*np.diff(line, axis=0).T)) for line in turned]
    assert turns == sorted(turns)


@pytest.mark.parametrize("crossed", [False, True])
def test_a_belt_touches_both_wheels_without_a_corner(crossed: bool) -> None:
    line = wheel_lines.belt_line(START, 0.5, END, 1.5, crossed)
    distances = np.minimum(np.hypot(*(line - START).T) - 0.5, np.hypot(*(line - END).T) - 1.5)
    assert np.abs(distances) == pytest.approx(0.0, abs=1e-12)
    assert line[0] == pytest.approx(line[-1])
    steps = np.diff(line, axis=0)
    ways = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    assert np.max(np.abs(np.diff(ways))) < 0.2  # no corner where lines meet arcs
    assert np.hypot(*steps.T).max() > 4.0  # the free part of the belt


def test_a_wheels_teeth_lie_about_its_pitch_circle() -> None:
    gear = wheel_lines.gear_profile(0.5, 0.05, phase=0.3)
    ring = wheel_lines.gear_profile(0.5, 0.05, internal=True)
    radii = np.hypot(*gear.T)
    assert len(gear) == 4 * 20
    assert radii.min() == pytest.approx(0.5 - 1.1 * 0.05)
    assert radii.max() == pytest.approx(0.5 + 0.9 * 0.05)
    assert np.hypot(*ring.T).min() == pytest.approx(0.5 - 0.9 * 0.05)
    crest = np.mean(gear[1:3], axis=0)
    assert np.arctan2(crest[1], crest[0]) == pytest.approx(0.3)


def test_the_module_gives_whole_numbers_of_teeth_where_it_can() -> None:
    module = wheel_lines.common_module([0.3, 0.1, 0.25])
    teeth = np.array([0.3, 0.1, 0.25]) * 2 / module
    assert teeth == pytest.approx(np.round(teeth))


HEADING = np.radians(40)


def gears(radius_i: float, radius_j: float, turn: float) -> Picture:
    """Two gears, the second at 40° from the first, after a turn of the first."""
    distance = abs(radius_i + radius_j)
    at = distance * np.cos(HEADING), distance * np.sin(HEADING)
    return picture(["first", "second"], [(0.0, 0.0, turn), (*at, -turn * radius_i / radius_j)], [
        ("A", "joint", Pin(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0))),
        ("mesh", "joint", Wheel(Place(1, 0.0, 0.0), radius_i, True)),
        ("mesh", "joint", Wheel(Place(2, 0.0, 0.0), radius_j, True)),
    ])  # fmt: skip


@pytest.mark.parametrize(("radius_i", "radius_j"), [(0.2, 0.1), (0.1, 0.3), (-0.4, 0.1)])
@pytest.mark.parametrize("later", [0.0, 0.7])
def test_teeth_of_gears_mesh_and_stay_so(radius_i: float, radius_j: float, later: float) -> None:
    drawn, moved = gears(radius_i, radius_j, 0.3), gears(radius_i, radius_j, 0.3 + later)
    internal = radius_i < 0
    lines = [s for s in rigid_strokes(drawn) if s.style in ("gear", "profile")]
    teeth = {s.body: s.points for s in reversed(lines)}
    first = _ahead(teeth[1], moved, 1, HEADING)
    second = _ahead(teeth[2], moved, 2, HEADING + (0.0 if internal else np.pi))
    meeting = second - first if internal else second + first
    assert meeting % 1.0 == pytest.approx(0.5, abs=1e-6)


def _ahead(points: np.ndarray, drawn: Picture, body: int, heading: float) -> float:
    """How far a direction is ahead of the middle of a tooth, in pitches."""
    crest = points[1:3].mean(axis=0)
    angle = np.arctan2(crest[1], crest[0]) + drawn.poses[body, 2]
    return float((heading - angle) * len(points) / 4 / (2 * np.pi))


def test_a_rack_meshes_with_its_pinion() -> None:
    drawn = picture(["pinion", "rack"], [(0.0, 0.1, 0.4), (0.3, 0.0, 0.0)], [
        ("A", "joint", Pin(Place(0, 0.0, 0.1), Place(1, 0.0, 0.0))),
        ("mesh", "joint", Wheel(Place(1, 0.0, 0.0), 0.1, True)),
        ("mesh", "joint", Rack(Place(2, 0.0, 0.0), 1.0, 0.0, True)),
    ])  # fmt: skip
    pitch = np.pi * meshing(drawn).module
    pinion, rack = (s for s in rigid_strokes(drawn) if s.style == "gear")
    crests = placed(pinion.points.reshape(-1, 4, 2)[:, 1:3].mean(axis=1), drawn.poses[1])
    tooth = crests[np.argmin(crests[:, 1]), 0]
    tops = placed(rack.points[2:-2].reshape(-1, 4, 2)[:, 1:3].mean(axis=1), drawn.poses[2])[:, 0]
    assert (tops - tooth) / pitch % 1 == pytest.approx(0.5, abs=0.1)


def test_the_ground_is_hatched_at_a_pin_and_along_a_guide() -> None:
    strokes = rigid_strokes(slider_crank())
    counts = Counter((s.style, s.element) for s in strokes)
    assert counts["support", "A"] == counts["rail", "A"] == counts["rail", "guide"] == 1
    assert counts["hatch", "A"] >= 4
    assert counts["hatch", "guide"] > 20
    assert {s.element for s in strokes if s.style == "pin"} == {"A", "B", "C"}
    below = [s.points for s in strokes if s.style == "hatch"]
    assert all(line[1, 1] < line[0, 1] for line in below)


def test_a_support_stands_before_a_wheel_that_would_hide_it() -> None:
    pin = ("A", "joint", Pin(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0)))
    far = ("far", "force", Force(Place(0, 1.0, 0.0), 0.0, 0.0))
    for radius, style in ((0.3, "bracket-support"), (0.035, "bracket-support"), (0.02, "support")):
        wheel = ("wheel", "joint", Wheel(Place(1, 0.0, 0.0), radius, True))
        strokes = rigid_strokes(complete_picture(picture(["gear"], [(0, 0, 0)], [pin, far, wheel])))
        assert [s.style for s in strokes if s.style.endswith("support")] == [style]


@pytest.mark.parametrize(
    ("turn", "styles"),
    [(0.02, {"rail", "hatch"}), (0.5, {"support", "rail", "hatch", "pin"})],
)
def test_a_spring_that_swings_has_a_support_on_the_ground(turn: float, styles: set[str]) -> None:
    spring = ("spring", "force", Spring(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0)))
    drawn = picture(["block"], [(1.0, 0.0, 0.0)], [spring])
    motion = np.array([[[0, 0, 0], [np.cos(a), np.sin(a), 0]] for a in (0.0, turn)])
    strokes = rigid_strokes(drawn, motion)
    assert {s.style for s in strokes if s.body == 0} == styles
    assert [s.style for s in strokes if s.element == "spring" and s.body == 1] == ["pin"]


def test_a_joint_that_is_not_closed_shows_its_gap() -> None:
    assert [s for s in moving_strokes(slider_crank()) if s.style == "gap"] == []
    gaps = [s for s in moving_strokes(slider_crank(closed=False)) if s.style == "gap"]
    assert [s.element for s in gaps] == ["B", "C"]
    for stroke in gaps:
        assert np.hypot(*np.ptp(stroke.points, axis=0)) == pytest.approx(0.4 * np.sqrt(2))


def test_rods_belts_and_springs_move_with_their_bodies() -> None:
    drawn = picture(["a", "b"], [(1.0, 0.0, 0.0), (3.0, 0.0, 0.0)], [
        ("rod", "joint", Rod(Place(1, 0.0, 0.0), Place(2, 0.0, 0.5))),
        ("belt", "joint", Belt(Place(1, 0.0, 0.0), Place(2, 0.0, 0.0), 0.3, 0.4)),
        ("spring", "force", Spring(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0))),
    ])  # fmt: skip
    moved = replace(drawn, poses=drawn.poses + np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0]]))
    before, after = moving_strokes(drawn), moving_strokes(moved)
    assert [s.style for s in before] == ["rod", "belt", "spring"]
    for here, there in zip(before[:2], after[:2], strict=True):
        assert there.points - here.points == pytest.approx(
            np.broadcast_to([0, 1], here.points.shape)
        )
    assert after[2].points[[0, -1]] == pytest.approx(np.array([[0, 0], [1, 1]]))


def test_arrows_end_at_their_tips() -> None:
    shaft, head = arrow_lines.straight_arrow(np.zeros(2), np.array([3.0, 4.0]), 0.5)
    assert head[0] == pytest.approx([3.0, 4.0])
    assert shaft[0] == pytest.approx([0.0, 0.0])
    arc, tip = arrow_lines.round_arrow(np.zeros(2), 1.0, 0.0, -np.pi / 2, 0.2)
    assert tip[0] == pytest.approx([0.0, -1.0])
    assert arc[0] == pytest.approx([1.0, 0.0])
    assert len(arrow_lines.hatching(np.zeros(2), np.array([1.0, 0.0]), 1.0, 0.1)) == 10


def test_the_hatchings_of_lines_that_lie_on_one_another_coincide() -> None:
    def feet(first: float, last: float) -> set[float]:
        line = np.array([[first, 2.0], [last, 2.0]])
        strokes = arrow_lines.hatching(line[0], line[1], -1.0, 0.1)
        return {round(float(stroke[0, 0]), 9) for stroke in strokes}

    one, other = feet(-0.234, 0.5), feet(0.03, 1.07)
    assert {x for x in one if x > 0.03} == {x for x in other if x <= 0.5}
    assert len(one | other) == 13
    assert len(feet(0.01, 0.02)) == 1
