"""Pages of machines and runs of other kinds: many bodies, several runs, rest, joints that go."""

import sys
from pathlib import Path

import numpy as np
import pytest

import runtime
from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import BodyPicture, Picture, Symbol
from codegen.drawing.shapes import Pin, Place
from codegen.errors import InputError
from runtime import Result, load
from runtime.show.animation.page_data import block, in_two, machine_data
from runtime.show.animation.page_text import page_text
from tests.runtime.show.animation.conftest import Open

BODIES = 20


def chain_page() -> str:
    """Twenty bars that hang from each other, each turned further by 0.1 rad."""
    t = np.linspace(0.0, 2.0, 121)
    poses = np.zeros((len(t), BODIES + 1, 3))
    end = np.zeros((len(t), 2))
    for k in range(1, BODIES + 1):
        angle = 0.1 * k * t
        half = 0.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        poses[:, k, :2], poses[:, k, 2] = end + half, angle
        end = end + 2 * half
    pins = [
        Symbol(f"J{k}", "revolute", "joint", Pin(Place(k - 1, 0.5, 0.0), Place(k, -0.5, 0.0)))
        for k in range(1, BODIES + 1)
    ]
    bodies = (BodyPicture("ground", True), *(BodyPicture(f"bar{k}") for k in range(BODIES)))
    picture = complete_picture(Picture("chain", bodies, poses, tuple(pins), 1.0, poses, t))
    run = {
        "label": "", "title": "chain", "t": in_two(t), "series": [], "groups": [],
        **machine_data(picture),
    }  # fmt: skip
    return page_text("chain", block({"runs": [run]}))


def test_a_page_stays_within_its_size() -> None:
    machine = load("slider_crank", "compressor")
    short, long = (len(machine.simulate(t_end).animate().html) for t_end in (10.0, 20.0))
    assert short < 2_000_000
    assert long - short < 1_000_000


def test_a_frame_of_twenty_bodies_moves_what_is_there(show: Open, tmp_path: Path) -> None:
    (tmp_path / "chain.html").write_text(chain_page())
    page = show(tmp_path / "chain.html")
    assert page.locator(".bodies > .body").count() == BODIES
    made, changed = page.evaluate("""() => {
      const world = document.querySelector(".world");
      const observer = new MutationObserver(() => {});
      observer.observe(world, {subtree: true, childList: true, attributes: true});
      player.clock.seek(0.5);
      const records = observer.takeRecords();
      const made = records.filter(({type}) => type === "childList").length;
      return [made, records.length];
    }""")
    assert made == 0
    assert BODIES <= changed <= 4 * BODIES  # outline, pin, axes and centre of mass
    x = page.evaluate("(player.clock.seek(1.3), player.scenes[0].poses.at(-1).x)")
    angles = 0.13 * np.arange(1, BODIES + 1)
    assert x == pytest.approx(np.cos(angles).sum() - 0.5 * np.cos(angles[-1]), abs=1e-3)


def test_several_runs_share_a_clock(show: Open, tmp_path: Path) -> None:
    machine = load("slider_crank", "compressor")
    runs = [machine.simulate(0.5, parameters={"J1": value}) for value in (225.0, 450.0, 900.0)]
    shown = runtime.animate(runs, file=tmp_path / "three.html")
    assert shown.labels == ("J1 = 225", "J1 = 450", "J1 = 900")
    page = show(tmp_path / "three.html")
    assert page.locator("figcaption").all_text_contents() == list(shown.labels)
    page.evaluate("player.clock.seek(0.3)")
    for k, run in enumerate(runs):
        pose = page.evaluate(f"player.scenes[{k}].poses[1].phi")
        assert pose == pytest.approx(float(run.at(0.3).q("crank.phi")[0]), abs=1e-4)
    assert "crank.phi, J1 = 450" in page.locator(".legend").first.text_content()
    assert {mark["run"] for mark in page.evaluate("player.timeline.events")} == {0, 1, 2}
    page.locator(".chip").first.click()
    assert not page.evaluate("player.curves.panels[0].lines[0].renderer.visible")


def test_labels_are_text_alone(show: Open, compressor: Result, tmp_path: Path) -> None:
    label = "</script><b id=x>"
    shown = runtime.animate([compressor, compressor], labels=[label, "b"])
    assert label not in shown.html
    page = show(shown.save(tmp_path / "labels.html"))
    assert page.locator("figcaption").first.text_content() == label
    assert page.locator("#x").count() == 0


def test_a_joint_that_lets_go_is_gone(show: Open, tmp_path: Path) -> None:
    run = load("trebuchet").simulate(2.0)
    (change,) = (one for one in run.reconnections if one.action == "release")
    page = show(run.animate().save(tmp_path / "throw.html"))
    symbol = page.locator(f".between [data-element={change.joint}]")
    for instant, seen in ((change.time - 0.05, True), (change.time + 0.05, False)):
        page.evaluate(f"player.clock.seek({instant})")
        assert symbol.first.is_visible() is seen
    assert "released" in page.locator("#events").text_content()
    page.evaluate("player.camera.toggleFit()")
    small = page.evaluate("player.camera.scale")
    page.evaluate("player.camera.toggleFit()")
    assert page.evaluate("player.camera.scale") > 1.5 * small  # the ball flies far away


def test_impacts_flash_unless_motion_is_unwelcome(show: Open, tmp_path: Path) -> None:
    run = load("hard/bouncing_ball").simulate(1.5)
    hit = next(event.time for event in run.events if event.word == "touches")
    path = run.animate().save(tmp_path / "ball.html")
    for wish, seen in (("no-preference", True), ("reduce", False)):
        page = show(path, reduced_motion=wish)
        page.evaluate(f"player.clock.seek({hit + 0.01})")
        assert page.locator(".flash").first.is_visible() is seen
        assert page.locator(".happened").text_content().endswith("touches")


def test_wrong_arguments_are_named(compressor: Result, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"results is .*; it must be a list of results"):
        runtime.animate([1])
    with pytest.raises(InputError, match="0 runs; it shows 1 to 6"):
        runtime.animate([])
    with pytest.raises(InputError, match="1 labels for 2 runs"):
        runtime.animate([compressor, compressor], labels=["a"])
    with pytest.raises(InputError, match=r"a.pdf: a movie ends in .*, a page in .html"):
        compressor.animate(file=tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


def test_without_bokeh_the_message_says_how_to_get_it(
    compressor: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    from runtime.show.animation import page_text

    monkeypatch.setitem(sys.modules, "bokeh", None)
    page_text.panels.cache_clear()
    with pytest.raises(InputError, match=r"needs bokeh.*pip install 'linkwright\[animation\]'"):
        compressor.animate().html  # noqa: B018
