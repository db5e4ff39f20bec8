"""The player in a real browser: motion, curves, keyboard, themes, sizes, what a reader hears."""

from pathlib import Path
from typing import Any

import pytest

from runtime import Result
from tests.runtime.show.animation.conftest import PHONE, Open

TIME = "player.clock.t"
CRANK = "document.querySelector('[data-body=crank]').getAttribute('transform')"


def cursors(page: Any) -> list[float]:
    """Where the time cursors of the panels are, px."""
    script = "[...document.querySelectorAll('.plot .cursor')].map(c => c.getBoundingClientRect().x)"
    return list(page.evaluate(script))


@pytest.fixture(name="page")
def _page(show: Open, compressor_page: Path) -> Any:
    return show(compressor_page)


def test_the_machine_plays_and_stops(page: Any) -> None:
    before = page.evaluate(CRANK)
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_function(f"{TIME} > 0.2")
    page.get_by_role("button", name="Pause", exact=True).click()
    stopped = page.evaluate(TIME)
    assert page.evaluate(CRANK) != before
    page.wait_for_timeout(150)
    assert page.evaluate(TIME) == stopped


def test_scrubbing_moves_machine_and_cursors(page: Any) -> None:
    before, pose = cursors(page), page.evaluate(CRANK)
    page.locator("#time").fill("1")
    assert page.evaluate(TIME) == pytest.approx(1.0)
    assert page.evaluate(CRANK) != pose
    after = cursors(page)
    assert len(after) == 4
    assert all(x > old + 50 for x, old in zip(after, before, strict=True))
    assert page.locator(".timeline .now").text_content() == "1.000 s"


def test_hovering_and_clicking_on_a_curve_move_the_machine(page: Any) -> None:
    box = page.locator(".plot").nth(1).bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 40)
    hovered = page.evaluate(TIME)
    assert 0.6 < hovered < 1.2
    page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 40)
    clicked = page.evaluate(TIME)
    assert clicked > hovered + 0.3
    assert cursors(page)[1] == pytest.approx(box["x"] + 0.8 * box["width"], abs=1.5)
    page.mouse.move(box["x"] + 2, box["y"] + 40)  # beside the axes
    assert page.evaluate(TIME) == clicked


def test_a_joint_shows_its_reaction_and_a_body_its_motion(page: Any) -> None:
    title = page.locator(".panel select").nth(2)
    page.locator("[data-element=B] .grasp").first.click()
    assert title.evaluate("e => e.selectedOptions[0].text") == "B: reaction, N"
    assert "B.fx" in page.locator(".legend").nth(2).text_content()
    drawn = page.evaluate("player.curves.panels[2].lines[0].renderer.data_source.data.y.length")
    assert drawn == page.evaluate("player.scenes[0].times.length")
    page.evaluate("player.clock.seek(0.9)")
    middle = page.evaluate("player.camera.toScreen(player.scenes[0].poses[2])")
    page.locator("svg.stage").click(position={"x": middle["x"] + 20, "y": middle["y"]})
    assert page.evaluate("player.stages[0].chosen") == "rod"
    assert title.evaluate("e => e.selectedOptions[0].text").startswith("rod: ")


def test_keys(page: Any) -> None:
    page.locator("body").press("e")
    first = page.evaluate("player.timeline.events[0].t")
    assert page.evaluate(TIME) == pytest.approx(first)
    page.locator("body").press("e")
    second = page.evaluate("player.timeline.events.find(e => e.t > player.timeline.events[0].t).t")
    assert page.evaluate(TIME) == pytest.approx(second)
    page.locator("body").press("E")
    assert page.evaluate(TIME) == pytest.approx(first)
    page.locator("body").press("E")  # there is none before it
    assert page.evaluate(TIME) == pytest.approx(first)
    page.locator("body").press("End")
    assert page.evaluate(TIME) == 2.0
    page.locator("body").press("Home")
    page.locator("body").press("ArrowRight")
    assert page.evaluate(TIME) == pytest.approx(1 / 60)
    page.locator("body").press("Shift+ArrowRight")
    assert page.evaluate(TIME) == pytest.approx(11 / 60)
    page.locator("body").press(" ")
    assert page.evaluate("player.clock.playing")
    page.locator("body").press(" ")
    assert not page.evaluate("player.clock.playing")
    scale = page.evaluate("player.camera.scale")
    page.locator("body").press("+")
    assert page.evaluate("player.camera.scale") == pytest.approx(1.25 * scale)
    page.locator("body").press("0")
    assert page.evaluate("player.camera.scale") == pytest.approx(scale)
    page.locator("body").press(">")
    assert page.evaluate("player.clock.speed") == 2
    page.locator("body").press("?")
    assert page.get_by_role("dialog").get_by_role("row").count() > 15


