"""The lines of which a picture consists: widths, colours and order of each style.

One table serves figures of Matplotlib and the style sheet of a page.
"""

from collections.abc import Iterable
from typing import NamedTuple

from codegen.drawing.colors import LIGHT
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import Points, area
from codegen.drawing.proportions import BLOCK
from codegen.drawing.shapes import Slide, Spring


class Stroke(NamedTuple):
    """A polyline, or a polygon.

    Attributes
    ----------
    style
        What it stands for: a name of `STYLES`.
    body
        The body in whose frame its points are: 0, the ground, has the global frame.
    points
        Its points (k,), m.
    closed
        Whether the last point is joined to the first.
    element
        The element that it belongs to.
    """

    style: str
    body: int
    points: Points
    closed: bool = False
    element: str = ""


Dashes = tuple[float, tuple[float, ...] | None]
SOLID: Dashes = (0.0, None)
DASHED: Dashes = (0.0, (4.0, 2.5))  # layout: of lines, in their widths
DASH_DOTTED: Dashes = (0.0, (7.0, 2.0, 1.5, 2.0))  # layout: the same, of pitch circles


class Style(NamedTuple):
    """How the lines of a style are drawn.

    Attributes
    ----------
    layer
        "ground", "bodies", "between" (bodies), "joints" or "signs", from back to front.
    fill, line
        Colours of the inside and the line: names of a palette, "body" for the colour of the body,
        or empty for none.
    width, dashes
        Of the line in points, and its dashes.
    depth
        Place among the strokes of a body, the lowest at the back.
    """

    layer: str
    fill: str
    line: str
    width: float
    dashes: Dashes = SOLID
    depth: int = 1


LAYERS = ("ground", "behind", "bodies", "between", "joints", "signs")
STYLES = {
    "hatch": Style("ground", "", "hatching", 0.7),
    "rail": Style("ground", "", "joint", 1.3),
    "support": Style("ground", "ground", "joint", 1.1),
    "bracket-hatch": Style("joints", "", "joint", 0.7),
    "bracket-rail": Style("joints", "", "joint", 1.3),
    "bracket-support": Style("joints", "ground", "joint", 1.1),
    "edge": Style("bodies", "", "body", 2.2),
    "inside": Style("bodies", "body", "", 0.0),
    "slot": Style("bodies", "background", "body", 0.9, depth=2),
    "gear": Style("bodies", "body", "body", 1.0, depth=0),
    "ring": Style("bodies", "body", "", 0.0, depth=0),
    "pitch": Style("bodies", "", "body", 0.5, DASH_DOTTED),
    "spoke": Style("bodies", "", "body", 1.1),
    "profile": Style("bodies", "", "body", 1.3),
    "rack": Style("bodies", "", "body", 1.1),
    "pin": Style("joints", "background", "joint", 1.2),
    "hub": Style("joints", "background", "joint", 1.0),
    "fixing": Style("joints", "joint", "joint", 0.8),
    "hole": Style("between", "background", "joint", 1.2),
    "mark": Style("between", "", "joint", 1.0),
    "belt": Style("between", "", "joint", 1.7),
    "rod": Style("between", "", "joint", 2.4),
    "spring": Style("between", "", "spring", 1.2),
    "damper": Style("between", "", "damper", 1.2),
    "actuator": Style("between", "", "actuator", 1.2),
    "gap": Style("signs", "", "bad", 1.4, DASHED),
    "driver": Style("signs", "", "driver", 1.6),
    "driver head": Style("signs", "driver", "driver", 0.5),
    "force": Style("signs", "", "force", 1.7),
    "force head": Style("signs", "force", "force", 0.5),
    "torque": Style("signs", "", "torque", 1.6),
    "torque head": Style("signs", "torque", "torque", 0.5),
    "reaction": Style("signs", "", "reaction", 1.7),
    "reaction head": Style("signs", "reaction", "reaction", 0.5),
    "axis": Style("signs", "", "muted", 0.9),
    "axis head": Style("signs", "muted", "muted", 0.4),
    "center": Style("signs", "background", "ink", 0.8),
    "quadrant": Style("signs", "ink", "ink", 0.3),
    "dimension": Style("signs", "", "muted", 0.6),
    "dimension head": Style("signs", "muted", "muted", 0.3),
    "trace": Style("signs", "", "trace", 1.0),
}


def colors_of(style: str, body: int) -> tuple[str, str]:
    """Colours of the inside and line of a stroke of a body, which may pick them; empty for none."""
    one = STYLES[style]
    own = (LIGHT.fill(body - 1), LIGHT.line(body - 1)) if body else (LIGHT.ground, LIGHT.joint)
    fill, line = (
        color if name == "body" else getattr(LIGHT, name) if name else ""
        for name, color in zip((one.fill, one.line), own, strict=True)
    )
    return fill, line


def ordered(picture: Picture, strokes: Iterable[Stroke]) -> list[Stroke]:
    """All strokes and the bodies' outlines in the order in which they are drawn.

    First the ground, then springs that end in blocks, then bodies, the largest at the back, then
    what lies between bodies, pins, and signs. The lines of a body's polygons are drawn before their
    insides, so that polygons that overlap look like one.
    """
    layers: dict[str, list[Stroke]] = {name: [] for name in LAYERS}
    own: list[list[Stroke]] = [[] for _ in picture.bodies]
    behind = springs_of_blocks(picture)
    for stroke in strokes:
        layer = "behind" if stroke.element in behind else STYLES[stroke.style].layer
        (own[stroke.body] if layer == "bodies" else layers[layer]).append(stroke)
    sizes = [size_of(picture, number, lines) for number, lines in enumerate(own)]
    for number in sorted(range(len(own)), key=lambda n: -sizes[n]):
        polygons = picture.bodies[number].polygons
        for style in ("edge", "inside"):
            layers["bodies"] += [Stroke(style, number, points, True) for points in polygons]
        layers["bodies"] += sorted(own[number], key=lambda stroke: STYLES[stroke.style].depth)
    return [stroke for layer in layers.values() for stroke in layer]


def springs_of_blocks(picture: Picture) -> set[str]:
    """Springs that end within a block: behind it they look as if they were fixed to its side."""
    blocks = {
        shape.i.body if picture.is_ground(shape.j.body) else shape.j.body
        for _, shape in picture.having(Slide)
    }
    return {
        symbol.element
        for symbol, spring in picture.having(Spring)
        for place in (spring.i, spring.j)
        if place.body in blocks and abs(place.point) < BLOCK[0] * picture.size
    }


def size_of(picture: Picture, number: int, own: Iterable[Stroke]) -> float:
    """The area of the largest polygon of a body, which has these strokes, m²."""
    polygons = [stroke.points for stroke in own if stroke.closed and STYLES[stroke.style].fill]
    return max((abs(area(p)) for p in (*picture.bodies[number].polygons, *polygons)), default=0.0)
