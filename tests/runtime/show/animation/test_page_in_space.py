"""The page of a machine in space: its data, solids in WebGL, views, a pick and keys."""

import hashlib
import json
import re
from collections.abc import Iterator
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model, disc, extruded
from models.space.heavy_top import heavy_top
from runtime import Result, animate, load
from runtime.show.animation import animation, page_data, page_text
from runtime.show.animation.animation import TURN, animated, turns
from runtime.show.pictures import exerted, moving_picture
from tests.runtime.show.animation.conftest import WIDE
from tests.space.machines import slider_crank

THREE = Path(page_text.__file__).parent / "three"
SHA256 = "e5b8a32f3c0ad55e1fcb3414a5f551de9656db4c867604185ca2fe9259fbd91a"
_WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Result:
    folder = tmp_path_factory.mktemp("crank")
    return load(slider_crank(with_rod=True), folder=folder).simulate(1.0, progress=False)


@pytest.fixture(scope="module")
def path(run: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("page") / "crank.html"
    run.animate(file=file)
    return file


@pytest.fixture(scope="module")
def page(browser: Any, path: Path) -> Iterator[Any]:
    """The page in a browser that draws by software, without an error or a request."""
    chromium = browser.browser_type.launch(
        executable_path=_executable(), args=["--no-sandbox", *_WEBGL]
    )
    wrong: list[str] = []
    shown = chromium.new_context(viewport=WIDE).new_page()
    shown.on("request", lambda request: request.url != path.as_uri() and wrong.append(request.url))
    shown.on("pageerror", lambda error: wrong.append(str(error)))
    shown.on("console", lambda m: m.type == "error" and wrong.append(m.text))
    shown.goto(path.as_uri())
    shown.wait_for_selector(".player[data-ready=all]")
    yield shown
    chromium.close()
    assert not [one for one in wrong if not one.startswith(("data:", "blob:"))]


def _executable() -> str:
    import shutil

    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))))
    return str(found)


def test_three_js_is_the_bundle_that_its_text_describes() -> None:
    bundle = (THREE / "three.js").read_bytes()
    assert hashlib.sha256(bundle).hexdigest() == SHA256
    assert SHA256 in (THREE / "README.md").read_text()
    assert "three.js authors" in (THREE / "LICENSE").read_text()
    used = {
        name
        for file in (THREE.parent / "page" / "space").glob("*.js")
        for name in re.findall(r"globalThis\.THREE\.(\w+)", file.read_text())
    }
    listed = re.findall(r"export \{(.*?)\}", (THREE / "entry.js").read_text(), re.DOTALL)
    assert {name.strip() for name in ",".join(listed).split(",") if name.strip()} == used


def test_pages_in_the_plane_have_nothing_of_space(compressor: Result) -> None:
    html = compressor.animate().html
    assert "three" not in html.replace(page_text.library(), "").lower()
    assert page_text.script() in html
    assert page_text.script(in_space=True) not in html


def test_a_page_is_small(path: Path) -> None:
    assert path.stat().st_size < 1.5e6


def test_no_body_turns_far_between_instants(tmp_path: Path) -> None:
    result = load(heavy_top(), folder=tmp_path).simulate(2.0, 601, progress=False)
    shown = animated(result)
    assert turns(result).max() > TURN  # at 150 rad/s
    assert turns(shown).max() < 1.01 * TURN
    p = shown.samples.q[:, 3:]
    angle = 2 * np.arccos(np.clip(np.abs((p[1:] * p[:-1]).sum(axis=1)), 0, 1))
    np.testing.assert_allclose(turns(shown), angle, rtol=0.01, atol=1e-6)


def test_pages_of_plane_and_space_are_apart(run: Result, compressor: Result) -> None:
    with pytest.raises(Exception, match="machines in the plane and in space are seen in different"):
        animate([run, compressor])


