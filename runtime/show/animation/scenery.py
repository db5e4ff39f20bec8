"""The picture of a mechanism as the page has it: bodies, poses, symbols, and what moves in them."""

from dataclasses import fields
from typing import Any

import numpy as np

from codegen.drawing.rigid_strokes import rigid_strokes
from codegen.drawing.shapes import Place
from runtime.show.animation.payload import Arrays
from runtime.show.pictures import Pictures

_POSES = 300  # layout: of a motion, from which guides and racks get their lengths


def scenery(pictures: Pictures, arrays: Arrays) -> dict[str, Any]:
    """Bodies, symbols and size, numbers over time in `arrays`."""
    picture = pictures.picture
    poses, active = pictures.poses, pictures.active
    moving: list[list[dict[str, Any]]] = [[] for _ in picture.symbols]
    for (number, path), values in pictures.moving.items():
        if np.isfinite(values).any():
            moving[number].append({"path": path.split("."), "values": arrays.add(values)})
    return {
        "size": float(picture.size),
        "bodies": [
            {
                "name": body.name,
                "fixed": body.fixed,
                "derived": body.is_derived,
                "outlines": [[[float(x), float(y)] for x, y in line] for line in body.outlines],
                "pose": [arrays.add(poses[:, row, column]) for column in range(3)],
            }
            for row, body in enumerate(picture.bodies)
        ],
        "symbols": [
            {
                "element": symbol.element,
                "type": symbol.kind,
                "role": symbol.role,
                "shape": _shape(symbol.shape),
                "moving": moving[number],
                **({"acts": active[number]} if number in active else {}),
            }
            for number, symbol in enumerate(picture.symbols)
        ],
        "strokes": [
            {
                "style": stroke.style,
                "body": stroke.body,
                "element": stroke.element,
                "closed": stroke.closed,
                "points": arrays.add(stroke.points),
            }
            for stroke in rigid_strokes(picture, poses[:: 1 + len(poses) // _POSES])
        ],
    }


def _shape(shape: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": shape.kind}
    for field in fields(shape):
        found[field.name] = _plain(getattr(shape, field.name))
    return found


def _plain(value: Any) -> Any:
    """A value of a shape in JSON: a place is an object of body, x and y."""
    if isinstance(value, Place):
        return {"body": int(value.body), "x": _finite(value.x), "y": _finite(value.y)}
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    if isinstance(value, bool | str) or value is None:
        return value
    return int(value) if isinstance(value, int | np.integer) else _finite(value)


def _finite(value: Any) -> float:
    number = float(value)
    return number if np.isfinite(number) else 0.0
