"""The picture of a mechanism as the page has it: bodies, poses, symbols, and what moves in them."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from codegen.drawing.picture import FloatArray, Picture
from codegen.drawing.shapes import Place
from runtime.show.animation.payload import Arrays

if TYPE_CHECKING:
    from runtime.results.reconnection import Reconnection


class Pictures(Protocol):
    """A picture at k instants."""

    @property
    def picture(self) -> Picture:
        """That of the first instant."""

    @property
    def t(self) -> FloatArray:
        """Instants in s, (k,)."""

    @property
    def poses(self) -> FloatArray:
        """x, y in m and φ in rad of each body, (k, bodies, 3)."""

    @property
    def moving(self) -> Mapping[tuple[int, str], FloatArray]:
        """Numbers of symbols that vary: (number of the symbol, ``"fx"`` or ``"i.x"``) → (k,)."""


def scenery(
    pictures: Pictures, changes: "Sequence[Reconnection]", arrays: Arrays
) -> dict[str, Any]:
    """Bodies, symbols and size, numbers over time in `arrays`."""
    picture = pictures.picture
    poses = pictures.poses
    moving: list[list[dict[str, Any]]] = [[] for _ in picture.symbols]
    for (number, path), values in pictures.moving.items():
        if np.isfinite(values).any():
            moving[number].append({"path": path.split("."), "values": arrays.add(values)})
    intervals = connected(changes)
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
                **({"acts": intervals[symbol.element]} if symbol.element in intervals else {}),
            }
            for number, symbol in enumerate(picture.symbols)
        ],
    }


def connected(changes: "Sequence[Reconnection]") -> dict[str, list[list[float | None]]]:
    """Joint → the intervals in which it acts, s; None where there is no bound."""
    intervals: dict[str, list[list[float | None]]] = {}
    for change in changes:
        of_joint = intervals.setdefault(change.joint, [])
        if change.action == "engage":
            of_joint.append([change.time, None])
        elif of_joint:
            of_joint[-1][1] = change.time
        else:
            of_joint.append([None, change.time])
    return intervals


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
