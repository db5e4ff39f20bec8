"""The picture of a mechanism as numbers: bodies with outlines, shapes of elements, poses."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from codegen.drawing.shapes import Place, Shape

FloatArray = npt.NDArray[np.float64]
Outline = tuple[tuple[float, float], ...]
"""A closed polygon in the frame of its body, m."""


@dataclass(frozen=True)
class BodyPicture:
    """A body: its name, whether it is the ground, and its outlines, given or derived."""

    name: str
    fixed: bool = False
    outlines: tuple[Outline, ...] = ()
    is_derived: bool = True  # the outlines follow from the joints; the modeller gave none


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
    """

    title: str
    bodies: tuple[BodyPicture, ...]
    poses: FloatArray
    symbols: tuple[Symbol, ...]
    size: float

    def position(self, place: Place) -> tuple[float, float]:
        """A place in the global frame, m."""
        x, y, phi = self.poses[place.body]
        c, s = np.cos(phi), np.sin(phi)
        return float(x + c * place.x - s * place.y), float(y + s * place.x + c * place.y)


def places(shape: Shape) -> Iterator[Place]:
    """The places of a shape, those of a profile included."""
    for field in fields(shape):
        value = getattr(shape, field.name)
        if isinstance(value, Place):
            yield value
        elif isinstance(value, tuple):
            yield from (v for v in value if isinstance(v, Place))