def test_poses_and_places_are_those_of_the_result(page: Any, run: Result) -> None:
    for t in (0.123, 0.876):
        page.evaluate(f"player.clock.seek({t})")
        at = run.at([t])
        seen = page.evaluate("player.scenes[0].poses.slice(1)")
        names = page.evaluate("player.scenes[0].bodies.slice(1).map(({ name }) => name)")
        for name, pose in zip(names, seen, strict=True):
            want = [at.q(f"{name}.{c}")[0] for c in "xyz"]
            np.testing.assert_allclose([pose[c] for c in "xyz"], want, atol=2e-5)
        pin = page.evaluate("player.scenes[0].place({ body: 1, x: 0, y: 0.08, z: 0 })")
        want = at.rotation("crank")[0] @ [0, 0.08, 0] + [0, 0.1, 0.12]
        np.testing.assert_allclose([pin[c] for c in "xyz"], want, atol=2e-5)


def test_the_picture_has_the_solids_of_the_machine(page: Any) -> None:
    meshes = page.evaluate(
        "player.stages[0].solids.meshes.map(({ userData }) => userData.element || "
        "player.scenes[0].bodies[userData.body].name)"
    )
    assert set(meshes) == {"A", "B", "C", "D", "crank", "rod", "slider"}
    painted = page.evaluate("""() => {
      const { renderer, root, view } = player.stages[0];
      renderer.render(root, view);
      const gl = renderer.getContext();
      const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
      const bytes = new Uint8Array(4 * w * h);
      gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      let count = 0;
      for (let k = 3; k < bytes.length; k += 4) count += bytes[k] > 0;
      return count / (w * h);
    }""")
    assert 0.01 < painted < 0.5


def screen(page: Any, place: str) -> tuple[float, float]:
    """Where a place of the scene is in the window, px."""
    at = page.evaluate(f"player.camera.toScreen(player.scenes[0].place({place}))")
    box = page.locator("svg.stage").bounding_box()
    return box["x"] + at["x"], box["y"] + at["y"]


def test_a_click_shows_a_body_and_a_joint(page: Any) -> None:
    page.evaluate("player.clock.seek(0.3)")
    page.mouse.click(*screen(page, "{ body: 3, x: 0.03, y: 0, z: 0 }"))
    assert page.locator("#element").input_value() == "rod"
    assert page.evaluate("player.stages[0].chosen") == "rod"
    page.mouse.click(*screen(page, "{ body: 1, x: 0, y: 0.08, z: 0 }"))
    assert page.locator("#element").input_value() == "B"
    titles = [one.text_content() for one in page.locator(".panel select option:checked").all()]
    assert any("B: reaction" in str(title) for title in titles)


def axes(page: Any) -> np.ndarray:
    return np.array(page.evaluate("player.camera.axes"))


def test_keys_and_buttons_turn_the_view(page: Any) -> None:
    for key, toward in (("x", [1, 0, 0]), ("Y", [0, -1, 0]), ("z", [0, 0, 1])):
        page.keyboard.press(f"Shift+{key}" if key.isupper() else key)
        np.testing.assert_allclose(axes(page)[2], toward, atol=1e-12)
        np.testing.assert_allclose(axes(page) @ axes(page).T, np.eye(3), atol=1e-12)
    page.locator('[data-action="alongX"]').click()
    np.testing.assert_allclose(axes(page)[:2], [[0, 1, 0], [0, 0, 1]], atol=1e-12)
    page.keyboard.press("v")
    usual = axes(page)
    assert usual[2].min() < 0 < usual[2, 2] < 1
    page.keyboard.press("6")
    assert np.linalg.norm(axes(page) - usual) > 0.1
    page.keyboard.press("v")
    np.testing.assert_allclose(axes(page), usual)


def test_a_drag_turns_with_shift_moves_and_the_wheel_zooms(page: Any) -> None:
    page.keyboard.press("v")
    box = page.locator("svg.stage").bounding_box()
    x, y = box["x"] + 0.2 * box["width"], box["y"] + 0.8 * box["height"]
    before, scale = axes(page), page.evaluate("player.camera.scale")

    def drag() -> None:
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y + 20, steps=4)
        page.mouse.up()

    drag()
    turned = axes(page)
    assert np.linalg.norm(turned - before) > 0.2
    assert page.evaluate("player.camera.scale") == scale
    page.keyboard.down("Shift")
    place = page.evaluate("player.camera.x")
    drag()
    page.keyboard.up("Shift")
    np.testing.assert_allclose(axes(page), turned)
    assert page.evaluate("player.camera.x") > place + 40
    page.mouse.wheel(0, -200)
    page.wait_for_function(f"player.camera.scale > {1.2 * scale}")
    page.keyboard.press("v")


