"""Widths, colours and order of the strokes of a picture, for Matplotlib; body by body."""

from typing import NamedTuple

import numpy as np

from codegen.drawing.colors import Palette
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray, area
from codegen.drawing.shapes import Slide, Spring
from codegen.drawing.sizes_and_held_places import BLOCK
from codegen.drawing.strokes import FILLED, Stroke

DASHED = (0.0, (4.0, 2.5))  # layout: of lines, in their widths
DASH_DOTTED = (0.0, (7.0, 2.0, 1.5, 2.0))  # layout: the same, of pitch circles
SOLID = (0.0, None)
Dashes = tuple[float, tuple[float, ...] | None]


class Pen(NamedTuple):
    """The inside, line, width in points and dashes of a stroke; an empty colour is none."""

    fill: str
    line: str
    width: float
    dashes: Dashes = SOLID


class Painted(NamedTuple):
    """A stroke with its pen."""

    stroke: Stroke
    pen: Pen


GROUND, BEHIND, BODY, BETWEEN, JOINT, SIGN = range(6)
_LAYER = {
    "hatch": GROUND, "rail": GROUND, "support": GROUND,
    "slot": BODY, "gear": BODY, "ring": BODY, "pitch": BODY, "profile": BODY, "spoke": BODY,
    "rack": BODY, "body": BODY, "mark": BETWEEN, "belt": BETWEEN, "rod": BETWEEN,
    "spring": BETWEEN, "damper": BETWEEN, "actuator": BETWEEN, "hole": BETWEEN,
    "bracket-support": JOINT, "bracket-rail": JOINT, "bracket-hatch": JOINT,
    "hub": JOINT, "pin": JOINT, "fixing": JOINT,
}  # fmt: skip

LAYER_NAMES = {
    GROUND: "ground", BEHIND: "bodies", BODY: "bodies", BETWEEN: "between", JOINT: "joints",
    SIGN: "extras",
}  # fmt: skip
"""The layers of a page, in which springs lie above bodies."""
_DEPTH = {"gear": 0, "ring": 0, "slot": 2}  # among the strokes of a body; 1 for all others


def layer_name(style: str) -> str:
    """The layer of a page that has the strokes of a style."""
    return LAYER_NAMES[_LAYER.get(style, SIGN)]


def depth(style: str) -> int:
    """The place of a style among the strokes of a body, the lowest at the back."""
    return _DEPTH.get(style, 1)


def pen(style: str, body: int, colors: Palette) -> Pen:
    """The pen for a stroke of a body, whose number picks the colours."""
    line = colors.line(body - 1) if body else colors.joint
    fill = colors.fill(body - 1) if body else colors.ground
    pens = {
        "hatch": Pen("", colors.hatching, 0.7),
        "rail": Pen("", colors.joint, 1.3),
        "support": Pen(colors.ground, colors.joint, 1.1),
        "bracket-hatch": Pen("", colors.joint, 0.7),
        "bracket-rail": Pen("", colors.joint, 1.3),
        "bracket-support": Pen(colors.ground, colors.joint, 1.1),
        "slot": Pen(colors.background, line, 0.9),
        "pin": Pen(colors.background, colors.joint, 1.2),
        "hole": Pen(colors.background, colors.joint, 1.2),
        "hub": Pen(colors.background, colors.joint, 1.0),
        "fixing": Pen(colors.joint, colors.joint, 0.8),
        "mark": Pen("", colors.joint, 1.0),
        "gear": Pen(fill, line, 1.0),
        "ring": Pen(fill, "", 0.0),
        "pitch": Pen("", line, 0.5, DASH_DOTTED),
        "spoke": Pen("", line, 1.1),
        "profile": Pen("", line, 1.3),
        "rack": Pen("", line, 1.1),
        "belt": Pen("", colors.joint, 1.7),
        "rod": Pen("", colors.joint, 2.4),
        "spring": Pen("", colors.spring, 1.2),
        "damper": Pen("", colors.damper, 1.2),
        "actuator": Pen("", colors.actuator, 1.2),
        "gap": Pen("", colors.bad, 1.4, DASHED),
        "driver": Pen("", colors.driver, 1.6),
        "driver head": Pen(colors.driver, colors.driver, 0.5),
        "force": Pen("", colors.force, 1.7),
        "force head": Pen(colors.force, colors.force, 0.5),
        "torque": Pen("", colors.torque, 1.6),
        "torque head": Pen(colors.torque, colors.torque, 0.5),
        "reaction": Pen("", colors.reaction, 1.7),
        "reaction head": Pen(colors.reaction, colors.reaction, 0.5),
        "axis": Pen("", colors.muted, 0.9),
        "axis head": Pen(colors.muted, colors.muted, 0.4),
        "center": Pen(colors.background, colors.ink, 0.8),
        "quadrant": Pen(colors.ink, colors.ink, 0.3),
        "dimension": Pen("", colors.muted, 0.6),
        "dimension head": Pen(colors.muted, colors.muted, 0.3),
        "trace": Pen("", colors.trace, 1.0),
    }
    return pens[style]


