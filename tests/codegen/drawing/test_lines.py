"""Lines of elements: springs between their ends, teeth that mesh, belts that touch, hatching."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.guides import Meshing, common_module, gear_profile
from codegen.drawing.lines_between_bodies import (
    SPIRAL,
    SPIRAL_TURNS,
    lines_between_bodies,
    linked,
    links,
    winding_angles,
    windings,
    wound,
)
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import Picture
from codegen.drawing.shapes import (
    Belt,
    Fixing,
    Force,
    Mark,
    Pin,
    Place,
    Rack,
    Rod,
    SpiralSpring,
    Spring,
    Wheel,
)
from tests.codegen.drawing.hand_drawn_pictures import picture, slider_crank

ORIGIN, BODY = Place(0, 0.0, 0.0), Place(1, 0.0, 0.0)
START, END = 1 + 1j, 4 + 5j  # 5 m apart


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
    found = links(Spring(ORIGIN, BODY, elastic, damper, actuator))
    assert Counter(style for style, _ in found) == styles
    lines = np.concatenate([linked(points, START, END, 0.1) for _, points in found])
    assert max(abs(lines - end).min() for end in (START, END)) < 1e-12
    across = ((lines - START) * (0.6 - 0.8j)).imag
    assert abs(across).max() == pytest.approx({1: 0.1, 2: 0.22, 3: 0.34}[len(styles)])


def test_a_torsion_spring_winds_up() -> None:
    ((style, spiral),) = windings(SpiralSpring(ORIGIN, BODY), 1.0)
    assert style == "spring"
    ends = (0.0, 1.0, 2 * np.pi)
    turned = [wound(spiral, 9, 0, 0.0, end) for end in ends]
    pin = abs(turned[0][0]) / SPIRAL[0]
    for line, end in zip(turned, ends, strict=True):
        angle = end + 2 * np.pi * SPIRAL_TURNS
        assert line[[0, -1]] == pytest.approx(pin * np.array(SPIRAL) * np.exp([0, 1j * angle]))
    turns = [abs(np.diff(line)).sum() for line in turned]
    assert turns == sorted(turns)


@pytest.mark.parametrize("crossed", [False, True])
def test_a_belt_touches_both_wheels_without_a_corner(crossed: bool) -> None:
    belt = Belt(Place(0, START.real, START.imag), Place(0, END.real, END.imag), 0.5, 1.5, crossed)
    drawn = picture([], [], [("belt", "joint", belt)])
    ((_, points),) = windings(belt, 1.0)
    line = wound(points, START, END, *winding_angles(drawn, belt))
    distances = np.minimum(abs(line - START) - 0.5, abs(line - END) - 1.5)
    assert abs(distances) == pytest.approx(0.0, abs=1e-12)
    assert line[0] == pytest.approx(line[-1])
    ways = np.unwrap(np.angle(np.diff(line)))
    assert abs(np.diff(ways)).max() < 0.2  # no corner where lines meet arcs
    assert abs(np.diff(line)).max() > 4.0  # the free part of the belt


def test_a_wheels_teeth_lie_about_its_pitch_circle() -> None:
    gear = gear_profile(0.5, 0.05, phase=0.3)
    assert len(gear) == 4 * 20
    assert [abs(gear).min(), abs(gear).max()] == pytest.approx([0.5 - 0.055, 0.5 + 0.045])
    assert abs(gear_profile(0.5, 0.05, internal=True)).min() == pytest.approx(0.5 - 0.045)
    assert np.angle(gear[1:3].mean()) == pytest.approx(0.3)


def test_the_module_gives_whole_numbers_of_teeth_where_it_can() -> None:
    teeth = np.array([0.3, 0.1, 0.25]) * 2 / common_module([0.3, 0.1, 0.25])
    assert teeth == pytest.approx(np.round(teeth))


HEADING = np.radians(40)


def gears(radius_i: float, radius_j: float, turn: float) -> Picture:
    """Two gears, the second at 40° from the first, after a turn of the first."""
    at = abs(radius_i + radius_j) * np.exp(1j * HEADING)
    second = (at.real, at.imag, -turn * radius_i / radius_j)
    return picture(["first", "second"], [(0.0, 0.0, turn), second], [
        ("A", "joint", Pin(ORIGIN, BODY)),
        ("mesh", "joint", Wheel(BODY, radius_i, True)),
        ("mesh", "joint", Wheel(Place(2, 0.0, 0.0), radius_j, True)),
    ])  # fmt: skip


@pytest.mark.parametrize(("radius_i", "radius_j"), [(0.2, 0.1), (0.1, 0.3), (-0.4, 0.1)])
@pytest.mark.parametrize("later", [0.0, 0.7])
def test_teeth_of_gears_mesh_and_stay_so(radius_i: float, radius_j: float, later: float) -> None:
    drawn, moved = gears(radius_i, radius_j, 0.3), gears(radius_i, radius_j, 0.3 + later)
    internal = radius_i < 0
    lines = [s for s in lines_in_bodies(drawn) if s.style in ("gear", "profile")]
    teeth = {s.body: s.points for s in reversed(lines)}
    first = _ahead(teeth[1], moved, 1, HEADING)
    second = _ahead(teeth[2], moved, 2, HEADING + (0.0 if internal else np.pi))
    meeting = second - first if internal else second + first
    assert meeting % 1.0 == pytest.approx(0.5, abs=1e-6)


def _ahead(points: np.ndarray, drawn: Picture, body: int, heading: float) -> float:
    """How far a direction is ahead of the middle of a tooth, in pitches."""
    angle = np.angle(points[1:3].mean()) + drawn.poses[body, 2]
    return float((heading - angle) * len(points) / 4 / (2 * np.pi))


def test_a_rack_meshes_with_its_pinion() -> None:
    drawn = picture(["pinion", "rack"], [(0.0, 0.1, 0.4), (0.3, 0.0, 0.0)], [
        ("A", "joint", Pin(Place(0, 0.0, 0.1), BODY)),
        ("mesh", "joint", Wheel(BODY, 0.1, True)),
        ("mesh", "joint", Rack(Place(2, 0.0, 0.0), 1.0, 0.0, True)),
    ])  # fmt: skip
    pitch = np.pi * Meshing(drawn).module
    pinion, rack = (s.points for s in lines_in_bodies(drawn) if s.style == "gear")
    crests = drawn.placed(pinion.reshape(-1, 4)[:, 1:3].mean(axis=1), 1)
    tooth = crests[np.argmin(crests.imag)].real
    tops = drawn.placed(rack[2:-2].reshape(-1, 4)[:, 1:3].mean(axis=1), 2).real
    assert (tops - tooth) / pitch % 1 == pytest.approx(0.5, abs=0.1)


def test_the_ground_is_hatched_at_a_pin_and_along_a_guide() -> None:
    strokes = lines_in_bodies(slider_crank())
    counts = Counter((s.style, s.element) for s in strokes)
    assert counts["support", "A"] == counts["rail", "A"] == counts["rail", "guide"] == 1
    assert counts["hatch", "A"] >= 4
    assert counts["hatch", "guide"] > 20
    assert {s.element for s in strokes if s.style == "pin"} == {"A", "B", "C"}
    assert all(np.diff(s.points.imag) < 0 for s in strokes if s.style == "hatch")


@pytest.mark.parametrize(
    ("radius", "style"), [(0.3, "bracket-support"), (0.035, "bracket-support"), (0.02, "support")]
)
def test_a_support_stands_before_a_wheel_that_would_hide_it(radius: float, style: str) -> None:
    drawn = picture(["gear"], [(0, 0, 0)], [
        ("A", "joint", Pin(ORIGIN, BODY)),
        ("far", "force", Force(Place(0, 1.0, 0.0), 0.0, 0.0)),
        ("wheel", "joint", Wheel(BODY, radius, True)),
    ])  # fmt: skip
    strokes = lines_in_bodies(complete_picture(drawn))
    assert [s.style for s in strokes if s.style.endswith("support")] == [style]


@pytest.mark.parametrize(
    ("turn", "styles"), [(0.02, {"rail", "hatch"}), (0.5, {"support", "rail", "hatch", "pin"})]
)
def test_a_spring_that_swings_has_a_support_on_the_ground(turn: float, styles: set[str]) -> None:
    drawn = picture(["block"], [(1.0, 0.0, 0.0)], [("spring", "force", Spring(ORIGIN, BODY))])
    motion = np.array([[[0, 0, 0], [np.cos(a), np.sin(a), 0]] for a in (0.0, turn)])
    strokes = lines_in_bodies(replace(drawn, motion=motion))
    assert {s.style for s in strokes if s.body == 0} == styles
    assert [s.style for s in strokes if s.element == "spring" and s.body == 1] == ["pin"]


def test_a_mast_that_is_welded_at_its_origin_stands_on_its_wall() -> None:
    drawn = picture(["mast"], [(0.0, 0.0, 0.0)], [
        ("weld", "joint", Fixing(ORIGIN, BODY)),
        ("top", "joint", Mark(Place(1, 0.0, 2.0))),
    ])  # fmt: skip
    (wall,) = (s.points for s in lines_in_bodies(drawn) if s.style == "rail")
    assert np.diff(wall).imag == pytest.approx(0.0, abs=1e-12)


def test_a_pin_of_two_joints_at_one_place_is_drawn_once() -> None:
    pins = [(name, "joint", Pin(ORIGIN, BODY)) for name in "AB"]
    drawn = picture(["arm"], [(0.0, 0.0, 0.0)], pins)
    assert {s.element for s in lines_in_bodies(drawn) if s.style == "pin"} == {"A"}
    passing = replace(drawn.symbols[0], spans=((0.0, 1.0),))
    drawn = replace(drawn, symbols=(passing, drawn.symbols[1]))
    assert {s.element for s in lines_in_bodies(drawn) if s.style == "pin"} == {"A", "B"}


@pytest.mark.parametrize("later", [True, False])
def test_a_place_that_moves_in_its_body_is_shifted_beside_one_that_stays(later: bool) -> None:
    def drawn(x: float) -> Picture:
        marks = [Mark(Place(1, x, 0.0)), Mark(BODY)]
        own = [("own", "joint", mark) for mark in (reversed(marks) if later else marks)]
        return picture(["arm"], [(0.0, 0.0, 0.0)], own)

    assert drawn(1.5).shifts(drawn(1.0)) == {("own", 1): 0.5}


def test_a_joint_that_is_not_closed_shows_its_gap() -> None:
    assert [s for s in lines_between_bodies(slider_crank()) if s.style == "gap"] == []
    gaps = [s for s in lines_between_bodies(slider_crank(closed=False)) if s.style == "gap"]
    assert [s.element for s in gaps] == ["B", "C"]
    assert [abs(np.diff(s.points)) for s in gaps] == pytest.approx([0.4 * np.sqrt(2)] * 2)


def test_rods_belts_and_springs_move_with_their_bodies() -> None:
    drawn = picture(["a", "b"], [(1.0, 0.0, 0.0), (3.0, 0.0, 0.0)], [
        ("rod", "joint", Rod(BODY, Place(2, 0.0, 0.5))),
        ("belt", "joint", Belt(BODY, Place(2, 0.0, 0.0), 0.3, 0.4)),
        ("spring", "force", Spring(ORIGIN, BODY)),
    ])  # fmt: skip
    moved = replace(drawn, poses=drawn.poses + np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0]]))
    before, after = lines_between_bodies(drawn), lines_between_bodies(moved)
    assert [s.style for s in before] == ["rod", "belt", "spring"]
    for here, there in zip(before[:2], after[:2], strict=True):
        assert there.points - here.points == pytest.approx(1j * np.ones(len(here.points)))
    assert after[2].points[[0, -1]] == pytest.approx(np.array([0, 1 + 1j]))
