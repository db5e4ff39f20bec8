"""A picture in space as strokes in the plane of its view, the farthest first, and its arrows."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from codegen.drawing.annotations import FRAME, LARGEST, Arrow, Load, arrow, force_scale, largest_of
from codegen.drawing.lines_between_bodies import GAP, linked, links
from codegen.drawing.picture import ARROW, HEAD, PIN, SPRING, SpacePicture, Symbol
from codegen.drawing.plane_geometry import FloatArray, Points, convex_hull, straight_arrow, unit
from codegen.drawing.shapes import Rod, Spring
from codegen.drawing.solids import Solid, held_apart
from codegen.drawing.space_shapes import SpaceJoint
from codegen.drawing.styles import Stroke

SHARP = 0.85  # layout: cosine between triangles at whose edge a mesh has a line
LEAST = 0.02  # layout: of an arrow toward the viewer, in typical lengths


def strokes_in_space(
    picture: SpacePicture, rigid: Iterable[Solid], gaps: bool = True
) -> list[Stroke]:
    """The strokes of solids, springs, rods and open joints, from the farthest to the nearest."""
    found: list[tuple[float, list[Stroke]]] = []
    for solid in rigid:
        points = picture.in_world(solid.corners, solid.body)
        if not np.isfinite(points).all():
            continue
        depth = _depth(picture, points)
        if solid.mesh:
            found.append((depth, _of_mesh(picture, solid, points)))
            continue
        line = convex_hull(picture.flat(points))
        styles: tuple[str, ...] = ("edge", "inside")
        if solid.form == "plate":
            styles = ("plate",)
        elif solid.element:  # before the bars that it holds
            styles = ("support",) if picture.is_ground(solid.body) else ("hub",)
            depth += 2.0 * PIN * picture.size
        found.append((depth, [Stroke(s, solid.body, line, True, solid.element) for s in styles]))
    for symbol in picture.symbols:
        shape = symbol.shape
        if isinstance(shape, Rod | Spring):
            ends = np.array([picture.where(shape.i), picture.where(shape.j)])
            if np.isfinite(ends).all():
                i, j = picture.flat(ends)
                lines = [(s, linked(p, i, j, SPRING * picture.size)) for s, p in links(shape)]
                depth = _depth(picture, ends)
                found.append((depth, [Stroke(s, 0, p, False, symbol.element) for s, p in lines]))
    ordered = sorted(found, key=lambda one: one[0])
    open_joints = [gap_in_space(picture, symbol) for symbol in picture.symbols if gaps]
    return [
        *(stroke for _, strokes in ordered for stroke in strokes),
        *(Stroke("gap", 0, gap) for gap, _ in filter(None, open_joints)),
    ]


def _of_mesh(picture: SpacePicture, solid: Solid, points: FloatArray) -> list[Stroke]:
    """The outer edges of a mesh, its inside as one stroke with gaps, and its sharp edges."""
    assert solid.mesh
    triangles, flat, body = solid.mesh.triangles, picture.flat(points), solid.body
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    seen = normals @ picture.view[2] > 0.0
    sides = np.sort(np.concatenate(np.moveaxis(triangles[:, [[0, 1], [1, 2], [2, 0]]], 1, 0)))
    order = np.lexsort(sides.T)
    twice = np.flatnonzero((np.diff(sides[order], axis=0) == 0).all(axis=1))
    edges, one, other = sides[order][twice], *(order[twice + k] % len(triangles) for k in (0, 1))
    outer, border = seen[one] != seen[other], np.delete(order, [*twice, *(twice + 1)])
    sharp = seen[one] & seen[other] & ((normals[one] * normals[other]).sum(axis=1) < SHARP)
    cells = np.column_stack([flat[triangles[seen]], np.full(seen.sum(), np.nan)]).ravel()
    return [
        *(Stroke("edge", body, flat[edge]) for edge in (*edges[outer], *sides[border])),
        *([Stroke("inside", body, cells[:-1])] if seen.any() else []),
        *(Stroke("spoke", body, flat[edge]) for edge in edges[sharp]),
    ]


def _depth(picture: SpacePicture, points: FloatArray) -> float:
    """How near points lie to the viewer, in the mean."""
    return float((points @ picture.view[2]).mean())


def gap_in_space(picture: SpacePicture, symbol: Symbol) -> tuple[Points, float] | None:
    """Two places (2,) that a joint should hold together and does not, and their distance, m."""
    if symbol.role != "joint" or not isinstance(symbol.shape, SpaceJoint):
        return None
    apart = held_apart(picture, symbol.shape)
    end = picture.where(symbol.shape.j)
    distance = float(np.linalg.norm(apart))
    line = picture.flat(np.array([end - apart, end]))
    return (line, distance) if distance > GAP * picture.size else None


def arrows_in_space(picture: SpacePicture, acting: list[Load], to_scale: bool) -> list[Arrow]:
    """What acts, each with its arrow; a torque has two heads, along the axis that it turns about.

    The loads are in the plane of the view, with their true sizes.
    """
    scale = {
        "N": force_scale(picture, acting) or 0.0,
        "N m": LARGEST * picture.size / (largest_of(acting, "N m") or 1.0),
    }
    found = []
    for load in acting:
        long = scale[load.unit] * load.size if to_scale else ARROW * picture.size
        start, way = picture.flat(load.at), picture.flat(load.value / load.size) * long
        if abs(way) < LEAST * picture.size:
            way = LEAST * picture.size * unit(way)
        shaft, tip = straight_arrow(start, start + way, HEAD * picture.size)
        strokes = arrow(load.style, (shaft, tip), load.element)
        if load.style == "torque":
            strokes.append(strokes[1]._replace(points=tip - 0.7 * abs(tip[0] - tip[1]) * unit(way)))
        flat = load._replace(at=start, value=load.size * unit(way), place=None)
        found.append((flat, strokes))
    return found


def frames_in_space(picture: SpacePicture) -> Iterator[Stroke]:
    """The axes x', y' and z' of all bodies that move."""
    for number in range(1, len(picture.bodies)):
        tips = picture.in_world(FRAME * picture.size * np.eye(3), number)
        start: Any = picture.flat(picture.poses[number, :3])
        for tip in picture.flat(tips):
            yield from arrow("axis", straight_arrow(start, tip, 0.5 * HEAD * picture.size))
