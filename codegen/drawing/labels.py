"""Names and numbers of a picture: what they say, beside what they may stand, and where they do.

Names overlap neither each other nor lines, as far as there is room.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.annotations import WIDE, Series, drawn_loads
from codegen.drawing.contacts import surfaces
from codegen.drawing.guides import guide_of, rail_ends
from codegen.drawing.lines_between_bodies import gap_of
from codegen.drawing.picture import ARROW, PIN, ROUND_ARROW, Picture
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    area,
    circle,
    contains,
    dot,
    pairs,
    samples,
    unit,
)
from codegen.drawing.styles import LIGHT, Stroke

if TYPE_CHECKING:
    from matplotlib.axes import Axes

JOINT_SIZE, BODY_SIZE, OTHER_SIZE, NUMBER_SIZE = 9.5, 8.5, 8.0, 7.5  # layout: letters, in points
MOST_NAMES = 40  # layout: more than these cover the picture; bodies alone have theirs then
MOST_AT_ONE_PLACE = 3  # layout: names of joints at one place
ANGLES = 16  # layout: directions from an anchor in which a name may stand
DISTANCES = (0.0, 5.0, 12.0, 22.0, 36.0)  # layout: points between an anchor's room and the name
LABEL_COST, LINE_COST, OUTSIDE_COST = 400.0, 5.0, 300.0  # layout: of an overlap, per sample
DISTANCE_COST = 0.35  # layout: per point of distance
SAMPLE = 2.0  # layout: distance of the samples of lines that names avoid, in points
SWEEPS = 3  # layout: how often all names are placed anew, given the others


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
    named = {one.text.partition(", ")[0] for one in valued}
    bodies, gaps = list(_bodies(picture)), list(_gaps(picture))
    wanted = [*_joints(picture, named), *bodies, *valued, *_others(picture, values), *gaps]
    if len(wanted) > MOST_NAMES:  # of a long chain of alike parts, say: bodies are enough
        return [*bodies, *gaps]
    return wanted


def _joints(picture: Picture, forces: set[str]) -> Iterator[LabelText]:
    """Names of joints, those at one place together; without those that a force names."""
    room, known = PIN * picture.size, set(forces)
    found: list[tuple[Points, list[str]]] = []
    for symbol in picture.symbols:
        at = _places(picture, symbol.shape) if symbol.role == "joint" else None
        if symbol.element in known or at is None:
            continue
        known.add(symbol.element)
        near = [names for places, names in found if abs(places[0] - at[0]) < room]
        if near:
            near[0].append(symbol.element)
        else:
            found.append((at, [symbol.element]))
    for at, names in found:
        more = " …" if len(names) > MOST_AT_ONE_PLACE else ""
        text = ", ".join(names[:MOST_AT_ONE_PLACE]) + more
        yield LabelText(text, at, room, JOINT_SIZE, LIGHT.ink, "italic")


def _places(picture: Picture, shape: shapes.Shape) -> Points | None:
    """Places (k,) beside which the name of the shape's element may stand, m; None: it has none."""
    match shape:
        case shapes.Pin(at) | shapes.Fixing(at) | shapes.Bearing(at) | shapes.Trace(at):
            return np.array([picture.at(at)])
        case shapes.Torque(at) | shapes.SpiralSpring(j=at) | shapes.Drive(j=at):
            return np.array([picture.at(at)])
        case shapes.Slide() | shapes.Slot():
            guide = guide_of(picture, shape)
            if not picture.is_ground(guide.body):
                return np.array([picture.at(guide.block)])
            ends = rail_ends(picture, guide)
            return np.array([*ends[np.argsort(-ends.real)], ends.mean()])
        case shapes.Rod(i, j):
            ends = np.array([picture.at(i), picture.at(j)])
            return np.asarray(ends[0] + (ends[1] - ends[0]) * np.array([0.5, 0.35, 0.65]))
        case shapes.Belt(i, j) | shapes.Spring(i, j):
            return np.array([(picture.at(i) + picture.at(j)) / 2])
        case shapes.Wheel(toothed=True):
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
        if wheel.is_ring
    }
    for number, body in enumerate(picture.bodies):
        if number == 0 or body.fixed:
            continue
        largest = max(body.polygons, key=lambda one: abs(area(one)), default=np.zeros(1))
        places = picture.placed(rings.get(number, largest), number)
        if number not in rings and body.outlines:
            places = _along(places)
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


