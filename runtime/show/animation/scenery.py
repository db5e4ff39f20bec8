"""The picture of a mechanism as the page has it: bodies, poses, symbols, and what moves in them."""

from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.contact_points import sides_of
from codegen.drawing.moving_strokes import SPRING
from codegen.drawing.rigid_strokes import rigid_strokes
from codegen.drawing.shapes import Belt, ContactSide, Place, SpiralSpring, Spring
from codegen.drawing.spring_lines import spring_parts, torsion_parts
from codegen.drawing.stroke_styles import depth, layer_name
from codegen.drawing.wheel_lines import belt_parts
from runtime.show.animation.contacts import contact_numbers, moving_surfaces
from runtime.show.animation.payload import Arrays
from runtime.show.pictures import Pictures

FloatArray = npt.NDArray[np.float64]

_POSES = 300  # layout: of a motion, from which guides and racks get their lengths


def scenery(pictures: Pictures, arrays: Arrays) -> dict[str, Any]:
    """Bodies, symbols and size, numbers over time in `arrays`."""
    picture = pictures.picture
    poses, active = pictures.poses, pictures.active
    moving: list[list[dict[str, Any]]] = [[] for _ in picture.symbols]
    sides = {number: side for number, _, side in sides_of(picture)}
    numbers = {key: v for key, v in pictures.moving.items() if key[0] not in sides}
    for number, side in sides.items():
        for name, values in contact_numbers(pictures, number, side).items():
            numbers[number, name] = values
    for (number, path), values in numbers.items():
        if np.isfinite(values).any():
            moving[number].append({"path": path.split("."), "values": arrays.add(values)})
    places = _moving_places(pictures)
    kept = [
        number
        for number, one in enumerate(picture.symbols)
        if (np.isfinite(numbers[number, "x"]).any() if number in sides else _is_finite(one.shape))
    ]
    return {
        "size": float(picture.size),
        "spring": SPRING,
        "bodies": [
            {
                "name": body.name,
                "fixed": body.fixed,
                "derived": body.is_derived,
                "outlines": [[[float(x), float(y)] for x, y in line] for line in body.outlines],
                "pose": [*map(arrays.add, poses[:, row, :2].T), *_angle(poses[:, row, 2], arrays)],
            }
            for row, body in enumerate(picture.bodies)
        ],
        "symbols": [
            {
                "element": picture.symbols[number].element,
                "type": picture.symbols[number].kind,
                "role": picture.symbols[number].role,
                "shape": _side(sides[number])
                if number in sides
                else _shape(picture.symbols[number].shape),
                **_lines(picture.symbols[number].shape),
                "moving": moving[number],
                **({"acts": active[number]} if number in active else {}),
            }
            for number in kept
        ],
        "strokes": [
            {
                "style": stroke.style,
                "layer": layer_name(stroke.style),
                "depth": depth(stroke.style),
                "body": stroke.body,
                "element": stroke.element,
                "closed": stroke.closed,
                "points": arrays.add(stroke.points),
                **_shift(places.get((stroke.element, stroke.body)), arrays),
            }
            for stroke in rigid_strokes(picture, poses[:: 1 + len(poses) // _POSES])
            if np.isfinite(stroke.points).all()
        ]
        + [
            {
                "style": stroke.style,
                "layer": layer_name(stroke.style),
                "depth": depth(stroke.style),
                "body": 0,
                "element": stroke.element,
                "closed": False,
                "points": arrays.add(stroke.points),
                "shift": frame,
            }
            for surface in moving_surfaces(pictures)
            for frame in ([arrays.add(values) for values in surface.poses.T],)
            for stroke in surface.strokes
        ],
    }


def _side(side: ContactSide) -> dict[str, Any]:
    """A side of a contact, whose place and slopes move."""
    kept = {"kind": side.kind, "body": int(side.body), "force": side.force}
    return {**kept, **dict.fromkeys(("x", "y", "gx", "gy", "gap"), 0.0)}


def _angle(values: FloatArray, arrays: Arrays) -> tuple[int, ...]:
    """Arrays of an angle: within half a turn of 0, and, unless all are 0, the number of turns.

    An angle of many turns has too few digits as float32.
    """
    turns = np.where(np.isfinite(values), np.round(values / (2 * np.pi)), 0.0)
    wrapped = arrays.add(values - 2 * np.pi * turns)
    return (wrapped, arrays.add(turns)) if turns.any() else (wrapped,)


def _moving_places(pictures: Pictures) -> dict[tuple[str, int], tuple[FloatArray, FloatArray]]:
    """Element and body → how far its place is from where it is at first, x' and y', (k,), m."""
    found: dict[tuple[str, int], tuple[FloatArray, FloatArray]] = {}
    for number, symbol in enumerate(pictures.picture.symbols):
        for field in fields(symbol.shape):
            place = getattr(symbol.shape, field.name)
            if not isinstance(place, Place):
                continue
            still = np.zeros(len(pictures.t))
            dx, dy = (
                pictures.moving[key] - start if key in pictures.moving else still
                for key, start in (
                    ((number, f"{field.name}.x"), place.x), ((number, f"{field.name}.y"), place.y),
                )
            )  # fmt: skip
            if dx is not still or dy is not still:
                found.setdefault((symbol.element, place.body), (dx, dy))
    return found


def _shift(by: tuple[FloatArray, FloatArray] | None, arrays: Arrays) -> dict[str, list[int]]:
    return {} if by is None else {"shift": [arrays.add(values) for values in by]}


def _lines(shape: Any) -> dict[str, Any]:
    """The lines of springs, torsion springs and belts, which the page places at each instant."""
    match shape:
        case Spring():
            parts = spring_parts(shape.elastic, shape.damper, shape.actuator)
        case SpiralSpring():
            parts = torsion_parts(shape.elastic, shape.damper, shape.actuator)
        case Belt():
            parts = [("belt", belt_parts(shape.crossed))]
        case _:
            return {}
    return {"lines": [[style, points.tolist()] for style, points in parts]}


def _is_finite(shape: Any) -> bool:
    """Whether all places and numbers of a shape are finite: the page leaves others out."""
    values = [getattr(shape, field.name) for field in fields(shape)]
    parts = [p for value in values for p in (value if isinstance(value, tuple) else (value,))]
    numbers = [n for p in parts for n in (p if isinstance(p, tuple) else (p,))]
    return all(np.isfinite(n) for n in numbers if isinstance(n, float))


def _shape(shape: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": shape.kind}
    for field in fields(shape):
        found[field.name] = _plain(getattr(shape, field.name))
    return found


def _plain(value: Any) -> Any:
    """A value of a shape in JSON: a place is an object of body, x and y."""
    if isinstance(value, Place):
        return {"body": int(value.body), "x": float(value.x), "y": float(value.y)}
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    if isinstance(value, bool | str) or value is None:
        return value
    return int(value) if isinstance(value, int | np.integer) else float(value)
