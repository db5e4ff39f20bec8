"""Outlines with holes as one closed polygon each, as pictures draw them.

The polygon goes round the outline, along a bridge to a hole, round it the other way, and back. Each
hole is joined by the shortest way to what is joined already, so that no bridge leads over another.
"""

import numpy as np

from codegen.declare.outlines import Corner, Defaults, Outline, numbers_of
from codegen.drawing.plane_geometry import area


def polygon_with_holes(outline: Outline, defaults: Defaults) -> tuple[Corner, ...]:
    """Corners of the polygon, whose bridges are chosen for the values of parameters."""
    joined, *left = ([*zip(one, numbers_of(tuple(one), defaults), strict=True)]
                     for one in (outline, *outline.holes))  # fmt: skip
    side = np.sign(area(np.array([place for _, place in joined])))
    while left:
        ways = []
        for k, hole in enumerate(left):
            gaps = abs(np.subtract.outer([z for _, z in joined], [z for _, z in hole]))
            at, to = np.unravel_index(gaps.argmin(), gaps.shape)
            ways.append((gaps[at, to], k, int(at), int(to)))
        _, k, at, to = min(ways)
        hole = left.pop(k)
        hole = hole[to:] + hole[: to + 1]
        if side == np.sign(area(np.array([place for _, place in hole]))):
            hole.reverse()
        joined[at : at + 1] = [joined[at], *hole, joined[at]]
    return tuple(corner for corner, _ in joined)