_OTHERS = {
    shapes.Spring: (0.02, LIGHT.spring), shapes.SpiralSpring: (0.05, LIGHT.spring),
    shapes.Trace: (PIN, LIGHT.joint), shapes.Drive: (ARROW, LIGHT.driver),
    shapes.Torque: (WIDE * ROUND_ARROW, LIGHT.torque), shapes.Force: (0.0, LIGHT.force),
}  # fmt: skip
"""Room about other shapes, in typical lengths, and the colours of their names."""


def _others(picture: Picture, values: bool) -> Iterator[LabelText]:
    """Names of drivers, springs, tracked points and contacts; of forces where none has its size."""
    ends = {} if values else {load.element: _ends(one) for load, one in drawn_loads(picture)}
    for symbol in picture.symbols:
        shape, text = symbol.shape, symbol.element
        is_load = isinstance(shape, shapes.Force | shapes.Torque)
        if type(shape) in _OTHERS and (text in ends or not is_load):
            room, color = _OTHERS[type(shape)]
            if isinstance(shape, shapes.Drive) and shape.turns:
                room = ROUND_ARROW
            places: Any = ends[text] if isinstance(shape, shapes.Force) else _places(picture, shape)
            yield LabelText(text, places, room * picture.size, OTHER_SIZE, color)
    for one in [] if values else [*surfaces(picture, True), *surfaces(picture, False)]:
        places = one.middle + 0.85 * one.half * one.along * np.array([1, -1])
        yield LabelText(one.element, places, 0.0, OTHER_SIZE, LIGHT.joint)


def _valued(picture: Picture, series: Series | None) -> Iterator[LabelText]:
    """What acts on which body, with its size."""
    for load, strokes in drawn_loads(picture, None, series):
        text = f"{load.label}: {engineering(load.size, load.unit)}"
        places = _ends(strokes) if load.style == "force" else np.array([load.at])
        room = WIDE * ROUND_ARROW * picture.size if load.style == "torque" else 0.0
        yield LabelText(text, places, room, OTHER_SIZE, getattr(LIGHT, load.style))


def _ends(strokes: list[Stroke]) -> Points:
    """The ends of the shaft of an arrow, the far one first, (2,)."""
    return strokes[0].points[[-1, 0]]


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


class Label(NamedTuple):
    """A text to be placed: places (k,) beside which it may stand, m, the best first.

    `half` has half its width and, times i, half its height, m; it keeps `room` about a place, m.
    """

    places: Points
    half: complex
    room: float


class Spot(NamedTuple):
    """Where a text stands: its centre, what it stands beside, and whether that is far away."""

    center: complex
    place: complex
    is_far: bool