def painted(picture: Picture, strokes: tuple[Stroke, ...], colors: Palette) -> list[Painted]:
    """All strokes and the bodies' outlines in the order in which they are drawn.

    First the ground, then springs that end in blocks, then bodies, the largest at the back, then
    what lies between bodies, pins, and signs. The lines of a body's polygons are drawn before their
    insides, so that polygons that overlap look like one.
    """
    layers: list[list[Painted]] = [[] for _ in range(SIGN + 1)]
    own: dict[int, list[Painted]] = {}
    behind = springs_of_blocks(picture)
    for stroke in strokes:
        one = Painted(stroke, pen(stroke.style, stroke.body, colors))
        layer = BEHIND if stroke.element in behind else _LAYER.get(stroke.style, SIGN)
        if layer == BODY:
            own.setdefault(stroke.body, []).append(one)
        else:
            layers[layer].append(one)
    sizes = {n: _extent(picture, n, own.get(n, [])) for n in range(len(picture.bodies))}
    for number in sorted(sizes, key=lambda n: -sizes[n]):
        line, fill = colors.line(number - 1), colors.fill(number - 1)
        polygons = [np.array(outline) for outline in picture.bodies[number].outlines]
        outlines = [Stroke("body", number, points, True) for points in polygons]
        layers[BODY] += [Painted(one, Pen("", line, 2.2)) for one in outlines]
        layers[BODY] += [Painted(one, Pen(fill, "", 0.0)) for one in outlines]
        layers[BODY] += sorted(own.get(number, []), key=lambda one: depth(one.stroke.style))
    return [one for layer in layers for one in layer]


def springs_of_blocks(picture: Picture) -> set[str]:
    """Springs that end within a block: behind it they look as if they were fixed to its side."""
    blocks = {
        shape.j.body if not picture.bodies[shape.j.body].fixed else shape.i.body
        for shape in (symbol.shape for symbol in picture.symbols)
        if isinstance(shape, Slide)
    }
    return {
        symbol.element
        for symbol in picture.symbols
        if isinstance(symbol.shape, Spring)
        and any(
            place.body in blocks and np.hypot(place.x, place.y) < BLOCK[0] * picture.size
            for place in (symbol.shape.i, symbol.shape.j)
        )
    }


def _extent(picture: Picture, number: int, own: list[Painted]) -> float:
    """The area of a body's largest polygon, m²."""
    polygons = [np.array(outline) for outline in picture.bodies[number].outlines]
    polygons += [one.stroke.points for one in own if one.stroke.style in FILLED]
    return max((abs(area(points)) for points in polygons), default=0.0)


def extent(points: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinates of polylines."""
    joined = np.concatenate(points)
    joined = joined[np.all(np.isfinite(joined), axis=1)]
    return joined.min(axis=0), joined.max(axis=0)
