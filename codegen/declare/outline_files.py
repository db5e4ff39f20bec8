"""Outlines out of drawings, and paths into them: DXF by ezdxf, SVG read by svgelements.

A drawing is a heap of strands, curves from end to end, which are joined into loops: the largest is
the outline, and the others are its holes.
"""

from collections.abc import Callable, Iterable, Iterator
from math import hypot, pi, radians, tan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.declare.outlines import Outline, numbers_of
from codegen.drawing.plane_geometry import Points, area, flattened, library, pairs
from codegen.errors import ModelError
from codegen.files.whole_files import whole_file
from codegen.readers.calls import declaring
from codegen.readers.quantities import UnitError, converted, finite_in_unit
from codegen.readers.values import nearest, shown

GAP = 1e-6  # accuracy: of the drawing's diagonal; ends of lines that are nearer meet
FLAT = 1e-6  # accuracy: of the diagonal; how far a polygon may be from the spline it stands for
PARTS = 500  # accuracy: edges for a spline of an SVG file; a half circle errs by 5e-6 of its radius
_LINE = 0.003  # layout: of the larger side of a path; width of its line in an SVG file
DRAWN = 5e-4  # layout: of the diagonal; the same of the polygon that is drawn


class Strand(NamedTuple):
    """A curve from end to end: its points (k,), x + iy, and the bulges of the edges between."""

    points: list[complex]
    bulges: list[float]


@declaring("read_outline")
def read_outline(file: str | Path, layer: str | None = None, unit: str | None = None) -> Outline:
    """The outline, with its holes, that a DXF or SVG file draws, in m and in the drawing's axes.

    Lines, arcs and circles are exact; splines and ellipses become polygons. The y axis of an SVG
    file points upwards here. A change of the file makes builds stale.

    Parameters
    ----------
    file
        Its path ends in ``.dxf`` or ``.svg``; model files write ``Path(__file__).parent / name``.
    layer
        The layer of a DXF file, or the id or label of a group of an SVG file; all unless given.
    unit
        Unit of the drawing's numbers, such as ``"mm"``, or of the pixels of an SVG file; by default
        the unit that the file names.

    Raises
    ------
    ModelError
        If the file does not exist, has another format, names no unit, or has open contours; the
        message has the distances of their ends.
    InputError
        If ezdxf, shapely or svgelements is not installed.
    """
    path = drawing_file(file, (".dxf", ".svg"))
    reader = _of_dxf if path.suffix.lower() == ".dxf" else _of_svg
    try:
        strands, own = reader(path, layer)
        scale = own if unit is None else float(converted(1.0, unit, "m"))
    except UnitError as misfit:
        raise ModelError(f"{path.name}, unit: {misfit}") from misfit
    if scale is None:
        raise ModelError(f"{path.name} does not say its unit; give unit='mm' or another one.")
    gap = GAP * _diagonal(np.array([p for one in strands for p in one.points]))
    strands = _distinct(strands, gap)
    if not strands:
        raise ModelError(f"{path.name} has no lines, arcs, circles or splines there.")
    loops = [_outline(one, scale) for one in _loops(path.name, strands, scale, gap)]
    loops.sort(key=lambda one: -abs(area(numbers_of(tuple(one), {}))))
    return loops[0].with_holes(*loops[1:])


def drawing_file(file: str | Path, kinds: tuple[str, ...]) -> Path:
    """The path of a file that exists and ends in one of two kinds."""
    path = Path(str(file))
    if not path.is_file():
        beside = [one.name for one in path.parent.glob("*.*") if one.suffix.lower() in kinds]
        raise ModelError(f"There is no file {shown(str(path))}; {nearest(path.name, beside)}")
    if path.suffix.lower() not in kinds:
        raise ModelError(f"{shown(str(path))} is no file that ends in {' or '.join(kinds)}.")
    return path


def _outline(strand: Strand, scale: float) -> Outline:
    """A closed strand as an outline in m; its polygon in pictures has the corners that show."""
    points = np.array([scale * p for p in strand.points])
    kept = np.flatnonzero(np.diff(points))
    corners = tuple(map(tuple, pairs(points[kept]).tolist()))
    bulges = tuple(strand.bulges[k] for k in kept)
    shape = library("shapely").LinearRing(flattened(corners, bulges))
    drawn = shape.simplify(DRAWN * _diagonal(points)).coords[:-1]
    return Outline(corners, bulges, drawn=tuple(drawn))


def _distinct(strands: list[Strand], gap: float) -> list[Strand]:
    """Without those that are shorter than the gap or drawn twice, in either direction."""
    found = dict[tuple[tuple[complex, ...], tuple[float, ...]], Strand]()
    for one in strands:
        back = tuple(one.points[::-1]), tuple(-bulge for bulge in one.bulges[::-1])
        if back not in found and _diagonal(np.array(one.points)) > gap:
            found[tuple(one.points), tuple(one.bulges)] = one
    return [*found.values()]


