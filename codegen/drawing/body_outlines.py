"""Outlines of bodies for which the modeller gave none, from the places where elements hold them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codegen.drawing.contacts import contact_line, heights, is_far
from codegen.drawing.guides import (
    block_half_length,
    circles_of,
    guide_ends,
    guide_of,
    held_places,
    parallel_rack,
    rack_ends,
    rack_side,
    slot_ends,
)  # fmt: skip
from codegen.drawing.picture import (
    BAR,
    BLOCK,
    BOB,
    CHEEK,
    PARTICLE,
    SAME,
    BodyPicture,
    Picture,
    SpacePicture,
)
from codegen.drawing.plane_geometry import (
    Points,
    box,
    circle,
    distinct,
    dot,
    is_closed,
    origin,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.shapes import ContactSide, Profile, Rack, Slide, Slot, Wheel, places
from codegen.drawing.solids import reach


def complete_picture(picture: Picture) -> Picture:
    """The picture with its size, and in the plane with outlines of all bodies."""
    first = picture.first
    if isinstance(first, SpacePicture):
        return replace(picture, size=reach(first))
    sized = replace(first, size=typical_length(first))
    return replace(picture, size=sized.size, bodies=derived_outlines(sized))


def typical_length(picture: Picture) -> float:
    """The diagonal of the box about all places of the shapes and the bodies' origins, m.

    Wheels count with their circles. The length is 1 m where everything is at one place. Origins
    count only where no element holds the body, or one: a centre of mass may be far away. Surfaces
    of contacts count where a body comes near.
    """
    points = [picture.at(place) for symbol in picture.symbols for place in places(symbol.shape)]
    for _, profile in picture.having(Profile):
        points += [*picture.placed(profile.curve.points, profile.curve.body)]
    for symbol in picture.symbols:
        for place, radius in circles_of(symbol.shape):
            points += [picture.at(place) + way * radius for way in (-1 - 1j, 1 + 1j)]
    for number, body in enumerate(picture.bodies):
        if number > 0 and len(distinct(held_places(picture, number), 0.0)) < 2:
            points.append(origin(picture.poses[number]))
        if not body.is_derived:
            points += [z for line in body.outlines for z in picture.placed(line, number)]
    length = _diagonal(points)
    for _, side in picture.having(ContactSide):
        line = contact_line(picture, side)
        near = length == 0.0 or not is_far(heights(picture, side), length)
        if side.is_grounded and near:
            points += [line.center, line.center - line.gap * line.normal]
    return _diagonal(points) or 1.0


def _diagonal(points: list[complex]) -> float:
    """The diagonal of the box about the points that are finite, m; 0 without one."""
    known = np.array(points)[np.isfinite(points)]
    return float(np.hypot(np.ptp(known.real), np.ptp(known.imag))) if len(known) else 0.0


def derived_outlines(picture: Picture) -> tuple[BodyPicture, ...]:
    """The bodies of a picture, each without outlines given those that follow from its elements.

    - Two places: a bar with round ends. Three and more: a rounded plate round their convex hull.
    - One place and the centre of mass apart: a bar to a disc about the centre of mass.
    - A block along each guide on which the body slides, a bar with room for each of its slots.
    - A disc for each wheel without teeth (those with teeth, rings and profiles are strokes of
      their own: `lines_in_bodies`).
    - A body that nothing holds: a small disc.
    """
    return tuple(
        body
        if body.outlines or body.fixed or number == 0
        else replace(body, outlines=_outlines(picture, number), is_derived=True)
        for number, body in enumerate(picture.bodies)
    )


def _outlines(picture: Picture, body: int) -> tuple[Points, ...]:
    """The polygons of all shapes of a body, and those that connect them."""
    held, half_width = held_places(picture, body), BAR * picture.size
    polygons: list[Points] = []
    seats: list[complex] = []  # where a block is, or a wheel's hub: other places join to them
    bars: list[Points] = []  # ends of guides and racks, which other places join in one point
    for symbol in picture.symbols:
        match symbol.shape:
            case Slide() as shape:
                guide = guide_of(picture, shape)
                if guide.body == body:
                    bars.append(guide_ends(picture, guide))
                    polygons.append(rounded_hull(bars[-1], half_width))
                if guide.block.body == body and parallel_rack(picture, guide) is None:
                    reach, across = block_half_length(picture, guide), BLOCK[1] * picture.size
                    seats.append(guide.block.point)
                    polygons.append(box(seats[-1], guide.along_in_block, reach, across))
            case Slot() as shape if shape.i.body == body:
                bars.append(slot_ends(picture, guide_of(picture, shape)))
                polygons.append(rounded_hull(bars[-1], CHEEK * picture.size))
            case Slot() as shape if shape.j.body == body:
                seats.append(shape.j.point)
            case Rack() as shape if shape.i.body == body:
                below = -rack_side(picture, shape) * half_width * 1j * shape.along
                bars.append(rack_ends(picture, shape) + below)
                if not shape.toothed:
                    first, last = bars[-1]
                    along, reach = unit(last - first), abs(last - first) / 2
                    polygons.append(box((first + last) / 2, along, reach, half_width))
            case Profile((on, curve)) if on == body:
                seats.append(0j)
                polygons += _profile(curve, held, picture.size)
            case shape:
                for place, radius in circles_of(shape):
                    if place.body == body:
                        seats.append(place.point)
                        if not isinstance(shape, Wheel) or not shape.toothed | shape.internal:
                            polygons.append(circle(place.point, radius, 64))
    middle = complex(np.mean([*seats, *held])) if len(seats) + len(held) else 0j
    seats += [_nearest(bar, middle) for bar in bars]
    polygons += _links(np.array([*held, *seats], dtype=complex), len(seats) > 0, picture.size)
    return tuple(polygons)


def _profile(curve: Points, held: Points, size: float) -> Iterator[Points]:
    """The inside of a closed profile; an open one is a line alone, with bars to its middle."""
    if is_closed(curve):
        yield curve
        return
    middle = curve[len(curve) // 2]
    for place in held if len(held) else [0j]:
        if abs(place - middle) > SAME * size:
            yield rounded_hull(np.array([place, middle]), 0.75 * BAR * size)


def _links(held: Points, has_seats: bool, size: float) -> Iterator[Points]:
    """Bars and plates between the places of a body, and the disc of a pendulum."""
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