def place_labels(
    labels: Sequence[Label], lines: Points, low: complex, high: complex, point: float
) -> list[Spot]:
    """Where the texts stand: each in turn takes its best place, given those of all others.

    Parameters
    ----------
    lines
        Samples of all lines, (n,), m: a text should cover few of them.
    low, high
        Lower left and upper right corner of the paper, m.
    point
        The length of a point of the paper, m.
    """
    margin = point * (1 + 1j)
    choices = [_candidates(label, lines, low, high, point) for label in labels]
    chosen = [int(np.argmin(costs)) for _, costs in choices]
    for _ in range(SWEEPS):
        for k, label in enumerate(labels):
            centers, costs = choices[k]
            total = costs.copy()
            for other, number in enumerate(chosen):
                if other != k:
                    away = centers - choices[other][0][number]
                    total += LABEL_COST * _is_within(away, label.half + labels[other].half + margin)
            chosen[k] = int(np.argmin(total))
    spots = []
    for label, (centers, _), number in zip(labels, choices, chosen, strict=True):
        center, place = centers[number], label.places[number // (len(DISTANCES) * ANGLES)]
        near = label.half + (label.room + (DISTANCES[2] + 1) * point) * (1 + 1j)
        spots.append(Spot(center, place, not _is_within(center - place, near)))
    return spots


def _candidates(
    label: Label, lines: Points, low: complex, high: complex, point: float
) -> tuple[Points, FloatArray]:
    """Centres at which a text may stand, (c,), m, and the cost of each, (c,).

    Its nearest point is at each distance from each place, in each direction.
    """
    half, number, distances = label.half, np.arange(ANGLES), np.array(DISTANCES)[:, None]
    ways = np.exp(2j * np.pi * number / ANGLES)
    lean = half.real * np.clip(1.5 * ways.real, -1, 1) + 1j * half.imag * np.clip(
        1.5 * ways.imag, -1, 1
    )
    shifts = (label.room + point * distances) * ways + lean
    centers = (label.places[:, None, None] + shifts).ravel()
    order = np.arange(len(label.places))[:, None, None]
    costs = DISTANCE_COST * distances + 1.5 * order + 0.4 * ((number * 3) % 4 != 2)
    margin = half + point * (1 + 1j)
    covered = [np.count_nonzero(_is_within(lines - center, margin)) for center in centers]
    is_inside = _is_within(centers - (low + high) / 2, (high - low) / 2 - half)
    return centers, costs.ravel() + LINE_COST * np.array(covered) + OUTSIDE_COST * ~is_inside


def _is_within(away: Any, half: complex) -> Any:
    """Whether vectors end within a box of this half width and height."""
    return (np.abs(away.real) < half.real) & (np.abs(away.imag) < half.imag)


class Writer:
    """Writes texts on equal axes, so that they do not overlap.

    Parameters
    ----------
    lines
        All lines of the picture in the global frame, (k,) each, m, which names avoid.
    """

    def __init__(self, axes: "Axes", lines: Iterable[Points]) -> None:
        self.axes = axes
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        self.low, self.high = complex(left, bottom), complex(right, top)
        self.pixel = (right - left) / axes.get_window_extent().width  # m
        self.point = self.pixel * axes.figure.dpi / 72.0  # m
        self.obstacles = [samples(line, SAMPLE * self.point) for line in lines]

    def _write(
        self, at: complex, text: str, avoid: bool = False, **style: Any
    ) -> tuple[Any, complex]:
        """A text, and half its width and height, m; no name covers what is to be avoided."""
        style = {"ha": "center", "va": "center", "zorder": 8, **style}
        artist: Any = self.axes.text(at.real, at.imag, text, **style)
        box = artist.get_window_extent()
        half = self.pixel * complex(box.width, box.height) / 2
        if avoid:
            center = complex(
                *self.axes.transData.inverted().transform((box.x0 + box.x1, box.y0 + box.y1)) / 2
            )
            step = 2 * self.point
            x, y = (np.arange(-size, size + step, step) for size in (half.real, half.imag))
            self.obstacles.append((center + x + 1j * y[:, None]).ravel())
        return artist, half

    def add_names(self, picture: Picture, series: Series | None, values: bool) -> None:
        """Write the names of bodies, joints, drivers and forces beside them.

        `values` says whether forces have their sizes behind their names.
        """
        labels, artists = [], []
        for text, places, room, size, color, style in label_texts(picture, series, values):
            artist, half = self._write(0j, text, fontsize=size, color=color, fontstyle=style)
            labels.append(Label(places, half, room + 2.0 * self.point))
            artists.append(artist)
        lines = np.concatenate([*self.obstacles, np.zeros(0)])
        spots = place_labels(labels, lines, self.low, self.high, self.point)
        for artist, (center, place, is_far) in zip(artists, spots, strict=True):
            artist.set_position((center.real, center.imag))
            if is_far:
                ends, color = np.array([center, place]), artist.get_color()
                self.axes.plot(*pairs(ends).T, zorder=7, color=color, linewidth=0.5, alpha=0.6)
            artist.set_bbox({"facecolor": LIGHT.background, "alpha": 0.72,
                             "edgecolor": "none", "boxstyle": "round,pad=0.08"})  # fmt: skip

    def add_dimension(self, line: Points) -> None:
        """Write the distance along a dimension line, readable from below and from the right."""
        along = line[1] - line[0]
        self._write(
                complex(line.mean()), f"{abs(along):.4g}", True,
                fontsize=NUMBER_SIZE, color=LIGHT.ink,
                rotation=(np.degrees(np.angle(along)) + 90.0) % 180.0 - 90.0,
                bbox={"facecolor": LIGHT.background, "edgecolor": "none", "pad": 0.6},
            )  # fmt: skip

    def add_scale(self, scale: float, size: float) -> None:
        """The scale of the forces, m/N: a bar in the lower right corner for a round force."""
        exact = 0.2 * size / scale
        power = 10.0 ** np.floor(np.log10(exact))
        value = power * max(m for m in (1, 2, 5) if m * power <= exact * (1 + 1e-9))
        end = complex(self.high.real, self.low.imag) + (-0.03 + 0.03j) * size
        x, y = pairs(np.array([end - value * scale, end])).T
        self.axes.plot(x, y, "|-", color=LIGHT.force, linewidth=1.4, markersize=6, zorder=8,
                       solid_capstyle="butt")  # fmt: skip
        at = end - value * scale / 2 + 0.015j * size
        style = {"va": "bottom", "fontsize": NUMBER_SIZE, "color": LIGHT.force}
        self._write(at, engineering(value, "N"), True, **style)
