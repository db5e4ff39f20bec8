"""Pages of machines that are fast, small, long at work, pushed unevenly, or beside others."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import runtime
from codegen.drawing.shapes import Force, Mark, Place
from runtime import Result, load
from runtime.show.animation.animation import TURN, instants_between
from runtime.show.animation.page_data import event_marks
from tests.runtime.show.animation.conftest import PHONE, Open
from tests.runtime.show.animation.machines import (
    crank_pictures,
    page_of,
    pushed_crank,
    spring_on_a_shaker,
)

PIN_GAP = """(() => {
  const {x, y, phi} = player.scenes[0].poses[1];
  return Math.hypot(x - ARM / 2 * Math.cos(phi), y - ARM / 2 * Math.sin(phi));
})()"""
BOX = "(e => { const b = e.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })"


def test_pins_stay_together_where_a_crank_turns_fast(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 500.0, 6001)
    page = show(page_of(tmp_path / "fast.html", crank_pictures(t, 100.0 * t)))
    for instant in (0.04, 123.456, 499.97):
        page.evaluate(f"player.clock.seek({instant})")
        assert page.evaluate(PIN_GAP.replace("ARM", "1")) < 1e-5
    note = page.locator(".note").text_content()
    assert "drawn at 6001 instants" in note
    assert "turns by up to 8.333 rad" in note


def test_slow_machines_have_no_note_and_move_between_samples(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    page = show(page_of(tmp_path / "slow.html", crank_pictures(t, t)))
    page.evaluate("player.clock.seek(0.55)")
    assert page.evaluate("player.scenes[0].poses[1].phi") == pytest.approx(0.55, abs=1e-6)
    assert page.locator(".note").is_hidden()


def test_instants_follow_the_turn_and_the_room() -> None:
    t, turned = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.1, 1.5, 0.0])
    between = instants_between(t, turned, 100)
    assert np.all((between > 0.0) & (between < 3.0))
    turns = np.interp(np.union1d(t, between), t, [0.0, *np.cumsum(turned)])
    assert np.diff(turns).max() <= TURN * (1 + 1e-9)
    counts = [len(instants_between(t, k * turned, room)) for k, room in ((1, 4), (1, 0), (0, 9))]
    assert counts == [4, 0, 0]
    assert len(instants_between(t, turned, -5)) == 0


def test_steps_without_a_large_turn_are_not_split() -> None:
    t, turned = np.arange(6000.0), np.full(5999, 0.14)
    turned[2000] = 0.2
    assert instants_between(t, turned, 14_000) == pytest.approx([2000.5])
    turned[3000] = 0.9
    assert instants_between(t, turned, 1) == pytest.approx([3000 + 0.35 / 0.9])


def test_what_is_not_finite_at_first_has_its_kind_by_its_arrow(show: Open, tmp_path: Path) -> None:
    pushed = pushed_crank(np.array([0.0, 1.0, 2.0]), np.array([np.nan, 1.0, 1.0]))
    page = show(page_of(tmp_path / "late.html", pushed))
    assert page.evaluate("player.scenes[0].kinds") == {"A": "revolute", "E1": "own"}


def test_angles_of_many_turns_keep_their_digits(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    angle = 5e4 + t
    page = show(page_of(tmp_path / "turns.html", crank_pictures(t, angle)))
    page.evaluate("player.clock.seek(0.7)")
    assert page.evaluate("player.scenes[0].poses[1].phi") == pytest.approx(5e4 + 0.7, abs=2e-6)
    assert page.evaluate(PIN_GAP.replace("ARM", "1")) < 1e-4


@pytest.mark.parametrize("arm", [1e-6, 1e6])
def test_machines_of_any_size_fill_the_picture(show: Open, tmp_path: Path, arm: float) -> None:
    t = np.linspace(0.0, 1.0, 11)
    page = show(page_of(tmp_path / "size.html", crank_pictures(t, t, arm)))
    with Image.open(BytesIO(page.locator("svg.stage").screenshot())) as image:
        painted = np.any(np.asarray(image.convert("RGB"), dtype=int) < 250, axis=2)
    assert painted.mean() > 0.02
    page.evaluate("player.clock.seek(0)")
    page.wait_for_function("document.querySelector('#state').textContent.includes('at 0.000')")
    assert f"crank at x {arm / 2:.2e} m" in page.locator("#state").text_content().replace(
        "−", "-"
    ).replace("e-7", "e-07").replace("e+5", "e+05")


def test_a_spring_and_its_wall_move_together(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 3.0, 301)
    page = show(page_of(tmp_path / "shaker.html", spring_on_a_shaker(t)))
    wall = page.locator(".ground .stroke[data-element=E1]").first
    spring = page.locator(".between [data-element=E1]")
    scale = page.evaluate("player.camera.scale")
    starts = [one.evaluate(BOX) for one in (wall, spring)]
    page.evaluate(f"player.clock.seek({np.pi / 2})")
    (wall_x, *_), (spring_x, _, spring_width, _) = (one.evaluate(BOX) for one in (wall, spring))
    assert wall_x - starts[0][0] == pytest.approx(0.5 * scale, abs=1)
    ends = spring_x + spring_width - starts[1][0] - starts[1][2]
    assert ends == pytest.approx(0.5 * scale, abs=2)


def test_arrows_of_runs_beside_each_other_have_one_scale(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    both = (pushed_crank(t, 100.0 + t), pushed_crank(t, 25.0 + t))
    page = show(page_of(tmp_path / "two.html", *both, labels=("a", "b")))
    lengths = [one.evaluate("e => e.getBBox().width") for one in page.locator(".arrow.force").all()]
    assert lengths[1] / lengths[0] == pytest.approx(0.25, abs=0.01)


def test_a_constant_force_among_smaller_ones_is_not_cut(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 101)
    fx = np.where(t == 0.5, 1000.0, 10.0 + t)  # a blow of one sample
    page = show(page_of(tmp_path / "blow.html", pushed_crank(t, fx)))
    assert page.locator(".arrows .cut").count() == 0
    page.evaluate("player.clock.seek(0.5)")
    assert page.locator(".arrows .cut").count() == 1
    assert "1.000 kN" in page.locator(".arrow-text").text_content()


def test_each_arrow_counts_for_the_scale(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    sizes = [*np.full(60, 1.0), 50.0]
    forces = tuple(Force(Place(1, 0.5, 0.0), size, 0.0) for size in sizes)
    drawn = crank_pictures(t, np.zeros(len(t)), shapes=forces)
    page = show(page_of(tmp_path / "many.html", drawn))
    assert page.evaluate("player.stages[0].arrows.largest.N") == 50.0
    assert page.locator(".arrows .cut").count() == 0


def test_six_runs_have_equal_pictures_and_one_that_ended_says_so(
    show: Open, tmp_path: Path
) -> None:
    ends = (1.0, 2.0, 2.0, 2.0, 2.0, 2.0)
    drawn = [crank_pictures(np.linspace(0.0, end, 21), np.linspace(0.0, end, 21)) for end in ends]
    path = page_of(tmp_path / "six.html", *drawn, labels=tuple("abcdef"))
    page = show(path)
    sizes = page.evaluate(
        "[...document.querySelectorAll('svg.stage')].map(e => [e.clientWidth, e.clientHeight])"
    )
    assert len(sizes) == 6
    assert all(size == sizes[0] for size in sizes)
    centers = page.evaluate("player.cameras.map(c => c.toScreen({x: 0, y: 0}).x)")
    assert centers == pytest.approx([centers[0]] * 6)
    page.evaluate("player.clock.seek(1.5)")
    notes = page.locator(".ended").all()
    assert [one.is_visible() for one in notes] == [True, *[False] * 5]
    assert notes[0].text_content() == "ended at t = 1.000 s"
    page.evaluate("player.camera.zoom(2)")
    scales = page.evaluate("player.cameras.map(c => c.scale)")
    assert scales == pytest.approx([scales[0]] * 6)
    narrow = show(path, PHONE)
    assert narrow.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


@pytest.mark.parametrize(("end", "speed"), [(1e-6, 1e-7), (10.0, 1.0), (1e6, 1e5)])
def test_a_run_takes_ten_seconds_at_first(
    show: Open, tmp_path: Path, end: float, speed: float
) -> None:
    t = np.linspace(0.0, end, 11)
    page = show(page_of(tmp_path / "pace.html", crank_pictures(t, t / end)))
    assert page.evaluate("player.clock.speed") == pytest.approx(speed)
    assert page.locator("#speed").input_value() == page.evaluate("String(player.clock.speed)")
    page.locator("body").press("<")
    assert page.evaluate("player.clock.speed") == pytest.approx(speed / 2)


def test_geometry_that_is_no_number_is_left_out(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 11)
    shapes = (Mark(Place(1, np.nan, 0.0)), Force(Place(1, 0.5, 0.0), 1.0, 0.0))
    page = show(page_of(tmp_path / "nan.html", crank_pictures(t, t, shapes=shapes)))
    assert page.locator("[data-element=E1]").count() == 0
    assert page.locator(".arrows [data-element=E2]").is_visible()


def test_one_instant_has_the_events_of_that_instant(compressor: Result) -> None:
    time = compressor.events[3].time
    assert len(event_marks(compressor)) == len(compressor.events)
    assert event_marks(compressor.at(time + 1e-4)) == []
    within = compressor.at([time - 1e-4, time + 1e-4])
    assert [mark["t"] for mark in event_marks(within)] == [time]


def test_runs_of_different_kinds_have_their_curves(
    show: Open, compressor: Result, tmp_path: Path
) -> None:
    other = load("hard/bouncing_ball").simulate(1.0)
    shown = runtime.animate([compressor, other], file=tmp_path / "kinds.html")
    assert shown.labels[0] != shown.labels[1]
    page = show(tmp_path / "kinds.html")
    titles = page.locator(".panel select").first.locator("option").all_text_contents()
    own = {row.name.rpartition(".")[0] for row in other.description.positions}
    assert any(f"{body}: position, m" in titles for body in own)
    assert "crank: angle, rad" in titles


def test_a_panel_has_a_line_for_each_of_eighteen_curves(
    show: Open, compressor: Result, tmp_path: Path
) -> None:
    short = compressor.at(np.linspace(0.0, 0.2, 11))
    runtime.animate([short] * 6, file=tmp_path / "lines.html")
    page = show(tmp_path / "lines.html")
    page.locator(".panel select").first.select_option(label="energy, J")
    assert page.locator(".panel").first.locator(".chip").count() == 18
    drawn: Any = page.evaluate(
        "player.curves.panels[0].lines.filter(l => l.renderer.visible).length"
    )
    assert drawn == 18


def test_a_machine_without_its_model_file_has_curves_and_says_why(
    show: Open, tmp_path: Path
) -> None:
    run = load("slider_crank", "kinematics").kinematics(np.linspace(0.0, 1.0, 11))
    run._mechanism = None
    page = show(run.animate().save(tmp_path / "bare.html"))
    assert page.locator("figcaption").text_content().startswith("No picture: ")
    assert page.locator(".chip").count() > 2
    page.evaluate("player.clock.seek(0.5)")
