"""The texts of a picture: what names bodies, joints and forces, and where each may stand."""

from typing import Any

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.colors import Palette
from codegen.drawing.contact_surfaces import Surface, surfaces
from codegen.drawing.force_arrows import WIDE, Reactions, drawn_loads, force_strokes
from codegen.drawing.gear_meshing import meshing
from codegen.drawing.guides_and_racks import guide_ends, guide_of, rail_offset
from codegen.drawing.moving_strokes import gap_of
from codegen.drawing.picture import Picture, Symbol
from codegen.drawing.polygons import FloatArray, area, circle, contains, placed, unit
from codegen.drawing.rigid_strokes import rail
from codegen.drawing.signs import ARROW, ROUND
from codegen.drawing.sizes_and_held_places import PIN
from codegen.drawing.strokes import Stroke

JOINT_SIZE, BODY_SIZE, OTHER_SIZE, NUMBER_SIZE = 9.5, 8.5, 8.0, 7.5  # layout: letters, in points
MOST_NAMES = 40  # layout: more than these cover the picture; bodies alone have theirs then
MOST_AT_ONE_PLACE = 3  # layout: names of joints at one place
LabelText = tuple[str, FloatArray, float, dict[str, Any]]
"""A text, places (k, 2) beside which it may stand, the room about these, in m, and its style."""


def label_texts(
    picture: Picture, colors: Palette, reactions: Reactions | None = None, values: bool = False
) -> list[LabelText]:
    """The names of bodies, joints, drivers and forces, and how far open joints are apart.

    Parameters
    ----------
    values
        Whether forces have their sizes behind their names.
    """
    others = _others(picture, colors, reactions, values)
    forces = {text.partition(", ")[0] for text, *_ in others} if values else set[str]()
    bodies, gaps = _bodies(picture, colors), _gaps(picture, colors)
    wanted = [*_joints(picture, colors, forces), *bodies, *others, *gaps]
    if len(wanted) > MOST_NAMES:  # of a long chain of alike parts, say: bodies are enough
        return [*bodies, *gaps]
    return wanted


def _joints(picture: Picture, colors: Palette, forces: set[str]) -> list[LabelText]:
    """Names of joints, those at one place together; without those that a force names."""
    style = {"fontsize": JOINT_SIZE, "color": colors.ink, "fontstyle": "italic"}
    places: list[tuple[FloatArray, list[str]]] = []
    for symbol in picture.symbols:
        if symbol.role != "joint" or symbol.element in forces:
            continue
        at = _anchor(picture, symbol)
        if at is None:
            continue
        near = [names for p, names in places if np.hypot(*(p[0] - at[0])) < PIN * picture.size]
        if not near:
            places.append((at, [symbol.element]))
        elif symbol.element not in near[0]:
            near[0].append(symbol.element)
    known: set[str] = set()
    found = []
    for at, names in places:
        new = [name for name in names if name not in known]
        known |= set(new)
        text = ", ".join(new[:MOST_AT_ONE_PLACE]) + (" …" if len(new) > MOST_AT_ONE_PLACE else "")
        if new:
            found.append((text, at, PIN * picture.size, style))
    return found


def _anchor(picture: Picture, symbol: Symbol) -> FloatArray | None:
    """Places (k, 2) beside which the name of a joint may stand, m."""
    match symbol.shape:
        case shapes.Pin() | shapes.Fixing() | shapes.Bearing():
            return np.array([picture.position(symbol.shape.i)])
        case shapes.Slide() | shapes.Slot():
            guide = guide_of(picture, symbol.shape)
            if picture.bodies[guide.body].fixed:
                ends = placed(guide_ends(picture, guide, None), picture.poses[guide.body])
                ends = rail(ends, -rail_offset(picture, guide, meshing(picture).module))
                return np.concatenate([ends[np.argsort(-ends[:, 0])], ends.mean(axis=0)[None]])
            return np.array([picture.position(guide.block)])
        case shapes.Rod():
            i, j = (np.array(picture.position(p)) for p in (symbol.shape.i, symbol.shape.j))
            return np.array([(i + j) / 2, 0.65 * i + 0.35 * j, 0.35 * i + 0.65 * j])
        case shapes.Belt():
            i, j = (np.array(picture.position(p)) for p in (symbol.shape.i, symbol.shape.j))
            return np.array([(i + j) / 2])
        case shapes.Wheel() if symbol.shape.toothed:
            return _pitch_point(picture, symbol.element, symbol.shape)
    return None


def _pitch_point(picture: Picture, element: str, wheel: shapes.Wheel) -> FloatArray | None:
    """Where the pitch circle of a gear touches the other gear, or the rack, of its element."""
    for other in picture.symbols:
        if other.element == element and other.shape is not wheel:
            center = np.array(picture.position(wheel.center))
            if isinstance(other.shape, shapes.Wheel):
                larger, smaller = wheel, other.shape
                if abs(float(smaller.radius)) > abs(float(larger.radius)):
                    larger, smaller = smaller, larger
                start = np.array(picture.position(larger.center))
                way = unit(np.array(picture.position(smaller.center)) - start)
                return np.array([start + abs(float(larger.radius)) * way])
            if isinstance(other.shape, shapes.Rack):
                at = np.array(picture.position(other.shape.i))
                turn = picture.poses[other.shape.i.body]
                along = unit(np.array([other.shape.ux, other.shape.uy], dtype=float))
                along = placed(along[None], np.array([0.0, 0.0, turn[2]]))[0]
                return np.array([at + float((center - at) @ along) * along])
    return None


