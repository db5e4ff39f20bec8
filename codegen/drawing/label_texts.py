"""The texts of a picture: what names bodies, joints and forces, and where each may stand."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.arrows import WIDE, Series, drawn_loads
from codegen.drawing.colors import LIGHT
from codegen.drawing.contacts import surfaces
from codegen.drawing.gears import Meshing
from codegen.drawing.guides import guide_ends, guide_of, rail_offset
from codegen.drawing.line_styles import Stroke
from codegen.drawing.lines_between_bodies import gap_of
from codegen.drawing.lines_in_bodies import rail
from codegen.drawing.picture import Picture, Symbol
from codegen.drawing.plane_geometry import Points, area, circle, contains, dot, pairs, unit
from codegen.drawing.proportions import ARROW, PIN, ROUND_ARROW

JOINT_SIZE, BODY_SIZE, OTHER_SIZE, NUMBER_SIZE = 9.5, 8.5, 8.0, 7.5  # layout: letters, in points
MOST_NAMES = 40  # layout: more than these cover the picture; bodies alone have theirs then
MOST_AT_ONE_PLACE = 3  # layout: names of joints at one place


class LabelText(NamedTuple):
    """A text, places (k,) beside which it may stand, the room about these, in m, and its style."""

    text: str
    places: Points
    room: float
    fontsize: float
    color: str
    fontstyle: str = "normal"


def label_texts(
    picture: Picture, series: Series | None = None, values: bool = False
) -> list[LabelText]:
    """The names of bodies, joints, drivers and forces, and how far open joints are apart.

    Parameters
    ----------
    series
        Reactions of joints, drivers and contacts.
    values
        Whether forces have their sizes behind their names.
    """
    valued = list(_valued(picture, series)) if values else []
    forces = {one.text.partition(", ")[0] for one in valued}
    bodies, gaps = list(_bodies(picture)), list(_gaps(picture))
    others = [*valued, *_others(picture, values)]
    wanted = [*_joints(picture, forces), *bodies, *others, *gaps]
    if len(wanted) > MOST_NAMES:  # of a long chain of alike parts, say: bodies are enough
        return [*bodies, *gaps]
    return wanted


def _joints(picture: Picture, forces: set[str]) -> Iterator[LabelText]:
    """Names of joints, those at one place together; without those that a force names."""
    room = PIN * picture.size
    found: list[tuple[Points, list[str]]] = []
    for symbol in picture.symbols:
        if symbol.role != "joint" or symbol.element in forces:
            continue
        at = _places_of_joint(picture, symbol)
        if at is None:
            continue
        near = [names for places, names in found if abs(places[0] - at[0]) < room]
        if not near:
            found.append((at, [symbol.element]))
        elif symbol.element not in near[0]:
            near[0].append(symbol.element)
    known: set[str] = set()
    for at, names in found:
        new = [name for name in names if name not in known]
        known |= set(new)
        text = ", ".join(new[:MOST_AT_ONE_PLACE]) + (" …" if len(new) > MOST_AT_ONE_PLACE else "")
        if new:
            yield LabelText(text, at, room, JOINT_SIZE, LIGHT.ink, "italic")


def _places_of_joint(picture: Picture, symbol: Symbol) -> Points | None:
    """Places (k,) beside which the name of a joint may stand, m."""
    match symbol.shape:
        case shapes.Pin() | shapes.Fixing() | shapes.Bearing() as shape:
            return np.array([picture.at(shape.i)])
        case shapes.Slide() | shapes.Slot() as shape:
            guide = guide_of(picture, shape)
            if not picture.is_ground(guide.body):
                return np.array([picture.at(guide.block)])
            ends = picture.placed(guide_ends(picture, guide, None), guide.body)
            ends = rail(ends, -rail_offset(picture, guide, Meshing(picture).module))
            return np.array([*ends[np.argsort(-ends.real)], ends.mean()])
        case shapes.Rod() as shape:
            i, j = picture.at(shape.i), picture.at(shape.j)
            return i + (j - i) * np.array([0.5, 0.35, 0.65])
        case shapes.Belt() as shape:
            return np.array([(picture.at(shape.i) + picture.at(shape.j)) / 2])
        case shapes.Wheel() as shape if shape.toothed:
            return _pitch_point(picture, shape)
    return None


def _pitch_point(picture: Picture, wheel: shapes.Wheel) -> Points | None:
    """Where the pitch circle of a gear touches the other gear, or the rack, of its element."""
    for other in picture.partners(wheel, shapes.Wheel):
        if other is not wheel:
            smaller, larger = sorted((wheel, other), key=lambda one: abs(one.radius))
            start = picture.at(larger.center)
            return np.array([start + abs(larger.radius) * unit(picture.at(smaller.center) - start)])
    for rack in picture.partners(wheel, shapes.Rack):
        at, along = picture.at(rack.i), picture.turned(rack.along, rack.i.body)
        return np.array([at + dot(along, picture.at(wheel.center) - at) * along])
    return None


def _bodies(picture: Picture) -> Iterator[LabelText]:
    """Names of bodies, in their colours."""
    rings = {
        wheel.center.body: circle(wheel.center.point, abs(wheel.radius), 8)
        for _, wheel in reversed(picture.having(shapes.Wheel))
        if wheel.internal or wheel.radius < 0
    }
    for number, body in enumerate(picture.bodies):
        if number == 0 or body.fixed:
            continue
        if number in rings:
            places = picture.placed(rings[number], number)
        elif body.outlines:
            largest = max(body.polygons, key=lambda polygon: abs(area(polygon)))
            places = _along(picture.placed(largest, number))
        else:
            places = picture.placed(np.zeros(1), number)
        yield LabelText(body.name, places, 0.0, BODY_SIZE, LIGHT.line(number - 1))


def _along(polygon: Points) -> Points:
    """The middle of a polygon, and places along its longer axis, those inside; else its edges."""
    corners = pairs(polygon)
    middle = complex(*(corners.min(axis=0) + corners.max(axis=0)) / 2)
    centred = polygon - polygon.mean()
    axis = complex(*np.linalg.svd(pairs(centred), full_matrices=False)[2][0])
    reach = float(np.max(abs(dot(axis, centred))))
    found = middle + np.array([0.0, 0.35, -0.35, 0.55, -0.55]) * reach * axis
    inside = [p for p in found if contains(polygon, p)]
    return np.array(inside) if inside else (polygon + np.roll(polygon, -1)) / 2


def _others(picture: Picture, values: bool) -> Iterator[LabelText]:
    """Names of drivers, springs, tracked points and contacts; of forces where none has its size."""
    size = picture.size
    ends = {} if values else {load.element: _ends(one) for load, one in drawn_loads(picture)}
    for symbol in picture.symbols:
        text = symbol.element
        match symbol.shape:
            case shapes.Drive() as shape:
                room = (ROUND_ARROW if shape.turns else ARROW) * size
                at, color = picture.at(shape.j), LIGHT.driver
            case shapes.Spring() as shape:
                room = 0.02 * size
                at, color = (picture.at(shape.i) + picture.at(shape.j)) / 2, LIGHT.spring
            case shapes.Trace() as shape:
                at, room, color = picture.at(shape.at), PIN * size, LIGHT.joint
            case shapes.SpiralSpring() as shape:
                at, room, color = picture.at(shape.j), 0.05 * size, LIGHT.spring
            case shapes.Torque() as shape if text in ends:
                at, room, color = picture.at(shape.at), WIDE * ROUND_ARROW * size, LIGHT.torque
            case shapes.Force() if text in ends:
                yield LabelText(text, ends[text], 0.0, OTHER_SIZE, LIGHT.force)
                continue
            case _:
                continue
        yield LabelText(text, np.array([at]), room, OTHER_SIZE, color)
    for one in [] if values else [*surfaces(picture, True), *surfaces(picture, False)]:
        places = one.middle + 0.85 * one.half * one.along * np.array([1, -1])
        yield LabelText(one.element, places, 0.0, OTHER_SIZE, LIGHT.joint)


def _valued(picture: Picture, series: Series | None) -> Iterator[LabelText]:
    """What acts on which body, with its size."""
    for load, strokes in drawn_loads(picture, None, series):
        text = f"{load.label}: {engineering(load.size, load.unit)}"
        places = _ends(strokes) if load.style == "force" else load.at
        room = WIDE * ROUND_ARROW * picture.size if load.style == "torque" else 0.0
        yield LabelText(text, places, room, OTHER_SIZE, getattr(LIGHT, load.style))


def _ends(strokes: list[Stroke]) -> Points:
    """The ends of the shaft of an arrow, the far one first, (2,)."""
    return np.asarray(strokes[0].points[[-1, 0]])


def _gaps(picture: Picture) -> Iterator[LabelText]:
    """How far the places of joints are apart that are not closed."""
    for symbol in picture.symbols:
        gap = gap_of(picture, symbol)
        if gap is not None:
            text = f"{symbol.element}: {abs(gap[1] - gap[0]):.4g} m apart"
            places = np.array([gap.mean(), gap[1], gap[0]])
            yield LabelText(text, places, 0.01 * picture.size, NUMBER_SIZE, LIGHT.bad)


def engineering(value: float, unit: str) -> str:
    """A number with three digits and a prefix: 12.3 kN."""
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if abs(value) >= factor:
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"
