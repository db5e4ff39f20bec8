"""Arrows of what acts on bodies: applied forces and torques, reactions of joints and drivers."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.arrow_lines import round_arrow, straight_arrow
from codegen.drawing.contact_points import sides_of, touch_of_side
from codegen.drawing.picture import Picture, Symbol
from codegen.drawing.polygons import FloatArray, normal, placed, unit
from codegen.drawing.signs import ARROW, HEAD, ROUND, arrow, turned
from codegen.drawing.sizes_and_held_places import held_places
from codegen.drawing.strokes import Stroke

LARGEST = 0.32  # layout: length of the largest arrow to scale, in typical lengths
WIDE = 1.35  # layout: radius of a torque's arrow over that of a driver's
SMALLEST = 0.45  # layout: radius of the arrow of no torque over that of the largest
VANISHING = 1e-9  # accuracy: of the largest; what is smaller is 0 but for rounding
Reactions = Mapping[str, tuple[float, float, float]]
"""Joint → fx, fy in N in the joint's axes, and the torque in N m, of its second body.

Of a driver that pushes, fx is the force along its direction, N; of a contact, by the name of its
series as ``"plate.force"``, it is the force along the gap.
"""


class Load(NamedTuple):
    """A force (2,) in N in global axes, or a torque in N m, and where it acts, (2,), m."""

    symbol: Symbol
    style: str  # "force", "reaction" or "torque"
    label: str  # what acts, and on which body
    at: FloatArray
    force: FloatArray
    torque: float

    @property
    def size(self) -> float:
        """Of the force in N, or of the torque in N m."""
        return float(np.hypot(*self.force)) if self.style != "torque" else abs(self.torque)

    @property
    def unit(self) -> str:
        """N or N m."""
        return "N m" if self.style == "torque" else "N"


def loads(picture: Picture, reactions: Reactions | None = None) -> list[Load]:
    """All that act, that are finite, and not 0 beside the largest of their unit."""
    farther = _farther_sides(picture)
    found = [
        load
        for number, symbol in enumerate(picture.symbols)
        if number not in farther
        for load in _loads(picture, symbol, (reactions or {}).get(_key(symbol)))
        if np.isfinite(load.size) and np.isfinite(load.at).all()
    ]
    least = {word: VANISHING * largest(found, word) for word in ("N", "N m")}
    return [load for load in found if load.size > least[load.unit]]


def _farther_sides(picture: Picture) -> set[int]:
    """Numbers of the sides that share their force with one of the same body and a smaller gap.

    A rigid stop has one force for both of its limits, of which the nearer exerts it.
    """
    nearest: dict[tuple[str, str, int], tuple[float, int]] = {}
    sides = sides_of(picture)
    for number, symbol, side in sides:
        key = symbol.element, side.force, int(side.body)
        gap = float(side.gap) if np.isfinite(side.gap) else np.inf
        nearest[key] = min(nearest.get(key, (np.inf, number)), (gap, number))
    return {number for number, *_ in sides} - {number for _, number in nearest.values()}


def largest(found: list[Load], unit_: str) -> float:
    """The largest size of a unit; 0 where there is none."""
    return max((load.size for load in found if load.unit == unit_), default=0.0)


def _key(symbol: Symbol) -> str:
    """The name under which reactions have an element."""
    shape = symbol.shape
    return (
        f"{symbol.element}.{shape.force}"
        if isinstance(shape, shapes.ContactSide)
        else symbol.element
    )


def _loads(
    picture: Picture, symbol: Symbol, reaction: tuple[float, float, float] | None
) -> Iterator[Load]:
    shape, element = symbol.shape, symbol.element
    still = np.zeros(2)
    match shape:
        case shapes.Force():
            label = f"{element} on {picture.bodies[shape.at.body].name}"
            force = np.array([shape.fx, shape.fy], dtype=float)
            yield Load(symbol, "force", label, np.array(picture.position(shape.at)), force, 0.0)
        case shapes.Torque():
            label = f"{element} on {picture.bodies[shape.at.body].name}"
            at = np.array(picture.position(shape.at))
            yield Load(symbol, "torque", label, at, still, float(shape.torque))
        case shapes.Reaction() if reaction is not None:
            fx, fy, torque = reaction
            by, on = (picture.bodies[int(body)].name for body in (shape.by, shape.on))
            label = f"{element}, {by} on {on}"
            along = unit(np.array([shape.ux, shape.uy], dtype=float))
            at = np.array([shape.x, shape.y], dtype=float)
            yield Load(symbol, "reaction", label, at, fx * along + fy * normal(along), 0.0)
            yield Load(symbol, "torque", label, at, still, torque)
        case shapes.ContactSide() if reaction is not None:
            label = f"{element} on {picture.bodies[shape.body].name}"
            force = reaction[0] * np.array([shape.gx, shape.gy], dtype=float)
            yield Load(
                symbol, "reaction", label, touch_of_side(picture, shape).point[0], force, 0.0
            )
        case shapes.Drive() if reaction is not None:
            label = f"{element} on {picture.bodies[shape.j.body].name}"
            at = np.array(picture.position(shape.j))
            if shape.turns:
                yield Load(symbol, "torque", label, at, still, reaction[2])
            else:
                turn = picture.poses[shape.i.body, 2] if shape.i is not None else 0.0
                way = turned(np.array([shape.ux, shape.uy], dtype=float), turn)
                yield Load(symbol, "reaction", label, at, reaction[0] * way, 0.0)


def force_strokes(
    picture: Picture, scale: float | None = None, reactions: Reactions | None = None
) -> tuple[Stroke, ...]:
    """Arrows of the forces and torques that act, and of reactions.

    Parameters
    ----------
    scale
        Length of an arrow per force, m/N; None: arrows of one length.
    reactions
        Forces and torques of joints on their second bodies, and of drivers.
    """
    pairs = drawn_loads(picture, scale, reactions)
    return tuple(stroke for _, strokes in pairs for stroke in strokes)


def drawn_loads(
    picture: Picture, scale: float | None = None, reactions: Reactions | None = None
) -> list[tuple[Load, list[Stroke]]]:
    """What acts, each with its arrow: shaft and head."""
    size, acting = picture.size, loads(picture, reactions)
    strongest, found = largest(acting, "N m"), []
    for load in acting:
        if load.style == "torque":
            share = 1.0 if reactions is None else load.size / strongest
            radius = WIDE * ROUND * size * (SMALLEST + (1 - SMALLEST) * share)
            sweep = float(np.copysign(np.radians(200), load.torque))
            start = np.radians(120) if sweep > 0 else np.radians(60)
            lines = round_arrow(load.at, radius, start, sweep, HEAD * size)
        else:
            reach = ARROW * size if scale is None else scale * load.size
            ends = _pressing(picture, load.at, reach * unit(load.force))
            lines = straight_arrow(*ends, HEAD * size)
        found.append((load, arrow(load.style, lines, load.symbol.element)))
    return found


def force_scale(picture: Picture, reactions: Reactions | None = None) -> float | None:
    """Length per force, m/N, at which the largest arrow fits the picture; None without a force."""
    strongest = largest(loads(picture, reactions), "N")
    return LARGEST * picture.size / strongest if strongest > 0 else None


def _pressing(picture: Picture, at: FloatArray, way: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Start and end of an arrow that begins or ends at its point, on the side with more room."""
    points = [placed(held_places(picture, b), pose) for b, pose in enumerate(picture.poses) if b]
    others = np.concatenate([*points, picture.poses[1:, :2], at[None]])
    middle = others.mean(axis=0)
    if np.hypot(*(at - way - middle)) > np.hypot(*(at + way - middle)):
        return at - way, at
    return at, at + way
