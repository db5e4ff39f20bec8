"""Cams by their followers' motion: profiles, pressure angles, curvature, undercut, drawings."""

from math import hypot, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import (
    InputError,
    Model,
    ModelError,
    alpha,
    flat_faced_cam,
    fourier_series,
    motion_program,
    read_outline,
    roller_cam,
    write_path,
)
from codegen.reading.scene_selection import valid_scenes

BASE, ROLLER, OFFSET, LIFT = 0.03, 0.01, 0.006, 0.012
RISE, HIGH, FALL = np.radians([100.0, 40.0, 120.0])
MOVES = [(100, 12, "modified sine"), (40, 12), (120, 0, "modified sine"), (100, 0)]
LIFTS = motion_program(MOVES, units=("deg", "mm"))
AT = np.linspace(0.01, 2 * pi - 0.01, 97)


def lift(angle: float, order: int = 0) -> float:
    """The modified sine of the textbook by hand, with its derivatives by the angle."""
    begin, span, sign = (0.0, RISE, 1) if angle < RISE + HIGH else (RISE + HIGH, FALL, -1)
    x = min(max((angle - begin) / span, 0.0), 1.0)
    if x < 1 / 8 or x > 7 / 8:
        size, w, shift, first = -1 / 4, 4 * pi, 0.0, 0.0 if x < 0.5 else 4.0
    else:
        size, w, shift, first = -9 / 4, 4 * pi / 3, pi / 3, 2.0
    turned = w * x + shift + order * pi / 2
    value = size * w**order * np.sin(turned) + (first + pi * x, pi, 0.0)[order]
    rests = x in (0.0, 1.0) and order
    return 0.0 if rests else LIFT * sign * value / (4 + pi) / span**order + (
        LIFT if sign < 0 and not order else 0.0
    )  # fmt: skip


def by_hand(order: int = 0) -> np.ndarray:
    return np.array([lift(angle, order) for angle in AT])


def bodies() -> tuple[Model, Any, Any]:
    model = Model("cams")
    return model, model.body("cam", 1.0, 0.01), model.body("follower", 0.2, 0.01)