def _loops(name: str, strands: list[Strand], scale: float, gap: float) -> Iterator[Strand]:
    """Strands joined end to end until they are closed."""
    miner = library("ezdxf.edgeminer")
    edges = []
    for one in strands:
        first, last = one.points[0], one.points[-1]
        if abs(last - first) <= gap:
            yield one
        else:
            ends = ((p.real, p.imag) for p in (first, last))
            edges.append(miner.make_edge(*ends, payload=one))
    for chain in miner.find_all_simple_chains(miner.Deposit(edges, gap_tol=gap)) if edges else ():
        points, bulges = list[complex](), list[float]()
        for edge in chain:
            way, sign = (-1, -1.0) if edge.is_reverse else (1, 1.0)
            points += edge.payload.points[::way][bool(points) :]
            bulges += [sign * bulge for bulge in edge.payload.bulges[::way]]
        first, last = scale * points[0], scale * points[-1]
        if abs(last - first) > scale * gap:
            raise ModelError(
                f"{name} has a line or contour that is open, from ({first.real:.6g}, "
                f"{first.imag:.6g}) m to ({last.real:.6g}, {last.imag:.6g}) m, whose ends are "
                f"{abs(last - first):.6g} m apart; close it, take construction lines away, or name "
                "by layer= what draws the outline alone."
            )
        yield Strand(points, bulges)


def _diagonal(points: Points) -> float:
    """The diagonal of the box about points; 0 without one."""
    return float(np.hypot(np.ptp(points.real), np.ptp(points.imag))) if len(points) else 0.0


def _strand(corners: Iterable[tuple[float, float, float]], is_closed: bool = False) -> Strand:
    """From (x, y, bulge) of each corner."""
    rows = [*corners]
    rows += rows[:1] if is_closed else []
    return Strand([complex(x, y) for x, y, _ in rows], [bulge for _, _, bulge in rows[:-1]])


def _of_dxf(path: Path, layer: str | None) -> tuple[list[Strand], float | None]:
    """The strands of a DXF file, and its unit in m."""
    dxf, units = library("ezdxf"), library("ezdxf.units")
    try:
        document = dxf.readfile(path)
    except (OSError, dxf.DXFError) as error:
        raise ModelError(f"{path.name} cannot be read as DXF: {error}") from error
    off = {row.dxf.name.lower() for row in document.layers if row.is_off() or row.is_frozen()}
    flat = [*_visible(document.modelspace(), off - {(layer or "").lower()})]
    if layer is not None:
        names = {one.dxf.layer for one in flat}
        flat = [one for one in flat if one.dxf.layer.lower() == layer.lower()]
        if not flat:
            hint = nearest(layer, names)
            raise ModelError(f"{path.name} draws nothing on layer {shown(layer)}; {hint}")
    library("ezdxf.upright").upright_all(flat)
    for one in flat:
        x, y, z = one.dxf.get("extrusion", (0.0, 0.0, 1.0))
        if hypot(x, y) > GAP * z and one.dxftype() not in ("LINE", "SPLINE"):  # these are in space
            raise ModelError(
                f"{path.name}, layer {shown(one.dxf.layer)}: a {one.dxftype()} has the normal "
                f"({x:g}, {y:g}, {z:g}); draw it in the x-y plane, or leave it out by layer=."
            )
    distance = FLAT * library("ezdxf.bbox").extents(flat).size.magnitude if flat else 0.0
    unit = units.conversion_factor(document.units, units.M) if document.units else None
    return [_DXF[one.dxftype()](one, distance) for one in flat], unit


def _visible(entities: Iterable[Any], off: set[str], around: str = "0") -> Iterator[Any]:
    """What is drawn, on layers that are not off; of blocks layer 0 is that of the insert around."""
    for one in entities:
        if one.dxf.layer == "0":
            one.dxf.layer = around
        if one.dxf.layer.lower() in off or one.dxf.get("invisible", 0):
            continue
        if one.dxftype() == "INSERT":
            for each in one.multi_insert():
                yield from _visible(each.virtual_entities(), off, one.dxf.layer)
        elif one.dxftype() in _DXF:
            yield one


def _arc(arc: Any, _: float) -> Strand:
    (x, y, _), (u, v, _) = arc.start_point, arc.end_point
    sweep = radians((arc.dxf.end_angle - arc.dxf.start_angle) % 360.0)
    if min(sweep, 2.0 * pi - sweep) < GAP:
        return _circle(arc, 0.0)
    return _strand([(x, y, tan(sweep / 4)), (u, v, 0.0)])


def _circle(circle: Any, _: float) -> Strand:
    (x, y, _), radius = circle.dxf.center, circle.dxf.radius
    return _strand([(x + radius, y, 1.0), (x - radius, y, 1.0)], True)


def _spline(curve: Any, distance: float) -> Strand:
    return _strand((p.x, p.y, 0.0) for p in curve.flattening(distance))


