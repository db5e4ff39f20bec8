"""The layout of a picture: which number of a kernel stands where in its bodies and shapes.

A generated module has the layout as plain tuples, and the kernel `picture` writes the numbers, so
that a picture of any instant and any parameters needs neither the model nor SymPy.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.drawing import shapes
from codegen.drawing.picture import BodyPicture, Picture, Symbol
from codegen.drawing.plane_geometry import FloatArray
from codegen.drawing.shapes import Place, Shape

SAMPLES = 181  # layout: of a closed curve, ends included
KINDS: dict[str, type[Shape]] = {
    cls.kind: cls for cls in vars(shapes).values()
    if isinstance(cls, type) and issubclass(cls, Shape) and cls.kind
}  # fmt: skip
# A digest of the kinds and their fields: a module with another one was written by another version.
VERSION = hashlib.sha256(
    repr([(kind, [f.name for f in fields(cls)]) for kind, cls in KINDS.items()]).encode()
).hexdigest()[:16]


class BodyLayout(NamedTuple):
    """A body: slots of x, y and φ, or of x, y, cos φ and sin φ; outlines as pairs of slots."""

    name: str
    fixed: bool
    pose: tuple[int, ...]
    outlines: tuple[tuple[tuple[int, int], ...], ...]


class ShapeLayout(NamedTuple):
    """A shape: its fields in their order, each a pair (what it is, where to find it).

    ("at", (body, slot, slot)) is a place, ("number", slot) a number, ("body", number) a body,
    ("bodies", numbers) several, ("curve", (body, number)) a curve, ("word", value) a plain value.
    """

    element: str
    kind: str
    role: str
    shape: str
    fields: tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Layout:
    """The layout of a scene's picture."""

    title: str
    bodies: tuple[BodyLayout, ...]
    shapes: tuple[ShapeLayout, ...]
    curves: int  # how many

    @property
    def size(self) -> int:
        """How many slots there are."""
        poses = (slot for body in self.bodies for slot in body.pose)
        corners = (s for body in self.bodies for line in body.outlines for xy in line for s in xy)
        numbers = (slot for k in range(len(self.shapes)) for slot in self.slots(k).values())
        return 1 + max((*poses, *corners, *numbers), default=-1)

    def poses(self, numbers: FloatArray) -> FloatArray:
        """x, y and φ of each body at k instants, (k, bodies, 3); `numbers` are (k, slots)."""
        poses = np.empty((len(numbers), len(self.bodies), 3))
        for row, body in enumerate(self.bodies):
            x, y, *turn = body.pose
            poses[:, row, 0], poses[:, row, 1] = numbers[:, x], numbers[:, y]
            if len(turn) == 1:
                poses[:, row, 2] = numbers[:, turn[0]]
            else:
                c, s = (numbers[:, slot] for slot in turn)
                poses[:, row, 2] = np.unwrap(np.arctan2(s, c))
        return poses

    def picture(self, numbers: FloatArray, curves: Sequence[FloatArray]) -> Picture:
        """The picture of one instant, without outlines that follow from joints, of size 1.

        Parameters
        ----------
        numbers
            What the kernel `picture` writes, (slots,).
        curves
            Of each curve the points, m, (samples, 2).
        """
        symbols = tuple(
            Symbol(row.element, row.kind, row.role, _shape(row, numbers, curves))
            for row in self.shapes
        )
        bodies = tuple(
            BodyPicture(
                body.name, body.fixed,
                tuple(tuple(complex(numbers[x], numbers[y]) for x, y in outline)
                      for outline in body.outlines),
                not body.outlines,
            )
            for body in self.bodies
        )  # fmt: skip
        poses = self.poses(numbers[None, :])[0]
        return Picture(self.title, bodies, poses, symbols, 1.0)

    def slots(self, row: int) -> dict[str, int]:
        """The slots of a shape's numbers, and of its places as ``"i.x"``."""
        found = {}
        one = self.shapes[row]
        for field, (what, where) in zip(_fields(one), one.fields, strict=True):
            if what == "number":
                found[field] = where
            elif what == "at":
                found |= {f"{field}.x": where[1], f"{field}.y": where[2]}
        return found


def _fields(row: ShapeLayout) -> list[str]:
    return [field.name for field in fields(KINDS[row.shape])]


def _shape(row: ShapeLayout, numbers: FloatArray, curves: Sequence[FloatArray]) -> Shape:
    values: list[Any] = []
    for what, where in row.fields:
        match what:
            case "at":
                body, x, y = where
                values.append(Place(body, float(numbers[x]), float(numbers[y])))
            case "number":
                values.append(float(numbers[where]))
            case "curve":
                body, number = where
                points: npt.NDArray[np.float64] = curves[number]
                values.append(tuple(Place(body, float(x), float(y)) for x, y in points))
            case _:
                values.append(where)
    return KINDS[row.shape](*values)
