"""The picture of a mechanism as numbers: bodies with outlines, shapes of elements, poses."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np

from codegen.drawing.plane_geometry import FloatArray, Points, in_frame, placed
from codegen.drawing.shapes import Place, Shape

Outline = tuple[complex, ...]
"""A closed polygon in the frame of its body, x' + iy' in m."""
OneShape = TypeVar("OneShape", bound=Shape)


@dataclass(frozen=True)
class BodyPicture:
    """A body: its name, whether it is the ground, and its outlines, given or derived."""

    name: str
    fixed: bool = False
    outlines: tuple[Outline, ...] = ()
    is_derived: bool = True  # the outlines follow from the joints; the modeller gave none

    @property
    def polygons(self) -> list[Points]:
        """The outlines as arrays."""
        return [np.array(outline) for outline in self.outlines]


@dataclass(frozen=True)
class Symbol:
    """A shape, and the element that it belongs to."""

    element: str
    kind: str  # of the element, as "revolute"
    role: str  # "joint", "driver" or "force"
    shape: Shape


@dataclass(frozen=True)
class Picture:
    """A mechanism at one instant.

    Attributes
    ----------
    title
        Model and scene.
    bodies
        The ground first, then the bodies in the order of the scene.
    poses
        x, y in m and φ in rad of each body, shape (bodies, 3).
    symbols
        The shapes of all elements that act.
    size
        A typical length of the mechanism, m, by which signs of no size of their own are scaled.
    shifts
        Element and body → how far its place has moved within the body since the first instant, m.
    """

    title: str
    bodies: tuple[BodyPicture, ...]
    poses: FloatArray
    symbols: tuple[Symbol, ...]
    size: float
    shifts: Mapping[tuple[str, int], complex] = field(default_factory=dict)

    def at(self, place: Place) -> complex:
        """A place in the global frame, x + iy in m."""
        return complex(self.placed(place.point, place.body))

    def placed(self, points: Any, body: int) -> Any:
        """Points of a body in the global frame."""
        return placed(points, self.poses[body])

    def in_body(self, points: Any, body: int) -> Any:
        """Points of the global frame in that of a body."""
        return in_frame(points, self.poses[body])

    def turned(self, direction: complex, body: int) -> complex:
        """A direction of a body in the global frame."""
        return complex(direction * np.exp(1j * self.poses[body, 2]))

    def is_ground(self, body: int) -> bool:
        """Whether a body is fixed."""
        return self.bodies[body].fixed

    def having(self, *kinds: type[OneShape]) -> list[tuple[Symbol, OneShape]]:
        """The symbols whose shapes are of one of these kinds, and the shapes."""
        return [(s, s.shape) for s in self.symbols if isinstance(s.shape, kinds)]

    def partners(self, shape: Shape, kind: type[OneShape]) -> list[OneShape]:
        """The shapes of a kind that the element of a shape has."""
        elements = {symbol.element for symbol in self.symbols if symbol.shape is shape}
        return [one for symbol, one in self.having(kind) if symbol.element in elements]

    @property
    def still(self) -> "MovingPicture":
        """The picture as one of a single instant."""
        poses = self.poses[None]
        return MovingPicture(np.zeros(1), self, poses, {}, {}, poses)

    def without(self, numbers: set[int]) -> "Picture":
        """The picture without the symbols of these numbers."""
        kept = tuple(s for k, s in enumerate(self.symbols) if k not in numbers)
        return replace(self, symbols=kept)


@dataclass(frozen=True)
class MovingPicture:
    """A mechanism in motion.

    Attributes
    ----------
    t
        Instants in s, (k,).
    picture
        The first instant, with the shapes of all joints and forces that act at any time.
    poses
        x, y in m and φ in rad of each body, (k, bodies, 3).
    moving
        (index of a symbol, name of a number of its shape) → its values, (k,), of the numbers that
        vary; those of places are called ``"i.x"``.
    active
        Index of a symbol → spans of time, s, in which it acts, of those that come or go; the end
        of a span is not a part of it.
    motion
        Poses of the whole run, for the lengths of guides and surfaces; of a whole run its `poses`.
    """

    t: FloatArray
    picture: Picture
    poses: FloatArray
    moving: dict[tuple[int, str], FloatArray]
    active: dict[int, tuple[tuple[float, float], ...]]
    motion: FloatArray

    def number(self, symbol: int, name: str) -> FloatArray:
        """A number of a symbol's shape, or of a place of it as ``"i.x"``, at all instants, (k,)."""
        value = attrgetter(name)(self.picture.symbols[symbol].shape)
        return self.moving.get((symbol, name), np.full(len(self.t), value, dtype=float))

    def vector(self, symbol: int, x: str, y: str) -> Points:
        """Two numbers of a symbol's shape as the components of a vector, (k,)."""
        return self.number(symbol, x) + 1j * self.number(symbol, y)

    def place(self, symbol: int, name: str) -> Points:
        """A place of a symbol's shape in the frame of its body, (k,), m."""
        return self.vector(symbol, f"{name}.x", f"{name}.y")

    def moves(self, symbol: int, name: str) -> bool:
        """Whether a place of a symbol's shape moves in its body."""
        return any((symbol, f"{name}.{c}") in self.moving for c in "xy")

    def path(self, symbol: int, name: str) -> Points:
        """A place of a symbol's shape in the global frame, (k,), m."""
        body = getattr(self.picture.symbols[symbol].shape, name).body
        return np.asarray(placed(self.place(symbol, name), self.poses[:, body]))

    @cached_property
    def shifts(self) -> dict[tuple[str, int], Points]:
        """Element and body → how far its place is from where it is at first, (k,), m."""
        found: dict[tuple[str, int], Points] = {}
        for number, symbol in enumerate(self.picture.symbols):
            for one in fields(symbol.shape):
                place = getattr(symbol.shape, one.name)
                if isinstance(place, Place) and self.moves(number, one.name):
                    shift = self.place(number, one.name) - place.point
                    found.setdefault((symbol.element, place.body), shift)
        return found

    def at(self, instant: int) -> Picture:
        """The picture of an instant, with the numbers that its shapes have there."""
        symbols = list(self.picture.symbols)
        for (number, path), values in self.moving.items():
            name, _, component = path.partition(".")
            symbol, value = symbols[number], float(values[instant])
            if component:
                changed = getattr(symbol.shape, name)._replace(**{component: value})
            else:
                changed = value
            symbols[number] = replace(symbol, shape=replace(symbol.shape, **{name: changed}))
        shifts = {key: complex(values[instant]) for key, values in self.shifts.items()}
        poses = self.poses[instant]
        return replace(self.picture, poses=poses, symbols=tuple(symbols), shifts=shifts)

    def frames(self) -> list[Picture]:
        """The picture of each instant, with the symbols that act there."""
        return [
            self.at(k).without({
                number
                for number, spans in self.active.items()
                if not any(first <= t < last for first, last in spans)
            })
            for k, t in enumerate(self.t)
        ]  # fmt: skip
