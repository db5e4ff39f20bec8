"""Places that move within their bodies, and the strokes that go with them."""

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray
from codegen.drawing.shapes import Place, Shape
from codegen.drawing.strokes import Stroke

Shifts = Mapping[tuple[str, int], FloatArray]
"""Element and body → how far its place is from where it was at first, (2,), in the body's frame."""


def with_numbers(shape: Shape, numbers: Mapping[str, float]) -> Shape:
    """A shape with other numbers: of its own field ``"fx"``, of a place of it ``"i.x"``."""
    changed: dict[str, Place | float] = {}
    for path, value in numbers.items():
        field, _, component = path.partition(".")
        if component:
            place = changed.get(field, getattr(shape, field))
            changed[field] = place._replace(**{component: value})
        else:
            changed[field] = value
    return replace(shape, **changed)


def place_shifts(first: Picture, now: Picture) -> Shifts:
    """What has moved between two pictures of the same symbols."""
    found: dict[tuple[str, int], FloatArray] = {}
    for before, after in zip(first.symbols, now.symbols, strict=True):
        if before.shape is after.shape:
            continue
        for field in fields(before.shape):
            old, new = getattr(before.shape, field.name), getattr(after.shape, field.name)
            if isinstance(old, Place) and old != new:
                shift = np.array([new.x - old.x, new.y - old.y])
                found.setdefault((before.element, old.body), shift)
    return found


def shifted(strokes: tuple[Stroke, ...], shifts: Shifts) -> tuple[Stroke, ...]:
    """The strokes where the places of their elements are now."""
    if not shifts:
        return strokes
    return tuple(
        replace(s, points=s.points + shifts[s.element, s.body])
        if (s.element, s.body) in shifts
        else s
        for s in strokes
    )
