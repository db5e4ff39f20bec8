"""A run as the page has it: bodies, lines, arrows and events, with their numbers over time.

Lengths are in the unit of the run; points are complex numbers x + iy. A place is a body with x and
y in its frame, or, where it moves in there, its path in the global frame.

The page carries all runs as one block, gzip as base64: four bytes, the length of the JSON,
little-endian; the JSON, UTF-8, with the header, in which ``{"array": number}`` stands for an array,
and the lengths of the arrays; and all arrays one after another as float32 in four planes, first the
lowest byte of every number, the highest last. Neighbouring numbers share their high bytes, so that
planes compress well.
"""

import base64
import gzip
import json
from collections.abc import Iterable, Iterator, Set
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing import shapes
from codegen.drawing.annotations import Load, Series, acting_loads
from codegen.drawing.contacts import moving_surfaces, nearest_side, touch
from codegen.drawing.lines_between_bodies import belt_difference, link_styles, links, windings
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import (
    AZIMUTH,
    HEIGHT,
    PIN,
    SPACE_POSE,
    SPRING,
    Picture,
    SpacePicture,
    Symbol,
)
from codegen.drawing.shapes import ContactSide, Place, SpacePlace, is_finite, places
from codegen.drawing.solids import Solid, solids
from codegen.drawing.space_shapes import Pull, Wrench
from codegen.drawing.styles import STYLES, Stroke, size_of

if TYPE_CHECKING:
    from runtime.results.result import Result

_LEVEL = 9  # layout: of compression
_DROPPED = 8  # accuracy: low bits of a mantissa of 24 that curves leave out, 1.5e-5 of a value
MAX_MARKS = 2000  # layout: marks of a run
_FLASHES = {"touches", "tightens", "impact", "strikes", "closes", "engage"}
"""What an event's word, kind or action is where bodies hit each other."""
NO_MACHINE, NO_MACHINE_IN_SPACE = (
    picture("", (), np.zeros((1, 0, numbers)), (), t=np.zeros(1))
    for picture, numbers in ((Picture, 3), (SpacePicture, SPACE_POSE))
)
"""The pictures of a run whose machine is not known."""
FloatArray = npt.NDArray[np.float64]
Row = dict[str, Any]


def unit_for(size: float) -> float:
    """The unit of length of a run, m: browsers paint nothing whose lengths are 1e-6 or 1e6."""
    return 1.0 if 0.1 <= size <= 100 else float(10.0 ** round(np.log10(size)))


def machine_data(
    picture: Picture, unit: float | None = None, series: Series | None = None,
    marks: Iterable[Row] = (),
) -> Row:  # fmt: skip
    """Bodies, lines, arrows and events of a run, in a unit of length, m; marks of `event_marks`."""
    unit = unit or unit_for(picture.size)
    kind: type[_Machine] = _MachineInSpace if isinstance(picture, SpacePicture) else _Machine
    machine = kind(picture, unit)
    size = picture.size / machine.unit
    both = zip(picture.symbols, machine.first.symbols, strict=True)
    return {
        "size": size,
        "unit": machine.unit,
        "pin": PIN * size,
        "acts": machine.spans(),
        "bodies": [machine.body(number) for number in range(len(picture.bodies))],
        "strokes": [*machine.rigid_lines(), *machine.surfaces()],
        "symbols": [machine.symbol(one, still) for one, still in both if is_finite(still.shape)],
        "arrows": list(machine.arrows(series or {})),
        "events": [machine.with_place(mark) for mark in marks],
        **machine.more(),
    }


