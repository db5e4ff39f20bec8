"""A run as the page has it: bodies, lines, arrows and events, with their numbers over time.

Lengths are in the unit of the run; points are complex numbers x + iy. A place is a body with x and
y in its frame, or, where it moves in there, its path in the global frame.
"""

from collections.abc import Iterable, Iterator, Set
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.arrows import Series, loads
from codegen.drawing.contacts import moving_surfaces, sides_of, touch
from codegen.drawing.line_styles import STYLES, Stroke, size_of
from codegen.drawing.lines_between_bodies import links, windings
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import MovingPicture, Symbol
from codegen.drawing.proportions import PIN, SPRING
from codegen.drawing.shapes import Place, places
from runtime.show.animation.compressed_arrays import rounded

if TYPE_CHECKING:
    from runtime.results.result import Result

MAX_MARKS = 2000  # layout: marks of a run
_POSES = 300  # layout: of a motion, from which guides and racks get their lengths
_FLASHES = {"touches", "impact", "strikes", "closes", "engage"}
"""What an event's word, kind or action is where bodies hit each other."""
NO_MACHINE: dict[str, Any] = {
    "size": 1.0, "unit": 1.0, "pin": 0.01, "elements": {}, "acts": {}, "joints": 0, "bodies": [],
    "strokes": [], "links": [], "drives": [], "names": [], "traces": [], "arrows": [],
    "gravity": None,
}  # fmt: skip
"""What a page has of a run without a picture."""
Row = dict[str, Any]


def unit_for(size: float) -> float:
    """The unit of length of a run, m: browsers paint nothing whose lengths are 1e-6 or 1e6."""
    return 1.0 if 0.1 <= size <= 100 else float(10.0 ** round(np.log10(size)))


def machine_data(
    moving: MovingPicture, unit: float | None = None, series: Series | None = None,
    marks: Iterable[Row] = (),
) -> Row:  # fmt: skip
    """Bodies, lines, arrows and events of a run.

    Parameters
    ----------
    unit
        The unit of length, m; unless given, that for the size of the picture.
    series
        What joints, drivers and forces exert, by the names of the series, (k,) each.
    marks
        As of `event_marks`.
    """
    machine = _Machine(moving, unit or unit_for(moving.picture.size))
    picture, size = moving.picture, moving.picture.size / machine.unit
    arrows = list(machine.arrows(series or {}))
    finite = [(n, s) for n, s in enumerate(picture.symbols) if _is_finite(s.shape)]
    drawn = {symbol.element for _, symbol in finite} | {arrow["element"] for arrow in arrows}
    return {
        "size": size,
        "unit": machine.unit,
        "pin": PIN * size,
        "elements": {s.element: s.kind for s in picture.symbols if s.element in drawn},
        "acts": machine.spans(),
        "joints": len(picture.having(shapes.Reaction)),
        "bodies": [machine.body(number) for number in range(len(picture.bodies))],
        "strokes": [*machine.rigid_lines(), *machine.surfaces()],
        "links": [row for number, _ in finite for row in machine.links(number)],
        "drives": [
            {"element": symbol.element, "at": machine.place(number, "j"), "turns": drive.turns,
             "angle": np.angle(drive.along), "body": drive.i.body if drive.i else 0}
            for number, symbol in finite if isinstance(drive := symbol.shape, shapes.Drive)
        ],
        "names": [{"element": name, "at": at} for name, at in machine.names(finite).items()],
        "traces": [
            {"element": symbol.element, "at": machine.place(number, "at"),
             "path": machine.path(moving.path(number, "at"))}
            for number, symbol in finite if isinstance(symbol.shape, shapes.Trace)
        ],
        "arrows": arrows,
        "gravity": next((complex(g.gx, g.gy) for _, g in picture.having(shapes.Gravity)), None),
        "events": [machine.with_place(mark) for mark in marks],
    }  # fmt: skip