def _bodies(picture: Picture, colors: Palette) -> list[LabelText]:
    """Names of bodies, in their colours."""
    found = []
    for number, body in enumerate(picture.bodies):
        if number == 0 or body.fixed:
            continue
        style = {"fontsize": BODY_SIZE, "color": colors.line(number - 1)}
        pose = picture.poses[number]
        rings = [
            placed(circle(np.array(shape.center[1:]), abs(float(shape.radius)), 8), pose)
            for shape in (symbol.shape for symbol in picture.symbols)
            if isinstance(shape, shapes.Wheel) and shape.center.body == number
            and (shape.internal or float(shape.radius) < 0)
        ]  # fmt: skip
        if rings:
            anchors = rings[0]
        elif body.outlines:
            largest = max((np.array(o) for o in body.outlines), key=lambda o: abs(area(o)))
            anchors = _along(placed(largest, pose))
        else:
            anchors = picture.poses[number : number + 1, :2]
        found.append((body.name, anchors, 0.0, style))
    return found


def _along(polygon: FloatArray) -> FloatArray:
    """The middle of a polygon, and places along its longer axis, those inside; else its edges."""
    middle = (polygon.min(axis=0) + polygon.max(axis=0)) / 2
    centred = polygon - polygon.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    reach = float(np.max(np.abs(centred @ axes[0])))
    found = middle + np.outer([0.0, 0.35, -0.35, 0.55, -0.55], reach * axes[0])
    inside = [p for p in found if contains(polygon, p)]
    return np.array(inside) if inside else (polygon + np.roll(polygon, -1, axis=0)) / 2


def _others(
    picture: Picture, colors: Palette, reactions: Reactions | None, values: bool
) -> list[LabelText]:
    """Names of drivers, springs, tracked points and forces; sizes of forces where wanted."""
    size = picture.size
    found = _valued(picture, colors, reactions) if values else []
    arrows = {s.element: s for s in force_strokes(picture) if s.style in ("force", "torque")}
    arrows = {} if values else arrows
    for symbol in picture.symbols:
        text, color, at, room = symbol.element, "", None, 0.0
        match symbol.shape:
            case shapes.Drive():
                color, at = colors.driver, np.array([picture.position(symbol.shape.j)])
                room = ROUND * size if symbol.shape.turns else ARROW * size
            case shapes.Spring():
                i, j = (np.array(picture.position(p)) for p in (symbol.shape.i, symbol.shape.j))
                color, at, room = colors.spring, np.array([(i + j) / 2]), 0.02 * size
            case shapes.Trace():
                color, at = colors.joint, np.array([picture.position(symbol.shape.at)])
                room = PIN * size
            case shapes.SpiralSpring():
                color, at = colors.spring, np.array([picture.position(symbol.shape.j)])
                room = 0.05 * size
            case shapes.Force() if symbol.element in arrows:
                color, at = colors.force, _far_end(arrows[symbol.element])
            case shapes.Torque() if symbol.element in arrows:
                color, at = colors.torque, np.array([picture.position(symbol.shape.at)])
                room = WIDE * ROUND * size
        if at is not None:
            found.append((text, at, room, {"fontsize": OTHER_SIZE, "color": color}))
    if not values:
        style = {"fontsize": OTHER_SIZE, "color": colors.joint}
        found += [(one.element, _ends(one), 0.0, style) for fixed in (True, False)
                  for one in surfaces(picture, fixed)]  # fmt: skip
    return found


def _ends(surface: Surface) -> FloatArray:
    """Places at the ends of a surface, below it, (2, 2), m."""
    reach = 0.85 * surface.half * surface.along
    return np.array([surface.middle + reach, surface.middle - reach])


def _valued(picture: Picture, colors: Palette, reactions: Reactions | None) -> list[LabelText]:
    """What acts on which body, with its size."""
    shades = {"force": colors.force, "reaction": colors.reaction, "torque": colors.torque}
    return [
        (
            f"{load.label}: {engineering(load.size, load.unit)}",
            _far_end(shaft) if load.style == "force" else load.at[None],
            WIDE * ROUND * picture.size if load.style == "torque" else 0.0,
            {"fontsize": OTHER_SIZE, "color": shades[load.style]},
        )
        for load, (shaft, _) in drawn_loads(picture, None, reactions)
    ]


def _gaps(picture: Picture, colors: Palette) -> list[LabelText]:
    """How far the places of joints are apart that are not closed."""
    style = {"fontsize": NUMBER_SIZE, "color": colors.bad}
    found = []
    for symbol in picture.symbols:
        gap = gap_of(picture, symbol)
        if gap is not None:
            text = f"{symbol.element}: {np.hypot(*(gap[1] - gap[0])):.4g} m apart"
            anchors = np.array([gap.mean(axis=0), gap[1], gap[0]])
            found.append((text, anchors, 0.01 * picture.size, style))
    return found


def _far_end(stroke: Stroke) -> FloatArray:
    return stroke.points[[-1, 0]]


def engineering(value: float, unit: str) -> str:
    """A number with three digits and a prefix: 12.3 kN."""
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if abs(value) >= factor:
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"