class _Machine:
    """What a page has of a machine, row by row."""

    def __init__(self, picture: Picture, unit: float) -> None:
        self.picture, self.first, self.unit = picture, picture.first, unit
        lines = lines_in_bodies(self.first)
        self.strokes = [stroke for stroke in lines if np.isfinite(stroke.points).all()]
        sides: dict[str, list[ContactSide]] = {}
        for symbol, side in picture.having(ContactSide):
            sides.setdefault(symbol.element, []).append(side)
        # Contact → where its nearest side touches over time, (k,), m.
        self.touches = {
            element: self.over_time(
                np.choose(nearest_side(own), [touch(picture, side).point for side in own])
            )
            for element, own in sides.items()
        }

    def more(self) -> Row:
        """What machines in space have besides."""
        return {}

    def over_time(self, values: Any) -> Any:
        """A number at all instants, (k,)."""
        return np.broadcast_to(values, len(self.picture.poses))

    def path(self, points: Any) -> list[Any]:
        """Components of points over time."""
        points = self.over_time(points)
        return [points.real / self.unit, points.imag / self.unit]

    def place(self, place: Any) -> Row:
        """A place of a shape."""
        if np.ndim(place.point):
            return {"path": self.path(self.picture.at(place))}
        return {"body": place.body, "x": place.x / self.unit, "y": place.y / self.unit}

    def body(self, number: int) -> Row:
        """A body; an angle of many turns has too few digits as one float32."""
        body, (x, y, angle) = self.picture.bodies[number], self.picture.poses[:, number].T
        own = [stroke for stroke in self.strokes if stroke.body == number]
        turn = in_two(angle) if np.nanmax(abs(angle), initial=0.0) > np.pi else [angle]
        return {
            "name": body.name, "fixed": body.fixed, "area": size_of(self.picture, number, own),
            "outlines": [line / self.unit for line in body.outlines],
            "pose": [x / self.unit, y / self.unit, *turn],
        }  # fmt: skip

    def rigid_lines(self) -> Iterator[Row]:
        """The lines that are fixed in bodies, with how far they move in there."""
        shifts = self.picture.shifts(self.first).items()
        moves = {key: {"shift": self.path(shift)} for key, shift in shifts}
        for stroke in self.strokes:
            yield self._line(stroke) | moves.get((stroke.element, stroke.body), {})

    def _line(self, stroke: Stroke) -> Row:
        style = STYLES[stroke.style]
        known = {"layer": style.layer, "depth": style.depth, "points": stroke.points / self.unit}
        return stroke._asdict() | known

    def surfaces(self) -> Iterator[Row]:
        """The lines of surfaces that move, in the ground, with the poses of their frames."""
        for one in moving_surfaces(self.picture):
            angle, known = np.angle(one.along), np.isfinite(one.along)
            angle[known] = np.unwrap(angle[known])
            shift = [*self.path(one.middle), angle]
            for style, points in one._replace(middle=0j, normal=1j).lines(self.picture.size):
                yield self._line(Stroke(style, 0, points, False, one.element)) | {"shift": shift}

    def symbol(self, symbol: Symbol, still: Symbol) -> Row:
        """A symbol, where it is, and what the page draws of it that no stroke and no arrow is."""
        held = [self.place(place) for place in places(symbol.shape)]
        row: Row = {"element": symbol.element, "kind": symbol.kind, "role": symbol.role,
                    "shape": symbol.shape.kind, "at": held[-1] if held else None}  # fmt: skip
        match symbol.shape:
            case shapes.Gravity(gx, gy):
                return row | {"gravity": np.ravel(gx + 1j * gy)[0]}
            case shapes.Reaction(by, on):
                return row | {"ties": [by, on]}
            case shapes.Trace(at):
                return row | {"path": self.path(self.picture.at(at))}
            case shapes.Drive(i) as drive:
                angle = np.ravel(np.angle(drive.along))[0]
                return row | {"turns": drive.turns, "angle": angle, "body": i.body if i else 0}
        lines = self.links(still.shape)
        return row | (lines and dict(zip("ij", held, strict=True)) | lines)

    def links(self, shape: shapes.Shape) -> Row:
        """The lines between two places of springs, rods and belts, which the page places."""
        size = self.picture.size
        own = [(style, points / [1, self.unit, 1, 1]) for style, points in windings(shape, size)]
        lines = [
            {"style": style, "points": points.tolist()} for style, points in [*links(shape), *own]
        ]
        match shape:
            case shapes.Spring() | shapes.Rod():
                return {"lines": lines, "half_width": SPRING * size / self.unit}
            case shapes.SpiralSpring(i, j):
                return {"lines": lines, "turns": [i.body, j.body]}
            case shapes.Belt():
                return {"lines": lines, "belt": belt_difference(shape) / self.unit}
        return {}

    def spans(self) -> dict[str, list[list[float]]]:
        """Element → spans of time in which it acts, of those that come or go.

        Bounds are those of instants, of which the page has 48 bits; the last span has no end.
        """
        t = self.picture.t
        assert t is not None
        close = 1e-12 * max(abs(t[0]), abs(t[-1]))
        return {
            symbol.element: [
                [first - close, last - close if last < t[-1] - close else 1e300]
                for first, last in symbol.spans
            ]
            for symbol in self.picture.symbols
            if symbol.spans
        }

    def arrows(self, series: Series) -> Iterator[Row]:
        """All that acts, with its components over time."""
        kinds = {symbol.element: symbol.kind for symbol in self.picture.symbols}
        for load in acting_loads(self.picture, series):
            parts = self.components(load)
            at = {"path": self.path(load.at)} if load.place is None else self.place(load.place)
            yield {
                "element": load.element, "kind": kinds[load.element], "style": load.style,
                "label": load.label, "unit": load.unit, "at": at,
                "value": [rounded(part) for part in parts],
            }  # fmt: skip

    def components(self, load: Load) -> Iterable[FloatArray]:
        """Of a force along the global axes; of a torque in the plane it alone."""
        value: Any = self.over_time(load.value)
        return (value,) if load.style == "torque" else (value.real, value.imag)

    def with_place(self, mark: Row) -> Row:
        """A mark of an event with the place where bodies hit each other, if it flashes."""
        at = self._place_of_hit(mark["element"], mark["t"]) if mark["flash"] else None
        return mark if at is None else {**mark, "at": at}

    def _place_of_hit(self, element: str, t: float) -> Row | None:
        """Where an element is; a contact where its nearest side touches at an instant, if known."""
        own = [symbol.shape for symbol in self.picture.symbols if symbol.element == element]
        held = [found[-1] for found in map(places, own) if found]
        bodies = [b for one in own if isinstance(one, shapes.Contact) for b in one.bodies]
        if not held:
            assert self.picture.t is not None
            k = max(int(np.searchsorted(self.picture.t, t, "right")) - 1, 0)
            hit = self.touches[element][k] if element in self.touches else np.nan
            held = [Place(0, hit.real, hit.imag)] if np.isfinite(hit) else []
        held += [Place(body, 0.0, 0.0) for body in bodies if not self.picture.is_ground(body)]
        return self.place(held[0]) if held else None


