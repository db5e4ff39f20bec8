"""Figures of pictures: what they contain, where names stand, and what is asked for."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from codegen import Model
from codegen.drawing.annotations import acting_loads, dimension_lines, drawn_loads
from codegen.drawing.labels import Label, Writer, engineering, labels
from codegen.drawing.matplotlib_painter import PictureArtist, figure
from codegen.drawing.picture import Symbol
from codegen.drawing.shapes import Drive, Place, Reaction
from codegen.drawing.styles import LIGHT
from codegen.picture_at_start import declared_picture
from tests.codegen.drawing.hand_drawn_pictures import slider_crank


def texts(drawn: Figure) -> dict[str, Any]:
    return {text.get_text(): text for text in drawn.axes[0].texts}


@pytest.fixture(scope="module")
def plain() -> Figure:
    return figure(slider_crank())


def test_all_strokes_are_one_collection_on_equal_axes(plain: Figure) -> None:
    (axes,) = plain.axes
    (collection,) = axes.collections
    assert isinstance(collection, PathCollection)
    assert len(collection.get_paths()) > 40
    assert axes.get_aspect() == 1.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x, m", "y, m")
    assert axes.get_title() == "test"


def test_bodies_joints_drivers_and_forces_have_their_names(plain: Figure) -> None:
    assert set(texts(plain)) == {"A", "B", "C", "guide", "crank", "rod", "slider", "drive", "gas"}


def test_names_do_not_overlap(plain: Figure) -> None:
    boxes = [text.get_window_extent() for text in plain.axes[0].texts]
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_a_gap_says_how_far_the_places_are_apart() -> None:
    found = set(texts(figure(slider_crank(closed=False))))
    assert {"B: 0.5657 m apart", "C: 0.5657 m apart"} <= found


def test_forces_have_their_sizes_and_a_scale() -> None:
    drawn = slider_crank()
    reaction = Symbol("B", "revolute", "joint", Reaction(1, 2, 1.4, 1.4, 1.0, 0.0))
    drawn = replace(drawn, symbols=(*drawn.symbols, reaction))
    found = texts(figure(drawn, forces=True, series={"B.fx": 3e4, "B.fy": -4e4}))
    assert {"gas on slider: 50 kN", "B, crank on rod: 50 kN", "20 kN"} <= set(found)
    assert not any("kN" in text for text in texts(figure(drawn)))


def test_a_small_force_has_its_text_beside_its_own_short_arrow() -> None:
    drawn = slider_crank()
    reaction = Symbol("B", "revolute", "joint", Reaction(1, 2, 1.4, 1.4, 1.0, 0.0))
    drawn = replace(drawn, symbols=(*drawn.symbols, reaction))
    arrows = drawn_loads(drawn, acting_loads(drawn, {"B.fx": 50.0}), True)
    (label,) = (one for one in labels(drawn, arrows, True) if one.text.startswith("B,"))
    assert abs(label.places - (1.4 + 1.4j)).max() < 1e-3 * drawn.size


def test_torques_of_joints_and_drivers_have_sizes_and_bodies() -> None:
    drawn = slider_crank()
    symbols = (
        *drawn.symbols,
        Symbol("guide", "translational", "joint", Reaction(0, 3, 3.0, 0.0, 1.0, 0.0)),
        Symbol("motor", "driver", "driver", Drive(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0))),
        Symbol("piston", "driver", "driver", Drive(None, Place(3, 0.0, 0.0), False, 1.0, 0.0)),
    )
    drawn = replace(drawn, symbols=symbols)
    series = {"guide.fy": 2.0, "guide.torque": -0.5, "motor.torque": 2.0, "piston.force": -3.0}
    found = set(texts(figure(drawn, forces=True, series=series)))
    assert {
        "guide, ground on slider: 2 N", "guide, ground on slider: 500 mN m",
        "motor on crank: 2 N m", "piston on slider: 3 N",
    } <= found  # fmt: skip
    arcs = {
        load.element: shaft.points
        for load, (shaft, _) in drawn_loads(drawn, acting_loads(drawn, series), True)
        if load.style == "torque"
    }
    assert np.ptp(arcs["guide"].imag) < 0.7 * np.ptp(arcs["motor"].imag)


def test_frames_add_axes_and_centres_of_mass(plain: Figure) -> None:
    (with_frames,) = figure(slider_crank(), frames=True).axes[0].collections
    (without,) = plain.axes[0].collections
    # of three bodies: two axes with heads, a circle, two quadrants
    assert len(with_frames.get_paths()) - len(without.get_paths()) == 3 * (2 * 2 + 1 + 2)


def test_pale_colours_are_mixed_with_the_background() -> None:
    drawn = slider_crank()
    artist = PictureArtist(drawn, strength=0.25)
    axes = Figure().add_subplot()
    edges = artist.add_to(axes, drawn).get_edgecolors()
    wanted = 1 - 0.25 * (1 - np.array(to_rgb(LIGHT["line-0"])))
    assert np.abs(edges[:, :3] - wanted).max(axis=1).min() < 0.003


def test_labels_keep_off_lines_and_each_other() -> None:
    axes = Figure().add_subplot(aspect="equal", xlim=(0, 200), ylim=(0, 100))
    writer = Writer(axes, [np.array([50j, 200 + 50j])])
    for x in (80.0, 90.0, 100.0, 110.0):
        writer.add(Label(f"at {x:.0f}", np.array([x + 50j]), 3.0, {"fontsize": 9, "color": "k"}))
    boxes = [text.get_window_extent() for text in axes.texts]
    line = axes.transData.transform((0.0, 50.0))[1]
    for k, box in enumerate(boxes):
        assert not box.y0 < line < box.y1
        assert not any(box.overlaps(other) for other in boxes[:k])


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0 N"), (12345.0, "12.3 kN"), (0.004, "4 mN"), (3e6, "3 MN")]
)
def test_engineering_prefixes(value: float, text: str) -> None:
    assert engineering(value, "N") == text


def test_dimension_lines_keep_apart() -> None:
    """Three equal bars on one line: dimension lines in one place would cover each other."""
    model = Model("bars")
    for k in range(3):
        bar = model.body(f"bar_{k}", 1.0, 1.0)
        model.revolute(f"A_{k}", model.ground.at(0, 0), bar.at(0, 0))
        model.spring(f"S_{k}", model.ground.at(0, 1), bar.at(1, 0), 1.0, free_length=1.0)
    model.scene("level", ["S_0", "S_1", "S_2"])
    picture = declared_picture(model)
    lines = [strokes[0].points for strokes in dimension_lines(picture)]
    level = [a.imag for a, b in lines if abs(abs(b - a) - 1) + abs((b - a).imag) < 1e-9]
    assert len(level) == 3
    assert np.diff(np.sort(level)).min() > 0.04 * picture.size
