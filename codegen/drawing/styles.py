"""Colours and lines of pictures and pages: one table serves figures of Matplotlib and style sheets.

Colours are told apart by the colour-blind as well. The lines of bodies and curves are those of
M. Okabe and K. Ito, Color Universal Design (2008), in lightness adapted to either ground: every
line stands out from its ground with a contrast of at least 3 (WCAG 2.2, 1.4.11), texts with 4.5
(1.4.3).
"""

from collections.abc import Iterable
from typing import Literal, NamedTuple

from codegen.drawing.picture import BLOCK, Picture
from codegen.drawing.plane_geometry import Points, area
from codegen.drawing.shapes import Slide, Spring

Theme = Literal["light", "dark"]


class Palette(NamedTuple):
    """Colours as ``#rrggbb``, named by what they are for.

    Attributes
    ----------
    background, panel
        Behind the machine; behind tables and controls.
    ink, muted, grid
        Texts and outlines, secondary texts, lines of a grid.
    ground, hatching
        Fill and hatching of the ground.
    joint
        Pins, guides and slots; their inside is the background.
    spring, damper, actuator
        Elements between two bodies.
    driver
        Signs of drivers.
    force, reaction, torque, gravity
        Arrows: applied forces, reactions of joints, torques, gravity.
    contact
        Contacts that are closed, and impacts.
    trace
        Paths of points.
    cursor
        The instant that is shown, in curves and on the time line.
    accent
        What is chosen or has the focus.
    good, bad
        The outcome of a run: as asked for, or ended before its end.
    lines
        Outlines of bodies and curves, in their order.
    fills
        Insides of bodies, in the order of `lines`.
    """

    background: str
    panel: str
    ink: str
    muted: str
    grid: str
    ground: str
    hatching: str
    joint: str
    spring: str
    damper: str
    actuator: str
    driver: str
    force: str
    reaction: str
    torque: str
    gravity: str
    contact: str
    trace: str
    cursor: str
    accent: str
    good: str
    bad: str
    lines: tuple[str, ...]
    fills: tuple[str, ...]

    def line(self, number: int) -> str:
        """The line of a body or curve; they repeat."""
        return self.lines[number % len(self.lines)]

    def fill(self, number: int) -> str:
        """The inside of a body; they repeat."""
        return self.fills[number % len(self.fills)]


LIGHT = Palette(
    background="#ffffff",
    panel="#f5f7f9",
    ink="#1b1f24",
    muted="#57606a",
    grid="#d8dee4",
    ground="#e6e9ec",
    hatching="#6e7781",
    joint="#24292f",
    spring="#00795a",
    damper="#57606a",
    actuator="#9a4f00",
    driver="#9a4f00",
    force="#c2410c",
    reaction="#0063a0",
    torque="#8a3f73",
    gravity="#57606a",
    contact="#c9184a",
    trace="#8a3f73",
    cursor="#c9184a",
    accent="#0063a0",
    good="#1a7f37",
    bad="#c92a2a",
    lines=("#0072b2", "#6c2300", "#006232", "#a96084", "#6e7c21", "#00a0c3", "#4a4a4a"),
    fills=("#cfe6f5", "#f9dcc8", "#cdeade", "#f6dfec", "#eef0cf", "#d5f4fb", "#e2e2e2"),
)
DARK = Palette(
    background="#14181d",
    panel="#1d232a",
    ink="#e6edf3",
    muted="#9aa5b1",
    grid="#333c46",
    ground="#2a323b",
    hatching="#8b96a1",
    joint="#e6edf3",
    spring="#3fc79a",
    damper="#aab4be",
    actuator="#f0a860",
    driver="#f0a860",
    force="#ff8a5c",
    reaction="#6cb8f0",
    torque="#e29cc4",
    gravity="#9aa5b1",
    contact="#ff6b8b",
    trace="#e29cc4",
    cursor="#ff6b8b",
    accent="#6cb8f0",
    good="#4ac26b",
    bad="#ff7b72",
    lines=("#56b4e9", "#f08a3c", "#1fc296", "#e29cc4", "#e3d04a", "#2f86c9", "#c8c8c8"),
    fills=("#1c3b50", "#4d3018", "#14402f", "#4a2f40", "#453f16", "#173550", "#3a3a3a"),
)
PALETTES: dict[Theme, Palette] = {"light": LIGHT, "dark": DARK}


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
    "center": Style("signs", "background", "ink", 0.8),
    "quadrant": Style("signs", "ink", "ink", 0.3),
    "trace": Style("signs", "", "trace", 1.0),
}
for _name in ("hatch", "rail", "support"):  # the ground before a body that would hide it
    STYLES[f"bracket-{_name}"] = STYLES[_name]._replace(layer="joints", line="joint")
for _name, _color, _width in (
    ("driver", "driver", 1.6), ("force", "force", 1.7), ("torque", "torque", 1.6),
    ("reaction", "reaction", 1.7), ("axis", "muted", 0.9), ("dimension", "muted", 0.6),
):  # fmt: skip
    STYLES[_name] = Style("signs", "", _color, _width)
    STYLES[f"{_name} head"] = Style("signs", _color, _color, 0.3 * _width)


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
