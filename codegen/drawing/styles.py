"""Colours and lines of pictures and pages: one table serves figures of Matplotlib and style sheets.

Colours are told apart by the colour-blind as well. The lines of bodies and curves are those of
M. Okabe and K. Ito, Color Universal Design (2008), in lightness adapted to either ground: every
line stands out from its ground with a contrast of at least 3 (WCAG 2.2, 1.4.11), texts with 4.5
(1.4.3).
"""

from collections.abc import Iterable
from typing import NamedTuple

from codegen.drawing.picture import BLOCK, Picture
from codegen.drawing.plane_geometry import Points, area
from codegen.drawing.shapes import Slide, Spring

# Name of what it is for → its colour before a light and before a dark ground.
_COLORS = {
    "background": ("#ffffff", "#14181d"),  # behind the machine
    "panel": ("#f5f7f9", "#1d232a"),  # behind tables and controls
    "ink": ("#1b1f24", "#e6edf3"),  # texts and outlines
    "muted": ("#57606a", "#9aa5b1"),  # secondary texts
    "grid": ("#d8dee4", "#333c46"),
    "ground": ("#e6e9ec", "#2a323b"),
    "hatching": ("#6e7781", "#8b96a1"),
    "joint": ("#24292f", "#e6edf3"),  # pins, guides and slots; their inside is the background
    "spring": ("#00795a", "#3fc79a"),
    "damper": ("#57606a", "#aab4be"),
    "actuator": ("#9a4f00", "#f0a860"),
    "driver": ("#9a4f00", "#f0a860"),
    "force": ("#c2410c", "#ff8a5c"),
    "reaction": ("#0063a0", "#6cb8f0"),
    "torque": ("#8a3f73", "#e29cc4"),
    "gravity": ("#57606a", "#9aa5b1"),
    "contact": ("#c9184a", "#ff6b8b"),  # contacts that are closed, and impacts
    "trace": ("#8a3f73", "#e29cc4"),
    "cursor": ("#c9184a", "#ff6b8b"),  # the instant that is shown
    "accent": ("#0063a0", "#6cb8f0"),  # what is chosen or has the focus
    "good": ("#1a7f37", "#4ac26b"),
    "bad": ("#c92a2a", "#ff7b72"),
}
# Lines of bodies and curves, and insides of bodies, in their order; they repeat.
_LINES = (
    ("#0072b2", "#56b4e9"), ("#6c2300", "#f08a3c"), ("#006232", "#1fc296"), ("#a96084", "#e29cc4"),
    ("#6e7c21", "#e3d04a"), ("#00a0c3", "#2f86c9"), ("#4a4a4a", "#c8c8c8"),
)  # fmt: skip
_FILLS = (
    ("#cfe6f5", "#1c3b50"), ("#f9dcc8", "#4d3018"), ("#cdeade", "#14402f"), ("#f6dfec", "#4a2f40"),
    ("#eef0cf", "#453f16"), ("#d5f4fb", "#173550"), ("#e2e2e2", "#3a3a3a"),
)  # fmt: skip
COUNT = len(_LINES)
"""How many bodies have colours of their own."""
_ALL = {
    **_COLORS, **{f"line-{k}": pair for k, pair in enumerate(_LINES)},
    **{f"fill-{k}": pair for k, pair in enumerate(_FILLS)},
}  # fmt: skip
LIGHT, DARK = ({name: pair[k] for name, pair in _ALL.items()} for k in (0, 1))
"""Name of a colour → ``#rrggbb``; those of bodies are ``line-0``, ``fill-0`` and so on."""


class Stroke(NamedTuple):
    """A polyline, or a polygon, in the frame of a body: 0, the ground, has the global one."""

    style: str  # a name of `STYLES`
    body: int
    points: Points  # (k,), m
    closed: bool = False  # whether the last point is joined to the first
    element: str = ""  # to which it belongs


Dashes = tuple[float, tuple[float, ...] | None]
SOLID: Dashes = (0.0, None)
DASHED: Dashes = (0.0, (4.0, 2.5))  # layout: of lines, in their widths
DASH_DOTTED: Dashes = (0.0, (7.0, 2.0, 1.5, 2.0))  # layout: the same, of pitch circles


