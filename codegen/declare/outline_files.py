"""Outlines out of drawings: DXF is read by ezdxf, SVG by svgelements.

A drawing is a heap of strands, curves from end to end. They are joined into loops, of which the
largest is the outline and the others are its holes.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from math import radians, tan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.declare.outlines import Outline, flattened
from codegen.drawing.plane_geometry import Points, area, distance_to_edge
from codegen.errors import InputError, ModelError
from codegen.readers.calls import declaring
from codegen.readers.quantities import UnitError, converted
from codegen.readers.values import nearest, shown

GAP = 1e-6  # accuracy: of the drawing's diagonal; ends of strands that are nearer meet
FLAT = 1e-6  # accuracy: of the diagonal; how far a polygon may be from the spline it stands for
DRAWN = 2e-4  # layout: the same of the polygon that is drawn
METRES = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6}


class Strand(NamedTuple):
    """A curve from end to end: its points (k,), x + iy, and the bulges of the edges between."""

    points: list[complex]
    bulges: list[float]

    @property
    def reversed(self) -> "Strand":
        """The same curve the other way."""
        return Strand(self.points[::-1], [-bulge for bulge in self.bulges[::-1]])


@declaring("read_outline")
def read_outline(file: str | Path, layer: str | None = None, unit: str | None = None) -> Outline:
    """The outline, with its holes, that a DXF or SVG file draws.

    Lines, arcs and circles are exact; splines and ellipses become polygons that are within 1e-6 of
    the diagonal of the drawing. The largest loop is the outline, loops in it are holes. Texts,
    dimensions and hatchings are not read. Needs the extra `drawings`.

    Parameters
    ----------
    file
        Its path ends in ``.dxf`` or ``.svg``; model files write ``Path(__file__).parent / name``. A
        change of it makes builds stale.
    layer
        The layer that is read, of a DXF file, or the id or the label of a group of an SVG file; all
        of the drawing unless given.
    unit
        Unit of the drawing's numbers, ``"mm"``, of an SVG file of its pixels; that which the file
        names unless given.

    Returns
    -------
    Outline
        In the axes of the drawing, m; those of an SVG file with y upwards, from its upper left.

    Raises
    ------
    ModelError
        If the file does not exist or is none of these, names no unit, or has contours that are
        open, with the distance of their ends.
    InputError
        If ezdxf or svgelements is not installed.
    """
    path = Path(file)
    readers = {".dxf": _of_dxf, ".svg": _of_svg}
    if path.suffix.lower() not in readers:
        raise ModelError(f"{shown(str(file))}: give a file that ends in .dxf or .svg.")
    if not path.is_file():
        raise ModelError(f"read_outline: there is no file {shown(str(path))}.")
    strands, own = readers[path.suffix.lower()](path, layer)
    try:
        scale = own if unit is None else float(converted(1.0, unit, "m"))
    except UnitError as misfit:
        raise ModelError(f"{path.name}, unit: {misfit}") from misfit
    if scale is None:
        raise ModelError(f"{path.name} does not say its unit; give unit='mm' or another one.")
    if not strands:
        where = "" if layer is None else f" on layer {shown(layer)}"
        raise ModelError(f"{path.name} has no lines, arcs, circles or splines{where}.")
    loops = [_outline(one, scale) for one in _loops(path.name, strands, scale)]
    loops.sort(key=lambda one: -abs(area(np.array(one) @ [1, 1j])))
    return loops[0].with_holes(*loops[1:])


def _outline(strand: Strand, scale: float) -> Outline:
    """A closed strand as an outline in m; its polygon in pictures has the corners that show."""
    ends = [k for k, (p, q) in enumerate(pairwise(strand.points)) if p != q]
    corners = tuple((scale * strand.points[k].real, scale * strand.points[k].imag) for k in ends)
    bulges = tuple(strand.bulges[k] for k in ends)
    points = np.array(flattened(corners, bulges)) @ [1, 1j]
    tolerance, kept = DRAWN * _diagonal(points), [0]
    for k in range(2, len(points)):
        chord = points[[kept[-1], k]]
        if any(distance_to_edge(chord, p) > tolerance for p in points[kept[-1] + 1 : k]):
            kept.append(k - 1)
    drawn = tuple((float(points[k].real), float(points[k].imag)) for k in (*kept, len(points) - 1))
    return Outline(corners, bulges, drawn=drawn)


def _loops(name: str, strands: list[Strand], scale: float) -> Iterator[Strand]:
    """Strands joined end to end until they are closed."""
    from ezdxf import edgeminer

    gap = GAP * _diagonal(np.array([p for one in strands for p in one.points]))
    edges = []
    for one in strands:
        first, last = one.points[0], one.points[-1]
        if abs(last - first) <= gap:
            yield one
        else:
            ends = ((p.real, p.imag) for p in (first, last))
            edges.append(edgeminer.make_edge(*ends, payload=one))
    deposit = edgeminer.Deposit(edges, gap_tol=gap) if edges else None
    for chain in edgeminer.find_all_simple_chains(deposit) if deposit else ():
        parts = [edge.payload.reversed if edge.is_reverse else edge.payload for edge in chain]
        points = [parts[0].points[0], *(p for part in parts for p in part.points[1:])]
        first, last = scale * points[0], scale * points[-1]
        if abs(last - first) > scale * gap:
            raise ModelError(
                f"{name} has an open contour, from ({first.real:.6g}, {first.imag:.6g}) m to "
                f"({last.real:.6g}, {last.imag:.6g}) m, whose ends are {abs(last - first):.6g} m "
                "apart; close it, or name by layer= what draws the outline alone."
            )
        yield Strand(points, [bulge for part in parts for bulge in part.bulges])


def _diagonal(points: Points) -> float:
    """The diagonal of the box about points."""
    return float(np.hypot(np.ptp(points.real), np.ptp(points.imag)))


def _missing(package: str, error: ImportError) -> InputError:
    return InputError(
        f"Drawings are read by {package}, which cannot be imported ({error}). Run pip install "
        "'linkwright[drawings]', in the checkout pip install '.[drawings]'."
    )


def _of_dxf(path: Path, layer: str | None) -> tuple[list[Strand], float | None]:
    """The strands of a DXF file, and its unit in m."""
    try:
        import ezdxf
        from ezdxf import bbox, disassemble, upright
        from ezdxf.units import M, conversion_factor
    except ImportError as error:
        raise _missing("ezdxf", error) from error
    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError) as error:
        raise ModelError(f"{path.name} cannot be read as DXF: {error}") from error
    space = document.modelspace()
    wanted = [one for one in space if one.dxftype() == "INSERT" or one.dxftype() in _DXF]
    flat = [one for one in disassemble.recursive_decompose(wanted) if one.dxftype() in _DXF]
    layers = {one.dxf.layer.lower(): one.dxf.layer for one in flat}
    if layer is not None and layer.lower() not in layers:
        raise ModelError(
            f"{path.name} draws nothing on layer {shown(layer)}; {nearest(layer, layers.values())}"
        )
    flat = [one for one in flat if layer is None or one.dxf.layer.lower() == layer.lower()]
    upright.upright_all(flat)
    distance = FLAT * bbox.extents(flat).size.magnitude if flat else 0.0
    strands = [_DXF[one.dxftype()](one, distance) for one in flat]
    return strands, conversion_factor(document.units, M) if document.units else None


def _polyline(corners: Iterable[tuple[float, float, float]], is_closed: bool) -> Strand:
    """From (x, y, bulge) of each corner."""
    rows = [*corners]
    rows += rows[:1] if is_closed else []
    return Strand([complex(x, y) for x, y, _ in rows], [bulge for _, _, bulge in rows[:-1]])


def _straight(points: Iterable[Any]) -> Strand:
    return _polyline(((p.x, p.y, 0.0) for p in points), False)


def _arc(arc: Any, _: float) -> Strand:
    (x, y, _), (u, v, _) = arc.start_point, arc.end_point
    sweep = radians((arc.dxf.end_angle - arc.dxf.start_angle) % 360.0)
    return _polyline([(x, y, tan(sweep / 4)), (u, v, 0.0)], False)


def _circle(circle: Any, _: float) -> Strand:
    (x, y, _), radius = circle.dxf.center, circle.dxf.radius
    return _polyline([(x + radius, y, 1.0), (x - radius, y, 1.0)], True)


_DXF: dict[str, Callable[[Any, float], Strand]] = {
    "LINE": lambda one, _: _straight((one.dxf.start, one.dxf.end)),
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": lambda one, distance: _straight(one.flattening(distance)),
    "SPLINE": lambda one, distance: _straight(one.flattening(distance)),
    "LWPOLYLINE": lambda one, _: _polyline(one.get_points("xyb"), one.closed),
    "POLYLINE": lambda one, _: _polyline(
        ((*v.dxf.location.vec2, v.dxf.get("bulge", 0.0)) for v in one.vertices), one.is_closed
    ),
}
"""Kind of an entity → its strand; splines are within a distance of theirs."""


def _of_svg(path: Path, layer: str | None) -> tuple[list[Strand], float | None]:
    """The strands of an SVG file, y upwards, and the size of its pixels in m."""
    try:
        import svgelements as svg
    except ImportError as error:
        raise _missing("svgelements", error) from error
    try:
        root = svg.SVG.parse(str(path))
    except Exception as error:  # of the parser of XML, or of a number that is none
        raise ModelError(f"{path.name} cannot be read as SVG: {error}") from error
    group: Any = root
    if layer is not None:
        groups = {name: one for one in root.elements(lambda e: isinstance(e, svg.Group))
                  for key, name in one.values["attributes"].items()
                  if key == "id" or key.endswith("}label")}  # fmt: skip
        if layer not in groups:
            raise ModelError(f"{path.name} has no group {shown(layer)}; {nearest(layer, groups)}")
        group = groups[layer]
    shapes = (one for one in group.select() if isinstance(one, svg.Shape))
    lines = [line for shape in shapes for line in svg.Path(shape).as_subpaths() if len(line) > 1]
    paths = [svg.Path(line) for line in lines]
    boxes = [box for box in (one.bbox() for one in paths) if box]
    x, y, u, v = np.array(boxes).T if boxes else np.zeros((4, 1))
    distance = FLAT * abs(complex(u.max() - x.min(), v.max() - y.min()))
    width = str(root.values["attributes"].get("width", "")).strip()
    metres = METRES.get(width.lstrip("+.0123456789eE"))
    number = width.rstrip("mcinpt")
    unit = None if metres is None else metres * float(number) / float(root.width)
    return [_svg_strand(one, distance) for one in paths], unit


def _svg_strand(path: Any, distance: float) -> Strand:
    """A part of a path without gaps."""
    rows: list[tuple[float, float, float]] = []
    for segment in path:
        if segment.start is None:
            continue
        first, last = segment.start, segment.end
        bulge, between = 0.0, []
        kind = type(segment).__name__
        if kind == "Arc" and abs(segment.rx - segment.ry) < GAP * segment.rx:
            bulge = -tan(segment.sweep / 4)
        elif kind in ("Arc", "CubicBezier", "QuadraticBezier"):
            count = 4
            while count < 4096:
                places = segment.npoint(np.linspace(0, 1, 2 * count + 1)) @ [1, 1j]
                chords = (places[:-2:2] + places[2::2]) / 2
                if abs(places[1::2] - chords).max() <= distance:
                    break
                count *= 2
            between = [(z.real, -z.imag, 0.0) for z in places[1:-1].tolist()]
        rows += [(first.x, -first.y, bulge), *between]
    rows.append((last.x, -last.y, 0.0))
    return _polyline(rows, False)