class _MachineInSpace(_Machine):
    """What a page has of a machine in space."""

    picture: SpacePicture

    def __init__(self, picture: SpacePicture, unit: float) -> None:
        self.picture, self.first, self.unit = picture, picture.first, unit
        self.strokes, self.touches = [], {}

    def more(self) -> Row:
        """Solids, and the usual view."""
        right, up = (axis.tolist() for axis in self.picture.level)
        found = [self.solid(one) for one in solids(self.picture)]
        view = {"right": right, "up": up, "azimuth": AZIMUTH, "height": HEIGHT}
        return {"solids": found, "view": view}

    def solid(self, one: Solid) -> Row:
        """A solid; one of triangles has its matrix within its corners."""
        row: Row = {"form": one.form, "body": one.body, "element": one.element}
        if one.mesh:
            corners, triangles = one.mesh.vertices / self.unit, one.mesh.triangles
            return row | {"corners": rounded(corners), "triangles": triangles.astype(np.float32)}
        return row | {"matrix": (one.matrix / self.unit).ravel().round(9).tolist()}

    def path(self, points: Any) -> list[Any]:
        """Components of points over time."""
        return [rounded(c) for c in np.moveaxis(points / self.unit, -1, 0)]

    def place(self, place: Any) -> Row:
        """A place of a shape."""
        if any(np.ndim(c) for c in place):
            return {"path": self.path(self.picture.where(place))}
        return {"body": place.body} | {
            c: value / self.unit for c, value in zip("xyz", place[1:], strict=True)
        }

    def body(self, number: int) -> Row:
        """A body."""
        body, pose = self.picture.bodies[number], self.picture.poses[:, number].T
        return {
            "name": body.name, "fixed": body.fixed, "area": 0.0, "outlines": [],
            "pose": [rounded(c / self.unit) for c in pose[:3]], "turn": [*map(rounded, pose[3:])],
        }  # fmt: skip

    def rigid_lines(self) -> Iterator[Row]:
        """None: solids are in their place."""
        yield from ()

    def _place_of_hit(self, element: str, t: float) -> Row | None:
        """A place that an element holds, or the middle of a body that touches."""
        own = [symbol.shape for symbol in self.picture.symbols if symbol.element == element]
        bodies = [b for one in own if isinstance(one, shapes.Contact) for b in one.bodies]
        held = [place for one in own for place in places(one)[:2]]
        held += [SpacePlace(b, 0.0, 0.0, 0.0) for b in bodies if not self.picture.is_ground(b)]
        return self.place(held[0]) if held else None

    def symbol(self, symbol: Symbol, still: Symbol) -> Row:
        """A symbol, where it is, and between which places it lies."""
        held = [self.place(place) for place in places(symbol.shape)]
        pair = isinstance(symbol.shape, shapes.Pair)
        at = held[1 if pair else 0] if held else None
        row: Row = {"element": symbol.element, "kind": symbol.kind, "role": symbol.role,
                    "shape": symbol.shape.kind, "at": at}  # fmt: skip
        match symbol.shape:
            case Pull(gx, gy, gz):
                return row | {"gravity": [float(np.ravel(g)[0]) for g in (gx, gy, gz)]}
            case Wrench(by, at):
                return row | {"ties": [by, at.body]}
            case shapes.Trace():
                return row | {"path": self.path(self.picture.where(symbol.shape.at))}
            case shapes.Rod() | shapes.Spring():
                parts = link_styles(symbol.shape)
                width = SPRING * self.picture.size / self.unit
                ends = dict(zip("ij", held, strict=True))
                return row | ends | {"lines": [], "parts": parts, "half_width": width}
        return row

    def components(self, load: Load) -> Iterable[FloatArray]:
        """Along the global axes."""
        return np.broadcast_to(load.value, (len(self.picture.poses), 3)).T


