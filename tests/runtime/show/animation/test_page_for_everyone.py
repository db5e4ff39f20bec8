"""Keyboard, screen reader, phone, paper, notebook, and texts that can be read."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.drawing.shapes import Drive, Place
from runtime import Result
from tests.runtime.show.animation.conftest import PHONE, Open
from tests.runtime.show.animation.machines import crank_pictures, page_of

TIME = "player.clock.t"
FOCUS = """() => {
  let node = document.activeElement;
  while (node.shadowRoot?.activeElement) node = node.shadowRoot.activeElement;
  return [node.tagName, node.ariaLabel ?? node.textContent ?? "", Boolean(node.closest(".curves"))];
}"""
OVERLAPS = """[...document.querySelectorAll('.names text, .arrows g:not([hidden]) text')]
  .filter(e => !e.hasAttribute('hidden') && e.textContent)
  .map(e => e.getBoundingClientRect())
  .flatMap((a, k, all) => all.slice(k + 1).filter(b =>
    a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 2 && b.top < a.bottom - 2))
  .length"""


@pytest.fixture(name="page")
def _page(show: Open, compressor_page: Path) -> Any:
    return show(compressor_page)


def test_the_focus_meets_play_before_the_curves_and_names_all(page: Any) -> None:
    seen = []
    for _ in range(45):
        page.keyboard.press("Tab")
        seen.append(page.evaluate(FOCUS))
    labels = [label for _, label, _ in seen]
    assert labels.index("Play") < 8
    first_curve = next(k for k, (_, _, curves) in enumerate(seen) if curves)
    assert labels.index("Play") < first_curve
    assert all(label.strip() for tag, label, _ in seen if tag not in {"BODY", "INPUT"})
    assert "DIV" not in {tag for tag, _, _ in seen}


def test_joints_are_chosen_by_keys_and_by_a_list(page: Any) -> None:
    chosen = "player.stages[0].chosen"
    page.locator("body").press("j")
    first = page.evaluate(chosen)
    assert first
    assert page.locator(f".world [data-element='{first}'].chosen").count() > 0
    page.locator("body").press("j")
    assert page.evaluate(chosen) not in ("", first)
    page.locator("body").press("J")
    assert page.evaluate(chosen) == first
    page.locator("#element").select_option("B")
    title = page.locator(".panel select").nth(2)
    assert title.evaluate("e => e.selectedOptions[0].text") == "B: reaction, N"


def test_space_on_a_box_ticks_it_and_does_not_play(page: Any) -> None:
    box = page.locator("[data-layer=names]")
    before = box.is_checked()
    box.press(" ")
    assert box.is_checked() is not before
    assert not page.evaluate("player.clock.playing")


def test_texts_do_not_cover_each_other(page: Any) -> None:
    for instant in (0.0, 0.31, 0.6, 0.9, 1.25, 1.7):
        page.evaluate(f"player.clock.seek({instant})")
        page.evaluate("player.stages[0].drawArrows(true)")
        assert page.evaluate(OVERLAPS) == 0, instant
    for _ in range(8):
        page.locator("body").press("-")  # so small that most names have no room
    assert page.evaluate(OVERLAPS) == 0


def test_legends_of_three_curves_are_within_the_page(page: Any) -> None:
    page.locator(".panel select").first.select_option(label="energy, J")
    chips = [
        chip.bounding_box() for chip in page.locator(".panel .legend").first.locator(".chip").all()
    ]
    assert len(chips) == 3
    legend = page.locator(".panel .legend").first.bounding_box()
    for chip in chips:
        assert chip["x"] + chip["width"] <= legend["x"] + legend["width"] + 1
        assert chip["y"] + chip["height"] <= legend["y"] + legend["height"] + 1


def test_a_finger_scrolls_over_stage_and_curves(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page, PHONE, has_touch=True)
    devtools = page.context.new_cdp_session(page)

    def touch(kind: str, points: list[dict[str, float]]) -> None:
        devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    for selector in (".plot", "svg.stage"):
        page.evaluate("scrollTo(0, 0)")
        box = page.locator(selector).first.bounding_box()
        x, y = box["x"] + 150, box["y"] + 0.8 * box["height"]
        before = page.evaluate(f"[{TIME}, player.camera.y]")
        touch("touchStart", [{"x": x, "y": y}])
        for k in range(1, 11):
            touch("touchMove", [{"x": x, "y": y - 15 * k}])
            page.wait_for_timeout(16)
        touch("touchEnd", [])
        page.wait_for_function("scrollY > 80")
        assert page.evaluate(f"[{TIME}, player.camera.y]") == before


def test_paper_has_no_controls_and_the_light_colours(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page, color_scheme="dark")
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator(".tools").is_hidden()
    assert page.locator("svg.stage").is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    ink = page.evaluate("player.curves.panels[0].plot.left[0].major_label_text_color")
    page.emulate_media(media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("player.curves.panels[0].plot.left[0].major_label_text_color") != ink
    assert page.locator(".tools").is_visible()


def test_forced_colours_keep_the_picture(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page, forced_colors="active")
    line = "getComputedStyle(document.querySelector('.body-0 .edge')).stroke"
    assert page.evaluate(line) not in ("rgb(0, 0, 0)", "rgb(255, 255, 255)", "none")
    play = "getComputedStyle(document.querySelector('.play'), '::before').borderLeftColor"
    ground = "getComputedStyle(document.querySelector('.play')).backgroundColor"
    assert page.evaluate(play) != page.evaluate(ground)


def test_a_frame_of_a_notebook_is_as_high_as_its_page(
    show: Open, compressor: Result, tmp_path: Path
) -> None:
    path = tmp_path / "notebook.html"
    frame = compressor.animate()._repr_html_()
    path.write_text(
        f"<body><p class=player data-ready=all>a</p>{frame}<div style='height:3000px'></div></body>"
    )
    page = show(path)
    inner = page.frames[1]
    inner.wait_for_selector(".player[data-ready=all]")
    page.wait_for_timeout(200)
    height = page.locator("iframe").bounding_box()["height"]
    assert height == pytest.approx(inner.evaluate("document.documentElement.scrollHeight"), abs=2)
    assert inner.evaluate("innerHeight >= document.body.scrollHeight")
    scale = inner.evaluate("player.camera.scale")
    page.mouse.move(300, 300)
    page.mouse.wheel(0, 200)
    page.wait_for_function("scrollY > 100")
    assert inner.evaluate("player.camera.scale") == scale
    page.evaluate("scrollTo(0, 0)")
    inner.locator("svg.stage").click()
    page.mouse.wheel(0, -200)
    inner.wait_for_function(f"player.camera.scale > 1.1 * {scale}")


def test_a_reader_hears_all_bodies_on_demand(show: Open, tmp_path: Path) -> None:
    from tests.runtime.show.animation.test_pages import chain_page

    (tmp_path / "chain.html").write_text(chain_page())
    page = show(tmp_path / "chain.html")
    told = page.locator("#state")
    assert "and 12 more bodies" in told.text_content()
    assert "bar15" not in told.text_content()
    page.locator("body").press("i")
    assert "bar15 at x" in told.text_content()
    assert page.locator("svg.stage").get_attribute("aria-label") == "Picture of chain"


def test_events_close_to_each_other_are_told_apart_and_counted(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 100.0, 11)
    events = [
        {"t": 50.0 + 0.001 * k, "text": "touches", "element": "E", "flash": False}
        for k in range(500)
    ]
    drawn = crank_pictures(t, 0.01 * t)
    page = show(page_of(tmp_path / "events.html", drawn, events=events))
    rows = page.locator("#events li").all_text_contents()
    assert rows[:2] == ["50.000 s: touches", "50.001 s: touches"]
    assert rows[-1] == "and 100 more"


def test_drivers_of_a_coordinate_have_an_arrow(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    drive = Drive(None, Place(1, 0.5, 0.0), False, 0.0, 1.0)
    page = show(page_of(tmp_path / "driver.html", crank_pictures(t, t, shapes=(drive,))))
    assert "rotate(90" in page.locator(".between .driver").get_attribute("transform")


def test_a_joint_that_acts_to_the_end_is_there_at_the_end(show: Open, tmp_path: Path) -> None:
    from dataclasses import replace

    t = np.linspace(0.0, 0.7, 11)
    drawn = crank_pictures(t, t)
    spans = ((0.3, float(np.nextafter(t[-1], np.inf))),)
    drawn = replace(drawn, symbols=(replace(drawn.symbols[0], spans=spans),))
    page = show(page_of(tmp_path / "end.html", drawn))
    pin = page.locator(".joints [data-element=A]").first
    assert not pin.is_visible()
    page.evaluate("player.clock.seek(player.clock.end)")
    assert pin.is_visible()