class _Machine:
    """What a page has of a machine, row by row."""

    def __init__(self, moving: MovingPicture, unit: float) -> None:
        self.moving, self.picture, self.unit = moving, moving.picture, unit
        motion = moving.poses[:: 1 + len(moving.poses) // _POSES]
        lines = lines_in_bodies(self.picture, motion)
        self.strokes = [stroke for stroke in lines if np.isfinite(stroke.points).all()]
        self.touched: dict[int, Any] = {}  # by the numbers of sides of contacts

    def path(self, points: Any) -> list[Any]:
        """Components of points over time."""
        return [points.real / self.unit, points.imag / self.unit]

    def place(self, number: int, name: str) -> Row:
        """A place of a symbol's shape."""
        place = getattr(self.picture.symbols[number].shape, name)
        if self.moving.moves(number, name):
            return {"path": self.path(self.moving.path(number, name))}
        return self._fixed(place.body, place.point)

    def _fixed(self, body: int, point: complex) -> Row:
        return {"body": body, "x": point.real / self.unit, "y": point.imag / self.unit}

    def body(self, number: int) -> Row:
        """A body; its angle is within half a turn of 0, with the number of turns, if any, behind.

        An angle of many turns has too few digits as float32.
        """
        body, (x, y, angle) = self.picture.bodies[number], self.moving.poses[:, number].T
        own = [stroke for stroke in self.strokes if stroke.body == number]
        turns = np.where(np.isfinite(angle), np.round(angle / (2 * np.pi)), 0.0)
        turn = [angle - 2 * np.pi * turns, turns][: 2 if turns.any() else 1]
        return {
            "name": body.name, "fixed": body.fixed, "area": size_of(self.picture, number, own),
            "outlines": [line / self.unit for line in body.polygons],
            "pose": [x / self.unit, y / self.unit, *turn],
        }  # fmt: skip

    def rigid_lines(self) -> Iterator[Row]:
        """The lines that are fixed in bodies, with how far they move in there."""
        for stroke in self.strokes:
            shift = self.moving.shifts.get((stroke.element, stroke.body))
            yield self._line(stroke) | ({} if shift is None else {"shift": self.path(shift)})

    def _line(self, stroke: Stroke) -> Row:
        style = STYLES[stroke.style]
        known = {"layer": style.layer, "depth": style.depth, "points": stroke.points / self.unit}
        return stroke._asdict() | known

    def surfaces(self) -> Iterator[Row]:
        """The lines of surfaces that move, in the ground, with the poses of their frames."""
        for surface, poses in moving_surfaces(self.moving):
            x, y, angle = poses.T
            for style, points in surface.lines(self.picture.size):
                line = self._line(Stroke(style, 0, points, False, surface.element))
                yield line | {"shift": [x / self.unit, y / self.unit, angle]}

    def links(self, number: int) -> Iterator[Row]:
        """The lines between two places of springs, rods and belts, which the page places."""
        symbol = self.picture.symbols[number]
        size, own = self.picture.size / self.unit, Row()
        match symbol.shape:
            case shapes.Spring() | shapes.Rod() as shape:
                own = {"half_width": SPRING * size}
            case shapes.SpiralSpring() as shape:
                own = {"turns": [shape.i.body, shape.j.body]}
            case shapes.Belt() as shape:
                way = 1 if shape.crossed else -1
                own = {"belt": (abs(shape.radius_i) + way * abs(shape.radius_j)) / self.unit}
            case _:
                return
        lines = [
            *({"style": one.style, "points": one.points.tolist()} for one in links(shape)),
            *({"style": one.style, "points": (one.points / [1, self.unit, 1, 1]).tolist()}
              for one in windings(shape, self.picture.size)),
        ]  # fmt: skip
        ends = {name: self.place(number, name) for name in ("i", "j")}
        yield {"element": symbol.element, "lines": lines, **ends, **own}

    def names(self, symbols: Iterable[tuple[int, Symbol]]) -> dict[str, Row]:
        """Joints and tracked points, and where their names stand: at the last place of a shape."""
        found: dict[str, Row] = {}
        for number, symbol in symbols:
            at = _fields_of_places(symbol.shape)
            if at and (symbol.role == "joint" or isinstance(symbol.shape, shapes.Trace)):
                found.setdefault(symbol.element, self.place(number, at[-1]))
        return found

    def spans(self) -> dict[str, list[list[float]]]:
        """Element → spans of time in which it acts, of those that come or go.

        Bounds are those of instants, of which the page has 48 bits; the last span has no end.
        """
        t, symbols = self.moving.t, self.picture.symbols
        close = 1e-12 * max(abs(t[0]), abs(t[-1]))
        return {
            symbols[number].element: [
                [first - close, last - close if last < t[-1] - close else 1e300]
                for first, last in spans
            ]
            for number, spans in self.moving.active.items()
        }

    def arrows(self, series: Series) -> Iterator[Row]:
        """All that acts, with its components over time."""
        for load in loads(self.moving, series, springs=True):
            value: Any = load.value
            if np.isfinite(load.at * value).any() and np.nanmax(abs(value)) > 0:
                parts = (value,) if load.style == "torque" else (value.real, value.imag)
                at = self.place(load.number, load.field) if load.field else None
                yield {
                    "element": load.element, "style": load.style, "label": load.label,
                    "unit": load.unit, "at": at or {"path": self.path(load.at)},
                    "value": [rounded(part) for part in parts],
                }  # fmt: skip

    def with_place(self, mark: Row) -> Row:
        """A mark of an event with the place where bodies hit each other, if it flashes."""
        at = self._place_of_hit(mark["element"], mark["t"]) if mark["flash"] else None
        return mark if at is None else {**mark, "at": at}

    def _place_of_hit(self, element: str, t: float) -> Row | None:
        for number, symbol in enumerate(self.picture.symbols):
            if symbol.element != element:
                continue
            for name in ("at", "j", "center"):
                if isinstance(getattr(symbol.shape, name, None), Place):
                    return self.place(number, name)
            if isinstance(symbol.shape, shapes.Contact):
                hit = self._touch(element, t)
                if hit is not None:
                    return self._fixed(0, hit)
                bodies = [b for b in symbol.shape.bodies if not self.picture.is_ground(b)]
                return self._fixed(bodies[0], 0j) if bodies else None
        return None

    def _touch(self, element: str, t: float) -> complex | None:
        """Where the nearest side of a contact touches at an instant; None where none does."""
        k = max(int(np.searchsorted(self.moving.t, t, "right")) - 1, 0)
        nearest, found = np.inf, None
        for number, symbol, _ in sides_of(self.picture):
            if symbol.element == element:
                if number not in self.touched:
                    self.touched[number] = touch(self.moving, number).point
                at, gap = complex(self.touched[number][k]), self.moving.number(number, "gap")[k]
                if np.isfinite(at) and gap < nearest:
                    nearest, found = gap, at
        return found


def _fields_of_places(shape: shapes.Shape) -> list[str]:
    return [f.name for f in fields(shape) if isinstance(getattr(shape, f.name), Place)]


def _is_finite(shape: shapes.Shape) -> bool:
    """Whether all places and numbers of a shape are finite: the page leaves others out."""
    values = [getattr(shape, field.name) for field in fields(shape)]
    numbers = [value for value in values if isinstance(value, float)]
    return bool(np.isfinite([*numbers, *(place.point for place in places(shape))]).all())


def event_marks(result: "Result") -> list[Row]:
    """Every mark within the instants of a result, no more than `MAX_MARKS` of each kind.

    A mark has its instant in s, its text, the element that it is of, and whether it flashes.
    """
    if not len(result.t):
        return []
    first, last = float(result.t.min()), float(result.t.max())
    events = [
        _mark(event.time, event.text, event.element, {event.word, event.what})
        for event in result.events if first <= event.time <= last
    ]  # fmt: skip
    changes = [
        _mark(change.time, str(change).rstrip("."), change.joint, {change.action})
        for change in result.reconnections if first <= change.time <= last
    ]  # fmt: skip
    marks = [*events[:MAX_MARKS], *changes[:MAX_MARKS]]
    for dropped, what in ((events, "events"), (changes, "joints")):
        if len(dropped) > MAX_MARKS:
            marks.append(_mark(last, f"{len(dropped) - MAX_MARKS} more {what} have no marks"))
    motion = result._motion
    if (result.failed or result.ended_by) and (motion is None or last >= motion.span[1]):
        failure = f"{result.outcome.name}: {result.message}"
        marks.append(_mark(last, failure if result.failed else result.ended_by))
    return sorted(marks, key=lambda mark: mark["t"])


def _mark(t: float, text: str, element: str = "", words: Set[str] = frozenset()) -> Row:
    return {"t": float(t), "text": text, "element": element, "flash": bool(words & _FLASHES)}