def event_marks(result: "Result") -> list[Row]:
    """Every mark within the instants of a result, no more than `MAX_MARKS` of each kind.

    A mark has its instant in s, its text, the element that it is of, and whether it flashes.
    """
    if not len(result.t):
        return []
    first, last = float(result.t.min()), float(result.t.max())
    events = [(e.time, e.text, e.element, {e.word, e.what}) for e in result.events]
    changes = [(c.time, c.text, c.joint, {c.action}) for c in result.reconnections]
    marks = []
    for rows, what in ((events, "events"), (changes, "joints")):
        within = [_mark(*row) for row in rows if first <= row[0] <= last]
        marks += within[:MAX_MARKS]
        if len(within) > MAX_MARKS:
            marks.append(_mark(last, f"{len(within) - MAX_MARKS} more {what} have no marks"))
    motion = result._motion
    if (result.failed or result.ended_by) and (motion is None or last >= motion.span[1]):
        failure = f"{result.outcome.name}: {result.message}"
        marks.append(_mark(last, failure if result.failed else result.ended_by))
    return sorted(marks, key=lambda mark: mark["t"])


def _mark(t: float, text: str, element: str = "", words: Set[str] = frozenset()) -> Row:
    return {"t": float(t), "text": text, "element": element, "flash": bool(words & _FLASHES)}


def rounded(values: FloatArray) -> npt.NDArray[np.float32]:
    """The values with fewer digits, as curves have them."""
    part = values.astype(np.float32)
    half = np.uint32(1 << (_DROPPED - 1))
    mask = np.uint32(0xFFFFFFFF ^ ((1 << _DROPPED) - 1))
    kept = ((part.view(np.uint32) + half) & mask).view(np.float32)
    return np.where(np.isfinite(part) & np.isfinite(kept), kept, part)


def in_two(values: FloatArray) -> list[FloatArray]:
    """Two arrays whose sum has the values to 48 bits."""
    high = values.astype(np.float32).astype(np.float64)
    return [high, values - high]


def block(header: dict[str, Any]) -> str:
    """The block as base64. Complex numbers of the header are pairs x, y there, also in arrays."""
    parts: list[npt.NDArray[np.float32]] = []
    numbers: dict[bytes, int] = {}  # of an array that stands in several places

    def plain(value: Any) -> Any:
        if isinstance(value, complex):
            return [value.real, value.imag]
        if isinstance(value, np.generic):
            return value.item()
        both = [value.real, value.imag] if np.iscomplexobj(value) else [value]
        part = np.stack(both, axis=-1).ravel().astype("<f4")
        key = part.tobytes()
        if key not in numbers:
            numbers[key] = len(parts)
            parts.append(part)
        return {"array": numbers[key]}

    options: dict[str, Any] = {"ensure_ascii": False, "separators": (",", ":"), "allow_nan": False}
    text = json.dumps(header, default=plain, **options)
    text = f'{{"header":{text},"arrays":{[len(part) for part in parts]}}}'
    encoded = text.encode()
    planes = np.concatenate([*parts, np.empty(0, "<f4")]).view(np.uint8).reshape(-1, 4).T
    return compressed(len(encoded).to_bytes(4, "little") + encoded + planes.tobytes())


def compressed(data: bytes) -> str:
    """Bytes as gzip and base64; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, _LEVEL, mtime=0)).decode("ascii")
