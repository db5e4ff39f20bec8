"""Outlines of bodies for which the modeller gave none, from the places where elements hold them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codegen.drawing.guides import (
    Guide,
    block_half_length,
    guide_ends,
    guide_of,
    parallel_rack,
    rack_ends,
    rack_side,
    slot_ends,
)  # fmt: skip
from codegen.drawing.held_places import circles_of, held_places, typical_length
from codegen.drawing.picture import BodyPicture, Picture
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    box,
    circle,
    distinct,
    dot,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.proportions import BAR, BLOCK, BOB, CHEEK, PARTICLE, SAME
from codegen.drawing.shapes import Profile, Rack, Slide, Slot, Wheel


def complete_picture(picture: Picture, motion: FloatArray | None = None) -> Picture:
    """The picture with its size, and with outlines of all bodies; `motion` as for these."""
    sized = replace(picture, size=typical_length(picture, motion))
    return replace(sized, bodies=derived_outlines(sized, motion))


def derived_outlines(picture: Picture, motion: FloatArray | None = None) -> tuple[BodyPicture, ...]:
    """The bodies of a picture, each without outlines given those that follow from its elements.

    - Two places: a bar with round ends. Three and more: a rounded plate round their convex hull.
    - One place and the centre of mass apart: a bar to a disc about the centre of mass.
    - A block along each guide on which the body slides, a bar with room for each of its slots.
    - A disc for each wheel without teeth (those with teeth, rings and profiles are strokes of
      their own: `lines_in_bodies`).
    - A body that nothing holds: a small disc.

    Parameters
    ----------
    motion
        Poses of a motion, shape (instants, bodies, 3), m and rad: guides and slots are as long as
        it needs. Without one they are as long as the picture's own pose needs.
    """
    return tuple(
        body
        if body.outlines or body.fixed or number == 0
        else replace(body, outlines=_Outlines(picture, number, motion).found(), is_derived=True)
        for number, body in enumerate(picture.bodies)
    )


class _Outlines:
    """Gathers the polygons of a body.

    Attributes
    ----------
    seats
        Where a block is, or a wheel's hub: other places join to them.
    bars
        Ends of guides and racks, which other places join in one point.
    """

    def __init__(self, picture: Picture, body: int, motion: FloatArray | None) -> None:
        self.picture, self.body, self.motion = picture, body, motion
        self.held = held_places(picture, body)
        self.polygons: list[Points] = []
        self.seats: list[complex] = []
        self.bars: list[Points] = []

    def found(self) -> tuple[tuple[complex, ...], ...]:
        """The polygons of all shapes of the body, and those that connect them."""
        for symbol in self.picture.symbols:
            match symbol.shape:
                case Slide() as shape:
                    self._slide(guide_of(self.picture, shape))
                case Slot() as shape if shape.i.body == self.body:
                    ends = slot_ends(self.picture, guide_of(self.picture, shape), self.motion)
                    self._bar(ends, CHEEK)
                case Slot() as shape if shape.j.body == self.body:
                    self.seats.append(shape.j.point)
                case Rack() as shape if shape.i.body == self.body:
                    self._rack(shape)
                case Profile() as shape if any(p.body == self.body for p in shape.curve):
                    self._profile(np.array([place.point for place in shape.curve]))
                case shape:
                    for place, radius in circles_of(shape):
                        if place.body == self.body:
                            self.seats.append(place.point)
                            if not isinstance(shape, Wheel) or not shape.toothed | shape.internal:
                                self.polygons.append(circle(place.point, radius, 64))
        others = np.array([*self.seats, *self.held])
        middle = others.mean() if len(others) else 0j
        self.seats += [_nearest(bar, middle) for bar in self.bars]
        self.polygons += self._links()
        return tuple(tuple(polygon.tolist()) for polygon in self.polygons)

    def _bar(self, ends: Points, half_width: float) -> None:
        self.bars.append(ends)
        self.polygons.append(rounded_hull(ends, half_width * self.picture.size))

    def _slide(self, guide: Guide) -> None:
        if guide.body == self.body:
            self._bar(guide_ends(self.picture, guide, self.motion), BAR)
        if guide.block.body == self.body and parallel_rack(self.picture, guide) is None:
            center, reach = guide.block.point, block_half_length(self.picture, guide)
            half_width = BLOCK[1] * self.picture.size
            self.polygons.append(box(center, guide.along_in_block, reach, half_width))
            self.seats.append(center)

    def _rack(self, rack: Rack) -> None:
        half_width = BAR * self.picture.size
        below = -rack_side(self.picture, rack) * half_width * 1j * rack.along
        ends = rack_ends(self.picture, rack, self.motion) + below
        self.bars.append(ends)
        if not rack.toothed:
            reach = ends[1] - ends[0]
            self.polygons.append(box(ends.mean(), unit(reach), abs(reach) / 2, half_width))

    def _profile(self, curve: Points) -> None:
        """The inside of a closed profile; an open one is a line alone, with bars to its middle."""
        self.seats.append(0j)
        if is_closed(curve):
            self.polygons.append(curve)
            return
        middle, size = curve[len(curve) // 2], self.picture.size
        for place in self.held if len(self.held) else [0j]:
            if abs(place - middle) > SAME * size:
                self.polygons.append(rounded_hull(np.array([place, middle]), 0.75 * BAR * size))

    def _links(self) -> Iterator[Points]:
        """Bars and plates between the places of the body, and the disc of a pendulum."""
        size, has_seats = self.picture.size, len(self.seats) > 0
        held = np.array([*self.held, *self.seats], dtype=complex)
        held = distinct(held[np.isfinite(held)], SAME * size)
        if len(held) == 0:
            yield circle(0j, PARTICLE * size)
        elif len(held) > 1:
            middle = held.mean()
            if len(held) > 2 and abs(middle) < abs(held - middle).max():
                held = np.append(held, 0j)
            yield rounded_hull(held, BAR * size)
        elif not has_seats and abs(held[0]) > SAME * size:
            yield rounded_hull(np.append(held, 0j), 0.75 * BAR * size)
            yield circle(0j, BOB * size)
        elif not has_seats:
            yield circle(held[0], BOB * size)


def _nearest(bar: Points, point: complex) -> complex:
    """The place on a straight line (2,) that is nearest to a point."""
    reach = bar[1] - bar[0]
    square = abs(reach) ** 2
    share = dot(reach, point - bar[0]) / square if square > 0 else 0.0
    return complex(bar[0] + np.clip(share, 0.0, 1.0) * reach)


def is_closed(curve: Points) -> bool:
    """Whether the ends of a sampled curve (k,) are no farther apart than its samples are."""
    return len(curve) > 3 and abs(curve[-1] - curve[0]) <= 2 * abs(np.diff(curve)).max()
