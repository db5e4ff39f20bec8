"""Outlines that follow from the places where elements hold bodies, and the typical length."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.drawing.body_outlines import derived_outlines
from codegen.drawing.guides import guide_of, rack_ends, slot_ends
from codegen.drawing.picture import BAR, BLOCK, BOB, PARTICLE, BodyPicture, Picture
from codegen.drawing.plane_geometry import area, contains, pairs
from codegen.drawing.shapes import (
    Course,
    Fixing,
    Mark,
    Pin,
    Place,
    Profile,
    Rack,
    Slide,
    Slot,
    Spring,
    Wheel,
)
from tests.codegen.drawing.hand_drawn_pictures import picture, slider_crank

O = Place(0, 0.0, 0.0)  # noqa: E741 (the origin)


def pinned(*points: tuple[float, float]) -> Picture:
    """A body with pins to the ground."""
    return picture(["plate"], [(0.0, 0.0, 0.0)], [
        (f"P{k}", "joint", Pin(Place(0, *at), Place(1, *at))) for k, at in enumerate(points)
    ])  # fmt: skip


def test_two_places_are_a_bar_with_round_ends_and_a_slider_a_block() -> None:
    drawn = slider_crank()
    ((bar,), (block,)) = (drawn.bodies[body].outlines for body in (1, 3))
    w = BAR * drawn.size
    assert pairs(bar).min(axis=0) == pytest.approx([-w, -w], rel=0.01)
    assert pairs(bar).max(axis=0) == pytest.approx([2 + w, w], rel=0.01)
    assert np.ptp(pairs(block), axis=0) == pytest.approx(2 * drawn.size * np.array(BLOCK))


def test_a_guide_that_is_declared_on_the_slider_gives_the_same_block() -> None:
    turned = picture(["slider"], [(1.0, 1.0, np.pi / 2)], [
        ("guide", "joint", Slide(Place(1, 0.0, 0.0), Place(0, 0.0, 1.0), 0.0, -1.0)),
        ("far", "joint", Mark(Place(0, 4.0, 3.0))),
    ])  # fmt: skip
    (block,) = turned.bodies[1].outlines
    assert np.ptp(pairs(block), axis=0) == pytest.approx(2 * turned.size * np.array(BLOCK)[::-1])


def test_three_places_are_a_plate_that_holds_them_and_a_centre_of_mass_that_is_near() -> None:
    (plate,) = pinned((-1.0, 0.0), (1.0, 0.0), (0.2, 1.5)).bodies[1].outlines
    assert all(contains(plate, place) for place in (-1, 1, 0.2 + 1.5j, 0))
    far = pinned((9.0, 0.0), (11.0, 0.0), (10.0, 1.5))
    assert far.bodies[1].outlines[0].real.min() > 8.0
    assert far.size == pytest.approx(np.hypot(2.0, 1.5))


def test_a_pendulum_is_a_bar_and_a_disc() -> None:
    drawn = picture(["bob"], [(0.0, -1.0, -np.pi / 2)], [
        ("hinge", "joint", Pin(O, Place(1, -1.0, 0.0))),
    ])  # fmt: skip
    bar, disc = drawn.bodies[1].outlines
    assert bar.real.min() < -1.0
    assert abs(disc) == pytest.approx(BOB * drawn.size)


def test_a_body_that_nothing_holds_is_a_small_disc() -> None:
    drawn = picture(["ball", "other"], [(0.0, 3.0, 0.0), (4.0, 0.0, 0.0)], [])
    assert drawn.size == 5.0
    assert abs(drawn.bodies[1].outlines[0]) == pytest.approx(PARTICLE * 5.0)
    assert picture(["ball"], [(2.0, 3.0, 0.0)], []).size == 1.0  # all is at one place


@pytest.mark.parametrize("toothed", [False, True])
def test_a_wheel_without_teeth_is_a_disc_and_one_with_teeth_is_none(toothed: bool) -> None:
    drawn = picture(["wheel"], [(0.0, 0.0, 0.0)], [
        ("A", "joint", Pin(O, Place(1, 0.0, 0.0))),
        ("belt", "joint", Wheel(Place(1, 0.0, 0.0), 0.5, toothed)),
    ])  # fmt: skip
    areas = [area(polygon) for polygon in drawn.bodies[1].outlines]
    assert areas == pytest.approx([] if toothed else [np.pi / 4], rel=0.01)
    assert drawn.size == pytest.approx(np.sqrt(2))


def rocker(tilt: float, turn: float) -> Picture:
    """A slot on a body that turns about the origin, and the pin of a crank in it."""
    return picture(["rocker", "crank"], [(0.0, 0.0, tilt), (0.0, 1.0, turn)], [
        ("A", "joint", Pin(O, Place(1, 0.0, 0.0))),
        ("B", "joint", Pin(Place(0, 0.0, 1.0), Place(2, 0.0, 0.0))),
        ("slot", "joint", Slot(Place(1, 0.0, 0.0), Place(2, 0.5, 0.0), 1.0, 0.0)),
    ])  # fmt: skip


def test_a_slot_has_a_bar_that_is_as_long_as_the_motion_needs() -> None:
    drawn = rocker(np.pi / 2, 0.0)
    motion = np.repeat(drawn.poses[None], 8, axis=0)
    motion[:, 2, 2] = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    motion[:, 1, 2] = np.arctan2(1 + 0.5 * np.sin(motion[:, 2, 2]), 0.5 * np.cos(motion[:, 2, 2]))
    bodies = tuple(BodyPicture(body.name, body.fixed) for body in drawn.bodies)
    bar = np.concatenate(derived_outlines(replace(drawn, bodies=bodies, motion=motion))[1].outlines)
    assert bar.real.min() < 0.0
    assert 1.5 < bar.real.max() < 1.5 + 0.1 * drawn.size


def test_a_slot_without_a_motion_is_as_long_as_its_crank_needs() -> None:
    drawn = rocker(1.0, 0.6)
    slot = guide_of(drawn, drawn.symbols[2].shape)
    room = 0.02 * drawn.size
    assert slot_ends(drawn, slot).real == pytest.approx([0.5 - room, 1.5 + room])


def test_a_slot_without_a_motion_ends_within_an_outline_that_is_given() -> None:
    drawn = picture(["block", "pin"], [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)], [
        ("slot", "joint", Slot(Place(1, 0.0, 0.0), Place(2, 0.0, 0.0), 1.0, 0.0)),
        ("far", "joint", Mark(Place(0, 2.0, 0.0))),
    ])  # fmt: skip
    slot = guide_of(drawn, drawn.symbols[0].shape)
    corners = np.array([-0.2 - 0.2j, 0.3 - 0.2j, 0.3 + 0.2j, -0.2 + 0.2j])
    given = BodyPicture("block", outlines=(corners,), is_derived=False)
    bodies = (drawn.bodies[0], given, drawn.bodies[2])
    first, last = slot_ends(replace(drawn, bodies=bodies), slot).real
    assert -0.2 < first < -0.1
    assert 0.2 < last < 0.3


def test_a_rack_without_a_motion_has_room_for_its_pinion() -> None:
    drawn = picture(["pinion", "rack"], [(0.0, 1.0, 0.0), (0.0, 0.0, 0.0)], [
        ("mesh", "joint", Wheel(Place(1, 0.0, 0.0), 1.0, True)),
        ("mesh", "joint", Rack(Place(2, 0.0, 0.0), 1.0, 0.0, True)),
    ])  # fmt: skip
    assert rack_ends(drawn, drawn.symbols[1].shape) == pytest.approx(np.array([-2.2, 2.2]))


def test_blocks_beside_each_other_do_not_overlap() -> None:
    drawn = picture(["one", "other"], [(0.0, 0.0, 0.0), (0.12, 0.0, 0.0)], [
        *((f"guide_{k}", "joint", Slide(O, Place(k, 0.0, 0.0), 1.0, 0.0)) for k in (1, 2)),
        ("far", "joint", Mark(Place(0, 2.0, 0.0))),
    ])  # fmt: skip
    (one,), (other,) = (body.outlines for body in drawn.bodies[1:])
    assert one.real.max() < other.real.min() + 0.12


def test_a_closed_profile_is_the_outline() -> None:
    angles = np.linspace(0, 2 * np.pi, 60)
    curve = Course(1, 0.3 * np.cos(angles) + 0.2j * np.sin(angles))
    drawn = picture(["cam", "face"], [(0.0, 0.0, 0.0), (0.0, 0.2, 0.0)], [
        ("A", "joint", Pin(O, Place(1, 0.0, 0.0))),
        ("lift", "joint", Profile(curve)),
        ("lift", "joint", Rack(Place(2, 0.0, 0.0), 1.0, 0.0)),
        ("guide", "joint", Slide(O, Place(2, 0.0, 0.4), 0.0, 1.0)),
    ])  # fmt: skip
    assert any(len(polygon) == 60 for polygon in drawn.bodies[1].outlines)
    face = np.concatenate(drawn.bodies[2].outlines)
    assert face.imag.min() == pytest.approx(0.0, abs=1e-12)  # it stands on the cam


def test_given_outlines_stay() -> None:
    given = BodyPicture("hook", outlines=(np.array([0, 1, 1j]),), is_derived=False)
    drawn = slider_crank()
    changed = replace(drawn, bodies=(drawn.bodies[0], given, *drawn.bodies[2:]))
    assert derived_outlines(changed)[1] is given


def test_springs_and_welds_hold_bodies_as_well() -> None:
    drawn = picture(["arm"], [(0.0, 0.0, 0.0)], [
        ("clamp", "joint", Fixing(O, Place(1, 0.0, 0.0))),
        ("spring", "force", Spring(Place(0, 2.0, 1.0), Place(1, 2.0, 0.0))),
    ])  # fmt: skip
    (bar,) = drawn.bodies[1].outlines
    assert bar.real.max() == pytest.approx(2 + BAR * drawn.size)
