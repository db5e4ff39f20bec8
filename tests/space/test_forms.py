"""Forms of bodies in space: extruded outlines, and meshes of files; their solids and strokes."""

import sys
from functools import partial
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, bar, disc, extruded, polygon, read_mesh, rectangle
from codegen.declare import solid_forms
from codegen.drawing.meshes import Mesh, mesh_of
from codegen.drawing.picture import SpacePicture
from codegen.drawing.plane_geometry import area, convex_hull
from codegen.drawing.solids import solids
from codegen.drawing.space_strokes import strokes_in_space
from codegen.errors import InputError, ModelError
from codegen.picture_at_start import declared_picture

ROUND = 48 / (2 * pi) * np.sin(2 * pi / 48)  # of a disc, its polygon's share
C = [(0, 0), (0, 1), (1, 1), (1, 0.8), (0.2, 0.8), (0.2, 0.2), (1, 0.2), (1, 0)]
TETRAHEDRON = np.array([(0, 0, 0), (40, 0, 0), (0, 30, 0), (0, 0, 20)])
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))


def volume(mesh: Mesh) -> float:
    """By the divergence theorem; a triangle that looks inward is counted against it."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float((np.cross(a, b) * c).sum()) / 6


def is_closed(mesh: Mesh) -> bool:
    """Whether each side of a triangle is that of one other, the other way."""
    sides = [tuple(t[[k, (k + 1) % 3]].tolist()) for t in mesh.triangles for k in range(3)]
    return len({*sides}) == len(sides) and all((b, a) in {*sides} for a, b in sides)


@pytest.mark.parametrize(
    ("outline", "size"),
    [
        (rectangle(0.3, 0.2), 0.06),
        (C, 0.52),
        (C[::-1], 0.52),
        (disc(0.1), ROUND * pi * 0.01),
        (disc(0.1).with_holes(disc(0.05, (0.02, 0))), ROUND * pi * 0.0075),
        (
            rectangle(0.4, 0.2).with_holes(
                disc(0.03, (0.1, 0.05)), polygon([(-0.1, 0), (-0.05, 0), (-0.1, 0.05)]),
                rectangle(0.1, 0.02, (0, -0.07)),
            ),
            0.08 - ROUND * pi * 0.0009 - 0.00125 - 0.002,
        ),
    ],
)  # fmt: skip
def test_plates_enclose_their_area_times_their_thickness(outline: Any, size: float) -> None:
    plate = extruded(outline, 0.5)
    assert is_closed(plate)
    assert volume(plate) == pytest.approx(0.5 * size, rel=1e-9)
    assert_allclose(np.abs(plate.vertices[:, 2]), 0.25)


def test_a_form_stands_where_it_is_placed() -> None:
    plate = extruded(rectangle(0.4, 0.2), "2 cm", at=(1, 2, 3), axes=((0, 0, 2), (0, 3, 1)))
    low, high = plate.vertices.min(axis=0), plate.vertices.max(axis=0)
    assert_allclose(high - low, [0.02, 0.2, 0.4], atol=1e-12)  # y is made perpendicular to x
    assert_allclose((high + low) / 2, [1, 2, 3])
    assert volume(plate) == pytest.approx(0.0016)


def test_the_text_of_a_mesh_is_the_mesh() -> None:
    plate = extruded(bar(0.3, 0.05), 0.01, at=(0.1, 0.2, 0.3))
    read = mesh_of(plate.text)
    assert_allclose(read.vertices, plate.vertices, rtol=1e-7, atol=1e-9)
    assert (read.triangles == plate.triangles).all()


def flywheel() -> Model:
    model = Model("flywheel", space=True, gravity=(0, 0, -9.81))
    form = [
        extruded(disc(0.4), 0.05, axes=((0, 1, 0), (0, 0, 1))),
        extruded(disc(0.02), 0.5, at=(0, 0, 0.25)),
    ]
    wheel = model.body("wheel", 2.0, (0.2, 0.1, 0.1), draw=form)
    model.revolute("axle", model.ground, wheel, at=(0, 0, 0), axis=(1, 0, 0))
    model.draw_ground(extruded(rectangle(2.0, 1.0), 0.1, at=(0, 0, -0.7)))
    model.scene("turn", ["gravity"])
    return model


def test_bodies_and_the_ground_are_what_is_given() -> None:
    picture = declared_picture(flywheel())
    assert isinstance(picture, SpacePicture)
    own = [(one.form, one.body) for one in solids(picture) if not one.element]
    assert own == [("mesh", 0), ("mesh", 1), ("mesh", 1)]
    corners = np.concatenate([picture.in_world(one.corners, one.body) for one in solids(picture)
                              if one.form == "mesh"])  # fmt: skip
    assert picture.size == pytest.approx(np.linalg.norm(np.ptp(corners, axis=0)), rel=1e-6)
    assert flywheel().draw().axes[0].collections


def test_a_still_has_the_outline_of_a_mesh() -> None:
    model = Model("box", space=True)
    model.body("b", 1.0, (1, 1, 1), axes=(0.3, -0.2, 0.5), draw=extruded(rectangle(2, 1), 0.6))
    model.scene("s")
    picture = declared_picture(model)
    assert isinstance(picture, SpacePicture)
    (box,) = solids(picture)
    strokes = strokes_in_space(picture, [box])
    hull = convex_hull(picture.flat(picture.in_world(box.corners, box.body)))
    (inside,) = (one.points for one in strokes if one.style == "inside")
    triangles = np.append(inside, np.nan).reshape(-1, 4)[:, :3]
    assert sum(area(one) for one in triangles) == pytest.approx(area(hull), rel=1e-6)
    lines = {style: [s.points for s in strokes if s.style == style] for style in ("edge", "spoke")}
    assert len(lines["edge"]) == 6
    assert len(lines["spoke"]) == 3  # between three sides that are seen
    assert all(np.min(abs(end - hull)) < 1e-6 for line in lines["edge"] for end in line)


def write(path: Path) -> Path:
    """A tetrahedron, mm, as text."""
    if path.suffix == ".obj":
        rows = [f"v {x} {y} {z}" for x, y, z in TETRAHEDRON]
        rows += ["f " + " ".join(str(k + 1) for k in face) for face in FACES]
    else:
        rows = ["solid part"]
        for face in FACES:
            corners = [f"vertex {x} {y} {z}" for x, y, z in TETRAHEDRON[list(face)]]
            rows += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        rows += ["endsolid part"]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("kind", ["stl", "obj"])
def test_meshes_are_read_from_files(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    mesh = read_mesh(write(tmp_path / f"part.{kind}"), "mm", at=(1, 0, 0))
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(4e-6)
    assert_allclose(mesh.vertices.max(axis=0), [1.04, 0.03, 0.02])


def test_meshes_that_are_too_large_or_none_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write(tmp_path / "part.stl")
    with pytest.raises(ModelError, match=r"There is no file .*par\.stl'; did you mean 'part\.stl'"):
        read_mesh(tmp_path / "par.stl", "mm")
    with pytest.raises(ModelError, match=r"forms\.py' is no file that ends in \.stl or \.obj"):
        read_mesh(__file__, "mm")
    with pytest.raises(ModelError, match=r"part\.stl, unit: 1 kilogram has"):
        read_mesh(file, "kg")
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "trimesh", None)
        with pytest.raises(InputError, match=r"Meshes need trimesh.*linkwright\[meshes\]"):
            read_mesh(file, "mm")
    pytest.importorskip("trimesh")
    monkeypatch.setattr(solid_forms, "MOST", 3)
    with pytest.raises(
        ModelError, match=r"part\.stl has 4 triangles; give a file with 1 to 3, for"
    ):
        read_mesh(file, "mm")


CROSSED: Any = (
    [(0, 0), (1, 1), (1, 0), (0, 1)],
    [(0, 0), (1, 0), (2, 0)],
    [(0, 0), (1, 0), (0.5, 1e-18)],
    [(0, 0), (10, 0), (10, 1), (5, 1), (5, 0.5), (5, 1), (0, 1)],
    rectangle(1, 1).with_holes(disc(0.1, (3, 0))),
    rectangle(1, 1).with_holes(disc(0.2, (0.5, 0))),
    rectangle(1, 1).with_holes(rectangle(0.5, 0.5, (0.25, 0))),
    rectangle(1, 1).with_holes(disc(0.2), disc(0.2)),
    rectangle(1, 1).with_holes(disc(0.2), disc(0.1)),
)
ROUNDS = np.arange(6000) * 2 * pi / 6000


def test_a_corner_given_twice_is_one() -> None:
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    for twice in ([*square, square[0]], [square[0], *square]):
        plate = extruded(twice, 0.5)
        assert is_closed(plate)
        assert len(plate.vertices) == 8


@pytest.mark.parametrize("turn", [0.0, pi])
def test_an_open_mesh_shows_its_border_from_either_side(turn: float) -> None:
    sheet = Mesh(np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.0)]),
                 np.array([(0, 1, 2), (0, 2, 3)]))  # fmt: skip
    model = Model("sheet", space=True)
    model.body("b", 1.0, (1, 1, 1), axes=(turn, 0, 0), draw=sheet)
    model.scene("s")
    picture = declared_picture(model)
    assert isinstance(picture, SpacePicture)
    (solid,) = solids(picture)
    styles = [stroke.style for stroke in strokes_in_space(picture, [solid])]
    assert styles.count("edge") == 4
    assert model.draw()


def test_meshes_have_triangles_within_reach(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    file = write(tmp_path / "part.obj")
    file.write_text(file.read_text().replace("40", "5e7"))
    with pytest.raises(ModelError, match=r"4 triangles with an area, and corners to 5e\+10 m"):
        read_mesh(file, "km")
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 0 0\nf 1 2 3\n")
    with pytest.raises(ModelError, match=r"part\.obj has 0 triangles with an area"):
        read_mesh(file, "mm")


@pytest.mark.parametrize("corner", ["0", "0/1/1"])
def test_a_face_without_a_vertex_is_refused_by_its_line(corner: str, tmp_path: Path) -> None:
    """It is the last vertex to trimesh; normals and lines that are no faces may have a 0."""
    pytest.importorskip("trimesh")
    file = write(tmp_path / "part.obj")
    text = file.read_text()
    file.write_text(f"vn 0 0 0\n{text}f 1 2 {corner}\n")
    with pytest.raises(ModelError, match=r"part\.obj, line 10: a face has the vertex 0; OBJ"):
        read_mesh(file, "mm")
    file.write_text(f"vn 0 0 0\n{text}")
    assert is_closed(read_mesh(file, "mm"))


@pytest.mark.parametrize("number", ["nan", "inf"])
@pytest.mark.parametrize("kind", ["stl", "obj"])
def test_a_corner_that_is_not_finite_is_refused(kind: str, number: str, tmp_path: Path) -> None:
    """Else its triangles would be left out."""
    pytest.importorskip("trimesh")
    file = write(tmp_path / f"part.{kind}")
    file.write_text(file.read_text().replace("40", number))
    with pytest.raises(ModelError, match=rf"part\.{kind}: triangle \d has a corner that is not"):
        read_mesh(file, "mm")


def test_a_file_that_is_cut_off_is_no_package_that_is_missing(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    half = tmp_path / "half.stl"
    half.write_bytes(bytes(80) + (12).to_bytes(4, "little") + bytes([0, 0, 128, 63]) * 70)
    # Where a package that guesses encodings is installed, the file is read as a text of nothing.
    said = r"half\.stl (cannot be read: it is damaged, or cut off|has 0 triangles with an area)"
    with pytest.raises(ModelError, match=said):
        read_mesh(half, "mm")


def pictured(draw: Any = None, ground: Any = None) -> None:
    """The picture of one body with forms."""
    model = Model("m", space=True)
    model.body("b", 1.0, (1, 1, 1), draw=draw)
    model.draw_ground(ground)
    model.scene("s")
    declared_picture(model)


@pytest.mark.parametrize(
    ("mistake", "text"),
    [
        (lambda: extruded(3, 1), "3 is no list of three corners"),
        (lambda: extruded(disc(1), 0), "thickness is 0; give a length of more than 0 m"),
        (lambda: extruded(disc(1), 1e300), "thickness is 1e.300; give a length"),
        (lambda: extruded(disc(1), 1, at=(0, 0, 1e10)), "at is .*; give a place, three numbers"),
        (lambda: extruded([(0, 0), (1e300, 0), (0, 1e300)], 1), r"not within 1e\+09 m"),
        (lambda: extruded(disc(1), 1, at=3), "at is 3, axes is .*; give a place, three numbers"),
        (lambda: extruded(disc(1), 1, axes=((1, 0, 0), (2, 0, 0))), "two directions that are not"),
        (lambda: extruded(disc(1), 1, axes=3), "axes is 3; give a place"),
        (lambda: extruded(disc(1), "3 kg"), "thickness is '3 kg'; give a length"),
        (lambda: extruded([(0, 0), (1, np.nan), (1, 1)], 1), "a corner that is not within"),
        *((partial(extruded, lines, 0.1), "cross, touch or bound no area") for lines in CROSSED),
        (
            lambda: extruded(polygon(np.array([np.cos(ROUNDS), np.sin(ROUNDS)]).T.tolist()), 1),
            "takes 24000 triangles or more, and a page has room for 20000",
        ),
        (
            lambda: extruded(disc(Model("m").parameter("r", 1.0, unit="m")), 1),
            "contains parameters",
        ),
        (lambda: pictured(draw=[disc(1)]), "body 'b': draw is .*; give what extruded"),
        (lambda: pictured(ground=7), "ground: draw is 7; give what extruded"),
    ],
)
def test_mistakes_are_told(mistake: Any, text: str) -> None:
    with pytest.raises(ModelError, match=text):
        mistake()
