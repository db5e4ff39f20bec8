"""Arrows of drivers, and of what acts on bodies: forces, torques, reactions."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contacts import sides_of, touch
from codegen.drawing.held_places import held_places
from codegen.drawing.line_styles import Stroke
from codegen.drawing.picture import MovingPicture, Picture
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    origin,
    round_arrow,
    straight_arrow,
    unit,
)  # fmt: skip
from codegen.drawing.proportions import ARROW, BLOCK, HEAD, ROUND_ARROW

LARGEST = 0.32  # layout: length of the largest arrow to scale, in typical lengths
WIDE = 1.35  # layout: radius of a torque's arrow over that of a driver's
SMALLEST = 0.45  # layout: radius of the arrow of no torque over that of the largest
VANISHING = 1e-9  # accuracy: of the largest; what is smaller is 0 but for rounding
Series = Mapping[str, float | FloatArray]
"""Name of a series of a result, as ``"B.fx"``, → its values, (k,) or one, N or N m."""


class Load(NamedTuple):
    """A force or a torque that acts on a body at k instants.

    Attributes
    ----------
    number, element
        The symbol that it belongs to, by its index, and its element.
    style
        "force", "reaction" or "torque".
    label
        What acts, and on which body.
    field
        The name of the symbol's place where it acts, empty where that is no place of a body.
    at
        Where it acts in the global frame, (k,), m.
    value
        The force in global axes, Fx + iFy, N; or the torque, N m, (k,).
    """

    number: int
    element: str
    style: str
    label: str
    field: str
    at: Points
    value: Points | FloatArray

    @property
    def size(self) -> float:
        """At the first instant, of the force in N, or of the torque in N m."""
        return float(abs(self.value[0]))

    @property
    def unit(self) -> str:
        """N or N m."""
        return "N m" if self.style == "torque" else "N"


def loads(moving: MovingPicture, series: Series, springs: bool = False) -> list[Load]:
    """All that act: applied forces and torques, and reactions as far as `series` has them.

    `springs` says whether springs, dampers and actuators count as well.
    """
    found = _Loads(moving, series, springs)
    for number in range(len(moving.picture.symbols)):
        found.add(number)
    return found.found


class _Loads:
    """Gathers what acts by one symbol after the other."""

    def __init__(self, moving: MovingPicture, series: Series, springs: bool) -> None:
        self.moving, self.series, self.springs = moving, series, springs
        self.found: list[Load] = []

    def _exerted(self, number: int, word: str) -> FloatArray | None:
        """A series of a symbol's element at all instants; None of one that the result lacks."""
        values = self.series.get(f"{self.moving.picture.symbols[number].element}.{word}")
        return None if values is None else np.broadcast_to(values, len(self.moving.t))

    def _add(
        self, number: int, style: str, body: int, field: str, value: Points | FloatArray | None,
        at: Points | None = None, by: str = "",
    ) -> None:  # fmt: skip
        if value is None:
            return
        element = self.moving.picture.symbols[number].element
        name = self.moving.picture.bodies[body].name
        label = f"{element}, {by} on {name}" if by else f"{element} on {name}"
        where = self.moving.path(number, field) if at is None else at
        self.found.append(Load(number, element, style, label, field, where, value))

    def add(self, number: int) -> None:
        """Add what a symbol's element exerts."""
        moving = self.moving
        match moving.picture.symbols[number].shape:
            case shapes.Force() as shape:
                value = moving.vector(number, "fx", "fy")
                self._add(number, "force", shape.at.body, "at", value)
            case shapes.Torque() as shape:
                torque = moving.number(number, "torque")
                self._add(number, "torque", shape.at.body, "at", torque)
            case shapes.Reaction() as shape:
                at, by = moving.vector(number, "x", "y"), moving.picture.bodies[shape.by].name
                x, y = self._exerted(number, "fx"), self._exerted(number, "fy")
                force: Points | None = None
                if x is not None or y is not None:
                    axes = moving.vector(number, "ux", "uy")
                    force = ((0.0 if x is None else x) + 1j * (0.0 if y is None else y)) * axes
                self._add(number, "reaction", shape.on, "", force, at, by)
                self._add(number, "torque", shape.on, "", self._exerted(number, "torque"), at, by)
            case shapes.ContactSide() as shape:
                push = self._exerted(number, shape.force)
                if push is not None:
                    force = push * self._is_nearest(number) * moving.vector(number, "gx", "gy")
                    self._add(
                        number, "reaction", shape.body, "", force, touch(moving, number).point
                    )
            case shapes.Drive() as shape if shape.turns:
                self._add(number, "torque", shape.j.body, "j", self._exerted(number, "torque"))
            case shapes.Drive() as shape:
                push = self._exerted(number, "force")
                turn = moving.poses[:, shape.i.body, 2] if shape.i is not None else 0.0
                if push is not None:
                    force = push * shape.along * np.exp(1j * turn)
                    self._add(number, "reaction", shape.j.body, "j", force)
            case shapes.Spring() as shape if self.springs:
                tension = self._exerted(number, "force")
                away = moving.path(number, "j") - moving.path(number, "i")
                if tension is not None:
                    pull = tension * away / np.where(away == 0, 1.0, abs(away))
                    for field, place, value in (("i", shape.i, pull), ("j", shape.j, -pull)):
                        if not moving.picture.is_ground(place.body):
                            self._add(number, "force", place.body, field, value)
            case shapes.SpiralSpring() as shape if self.springs:
                self._add(number, "torque", shape.i.body, "j", self._exerted(number, "torque"))

    def _is_nearest(self, number: int) -> FloatArray:
        """1 where no other side with this force and body has a smaller gap, else 0, (k,).

        A rigid stop has one force for both of its limits, of which the nearer exerts it.
        """
        sides = {k: (symbol.element, side) for k, symbol, side in sides_of(self.moving.picture)}
        element, own = sides[number]
        gap, nearest = self.moving.number(number, "gap"), np.ones(len(self.moving.t))
        for k, (name, side) in sides.items():
            if k != number and (name, side.force, side.body) == (element, own.force, own.body):
                other = self.moving.number(k, "gap")
                nearest[(other < gap) | ((other == gap) & (k < number))] = 0.0
        return nearest


