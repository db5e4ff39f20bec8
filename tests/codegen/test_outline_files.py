"""Outlines out of DXF and SVG files: units, layers, arcs, splines, contours that are open."""

import sys
from math import pi
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from codegen import InputError, ModelError, read_outline
from codegen.declare.area_properties import area_condition, area_properties
from codegen.reading.model_file import read_model
from tests.codegen.workbench import write_model

AREA = 0.3 * 0.04 + pi * 0.02**2 - pi * 0.01**2 - (0.05 * 0.01 + pi * 0.005**2)


def size(outline: Any) -> float:
    assert not [*area_condition(outline).problems("", {})]
    return float(area_properties(outline, {}).size)


def write_link(path: Path, unit: int = 4, length: float = 300.0, gap: float = 0.0) -> Path:
    """A bar of loose lines and arcs with a round hole and a slot, mm; an axis on another layer."""
    document = ezdxf.new()
    document.units = unit
    space, cut = document.modelspace(), {"layer": "cut"}
    space.add_arc((length, 0), 20, 270, 90, dxfattribs=cut)
    space.add_line((0, 20), (length, 20 + gap), cut)
    space.add_line((length, -20), (0, -20), cut)
    space.add_arc((0, 0), 20, 90, 270, dxfattribs=cut)
    space.add_circle((200, 0), 10, cut)
    slot = [(50, -5, 0), (100, -5, 1), (100, 5, 0), (50, 5, 1)]
    space.add_lwpolyline(slot, "xyb", close=True, dxfattribs=cut)
    space.add_text("link", dxfattribs=cut)
    space.add_line((-50, 0), (350, 0), {"layer": "axis"})
    document.saveas(path)
    return path


def test_dxf_in_its_unit_with_exact_arcs(tmp_path: Path) -> None:
    outline = read_outline(write_link(tmp_path / "link.dxf"), layer="cut")
    assert size(outline) == pytest.approx(AREA, rel=1e-12)
    assert len(outline.vertices) == 4
    assert sorted(len(hole.vertices) for hole in outline.holes) == [2, 4]
    without = write_link(tmp_path / "bare.dxf", unit=0)
    with pytest.raises(ModelError, match=r"bare\.dxf does not say its unit; give unit='mm'"):
        read_outline(without, layer="cut")
    assert size(read_outline(without, "cut", "cm")) == pytest.approx(100 * AREA, rel=1e-12)
    with pytest.raises(ModelError, match=r"bare.dxf, unit: 1 kilogram has"):
        read_outline(without, "cut", "kg")


def test_dxf_that_is_mirrored_or_in_blocks(tmp_path: Path) -> None:
    document = ezdxf.new()
    block = document.blocks.new("part")
    block.add_arc((0, 0), 2, 0, 180)
    block.add_line((-2, 0), (2, 0))
    space = document.modelspace()
    space.add_blockref("part", (5, 0), {"yscale": -1})
    document.saveas(tmp_path / "block.dxf")
    outline = read_outline(tmp_path / "block.dxf")
    assert size(outline) == pytest.approx(2 * pi, rel=1e-12)
    assert float(area_properties(outline, {}).center[1]) == pytest.approx(-8 / (3 * pi), rel=1e-12)


def test_splines_and_ellipses_are_flattened(tmp_path: Path) -> None:
    document = ezdxf.new()
    document.modelspace().add_ellipse((1, 2), (3, 0), 0.5)
    document.saveas(tmp_path / "oval.dxf")
    outline = read_outline(tmp_path / "oval.dxf")
    assert size(outline) == pytest.approx(4.5 * pi, rel=1e-5)
    assert len(outline) < 100 < len(outline.vertices)


@pytest.mark.parametrize(
    ("layer", "gap", "word"),
    [
        (None, 0.0, r"is open, from \(.*\) m, whose ends are 0.4 m apart; close it, take constr"),
        ("cut", 0.5, "whose ends are 0.0005 m apart"),
        ("cutt", 0.0, "draws nothing on layer 'cutt'; did you mean 'cut'"),
    ],
)
def test_contours_that_are_open(tmp_path: Path, layer: str, gap: float, word: str) -> None:
    with pytest.raises(ModelError, match=word):
        read_outline(write_link(tmp_path / "link.dxf", gap=gap), layer=layer)


SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="40mm" viewBox="0 0 160 80"
 xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">