def test_arrows_point_as_the_reaction_is_seen(page: Any, run: Result) -> None:
    page.evaluate("player.clock.seek(0.25)")
    page.keyboard.press("v")
    arrow = page.locator('.arrows g[data-element="B"] path.reaction')
    way = [float(x) for x in re.findall(r"[-\d.]+", str(arrow.get_attribute("d")))[:4]]
    force = run.at([0.25]).wrench("B", on="rod", at=(-0.15, 0, 0))[0, :3]
    seen = axes(page)[:2] @ force
    drawn = np.array([way[2] - way[0], way[1] - way[3]])
    np.testing.assert_allclose(
        drawn / np.linalg.norm(drawn), seen / np.linalg.norm(seen), atol=0.02
    )
    text = str(page.locator('.arrows g[data-element="B"] text.reaction').text_content())
    told = re.fullmatch(r"B, crank on rod: ([\d.]+) N", text)
    assert told
    assert float(told[1]) == pytest.approx(np.linalg.norm(force), rel=1e-3)


def test_a_reader_hears_where_bodies_are(page: Any, run: Result) -> None:
    page.evaluate("player.clock.seek(0)")
    page.keyboard.press("i")
    text = str(page.locator("#state").text_content())
    turned = run.axis_angle("crank")
    assert "slider (z 0.000 m, turned about" in text
    assert ") at x 0.2" in text
    assert f"angle {abs(turned[1][0]):.4g} rad" in text


def test_both_themes_have_their_colours(page: Any) -> None:
    rod = "player.stages[0].solids.meshes.find((one) => !one.userData.element)"
    color = f"{rod}.material.color.getHexString()"
    light = page.evaluate(color)
    page.keyboard.press("t")
    page.wait_for_function(f"{color} !== {json.dumps(light)}")
    page.keyboard.press("t")
    page.wait_for_function(f"{color} === {json.dumps(light)}")


def test_without_a_card_motion_has_fewer_pixels_and_rest_more(page: Any) -> None:
    """This browser draws by software."""
    ratio = "player.stages[0].renderer.getPixelRatio()"
    size = "player.stages[0].renderer.domElement.width / player.camera.width"
    page.evaluate("player.clock.stopAt(0.1)")
    page.wait_for_function(f"{ratio} === 2 && Math.abs({size} - 2) < 0.01")
    page.evaluate("player.clock.play()")
    page.wait_for_function(f"{ratio} === 0.5 && Math.abs({size} - 0.5) < 0.01")
    page.evaluate("player.clock.pause()")
    page.wait_for_function(f"{ratio} === 2")


def test_a_body_has_the_form_that_is_given(page: Any, tmp_path: Path) -> None:
    model = Model("flywheel", space=True, gravity=(0, 0, -9.81))
    rim = disc(0.4).with_holes(disc(0.2))
    form = extruded(rim, 0.05, axes=((0, 1, 0), (0, 0, 1)))
    wheel = model.body("wheel", 2.0, (0.2, 0.1, 0.1), draw=form)
    model.revolute("axle", model.ground, wheel, at=(0, 0, 0), axis=(1, 0, 0))
    model.scene("turn", ["gravity"], start={"wheel.omega_x": 3.0})
    run = load(model, folder=tmp_path).simulate(0.1, progress=False)
    run.animate(file=tmp_path / "wheel.html")
    shown = page.context.new_page()
    shown.goto((tmp_path / "wheel.html").as_uri())
    shown.wait_for_selector(".player[data-ready=all]")
    own = "player.stages[0].solids.meshes.find((one) => !one.userData.element)"
    count = shown.evaluate(f"{own}.geometry.getAttribute('position').count")
    assert count == 3 * len(form.triangles)
    shown.evaluate(f"{own}.geometry.computeBoundingBox()")
    high = shown.evaluate(f"{own}.geometry.boundingBox.max")
    np.testing.assert_allclose([high[c] for c in "xyz"], [0.025, 0.4, 0.4], atol=1e-5)
    shown.keyboard.press("x")
    shown.mouse.click(*screen(shown, "{ body: 1, x: 0, y: 0.3, z: 0 }"))
    assert shown.locator("#element").input_value() == "wheel"
    shown.mouse.click(*screen(shown, "{ body: 1, x: 0, y: 0.12, z: 0 }"))  # through the hole
    assert shown.locator("#element").input_value() == "wheel"  # still
    shown.close()


