"""Surfaces of triangles, as which the modeller gives the form of a body in space."""

import base64
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from codegen.drawing.plane_geometry import FloatArray, Points, area, contains, pairs
from codegen.errors import ModelError

MOST = 20_000  # layout: triangles of a mesh; a page has some 10 bytes for each
NO_AREA = (
    "the lines of a form cross, touch or bound no area; give an outline round one area, and holes "
    "within it that are apart."
)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles in the frame of a body, whose corners go round to the left outside."""

    vertices: FloatArray  # (k, 3), m
    triangles: Any  # (n, 3), numbers of vertices

    @property
    def text(self) -> str:
        """The mesh as one word of a picture's layout."""
        parts = [len(self.vertices)], self.vertices.ravel(), self.triangles.ravel()
        return base64.b64encode(np.concatenate(parts).astype("<f4").tobytes()).decode("ascii")


@cache
def mesh_of(text: str) -> Mesh:
    """The mesh of a text."""
    count, *_ = numbers = np.frombuffer(base64.b64decode(text), "<f4").astype(float)
    vertices, triangles = np.split(numbers[1:], [3 * int(count)])
    return Mesh(vertices.reshape(-1, 3), triangles.reshape(-1, 3).astype(int))


def prism(loops: list[Points], height: float) -> Mesh:
    """A plate between z = -height/2 and height/2, with an outline and holes.

    Raises
    ------
    ModelError
        Where the lines bound no areas, or would take too many triangles.
    """
    loops = [loop[loop != np.roll(loop, 1)] for loop in loops]
    if not _bound_areas(loops):
        raise ModelError(NO_AREA)
    ways = [z if (area(z) > 0.0) == (k == 0) else z[::-1] for k, z in enumerate(loops)]
    corners, after, top = _cap(ways)
    a, below = np.arange(len(corners)), len(corners)
    walls = ((a + below, after + below, after), (a + below, after, a))
    flat = np.column_stack([corners.real, corners.imag, np.full(below, height / 2)])
    triangles = [top, top[:, ::-1] + below, *(np.column_stack(row) for row in walls)]
    return Mesh(np.concatenate([flat, flat * [1, 1, -1]]), np.concatenate(triangles))


def _cap(loops: list[Points]) -> tuple[Points, Any, Any]:
    """Corners of an outline and holes, which lie to its left, the one after each, and triangles.

    Edges that Delaunay's triangles do not have are halved until they have them.
    """
    from scipy.spatial import Delaunay, QhullError  # here: a compiler needs none

    while True:
        corners, ends = np.concatenate(loops), np.cumsum([len(loop) for loop in loops])[:-1]
        if 4 * len(corners) > MOST:
            raise ModelError(
                f"a form takes {4 * len(corners)} triangles or more, and a page has room for "
                f"{MOST}; give an outline with fewer corners, or no thin slits."
            )
        numbers = np.split(np.arange(len(corners)), ends)
        after = np.concatenate([np.roll(part, -1) for part in numbers])
        try:
            cells = Delaunay(pairs(corners)).simplices
        except QhullError as error:
            raise ModelError(NO_AREA) from error
        sides = np.concatenate(np.moveaxis(cells[:, [[0, 1], [1, 2], [2, 0]]], 1, 0))
        known = {*map(tuple, sides.tolist())} | {*map(tuple, sides[:, ::-1].tolist())}
        split = np.array([pair not in known for pair in enumerate(after.tolist())])
        if not split.any():
            break
        more = np.stack([corners, (corners + corners[after]) / 2], axis=1)
        kept = np.stack([np.ones(len(split), dtype=bool), split], axis=1)
        loops = [more[part][kept[part]] for part in numbers]
    a, b, c = np.moveaxis(corners[cells], 1, 0)
    turn = ((b - a).conj() * (c - a)).imag
    inside = [sum(contains(loop, z) for loop in loops) % 2 == 1 for z in (a + b + c) / 3]
    return corners, after, np.where(turn[:, None] > 0.0, cells, cells[:, ::-1])[np.array(inside)]


def _bound_areas(loops: list[Points]) -> bool:
    """Whether no two edges meet but at their common corner, and holes lie apart in the outline."""
    if min(map(len, loops)) < 3 or 4 * sum(map(len, loops)) > MOST:
        return min(map(len, loops)) >= 3  # the latter is told of with its number
    a, b = np.concatenate(loops), np.concatenate([np.roll(loop, -1) for loop in loops])
    for k, (begin, end) in enumerate(zip(a[:-1], b[:-1], strict=True)):
        c, d = a[k + 1 :], b[k + 1 :]
        sides = ((end - begin).conjugate() * (np.array([c, d]) - begin)).imag
        others = ((d - c).conjugate() * (np.array([begin, end])[:, None] - c)).imag
        apart = (sides[0] * sides[1] > 0.0) | (others[0] * others[1] > 0.0)
        for part in (np.real, np.imag):
            low, high = np.minimum(part(c), part(d)), np.maximum(part(c), part(d))
            apart |= (high < min(part(begin), part(end))) | (low > max(part(begin), part(end)))
        # neighbours meet at a corner; they must not lie upon each other
        folded = (sides == 0.0).all(axis=0) & (((end - begin).conjugate() * (d - c)).real < 0.0)
        if (~apart & (((c != end) & (d != begin)) | folded)).any():
            return False
    within = [[contains(loop, other[0]) for loop in loops if loop is not other] for other in loops]
    return not any(within[0]) and all(row[0] and not any(row[1:]) for row in within[1:])
