"""What a page shows before anybody has touched it: the machine, its colours, all panels."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model, t
from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import BodyPicture, Picture
from codegen.drawing.shapes import Trace
from runtime import Result, load
from runtime.show.pictures import moving_picture
from tests.runtime.show.animation.conftest import PHONE, Open
from tests.runtime.show.animation.machines import crank_pictures, page_of


@pytest.fixture(scope="module")
def throw(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("throw") / "throw.html"
    load("trebuchet").simulate(9.0).animate(file=path)
    return path


def test_a_ball_that_is_thrown_does_not_set_the_scale(show: Open, throw: Path) -> None:
    """The beam is 8 m long; the ball flies two hundred, and a key shows all of its flight."""
    page = show(throw)
    assert 8.0 * page.evaluate("player.camera.scale") > 150.0
    x = "player.camera.toScreen(player.scenes[0].poses.at(-1)).x"
    page.evaluate("player.clock.seek(player.clock.end)")
    assert page.evaluate(x) > page.evaluate("player.camera.width")
    page.locator("body").press("0")
    assert page.evaluate(x) < page.evaluate("player.camera.width")


def test_the_ball_is_in_the_view_while_the_sling_holds_it(show: Open, throw: Path) -> None:
    page = show(throw)
    for instant in (0.0, 0.5, 1.0):
        page.evaluate(f"player.clock.seek({instant})")
        at = page.evaluate("player.camera.toScreen(player.scenes[0].poses.at(-1))")
        assert 0.0 < at["x"] < page.evaluate("player.camera.width")
        assert 0.0 < at["y"] < page.evaluate("player.camera.height")


def test_the_view_goes_along_with_what_nothing_holds(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    poses = np.zeros((len(t), 2, 3))
    poses[:, 1, 0] = 100.0 * t
    bodies = (BodyPicture("ground", True), BodyPicture("car", outlines=(np.array([0, 1, 1j]),)))
    drawn = complete_picture(Picture("car", bodies, poses, (), 1.0, poses, t))
    page = show(page_of(tmp_path / "car.html", drawn))
    x = "player.camera.toScreen(player.scenes[0].poses[1]).x"
    before = page.evaluate(x)
    page.evaluate("player.clock.seek(0.7)")
    assert page.evaluate(x) == pytest.approx(before)
    assert page.evaluate("player.camera.scale") > 100.0
    page.locator("body").press("0")
    page.evaluate("player.clock.seek(0.2)")
    at_first = page.evaluate(x)
    page.evaluate("player.clock.seek(0.7)")
    assert page.evaluate(x) > at_first + 100.0


def test_curves_have_the_colours_of_their_bodies(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page)
    page.locator(".panel select").first.select_option(label="position, m")
    lines = page.evaluate("""player.curves.panels[0].lines.map((line) =>
      [line.name, line.renderer.glyph.line_color.value, line.renderer.glyph.line_dash.value])""")
    colors = {
        body: page.evaluate(f"""getComputedStyle(document.documentElement)
          .getPropertyValue("--line-{k}")""").strip()
        for k, body in enumerate(("crank", "rod", "slider"))
    }
    drawn = page.evaluate(
        "getComputedStyle(document.querySelector('[data-body=rod] .edge')).stroke"
    )
    assert drawn == "rgb({}, {}, {})".format(*bytes.fromhex(colors["rod"][1:]))
    assert {name.partition(".")[0] for name, *_ in lines} >= {"rod", "slider"}
    assert all(color == colors[name.partition(".")[0]] for name, color, _ in lines)
    dashes = [dash for name, _, dash in lines if name.startswith("rod.")]
    assert dashes == [[], [6, 3]]
    page.locator(".panel select").first.select_option(label="rod: velocity, m/s")
    assert page.evaluate("player.curves.panels[0].lines[0].color") == "line-1"


def test_gravity_says_what_it_is(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page)
    assert page.locator(".gravity text").text_content() == "gravity 9.810 m/s²"


def test_the_docstring_stands_under_the_name(show: Open, compressor_page: Path) -> None:
    text = show(compressor_page).locator(".about").text_content()
    assert text.startswith("The slider-crank compressor of Haug, Computer-Aided")
    assert "Section 8.2.4: how does it run?" in text


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1024, 768), (1920, 1080)])
def test_no_panel_is_cut(show: Open, throw: Path, width: int, height: int) -> None:
    page = show(throw, {"width": width, "height": height})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    column = page.locator(".curves").bounding_box()
    assert page.locator(".tools").bounding_box()["y"] + 34 <= height
    for panel in page.locator(".panel").all():
        plot, legend = panel.locator(".plot").bounding_box(), panel.locator(".legend")
        assert plot["height"] >= 60
        assert plot["y"] + plot["height"] <= column["y"] + column["height"] + 1 <= height
        assert legend.evaluate("e => e.scrollHeight <= e.clientHeight + 1")
        frame = panel.evaluate("p => player.curves.panels[p.dataset.panel].view.frame.bbox.height")
        assert 25 <= frame <= plot["height"]


def test_a_phone_shows_all_of_a_legend(show: Open, throw: Path) -> None:
    page = show(throw, PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for chip in page.locator(".chip").all():
        box = chip.bounding_box()
        assert box["x"] + box["width"] <= PHONE["width"]


def test_a_ground_is_seen_through_a_body_before_it(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    page = show(page_of(tmp_path / "crank.html", crank_pictures(t, t)))
    through = page.locator(".world > use")
    target = page.locator(through.get_attribute("href"))
    assert target.locator(".support").count() == 1
    order = "e => [...e.parentNode.children].map(part => part.getAttribute('class'))"
    layers = through.evaluate(order)
    assert layers.index("through") == layers.index("bodies") + 1


def linkage(outputs: Any) -> Result:
    model = Model("tracked_page")
    crank = model.body("crank", 1.0, 0.1)
    model.revolute("A", model.ground, crank.at(-0.5, 0))
    model.driver("drive", crank.phi, t)
    model.track("P", crank.at(0.5, 0.2))
    model.scene("driven", drivers=["drive"], outputs=outputs, analysis="kinematics")
    return load(model).kinematics(np.linspace(0.0, 1.0, 11))


@pytest.mark.parametrize("outputs", [None, ["points"]])
def test_a_tracked_point_is_drawn_whether_it_is_an_output_or_not(
    outputs: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    picture = moving_picture(linkage(outputs))
    ((symbol, trace),) = picture.having(Trace)
    assert symbol.element == "P"
    assert picture.at(trace.at)[0] == pytest.approx(1.0 + 0.2j)


def test_what_lies_loose_beside_the_machine_is_in_the_view(show: Open, tmp_path: Path) -> None:
    """A body that nothing holds and that stays near, such as a link of a chain round sprockets."""
    t = np.linspace(0.0, 1.0, 11)
    crank = crank_pictures(t, t)
    poses = np.concatenate([crank.poses, np.zeros((len(t), 1, 3))], axis=1)
    poses[:, 2, 0] = 1.0 + 0.3 * t
    bodies = (*crank.bodies, BodyPicture("link", outlines=(np.array([0, 0.2, 0.2j]),)))
    page = show(page_of(tmp_path / "loose.html", replace(crank, bodies=bodies, poses=poses)))
    assert page.evaluate("player.camera.box[2]") == pytest.approx(1.5, abs=0.02)