<g id="layer1" inkscape:label="part" transform="translate(10,10)">
<rect width="100" height="40" rx="5"/><circle cx="20" cy="20" r="6"/></g>
<path id="curved" d="M 0 0 C 0 10 20 10 20 0 Z"/></svg>"""


def test_a_construction_line_across_an_outline(tmp_path: Path) -> None:
    document = ezdxf.new()
    document.modelspace().add_lwpolyline([(0, 0), (4, 0), (4, 3), (0, 3)], close=True)
    document.modelspace().add_line((0, 0), (4, 3))
    document.saveas(tmp_path / "crossed.dxf")
    with pytest.raises(ModelError, match="5 m apart; close it, take construction lines away"):
        read_outline(tmp_path / "crossed.dxf", unit="m")


def test_a_circle_in_another_plane(tmp_path: Path) -> None:
    document = ezdxf.new()
    document.modelspace().add_circle((0, 0), 2, {"extrusion": (1, 0, 0), "layer": "cut"})
    document.saveas(tmp_path / "side.dxf")
    with pytest.raises(ModelError, match=r"layer .cut.: a CIRCLE has the normal \(1, 0, 0\)"):
        read_outline(tmp_path / "side.dxf", unit="m")


def test_svg_in_mm_with_y_upwards(tmp_path: Path) -> None:
    path = tmp_path / "part.svg"
    path.write_text(SVG.format(width="80mm"))
    for layer in ("part", "layer1"):
        outline = read_outline(path, layer)
        expected = 0.0005**2 * (100 * 40 - (4 - pi) * 25 - pi * 36)
        assert size(outline) == pytest.approx(expected, rel=1e-12)
        assert float(area_properties(outline, {}).center[1]) == pytest.approx(-0.015, rel=1e-9)
    with pytest.raises(ModelError, match="has no group 'parts'; did you mean 'part'"):
        read_outline(path, "parts")
    path.write_text(SVG.format(width="160").replace("part", "other").split("<g")[0] + "</svg>")
    with pytest.raises(ModelError, match="does not say its unit"):
        read_outline(path)
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0C0 10 20 10 20 0Z"/></svg>'
    )
    assert size(read_outline(path, unit="mm")) == pytest.approx(120e-6, rel=1e-5)


def test_files_that_are_none(tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "bad.dxf").write_text("no drawing")
    with pytest.raises(ModelError, match=r"bad.dxf cannot be read as DXF"):
        read_outline(tmp_path / "bad.dxf")
    with pytest.raises(ModelError, match=r"no file '.*nad\.dxf'; did you mean 'bad.dxf'"):
        read_outline(tmp_path / "nad.dxf")
    with pytest.raises(ModelError, match=r"py' is no file that ends in"):
        read_outline(__file__)
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(InputError, match=r"pip install 'linkwright\[shapes\]'"):
        read_outline(tmp_path / "bad.dxf")


def test_a_change_of_the_drawing_builds_again(tmp_path: Path) -> None:
    drawing = write_link(tmp_path / "link.dxf")
    text = """
from pathlib import Path
from codegen import read_outline
model = Model("swing", gravity=(0, -9.81))
outline = read_outline(Path(__file__).parent / "link.dxf", layer="cut")
link = model.body("link", outline=outline, thickness=0.004, density=7850.0)
model.revolute("hinge", model.ground.at(0, 0), link.at(0, 0))
model.body("other", outline=Path(__file__).parent / "part.svg")
model.scene("s", ["gravity"])
"""
    model = write_model(tmp_path, text, "swing")
    (tmp_path / "part.svg").write_text(SVG.format(width="80mm"))
    before, same = read_model(model), read_model(model)
    named = {Path(row.name).name: row.value for row in before.asked}
    assert {"link.dxf", "part.svg"} <= named.keys()
    assert not before.unwatched
    assert before.asked == same.asked
    write_link(drawing, length=400.0)
    after = {Path(row.name).name: row.value for row in read_model(model).asked}
    assert {name for name in named if after[name] != named[name]} == {"link.dxf"}
    (old, new) = (one.model.bodies["link"].mass for one in (before, read_model(model)))
    assert new - old == pytest.approx(0.1 * 0.04 * 0.004 * 7850, rel=1e-9)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ('<rect transform="rotate(90)" x="10" y="20" width="30" height="40"/>', 1200.0),
        ('<g transform="rotate(20)"><circle cx="10" cy="20" r="5"/></g>', 25 * pi),
        ('<ellipse transform="rotate(20)" cx="10" cy="20" rx="5" ry="4"/>', 20 * pi),
        ('<path transform="scale(2 1) rotate(30)" d="M5 0A5 5 0 0 1-5 0A5 5 0 0 1 5 0"/>', 50 * pi),
        ('<path transform="scale(-1 1)" d="M5 0A5 5 0 0 1-5 0Z"/>', 12.5 * pi),
    ],
)
def test_shapes_of_svg_below_any_transform(tmp_path: Path, shape: str, expected: float) -> None:
    head = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="100MM" height="100MM" viewBox="0 0 50 50">'
    )
    path = tmp_path / "moved.svg"
    path.write_text(f"{head}{shape}</svg>")
    assert size(read_outline(path)) == pytest.approx(4e-6 * expected, rel=1e-5)
    for width in ("abc", "0"):
        path.write_text(f"{head}{shape}</svg>".replace('width="100', f'width="{width}', 1))
        with pytest.raises(ModelError, match=f"moved.svg is '{width}mm' wide"):
            read_outline(path)


def test_dxf_as_it_is_seen(tmp_path: Path) -> None:
    """A full circle as an arc, dust, a line drawn twice, layers of blocks and ones that are off."""
    document = ezdxf.new()
    space, block = document.modelspace(), document.blocks.new("part")
    corners = [(-10, -10), (10, -10), (10, 10), (-10, 10)]
    for k in range(4):
        block.add_line(corners[k], corners[(k + 1) % 4])
    block.add_line(corners[1], corners[0])
    block.add_arc((0, 0), 5, 0, 360)
    space.add_blockref("part", (0, 0), {"layer": "cut"})
    for length in (0.0, 1e-6):
        space.add_line((7, 7), (7 + length, 7), {"layer": "cut"})
    space.add_circle((7, 7), 0, {"layer": "cut"})
    space.add_circle((7, 7), 1, {"layer": "cut", "invisible": 1})
    document.layers.add("off").off()
    space.add_circle((7, 7), 1, {"layer": "off"})
    document.saveas(tmp_path / "seen.dxf")
    for layer in ("cut", None):
        outline = read_outline(tmp_path / "seen.dxf", layer, "mm")
        assert size(outline) == pytest.approx(1e-6 * (400 - 25 * pi), rel=1e-12)
    hidden = read_outline(tmp_path / "seen.dxf", "off", "mm")
    assert size(hidden) == pytest.approx(1e-6 * pi, rel=1e-12)
