"""Pictures of machines in space: their solids, the plane of their view, stills and movies."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.drawing.annotations import acting_loads
from codegen.drawing.picture import SpacePicture, turned
from codegen.drawing.solids import Solid, half_sizes, solids
from codegen.drawing.space_shapes import Bulk, SpaceJoint
from codegen.drawing.space_strokes import arrows_in_space, strokes_in_space
from codegen.errors import InputError
from codegen.picture_at_start import declared_picture
from codegen.reading.model_file import read_model
from models.space.bricard import bricard
from models.space.heavy_top import heavy_top
from runtime import load
from runtime.show.pictures import exerted, moving_picture
from tests.space.machines import DOWN, X, Y, slider_crank
from tests.space.test_driver_arrows import arm


def drawn(model: Model) -> SpacePicture:
    picture = declared_picture(model)
    assert isinstance(picture, SpacePicture)
    return picture


def of(picture: SpacePicture, body: str) -> list[Solid]:
    """The solids of a body itself."""
    number = [one.name for one in picture.bodies].index(body)
    return [one for one in solids(picture) if one.body == number and not one.element]


def ends(solid: Solid) -> np.ndarray:
    """The ends of the axis of a cylinder, in its body."""
    return solid.center + np.outer([-1, 1], solid.matrix[:, 2])


@pytest.fixture(scope="module")
def result(workshop: Path) -> Any:
    return load(slider_crank(with_rod=True), folder=workshop).simulate(0.5, progress=False)


def test_a_rotation_is_that_of_euler_parameters() -> None:
    p = np.array([0.5, -0.1, 0.7, 0.5]) / np.linalg.norm([0.5, -0.1, 0.7, 0.5])
    e0, e = p[0], p[1:]
    skew = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    matrix = (2 * e0**2 - 1) * np.eye(3) + 2 * (np.outer(e, e) + e0 * skew)  # Haug, 9.3.13
    assert_allclose(turned(np.eye(3), p), matrix.T, atol=1e-15)


def test_bars_join_the_points_of_bodies() -> None:
    picture = drawn(slider_crank(with_rod=True))
    (rod,) = of(picture, "rod")
    assert rod.form == "cylinder"
    assert_allclose(sorted(ends(rod)[:, 0]), [-0.15, 0.15])
    assert_allclose(ends(rod)[:, 1:], 0.0, atol=1e-15)
    assert [one.form for one in of(picture, "slider")] == ["box"]
    forms = {one.element: one.form for one in solids(picture) if one.element}
    assert set(forms) == {"A", "B", "C", "D"}
    (pin,) = (one for one in solids(picture) if one.element == "A" and one.body == 1)
    along = turned(pin.matrix[:, 2] / np.linalg.norm(pin.matrix[:, 2]), picture.poses[1, 3:])
    assert_allclose(np.abs(along), X, atol=1e-12)


def test_a_body_of_three_points_is_a_star_about_its_centre() -> None:
    model = Model("star", space=True, gravity=DOWN)
    arm = model.body("arm", 1.0, (1.0, 1.0, 1.0))
    for k, at in enumerate([(1, 0, 0), (-1, 0.5, 0), (0, -1, 0.2)]):
        model.spherical(f"S{k}", model.ground, arm, at=at)
    model.scene("s", analysis="kinematics")
    bars = [one for one in of(drawn(model), "arm") if one.form == "cylinder"]
    assert len(bars) == 3
    assert all(np.abs(ends(bar)).min(axis=0).max() == 0.0 for bar in bars)


@pytest.mark.parametrize(
    ("inertia", "form"),
    [((0.1, 0.1, 0.1), "ball"), ((0.1, 0.2, 0.1), "cylinder"), ((0.1, 0.2, 0.25), "box"),
     ((0.2, 0.2, 0.3, 0.05, 0.0, 0.0), "box")],
)  # fmt: skip
def test_a_free_body_has_the_form_of_its_inertia(inertia: tuple[float, ...], form: str) -> None:
    model = Model("free", space=True)
    model.body("b", 2.0, inertia)
    model.scene("s")
    picture = drawn(model)
    assert form in {one.form for one in of(picture, "b")}
    ((_, bulk),) = picture.having(Bulk)
    (a, b, c), _ = half_sizes(bulk)
    moments = 2.0 / 3.0 * np.array([b**2 + c**2, a**2 + c**2, a**2 + b**2])  # of a box of 2 kg
    j = inertia if len(inertia) == 3 else (0.15, 0.25, 0.3)
    assert_allclose(sorted(moments), sorted(j), rtol=1e-12)


def test_a_ball_and_a_disc_have_the_radius_of_their_inertia() -> None:
    mass, radius, high = 3.0, 0.25, 0.04
    ball = 0.4 * mass * radius**2
    disc = mass * radius**2 / 2, mass * (3 * radius**2 + high**2) / 12
    for moments in ([ball] * 3, [disc[1], disc[0], disc[1]]):
        model = Model("round", space=True)
        model.body("b", mass, moments)
        for k, end in enumerate(
            model.body(f"end{s}", 1.0, [1.0] * 3, at=(s, 0, 0)) for s in (1, 5)
        ):
            model.spherical(f"S{k}", model.ground, end, at=end.place)  # far away: it is not capped
        model.scene("s")
        solid = of(drawn(model), "b")[0]
        lengths = np.linalg.norm(solid.matrix[:, :3], axis=0)
        assert_allclose(sorted(lengths)[-2:], radius, rtol=1e-9)
        if solid.form == "cylinder":
            assert_allclose(lengths[2], max(high / 2, 0.012 * drawn(model).size), rtol=1e-9)


def test_the_view_has_gravity_downward_and_axes_of_a_right_hand() -> None:
    for model in (slider_crank(with_rod=True), bricard(), heavy_top()):
        picture = drawn(model)
        assert_allclose(picture.view @ picture.view.T, np.eye(3), atol=1e-15)
        assert_allclose(np.linalg.det(picture.view), 1.0)
        assert picture.flat(picture.up).imag > 0.9 - 0.05
        assert abs(picture.flat(picture.up).real) < 1e-15
    assert tuple(drawn(bricard()).up) == Y


@pytest.mark.parametrize(
    ("view", "toward"), [("x", X), ("-y", np.negative(Y)), ("z", np.negative(DOWN))]
)
def test_a_still_looks_along_an_axis(result: Any, view: str, toward: Any) -> None:
    picture = replace(drawn(slider_crank(with_rod=True)), seen=view)
    assert_allclose(picture.view[2], np.divide(toward, np.linalg.norm(toward)), atol=1e-15)
    assert_allclose(np.cross(*picture.view[:2]), picture.view[2], atol=1e-15)
    widths = [result.draw(0.1, view=one).axes[0].get_xlim() for one in (view, "usual")]
    assert widths[0] != widths[1]


def test_the_plane_has_one_view() -> None:
    with pytest.raises(InputError, match="view= is there for machines in space alone"):
        read_model("slider_crank").model.draw(view="x")


def test_a_shaft_is_as_long_as_its_travel(result: Any) -> None:
    picture = moving_picture(result)
    assert isinstance(picture, SpacePicture)
    (rail,) = (one for one in solids(picture) if one.element == "D")
    x = ends(rail)[:, 0]
    reach = np.array([result.q("slider.x").min(), result.q("slider.x").max()])
    room = np.abs(np.sort(x) - reach)
    assert_allclose(room, room[0], rtol=1e-9)
    assert room[0] > 0


def test_the_line_of_a_bead_reaches_from_its_body_beyond_the_bead() -> None:
    model = Model("bead", space=True, gravity=DOWN)
    rod = model.body("rod", 1.0, (1.0, 1.0, 1.0))
    model.strut("S", rod, model.ground.at(0, 0, 0.6), axis=rod.along(0, 0, 1))
    model.scene("s", analysis="kinematics")
    picture = drawn(model)
    (line,) = (one for one in solids(picture) if one.element == "S" and one.body == 1
               and one.form == "cylinder")  # fmt: skip
    low, high = sorted(ends(line)[:, 2])
    assert low <= 0.0
    assert 0.6 < high < 0.7


def test_arrows_are_the_reactions_of_the_result(result: Any) -> None:
    picture = moving_picture(result)
    loads = {(one.element, one.style): one for one in acting_loads(picture, exerted(result))}
    force, torque = loads["A", "reaction"], loads["A", "torque"]
    for one, letter in ((force, "f"), (torque, "t")):
        wrench = np.column_stack([result.reaction("A", f"{letter}{c}") for c in "xyz"])
        assert_allclose(one.value, wrench, atol=1e-12)
    assert force.label == "A, ground on crank"
    assert_allclose(force.at, np.tile([0, 0.1, 0.12], (len(result.t), 1)), atol=1e-9)
    wrench = result.wrench("B", on="rod", at=(-0.15, 0, 0))
    assert_allclose(loads["B", "reaction"].value, wrench[:, :3], atol=1e-9)


def test_nearer_strokes_are_drawn_later() -> None:
    picture = drawn(bricard())
    bodies = [one.body for one in strokes_in_space(picture, solids(picture)) if one.style == "edge"]
    depth = picture.poses[:, :3] @ picture.view[2]
    assert bodies == sorted(bodies, key=lambda body: depth[body])


def test_the_text_of_a_torque_stands_by_the_tip_of_its_arrow_or_is_led_there(
    workshop: Path,
) -> None:
    result = load(arm(), folder=workshop).inverse_dynamics(0.5)
    drawing = result.draw(0.2, forces=True)
    (axes,) = drawing.axes
    picture = moving_picture(result, result.at(0.2)).first
    series = {name: now[0] for name, now in exerted(result.at(0.2)).items()}
    tips = {
        one.label: strokes[0].points[-1]
        for one, strokes in arrows_in_space(picture, acting_loads(picture, series), True)
    }
    points = axes.transData.inverted()
    pixel = np.ptp(points.transform([[0, 0], [1, 0]])[:, 0])
    leads = [complex(*line.get_xydata()[1]) for line in axes.lines]
    texts = [one for one in axes.texts if "N m" in one.get_text()]
    assert len(texts) > 3
    for text in texts:
        tip, box = tips[text.get_text().rpartition(":")[0]], text.get_window_extent()
        (left, low), (right, high) = points.transform([[box.x0, box.y0], [box.x1, box.y1]])
        away = np.hypot(
            max(left - tip.real, 0, tip.real - right), max(low - tip.imag, 0, tip.imag - high)
        )
        is_led = np.min(np.abs(np.array(leads) - tip)) < 1e-9
        assert away < 15 * pixel or is_led


def test_stills_have_names_arrows_and_what_is_apart(result: Any) -> None:
    texts = {one.get_text() for one in result.draw(0.2, forces=True, frames=True).axes[0].texts}
    assert {"x", "y", "z", "rod", "slider"} <= texts
    assert any(text.startswith("B, crank on rod: ") and text.endswith(" N") for text in texts)
    open_ = slider_crank(with_rod=True).draw(assembled=False)
    apart = [one.get_text() for one in open_.axes[0].texts if "apart" in one.get_text()]
    picture = declared_picture(slider_crank(with_rod=True), assembled=False)
    assert isinstance(picture, SpacePicture)
    (joint,) = (
        s.shape for s in picture.symbols if s.element == "B" and isinstance(s.shape, SpaceJoint)
    )
    distance = np.linalg.norm(picture.where(joint.i) - picture.where(joint.j))
    assert f"B: {distance:.4g} m apart" in apart
    with pytest.raises(InputError, match="dimensions= is there for machines in the plane alone"):
        result.draw(0.2, dimensions=True)


def test_movies_and_phases_are_written(result: Any, tmp_path: Path) -> None:
    for name in ("m.gif", "m.svg"):
        result.animate(
            tmp_path / name, span=(0.0, 0.1), **({"width": 200} if "gif" in name else {})
        )
        assert (tmp_path / name).stat().st_size > 1000