def test_a_run_begins_anew_at_its_end_until_the_loop_is_switched_off(page: Any) -> None:
    advanced = "player.clock.seek(1.9), player.clock.play(), player.clock.advance(0.3)"
    page.evaluate(advanced)
    assert page.evaluate(TIME) == pytest.approx(0.2, abs=0.1)
    page.locator("body").press("l")
    page.evaluate(f"player.clock.pause(), {advanced}")
    assert page.evaluate(f"[{TIME}, player.clock.playing]") == [2.0, False]


def test_wheel_and_drag_move_the_view(page: Any) -> None:
    box = page.locator("svg.stage").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    scale, x = page.evaluate("[player.camera.scale, player.camera.x]")
    page.mouse.move(*middle)
    page.mouse.wheel(0, -300)
    page.wait_for_function(f"player.camera.scale > {1.2 * scale}")
    page.keyboard.press("0")
    page.mouse.down()
    page.mouse.move(middle[0] + 80, middle[1], steps=4)
    page.mouse.up()
    assert page.evaluate("player.camera.x") == pytest.approx(x + 80)


@pytest.mark.parametrize(
    ("layer", "selector"),
    [("force", ".arrow.force"), ("reaction", ".arrow.reaction"), ("torque", ".arrow.torque"),
     ("frames", ".world .mass"), ("names", ".names text")],
)  # fmt: skip
def test_layers_come_and_go(page: Any, layer: str, selector: str) -> None:
    page.evaluate("player.clock.seek(0.6)")  # where the gas is compressed
    box = page.locator(f"[data-layer={layer}]")
    for checked in (True, False, True):
        box.set_checked(checked)
        assert (page.locator(selector).filter(visible=True).count() > 0) is checked


def test_arrows_have_the_size_and_direction_of_the_reaction(page: Any, compressor: Result) -> None:
    page.evaluate("player.clock.seek(1.25)")
    now = compressor.at(1.25)
    fx, fy = (float(now.reaction("A", part)[0]) for part in ("fx", "fy"))
    page.evaluate("player.choose('A')")
    line = page.locator("g[data-element=A] .arrow.reaction").get_attribute("d")
    start, _, rest = line.removeprefix("M").partition("L")
    tip = rest.partition("M")[0]
    (x0, y0), (x1, y1) = ([float(v) for v in point.split()] for point in (start, tip))
    assert (x1 - x0) / (y0 - y1) == pytest.approx(fx / fy, rel=1e-3)
    text = page.locator("g[data-element=A] .arrow-text.reaction").text_content()
    assert text == f"A, ground on crank: {(fx**2 + fy**2) ** 0.5 / 1e3:.4g} kN"


def test_both_themes(show: Open, compressor_page: Path) -> None:
    colors = {}
    for scheme in ("light", "dark"):
        page = show(compressor_page, color_scheme=scheme)
        read = "getComputedStyle(document.body).backgroundColor"
        axis = "player.curves.panels[0].plot.left[0].major_label_text_color"
        colors[scheme] = page.evaluate(f"[{read}, JSON.stringify({axis})]")
        page.get_by_role("button", name="Light or dark").click()
        colors[f"{scheme}, changed"] = page.evaluate(f"[{read}, JSON.stringify({axis})]")
    assert colors["light"] == colors["dark, changed"]
    assert colors["dark"] == colors["light, changed"]
    assert all(a != b for a, b in zip(colors["light"], colors["dark"], strict=True))


def test_a_phone_shows_all_of_it(show: Open, compressor_page: Path) -> None:
    page = show(compressor_page, PHONE, has_touch=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for selector in ("svg.stage", "#time", ".play", ".panel"):
        box = page.locator(selector).first.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
    stage, slider, panel = (
        page.locator(s).first.bounding_box()["y"] for s in ("svg.stage", "#time", ".panel")
    )
    assert stage < slider < panel
    page.locator(".play").tap()
    page.wait_for_function(f"{TIME} > 0.05")


def test_a_reader_hears_names_and_the_state(page: Any) -> None:
    tree = page.locator("body").aria_snapshot()
    for words in (
        'button "Play"', 'slider "Time"', 'toolbar "Motion"', 'combobox "Speed"', "status:",
        'checkbox "reactions"', 'img "Picture of slider_crank/compressor',
        'combobox "Quantity of curves 1"', 'button "Next event"',
    ):  # fmt: skip
        assert words in tree, words
    page.evaluate("player.clock.seek(1)")
    told = page.get_by_role("status")
    page.wait_for_function("document.querySelector('#state').textContent.includes('1.000 of')")
    assert told.get_attribute("aria-live") == "polite"
    assert "crank at x" in told.text_content()
    assert "Last event: " in told.text_content()


def test_the_text_of_the_state_waits_for_rest(page: Any) -> None:
    page.evaluate("""() => {
      globalThis.told = 0;
      const count = () => { globalThis.told += 1; };
      new MutationObserver(count).observe(document.querySelector('#state'), {childList: true});
      for (let k = 0; k < 200; k += 1) player.clock.seek(0.01 * k);
    }""")
    page.wait_for_timeout(900)
    assert page.evaluate("told") == 1