class Style(NamedTuple):
    """How the lines of a style are drawn."""

    layer: str  # of `LAYERS`
    fill: str  # names of colours, empty for none; "fill" and "line" are those of the body
    line: str
    width: float  # of the line, in points
    dashes: Dashes = SOLID
    depth: int = 1  # place among the strokes of a body, the lowest at the back
    opacity: float = 1.0  # of the inside


# From back to front; "between" are bodies.
LAYERS = ("ground", "bodies", "between", "joints", "signs")
STYLES = {
    "hatch": Style("ground", "", "hatching", 0.7),
    "rail": Style("ground", "", "joint", 1.3),
    "support": Style("ground", "ground", "joint", 1.1),
    "edge": Style("bodies", "", "line", 2.2),
    "inside": Style("bodies", "fill", "", 0.0),
    "slot": Style("bodies", "background", "line", 0.9, depth=2),
    "gear": Style("bodies", "fill", "line", 1.0, depth=0),
    "ring": Style("bodies", "fill", "", 0.0, depth=0),
    "pitch": Style("bodies", "", "line", 0.5, DASH_DOTTED),
    "spoke": Style("bodies", "", "line", 1.1),
    "profile": Style("bodies", "", "line", 1.3),
    "rack": Style("bodies", "", "line", 1.1),
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
    "center": Style("signs", "background", "ink", 0.8),
    "quadrant": Style("signs", "ink", "ink", 0.3),
    "trace": Style("signs", "", "trace", 1.0),
    "plate": Style("signs", "hatching", "joint", 0.6, opacity=0.3),
}
for _name in ("hatch", "rail", "support"):  # the ground before a body that would hide it
    STYLES[f"bracket-{_name}"] = STYLES[_name]._replace(layer="joints", line="joint")
for _name, _color, _width in (
    ("driver", "driver", 1.6), ("force", "force", 1.7), ("torque", "torque", 1.6),
    ("reaction", "reaction", 1.7), ("axis", "muted", 0.9), ("dimension", "muted", 0.6),
):  # fmt: skip
    STYLES[_name] = Style("signs", "", _color, _width)
    STYLES[f"{_name} head"] = Style("signs", _color, _color, 0.3 * _width)


def color_of(name: str, body: int) -> str:
    """A colour of `STYLES` where a body has it; empty for none."""
    if name in ("fill", "line"):
        of_ground = "ground" if name == "fill" else "joint"
        name = f"{name}-{(body - 1) % COUNT}" if body else of_ground
    return LIGHT.get(name, "")


def ordered(picture: Picture, strokes: Iterable[Stroke]) -> list[Stroke]:
    """All strokes and the bodies' outlines in the order in which they are drawn.

    First the ground and springs that end within a block, then bodies, the largest at the back, then
    what lies between bodies, pins, and signs. The lines of a body's polygons are drawn before their
    insides, so that polygons that overlap look like one.
    """
    layers: dict[str, list[Stroke]] = {name: [] for name in LAYERS}
    own: list[list[Stroke]] = [[] for _ in picture.bodies]
    behind = springs_of_blocks(picture)
    for stroke in strokes:
        layer = "ground" if stroke.element in behind else STYLES[stroke.style].layer
        (own[stroke.body] if layer == "bodies" else layers[layer]).append(stroke)
    sizes = [size_of(picture, number, lines) for number, lines in enumerate(own)]
    for number in sorted(range(len(own)), key=lambda n: -sizes[n]):
        for style in ("edge", "inside"):
            outlines = picture.bodies[number].outlines
            layers["bodies"] += [Stroke(style, number, points, True) for points in outlines]
        layers["bodies"] += sorted(own[number], key=lambda stroke: STYLES[stroke.style].depth)
    return [stroke for layer in layers.values() for stroke in layer]


def springs_of_blocks(picture: Picture) -> set[str]:
    """Springs that end within a block: behind it they look as if they were fixed to its side."""
    blocks = {place.body for _, slide in picture.having(Slide) for place in (slide.i, slide.j)}
    return {
        symbol.element
        for symbol, spring in picture.having(Spring)
        for place in (spring.i, spring.j)
        if place.body and place.body in blocks and abs(place.point) < BLOCK[0] * picture.size
    }


def size_of(picture: Picture, number: int, own: Iterable[Stroke]) -> float:
    """The area of the largest polygon of a body, which has these strokes, m²."""
    polygons = [stroke.points for stroke in own if stroke.closed and STYLES[stroke.style].fill]
    return max((abs(area(p)) for p in (*picture.bodies[number].outlines, *polygons)), default=0.0)
