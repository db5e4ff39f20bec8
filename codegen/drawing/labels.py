"""Names and numbers of a figure: their texts, their possible places, and the choice of a place."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.annotations import WIDE, Arrow
from codegen.drawing.contacts import surfaces
from codegen.drawing.guides import guide_of, pitch_point, rail_ends
from codegen.drawing.lines_between_bodies import gap_of
from codegen.drawing.picture import ARROW, BAR, PIN, ROUND_ARROW, Picture, SpacePicture
from codegen.drawing.plane_geometry import Points, area, circle, contains, pairs, samples
from codegen.drawing.space_shapes import SpaceJoint
from codegen.drawing.space_strokes import gap_in_space
from codegen.drawing.styles import LIGHT, color_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

JOINT_SIZE, BODY_SIZE, OTHER_SIZE, NUMBER_SIZE = 9.5, 8.5, 8.0, 7.5  # layout: letters, in points
MOST_NAMES = 40  # layout: more than these cover the picture; bodies alone have theirs then
MOST_AT_ONE_PLACE = 3  # layout: names of joints at one place
CORNERS = 8  # layout: of a body's outline, beside which its name may stand
# layout: directions from an anchor in which a name may stand, the best first
WAYS = np.array([1 + 1j, -1 + 1j, 1 - 1j, -1 - 1j, 1, -1, 1j, -1j])
DISTANCES = np.array([0.0, 5.0, 12.0, 22.0, 36.0])  # layout: points from an anchor's room
COVER_COST, OUTSIDE_COST = 5.0, 300.0  # layout: of a sample that is covered; off the paper
DISTANCE_COST = 0.35  # layout: per point of distance
SAMPLE = 2.0  # layout: distance of the samples of what names avoid, in points


class Label(NamedTuple):
    """A text, and beside what it may stand."""

    text: str
    places: Points  # (k,), m, the best first
    room: float  # that it keeps about these, m
    style: dict[str, Any]  # of its letters, for Matplotlib
    near: float = DISTANCES[2]  # points from its room, beyond which a line leads to its place


def labels(picture: Picture, arrows: Sequence[Arrow] = (), values: bool = False) -> list[Label]:
    """The names of bodies, joints, drivers and forces, and how far open joints are apart.

    With `values` forces, of which these are the arrows, have their sizes behind their names.
    """
    loads = {one.text: one for one in _loads(picture, arrows, values)}.values()
    named = {load.element for load, _ in arrows} if values else set()
    bodies, gaps = list(_bodies(picture)), list(_gaps(picture))
    wanted = [*_joints(picture, named), *bodies, *loads]
    wanted += [one for one in _others(picture) if one.text not in named]
    wanted += [] if values else _surfaces(picture)
    few = len(wanted) + len(gaps) <= MOST_NAMES  # else, in a chain of alike parts, bodies do
    return [*(wanted if few else bodies), *gaps]


def _style(color: str, size: float = OTHER_SIZE, fontstyle: str = "normal") -> dict[str, Any]:
    return {"fontsize": size, "color": color, "fontstyle": fontstyle}


def _joints(picture: Picture, named: set[str]) -> Iterator[Label]:
    """Names of joints, those at one place together; without those that are named otherwise."""
    room, known = PIN * picture.size, set(named)
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
        yield Label(text, at, room, _style(LIGHT["ink"], JOINT_SIZE, "italic"))


def _places(picture: Picture, shape: shapes.Shape) -> Points | None:
    """Places (k,) beside which the name of the shape's element may stand, m; None: it has none."""
    match shape:
        case shapes.Pin(at) | shapes.Fixing(at) | shapes.Bearing(at) | shapes.Trace(at):
            return np.array([picture.at(at)])
        case SpaceJoint(j=at):
            return np.array([picture.at(at)])
        case shapes.SpiralSpring(j=at) | shapes.Drive(j=at):
            return np.array([picture.at(at)])
        case shapes.Slide() | shapes.Slot():
            guide = guide_of(picture, shape)
            if not picture.is_ground(guide.body):
                return np.array([picture.at(guide.block)])
            ends = rail_ends(picture, guide)
            return np.array([*ends[np.argsort(-ends.real)], ends.mean()])
        case shapes.Rod(i, j) | shapes.Belt(i, j) | shapes.Spring(i, j):
            ends = np.array([picture.at(i), picture.at(j)])
            return np.asarray(ends[0] + (ends[1] - ends[0]) * np.array([0.5, 0.35, 0.65]))
        case shapes.Wheel(toothed=True):
            pair = picture.partners(shape, shapes.Wheel, shapes.Rack)
            return np.array([pitch_point(picture, *pair)]) if len(pair) == 2 else None
    return None


