"""A page places the lines of springs and belts where a figure has them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.drawing.plane_geometry import pairs
from codegen.drawing.shapes import Belt, Place, Shape, SpiralSpring, Spring, Wheel
from runtime.show.animation.page_data import machine_data
from tests.runtime.show.animation.conftest import Open
from tests.runtime.show.animation.machines import crank_pictures, page_of

GROUND, PIN, END = Place(0, 0.0, 0.0), Place(1, -0.5, 0.0), Place(1, 0.5, 0.0)


@pytest.mark.parametrize(
    "shape",
    [
        Spring(Place(0, 2.0, 0.0), END, True, True, True),
        SpiralSpring(GROUND, PIN, True, True, True),
        Belt(Place(0, 3.0, 1.0), END, 0.4, 0.2, False),
        Belt(Place(0, 3.0, 1.0), END, 0.4, 0.2, True),
    ],
)
def test_lines_of_a_page_are_those_of_a_figure(show: Open, tmp_path: Path, shape: Shape) -> None:
    t = np.linspace(0.0, 3.0, 31)
    drawn = crank_pictures(t, t, shapes=(shape,))
    page = show(page_of(tmp_path / "page.html", drawn))
    for instant in (0, 17, 30):
        page.evaluate(f"player.clock.seek({t[instant]})")
        paths = page.locator(".between [data-element=E1] path").evaluate_all(
            "paths => paths.map(path => [path.getAttribute('class'), path.getAttribute('d')])"
        )
        strokes = [s for s in lines_between_bodies(drawn.instant(instant)) if s.element == "E1"]
        assert [style for style, _ in paths] == [stroke.style for stroke in strokes]
        for (_, d), stroke in zip(paths, strokes, strict=True):
            points = [[float(v) for v in at.split()] for at in d.strip("MZ").split("L")]
            assert_allclose(points, pairs(stroke.points), atol=3e-6)


def test_a_page_has_the_layers_of_a_figure() -> None:
    wheel = Wheel(Place(1, 0.0, 0.0), 0.2, True)
    run = machine_data(crank_pictures(np.arange(2.0), np.zeros(2), shapes=(wheel,)))
    found = {stroke["style"]: (stroke["layer"], stroke["depth"]) for stroke in run["strokes"]}
    assert found == {
        "support": ("ground", 1), "rail": ("ground", 1), "hatch": ("ground", 1),
        "gear": ("bodies", 0), "pitch": ("bodies", 1), "spoke": ("bodies", 1),
        "hub": ("joints", 1), "pin": ("joints", 1),
    }  # fmt: skip