def acting_loads(picture: Picture, series: Series | None = None) -> list[Load]:
    """What acts at one instant, is finite, and not 0 beside the largest of its unit."""
    finite = [
        load
        for load in loads(picture.still, series or {})
        if np.isfinite(load.value).all() and np.isfinite(load.at).all()
    ]
    least = {word: VANISHING * largest(finite, word) for word in ("N", "N m")}
    return [load for load in finite if load.size > least[load.unit]]


def largest(found: list[Load], unit_: str) -> float:
    """The largest size of a unit; 0 where there is none."""
    return max((load.size for load in found if load.unit == unit_), default=0.0)


def drawn_loads(
    picture: Picture, scale: float | None = None, series: Series | None = None
) -> list[tuple[Load, list[Stroke]]]:
    """What acts at one instant, each with its arrow: shaft and head.

    Parameters
    ----------
    scale
        Length of an arrow per force, m/N; None: arrows of one length.
    series
        Reactions of joints, drivers and contacts.
    """
    size, acting = picture.size, acting_loads(picture, series)
    strongest, found = largest(acting, "N m"), []
    for load in acting:
        at, value = load.at[0], load.value[0]
        if load.style == "torque":
            share = 1.0 if series is None else load.size / strongest
            radius = WIDE * ROUND_ARROW * size * (SMALLEST + (1 - SMALLEST) * share)
            start, sweep = np.radians((120, 200) if value > 0 else (60, -200))
            lines = round_arrow(at, radius, start, sweep, HEAD * size)
        else:
            way = unit(value) * (ARROW * size if scale is None else scale * load.size)
            middle = _middle(picture, at)
            start = at - way if abs(at - way - middle) > abs(at + way - middle) else at
            lines = straight_arrow(start, start + way, HEAD * size)
        found.append((load, arrow(load.style, lines, load.element)))
    return found


def _middle(picture: Picture, at: complex) -> complex:
    """The middle of a point and all bodies: an arrow lies on the side with more room."""
    held = [picture.placed(held_places(picture, n), n) for n in range(1, len(picture.bodies))]
    return complex(np.concatenate([*held, origin(picture.poses[1:]), [at]]).mean())


def force_scale(picture: Picture, series: Series | None = None) -> float | None:
    """Length per force, m/N, at which the largest arrow fits the picture; None without a force."""
    strongest = largest(acting_loads(picture, series), "N")
    return LARGEST * picture.size / strongest if strongest > 0 else None


def arrow(style: str, lines: tuple[Points, Points], element: str) -> list[Stroke]:
    """The shaft and the head of an arrow."""
    shaft, tip = lines
    return [
        Stroke(style, 0, shaft, False, element), Stroke(f"{style} head", 0, tip, True, element)
    ]  # fmt: skip


def driver_strokes(picture: Picture) -> Iterator[Stroke]:
    """Arrows of the drivers, straight or round."""
    size = picture.size
    for symbol, drive in picture.having(shapes.Drive):
        at = picture.at(drive.j)
        if drive.turns:
            start, sweep = np.radians((-50, 230))
            lines = round_arrow(at, ROUND_ARROW * size, start, sweep, HEAD * size)
        else:
            way = drive.along
            if drive.i is not None:
                way = picture.turned(way, drive.i.body)
            start = at + (BLOCK[0] + 0.02) * size * way
            lines = straight_arrow(start, start + ARROW * size * way, HEAD * size)
        yield from arrow("driver", lines, symbol.element)