def _bodies(picture: Picture) -> Iterator[Label]:
    """Names of bodies, in their colours: within the largest outline, or beside it; at a ring."""
    rings = {
        wheel.center.body: circle(wheel.center.point, abs(wheel.radius), 8)
        for _, wheel in reversed(picture.having(shapes.Wheel))
        if wheel.is_ring
    }
    for number, body in enumerate(picture.bodies):
        if number == 0 or body.fixed:
            continue
        if isinstance(picture, SpacePicture):
            places = np.array([picture.flat(picture.poses[number, :3])])
            yield Label(body.name, places, BAR * picture.size,
                        _style(color_of("line", number), BODY_SIZE))  # fmt: skip
            continue
        largest = max(
            body.outlines, key=lambda one: abs(area(one)), default=np.zeros(1, dtype=complex)
        )
        some, middle = largest[:: len(largest) // CORNERS + 1], largest.mean()
        within = [z for z in (middle, *(some + middle) / 2) if contains(largest, z)]
        places = picture.placed(rings.get(number, np.array(within or some)), number)
        yield Label(body.name, places, 0.0, _style(color_of("line", number), BODY_SIZE))


_OTHERS: dict[type[shapes.Shape], tuple[float, str]] = {
    shapes.Spring: (0.02, "spring"), shapes.SpiralSpring: (0.05, "spring"),
    shapes.Trace: (PIN, "joint"), shapes.Drive: (ARROW, "driver"),
}  # fmt: skip
"""Room about other shapes, in typical lengths, and the colours of their names."""


def _others(picture: Picture) -> Iterator[Label]:
    """Names of drivers, springs and tracked points."""
    joints = {symbol.element for symbol in picture.symbols if symbol.role == "joint"}
    for symbol, shape in picture.having(*_OTHERS):
        if symbol.element in joints:  # a point that bears the name of a joint
            continue
        room, color = _OTHERS[type(shape)]
        if isinstance(shape, shapes.Drive) and shape.turns:
            room = ROUND_ARROW
        places = _places(picture, shape)
        assert places is not None
        yield Label(symbol.element, places, room * picture.size, _style(LIGHT[color]))


def _surfaces(picture: Picture) -> Iterator[Label]:
    """Names of contacts, at the ends of their surfaces."""
    for one in (*surfaces(picture, True), *surfaces(picture, False)):
        places = one.middle + 0.85 * one.half * one.along * np.array([1, -1])
        yield Label(one.element, places, 0.0, _style(LIGHT["joint"]))


def _loads(picture: Picture, arrows: Iterable[Arrow], values: bool) -> Iterator[Label]:
    """Names of what acts; with `values` also on which body, and its size."""
    for load, strokes in arrows:
        in_space = isinstance(picture, SpacePicture)
        is_torque = load.style == "torque" and not in_space
        number = f"{load.label}: {engineering(load.size, load.unit)}"
        places = strokes[0].points[[-1] if in_space else [-1, 0]]  # the far end; many begin at one
        places = np.array([load.at]) if is_torque else places
        room = WIDE * ROUND_ARROW * picture.size if is_torque else 0.0
        text = number if values else load.element
        yield Label(text, places, room, _style(LIGHT[load.style]), DISTANCES[1 if in_space else 2])


def _gaps(picture: Picture) -> Iterator[Label]:
    """How far the places of joints are apart that are not closed."""
    for symbol in picture.symbols:
        gap = gap_of(picture, symbol)
        distance = 0.0 if gap is None else abs(gap[1] - gap[0])
        if isinstance(picture, SpacePicture):
            gap, distance = gap_in_space(picture, symbol) or (None, 0.0)
        if gap is not None:
            text = f"{symbol.element}: {distance:.4g} m apart"
            places = np.array([gap.mean(), gap[1], gap[0]])
            yield Label(text, places, 0.01 * picture.size, _style(LIGHT["bad"], NUMBER_SIZE))


def engineering(value: float, unit: str) -> str:
    """A number with three digits and a prefix: 12.3 kN."""
    from matplotlib.ticker import EngFormatter

    return EngFormatter(unit)(float(f"{value:.3g}"))


class Writer:
    """Writes texts on equal axes: each keeps off lines, (k,), m, and off the texts before it."""

    def __init__(self, axes: "Axes", lines: Iterable[Points]) -> None:
        self.axes = axes
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        self.low, self.high = complex(left, bottom), complex(right, top)
        self.pixel = (right - left) / axes.get_window_extent().width  # m
        self.point = self.pixel * axes.figure.dpi / 72.0  # m
        self.taken = [samples(line, SAMPLE * self.point) for line in lines]

    def write(self, at: complex, text: str, **style: Any) -> tuple[Any, complex]:
        """A text, and half its width and height, m."""
        style = {"ha": "center", "va": "center", "zorder": 8, **style}
        artist: Any = self.axes.text(at.real, at.imag, text, **style)
        box = artist.get_window_extent()
        return artist, self.pixel * complex(box.width, box.height) / 2

    def take(self, center: complex, half: complex) -> None:
        """Have no later text cover a box."""
        step = SAMPLE * self.point
        x, y = (np.arange(-size, size + step, step) for size in (half.real, half.imag))
        self.taken.append((center + x + 1j * y[:, None]).ravel())

    def add(self, label: Label) -> None:
        """Write a text beside the best of its places; a line leads to one that is far away."""
        artist, half = self.write(0j, label.text, **label.style)
        center, place = self._spot(label, half)
        artist.set_position((center.real, center.imag))
        self.take(center, half)
        near = half + (label.room + (label.near + 3) * self.point) * (1 + 1j)
        if not _is_within(center - place, near):
            ends, color = np.array([center, place]), label.style["color"]
            self.axes.plot(*pairs(ends).T, zorder=7, color=color, linewidth=0.5, alpha=0.6)
        artist.set_bbox({"facecolor": LIGHT["background"], "alpha": 0.72,
                         "edgecolor": "none", "boxstyle": "round,pad=0.08"})  # fmt: skip

    def _spot(self, label: Label, half: complex) -> tuple[complex, complex]:
        """The centre of a text of this half width and height, and the place that it stands by."""
        distances, order = DISTANCES[:, None], np.arange(len(label.places))[:, None, None]
        shifts = (label.room + self.point * (2.0 + distances)) * WAYS / abs(WAYS)
        centers = label.places[:, None, None] + shifts + half.real * WAYS.real
        centers += 1j * half.imag * WAYS.imag
        taken, margin = np.concatenate(self.taken), half + self.point * (1 + 1j)
        covered = [np.count_nonzero(_is_within(taken - at, margin)) for at in centers.ravel()]
        middle, room = (self.low + self.high) / 2, (self.high - self.low) / 2 - half
        costs = (
            DISTANCE_COST * distances
            + 1.5 * order
            + COVER_COST * np.reshape(covered, centers.shape)
        )
        costs += OUTSIDE_COST * ~_is_within(centers - middle, room)
        best = np.unravel_index(np.argmin(costs), costs.shape)
        return complex(centers[best]), complex(label.places[best[0]])

    def add_dimension(self, line: Points) -> None:
        """Write the distance along a dimension line, readable from below and from the right."""
        along, center = line[1] - line[0], complex(line.mean())
        _, half = self.write(
            center, f"{abs(along):.4g}", fontsize=NUMBER_SIZE, color=LIGHT["ink"],
            rotation=(np.degrees(np.angle(along)) + 90.0) % 180.0 - 90.0,
            bbox={"facecolor": LIGHT["background"], "edgecolor": "none", "pad": 0.6},
        )  # fmt: skip
        self.take(center, half)

    def add_scale(self, scale: float, size: float) -> None:
        """The scale of the forces, m/N: a bar in the lower right corner for a round force."""
        exact = 0.2 * size / scale
        power = 10.0 ** np.floor(np.log10(exact))
        value = power * max(m for m in (1, 2, 5) if m * power <= exact * (1 + 1e-9))
        end = complex(self.high.real, self.low.imag) + (-0.03 + 0.03j) * size
        x, y = pairs(np.array([end - value * scale, end])).T
        color = LIGHT["force"]
        self.axes.plot(x, y, "|-", color=color, linewidth=1.4, markersize=6, zorder=8,
                       solid_capstyle="butt")  # fmt: skip
        at, text = end - value * scale / 2 + 0.015j * size, engineering(value, "N")
        _, half = self.write(at, text, va="bottom", fontsize=NUMBER_SIZE, color=color)
        self.take(at + 1j * half.imag, half)


def _is_within(away: Any, half: complex) -> Any:
    """Whether vectors end within a box of this half width and height."""
    return (np.abs(away.real) < half.real) & (np.abs(away.imag) < half.imag)