def test_lift_is_the_textbooks() -> None:
    for order in range(3):
        assert_allclose(LIFTS.values(AT, order), by_hand(order), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("clockwise", [False, True])
def test_pressure_angle_and_radius_of_an_offset_roller(clockwise: bool) -> None:
    """By the formulas of Norton for a cam that turns left, and mirrored."""
    _, cam, _ = bodies()
    profile = roller_cam(cam, LIFTS, BASE, ROLLER, offset=OFFSET, clockwise=clockwise)
    s, v, a = (by_hand(order) for order in range(3))
    way = -1 if clockwise else 1
    height = np.sqrt((BASE + ROLLER) ** 2 - OFFSET**2) + s
    assert_allclose(
        profile.pressure_angle(AT), np.arctan((way * v - OFFSET) / height), rtol=1e-11, atol=1e-15
    )
    slope = v - way * OFFSET
    bend = height**2 + 2 * slope**2 + way * OFFSET * slope - height * a
    pitch = (height**2 + slope**2) ** 1.5 / bend
    assert_allclose(profile.radius_of_curvature(AT, pitch=True), pitch, rtol=1e-11)
    assert_allclose(profile.radius_of_curvature(AT), pitch - ROLLER, rtol=1e-11)
    assert profile.undercut() == ""


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("kind", ["roller", "arm", "arm turned round", "flat face"])
def test_surface_has_the_distance_and_curvature_that_are_told(kind: str, clockwise: bool) -> None:
    """Points of the surface alone, by finite differences: radius, normal, and the follower."""
    _, cam, _ = bodies()
    pivot, length = np.array([-0.07, 0.02]), 0.06
    if kind == "flat face":
        profile = flat_faced_cam(cam, LIFTS, BASE, clockwise=clockwise)
    elif kind == "roller":
        profile = roller_cam(cam, LIFTS, BASE, ROLLER, OFFSET, clockwise=clockwise)
    else:
        swing = motion_program(
            [(*m[:1], m[1] / 0.06, *m[2:]) for m in MOVES], units=("deg", "mrad")
        )
        turned = kind != "arm"
        profile = roller_cam(
            cam, swing, BASE, ROLLER, clockwise=clockwise,
            arm=length, pivot=pivot, arm_clockwise=turned,
        )  # fmt: skip
    count = 7200
    z = profile.points(count) @ [1, 1j]
    at, step = np.arange(count) * 2 * pi / count, 2 * pi / count
    slope = (np.roll(z, -1) - np.roll(z, 1)) / (2 * step)
    bend = (np.roll(z, -1) - 2 * z + np.roll(z, 1)) / step**2
    curvature = (slope.conj() * bend).imag / np.abs(slope) ** 3 * (1 if clockwise else -1)
    told = profile.radius_of_curvature(at)
    far = np.ones(count, bool)  # from where pieces meet
    for angle in np.radians([0, 12.5, 87.5, 100, 140, 155, 245, 260]):
        far &= np.abs(np.angle(np.exp(1j * (at - angle)))) > 2 * step
    assert_allclose((told * curvature)[far], 1.0, rtol=2e-4)
    # in axes that do not turn the normal makes the pressure angle with the follower's way
    turn = np.exp((-1j if clockwise else 1j) * at)
    normal = (-1j if clockwise else 1j) * slope / np.abs(slope) * turn
    center = z * turn + (0.0 if kind == "flat face" else ROLLER) * normal
    way = np.full(count, 1j)
    if kind.startswith("arm"):
        arm = center - pivot @ [1, 1j]
        assert_allclose(np.abs(arm), length, rtol=1e-6)
        way = arm / length * (-1j if kind == "arm turned round" else 1j)
        assert np.abs(center).min() == pytest.approx(BASE + ROLLER, rel=1e-6)
    elif kind == "roller":
        assert_allclose(center.real, OFFSET, rtol=1e-5)
        due = np.sqrt((BASE + ROLLER) ** 2 - OFFSET**2) + LIFTS.values(at)
        assert_allclose(center.imag, due, rtol=1e-6)
    else:
        assert_allclose(center.imag, BASE + LIFTS.values(at), rtol=1e-6)
    assert_allclose(profile.pressure_angle(at), np.angle(normal / way), atol=2e-5)


def test_flat_face_has_the_radius_of_the_textbook() -> None:
    _, cam, _ = bodies()
    profile = flat_faced_cam(cam, LIFTS, BASE)
    assert_allclose(profile.radius_of_curvature(AT), BASE + by_hand() + by_hand(2), rtol=1e-11)


def test_lift_may_be_any_function_of_alpha() -> None:
    _, cam, _ = bodies()
    profile = flat_faced_cam(cam, fourier_series(alpha, 0.004, [-0.004]), BASE)
    assert_allclose(profile.radius_of_curvature(AT), BASE + 0.004)  # a circle


def test_undercut_is_named() -> None:
    """A roller that is larger than the radius of the pitch curve, a face on a lift too steep."""
    model, cam, follower = bodies()
    steep = motion_program([(45, 24, "cycloid"), (45, 0, "cycloid"), (270, 0)], units=("deg", "mm"))
    at = np.linspace(0, 2 * pi, 1441)
    size = 2 * ROLLER
    roller = roller_cam(cam, steep, BASE, size)
    pitch = roller.radius_of_curvature(at, pitch=True)
    where = np.argmin(np.where(pitch > 0, pitch, np.inf))
    assert 0 < pitch[where] < size
    radius = f"{pitch[where] - size:.3g}"
    text = f"undercut at its angle {np.degrees(at[where]):.4g}°, where the radius of curvature of "
    assert text in roller.undercut()
    assert f"its surface is {radius} m; enlarge the base circle" in roller.undercut()
    assert roller_cam(cam, steep, BASE, ROLLER).undercut() == ""
    assert roller_cam(cam, steep, 3 * BASE, size).undercut() == ""
    face = flat_faced_cam(cam, steep, BASE)
    assert "undercut" in face.undercut()
    model.cam_follower("lift", roller, follower.circle(size))
    model.cam_flat_follower("push", face, follower.at(0, 0))
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    for name in ("lift", "push"):
        assert f"curve of '{name}' on body 'cam': the cam is undercut at its ang" in str(
            caught.value
        )


def test_parameters_of_a_cam_take_numbers() -> None:
    model, cam, _ = bodies()
    base = model.parameter("base", BASE, unit="m", sign="positive")
    profile = roller_cam(cam, LIFTS, base, ROLLER, OFFSET)
    fixed = roller_cam(cam, LIFTS, BASE, ROLLER, OFFSET)
    numbers = {base: BASE}
    assert_allclose(profile.pressure_angle(AT, numbers), fixed.pressure_angle(AT), rtol=1e-12)
    assert_allclose(profile.points(90, {"base": BASE}), fixed.points(90), rtol=1e-12, atol=1e-17)
    with pytest.raises(ModelError, match=r"a Curve of Body\('cam'\) depends on base; give p"):
        profile.undercut()


DEGREES = motion_program([(180, 5, "cycloid"), (180, 0, "cycloid")], units=("deg", "deg"))
SECONDS = motion_program([(1, 5, "cycloid"), (1, 0, "cycloid")], units=("s", "mm"))


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        ({"offset": 0.05}, ["reaches no base circle of this radius with this offset or arm"]),
        ({"base_radius": -0.03}, ["base_radius is -0.03; give a length that is more than 0"]),
        ({"base_radius": 0}, ["base_radius is 0; give a length"]),
        ({"roller_radius": "-1 mm"}, ["roller_radius is '-1 mm'; give a length"]),
        ({"base_radius": "3 kg"}, ["base_radius: 3 kilogram has the dimension"]),
        ({"lift": DEGREES}, ["lift is in rad over rad; give m over an angle"]),
        ({"lift": SECONDS}, ["lift is in m over s; give m over an angle"]),
        ({"arm": 0.06, "pivot": (0.07, 0)}, ["lift is in m over rad; give rad over an angle"]),
        (
            {"lift": DEGREES, "arm": 0.06, "offset": 0.02, "roller_radius": -1},
            [
                "roller_radius is -1",
                "pivot: None is not 2 values",
                "offset= is of a roller that sl",
            ],
        ),
        ({"lift": DEGREES, "pivot": (0.07, 0)}, ["arm is missing; give it in m"]),
        ({"lift": DEGREES, "arm": 0.01, "pivot": (0.09, 0)}, ["reaches no base circle"]),
        ({"lift": DEGREES, "arm": 0, "pivot": (0.09, 0)}, ["reaches no base circle"]),
    ],
)
def test_cams_that_cannot_be_are_refused(words: dict[str, Any], messages: list[str]) -> None:
    _, cam, _ = bodies()
    given = {"lift": LIFTS, "base_radius": BASE, "roller_radius": ROLLER, **words}
    with pytest.raises(ModelError) as caught:
        roller_cam(cam, **given)
    for message in messages:
        assert message in str(caught.value)