_DXF: dict[str, Callable[[Any, float], Strand]] = {
    "LINE": lambda line, _: _strand((p.x, p.y, 0.0) for p in (line.dxf.start, line.dxf.end)),
    "ARC": _arc, "CIRCLE": _circle, "ELLIPSE": _spline, "SPLINE": _spline,
    "LWPOLYLINE": lambda line, _: _strand(line.get_points("xyb"), line.closed),
    "POLYLINE": lambda line, _: _strand(
        ((*v.dxf.location.vec2, v.dxf.get("bulge", 0.0)) for v in line.vertices), line.is_closed
    ),
}  # fmt: skip
"""Kind of an entity → its strand; splines are within a distance of theirs."""


def _of_svg(path: Path, layer: str | None) -> tuple[list[Strand], float | None]:
    """The strands of an SVG file, y upwards, and the size of its pixels in m."""
    svg = library("svgelements")
    try:
        root = svg.SVG.parse(str(path), reify=False)
    except Exception as error:  # of the parser of XML, or of a number that is none
        raise ModelError(f"{path.name} cannot be read as SVG: {error}") from error
    groups = {
        name: one for one in root.elements(lambda each: isinstance(each, svg.Group))
        for key, name in one.values["attributes"].items() if key == "id" or key.endswith("}label")
    }  # fmt: skip
    if layer is not None and layer not in groups:
        raise ModelError(f"{path.name} has no group {shown(layer)}; {nearest(layer, groups)}")
    drawn = root if layer is None else groups[layer]
    lines = [
        line for shape in drawn.select() if isinstance(shape, svg.Shape)
        for line in svg.Path(shape).as_subpaths() if len(line) > 1
    ]  # fmt: skip
    width, unit = str(root.values["attributes"].get("width", "")).strip().lower(), None
    if width.endswith(("mm", "cm", "in")):
        size = finite_in_unit(width, "m") or 0.0
        if size <= 0.0:
            raise ModelError(f"{path.name} is {shown(width)} wide; write a width such as '100mm'.")
        unit = size / float(root.width)
    return [_svg_strand(svg.Path(line)) for line in lines], unit


def _svg_strand(path: Any) -> Strand:
    """A part of a path without gaps, y upwards; arcs are those before its transform."""
    m = path.transform
    turned, mirrored = (complex(m.a + s * m.d, m.b - s * m.c) / 2 for s in (1, -1))
    is_similar = min(abs(turned), abs(mirrored)) < GAP * max(abs(turned), abs(mirrored))
    sign = 1 if abs(mirrored) > abs(turned) else -1
    points, bulges = list[complex](), list[float]()
    for segment in path[1:]:  # behind the move to its start
        kind, at, bulge = type(segment).__name__, np.linspace(0, 1, 2), 0.0
        if kind == "Arc" and is_similar and abs(segment.rx - segment.ry) < GAP * segment.rx:
            bulge = sign * tan(segment.sweep / 4)
        elif kind not in ("Line", "Close"):
            at = np.linspace(0, 1, PARTS + 1)
        places = segment.npoint(at) @ [1, 1j]
        places = turned * places + mirrored * places.conj() + complex(m.e, m.f)
        points[-1:] = places.conj().tolist()
        bulges += [bulge] * (len(at) - 1)
    return Strand(points, bulges)


@declaring("write_path")
def write_path(file: str | Path, points: Any, closed: bool = False) -> Path:
    """Write a path through points, of a cam, a coupler or a slot, into a DXF or SVG file, in mm.

    `read_outline` reads it back; in an SVG file the origin is the upper left corner of the path.

    Parameters
    ----------
    file
        Its path ends in ``.dxf`` or ``.svg``.
    points
        (x, y) in m, an array of two columns: ``result.point("P")``, ``profile.points()``.
    closed
        Whether the last point is joined to the first.
    """
    path, rows = Path(str(file)), 1e3 * np.asarray(points, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 2 or not np.isfinite(rows).all() or not len(rows):
        raise ModelError(f"{path.name}: a path is an array of finite x and y, two columns.")
    if (kind := path.suffix.lower()) not in (".dxf", ".svg"):
        raise ModelError(f"{path.name}: a path is written into a file that ends in .dxf or .svg.")
    if kind == ".dxf":
        document = library("ezdxf").new()
        document.units = library("ezdxf.units").MM
        document.modelspace().add_lwpolyline(rows.tolist(), format="xy", close=closed)
        with whole_file(path) as temporary:
            document.saveas(temporary)
        return path
    rows = np.column_stack([rows[:, 0] - rows[:, 0].min(), rows[:, 1].max() - rows[:, 1]])
    width, height = np.maximum(rows.max(axis=0), _LINE * (rows.max() or 1.0)).tolist()
    way = " L ".join(f"{x!r},{y!r}" for x, y in rows.tolist())
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}" overflow="visible">\n<path d="M {way}{" Z" * closed}" '
        f'fill="none" stroke="black" stroke-width="{_LINE * max(width, height):.3g}"/>\n</svg>\n'
    )
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path