def test_motors_have_arrows_planes_are_sheer_and_open_reactions_are_noted(
    page: Any, tmp_path: Path
) -> None:
    model = Model("stool", space=True, gravity=(0, 0, -9.81))
    stool = model.body("stool", 4.0, (0.1, 0.1, 0.15), at=(0, 0, 0.4))
    for k, (x, y) in enumerate([(0.3, 0.3), (-0.3, 0.3), (-0.3, -0.3), (0.3, -0.3)], 1):
        model.point_in_plane(f"foot_{k}", model.ground, stool.at(x, y, -0.4), axis=(0, 0, 1))
    arm = model.body("arm", 2.0, (0.1, 0.1, 0.1), at=(0.5, 0, 0.6))
    hinge = model.revolute("hinge", stool, arm, at=(0.2, 0, 0.6), axis=(0, 1, 0))
    model.rotation_driver("motor", hinge, 0.3)
    model.point_driver("along", stool, "x", 0.0)
    model.point_driver("across", stool, "y", 0.0)
    model.driver("turn", stool.e3, 0.0)
    model.scene("s", ["gravity"], ["motor", "along", "across", "turn"])
    run = load(model, folder=tmp_path).inverse_dynamics(0.2)
    assert run.not_unique == ("foot_1", "foot_2", "foot_3", "foot_4")
    run.animate(file=tmp_path / "stool.html")
    shown = page.context.new_page()
    shown.goto((tmp_path / "stool.html").as_uri())
    shown.wait_for_selector(".player[data-ready=all]")
    note = str(shown.locator("figcaption").text_content())
    feet = ", ".join(run.not_unique)
    assert note == f"Reactions of {feet} are not unique; one choice of them is given."
    looks = shown.evaluate(
        "player.stages[0].solids.meshes.map(({ material, userData }) => "
        "[userData.element ?? '', material.transparent, material.opacity])"
    )
    sheer = [(element, opacity) for element, transparent, opacity in looks if transparent]
    assert sheer == [(foot, pytest.approx(0.35)) for foot in run.not_unique]
    assert {opacity for _, transparent, opacity in looks if not transparent} == {1}
    arrow = shown.locator('.arrows g[data-element="motor"]')
    told = str(arrow.locator("text.torque").text_content())
    torque = run.reaction("motor", "torque")[0]
    assert torque == pytest.approx(-2.0 * 9.81 * 0.3 * np.cos(0.3))  # turns the arm up, about -y
    assert told == f"motor on arm: {-torque:.3f} N m"
    numbers = str(arrow.locator("path.torque").get_attribute("d"))
    x0, y0, x1, y1 = [float(x) for x in re.findall(r"[-\d.]+", numbers)[:4]]
    foot = shown.evaluate("player.camera.toScreen({ x: 0.2, y: 0, z: 0.6 })")
    np.testing.assert_allclose([x0, y0], [foot["x"], foot["y"]], atol=0.01)
    seen = axes(shown)[:2] @ [0, -1, 0]
    drawn = np.array([x1 - x0, y0 - y1])
    np.testing.assert_allclose(drawn / np.hypot(*drawn), seen / np.hypot(*seen), atol=0.02)
    shown.keyboard.press("Shift+Z")  # from below, with the planes before the legs
    assert axes(shown)[2, 2] == pytest.approx(-1.0)
    shown.mouse.click(*screen(shown, "{ body: 1, x: 0.24, y: 0.24, z: -0.32 }"))
    assert shown.locator("#element").input_value() == "stool"
    shown.close()