def test_a_cam_that_parameters_make_impossible_has_no_points() -> None:
    model, cam, _ = bodies()
    base = model.parameter("base", BASE, unit="m")
    profile = roller_cam(cam, LIFTS, base, ROLLER, OFFSET)
    for method in (profile.points, profile.undercut):
        with pytest.raises(ModelError, match="has no finite values: the follower does not reach"):
            method(parameters={"base": -0.009})


def test_points_are_in_the_axes_of_the_drawing() -> None:
    model = Model("plates")
    plate = [(0, 0), (0.1, 0), (0.1, 0.05), (0, 0.05)]
    cam = model.body("cam", outline=plate, thickness=0.01, density=7850)
    _, bare, _ = bodies()
    points = (roller_cam(one, LIFTS, BASE, ROLLER).points(60) for one in (cam, bare))
    assert_allclose(*points, rtol=1e-12, atol=1e-16)


def test_drawings_are_read_back(tmp_path: Path) -> None:
    """The same polygon, point by point; that of an SVG file from its upper left corner on."""
    _, cam, _ = bodies()
    points = roller_cam(cam, LIFTS, BASE, ROLLER, OFFSET, clockwise=True).points()
    for kind in ("dxf", "svg"):
        outline = read_outline(write_path(tmp_path / f"cam.{kind}", points, closed=True))
        read = np.array(outline.vertices, float)
        if kind == "svg":
            read += [points[:, 0].min(), points[:, 1].max()]
        assert len(read) == len(points)
        first = np.argmin(np.hypot(*(read - points[0]).T))
        read = np.roll(read, -first, axis=0)
        assert_allclose(read, points, rtol=0, atol=1e-9 * hypot(BASE, LIFT))


def test_open_paths_and_mistakes(tmp_path: Path) -> None:
    path = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.05]])
    text = write_path(tmp_path / "path.svg", path).read_text(encoding="utf-8")
    assert 'd="M 0.0,50.0 L 100.0,50.0 L 100.0,0.0" fill' in text
    assert 'width="100.0mm" height="50.0mm" viewBox="0 0 100.0 50.0"' in text
    write_path(tmp_path / "path.dxf", path)
    with pytest.raises(ModelError, match=r"path\.dxf has a line or contour that is open"):
        read_outline(tmp_path / "path.dxf")
    straight = write_path(tmp_path / "line.svg", path[:2]).read_text(encoding="utf-8")
    assert 'viewBox="0 0 100.0 0.3"' in straight  # an empty box is not drawn
    with pytest.raises(ModelError, match=r"path\.png: a path is written into a file that"):
        write_path(tmp_path / "path.png", path)
    with pytest.raises(ModelError, match=r"path\.svg: a path is an array of finite x and y"):
        write_path(tmp_path / "path.svg", [[0.0, np.nan]])
    for kind in ("svg", "dxf"):
        with pytest.raises(InputError, match="cannot write"):
            write_path(tmp_path / "absent" / f"path.{kind}", path)


def test_a_cam_is_a_body() -> None:
    for cam, make in (
        ("cam", lambda one: roller_cam(one, LIFTS, BASE, ROLLER)),
        (None, lambda one: flat_faced_cam(one, LIFTS, BASE)),
    ):
        with pytest.raises(ModelError, match=f"_cam: cam is {cam!r}; give a body"):
            make(cam)