def test_an_array_that_comes_twice_stands_once() -> None:
    values = np.sqrt(np.arange(1000.0))
    once, twice = (page_data.block({"a": [values.copy() for _ in range(k)]}) for k in (1, 2))
    assert len(twice) < 1.01 * len(once)


def test_a_frame_of_thirty_bodies_takes_little_script(page: Any) -> None:
    """Of script alone: drawing is left to the card, which this browser does not have."""
    ms = page.evaluate("""() => {
      const { solids, scene } = player.stages[0];
      const rounds = 300;
      const start = performance.now();
      for (let k = 0; k < rounds; k += 1) {
        scene.show((k / rounds) * scene.end);
        solids.update();
      }
      return (performance.now() - start) / rounds;
    }""")
    assert ms < 5.0


def test_many_bodies_have_fewer_instants(run: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = len(animated(run).t)
    monkeypatch.setattr(animation, "_VALUES_IN_SPACE", 20_000)
    assert 20 < len(animated(run).t) < 0.5 * usual


def test_a_run_that_took_long_has_no_more_instants_than_fit(
    run: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = copy(run)
    slow.stats = {**run.stats, "integration_seconds": 1e3}
    assert len(animated(slow).t) == len(run.t)
    monkeypatch.setattr(animation, "_VALUES_IN_SPACE", 20_000)
    shown = animated(slow)
    assert 20 < len(shown.t) <= 20_000 / len(page_text.curves(run)[0])
    assert (shown.t[0], shown.t[-1]) == (run.t[0], run.t[-1])
    np.testing.assert_array_equal(shown.q("slider.x"), run.at(shown.t).q("slider.x"))


def test_actuators_have_arrows_that_no_output_asks_for(tmp_path: Path) -> None:
    model = Model("lift", space=True, gravity=(0, 0, -9.81))
    arm = model.body("arm", 3.0, (0.1, 0.2, 0.25), at=(0.4, 0, 0))
    hinge = model.revolute("hinge", model.ground, arm, at=(0, 0, 0), axis=(0, 1, 0))
    model.spring("strut", model.ground.at(0.3, 0, -0.6), arm.at(0.1, 0, 0), actuator=-20.0)
    model.torsion_spring("motor", hinge, actuator=-4.0)
    model.scene("s", ["gravity", "strut", "motor"])
    shown = load(model, folder=tmp_path).simulate(0.3, progress=False)
    assert "strut.force" not in exerted(shown)
    found = page_data.machine_data(moving_picture(shown), 1.0, exerted(shown))["arrows"]
    values = {row["label"]: np.array(row["value"]) for row in found}
    assert {"hinge, ground on arm", "strut on arm", "motor on arm"} <= {*values}
    np.testing.assert_allclose(np.linalg.norm(values["strut on arm"], axis=0), 20.0, rtol=1e-4)
    along = np.tile([[0.0], [4.0], [0.0]], len(shown.t))  # the opposite acts on the first body
    np.testing.assert_allclose(values["motor on arm"], along, rtol=1e-4, atol=1e-4)
    styles = {row["label"]: row["style"] for row in found}
    assert (styles["strut on arm"], styles["motor on arm"]) == ("force", "torque")


def test_curves_have_angular_velocities_for_rates_of_euler_parameters(run: Result) -> None:
    series, groups = page_text.curves(run)
    names = [row["name"] for row in series]
    assert {"crank.e0", "crank.omega_x", "slider.vx", "a(slider.x)"} <= {*names}
    rates = {row.velocity for row in run.description.positions if row.name.startswith("crank.e")}
    assert len(rates) == 4
    assert not rates & {*names}
    shown = {g["title"]: [names[k] for k in g["series"]] for g in groups}
    assert shown["crank: angular velocity, rad/s"] == ["crank.omega_x"]
