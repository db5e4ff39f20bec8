"""Outlines of bodies for which the modeller gave none, from the places where elements hold them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codegen.drawing.guides_and_racks import (
    block_half_length,
    guide_ends,
    guide_of,
    parallel_rack,
    rack_ends,
    rack_side,
    slot_ends,
)  # fmt: skip
from codegen.drawing.picture import BodyPicture, Outline, Picture
from codegen.drawing.polygons import (
    FloatArray,
    box,
    circle,
    distinct,
    normal,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.shapes import Profile, Rack, Slide, Slot, Wheel
from codegen.drawing.sizes_and_held_places import (
    BAR,
    BLOCK,
    BOB,
    CHEEK,
    PARTICLE,
    SAME,
    circles_of,
    held_places,
    typical_length,
)  # fmt: skip


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
      their own: `strokes.rigid_strokes`).
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
        else replace(body, outlines=_outlines(picture, number, motion), is_derived=True)
        for number, body in enumerate(picture.bodies)
    )


def _outlines(picture: Picture, body: int, motion: FloatArray | None) -> tuple[Outline, ...]:
    size = picture.size
    polygons: list[FloatArray] = []
    seats: list[FloatArray] = []  # where a block is, or a wheel's hub: other places join to them
    bars: list[FloatArray] = []  # ends of guides and racks, which other places join in one point
    for symbol in picture.symbols:
        shape = symbol.shape
        if isinstance(shape, Slide):
            guide = guide_of(picture, shape)
            if guide.body == body:
                bars.append(guide_ends(picture, guide, motion))
                polygons.append(rounded_hull(bars[-1], BAR * size))
            if guide.block.body == body:
                center = np.array(guide.block[1:])
                if parallel_rack(picture, guide) is None:
                    reach = block_half_length(picture, guide)
                    polygons.append(box(center, guide.along_in_block, reach, BLOCK[1] * size))
                    seats.append(center)
        elif isinstance(shape, Slot) and shape.i.body == body:
            guide = guide_of(picture, shape)
            bars.append(slot_ends(picture, guide, motion))
            polygons.append(rounded_hull(bars[-1], CHEEK * size))
        elif isinstance(shape, Slot) and shape.j.body == body:
            seats.append(np.array(shape.j[1:]))
        elif isinstance(shape, Rack) and shape.i.body == body:
            below = -rack_side(picture, shape) * normal(unit(np.array([shape.ux, shape.uy], float)))
            bars.append(rack_ends(picture, shape, motion) + BAR * size * below)
            if not shape.toothed:
                polygons.append(box(*_middle_and_halves(bars[-1]), BAR * size))
        else:
            for place, radius in circles_of(shape):
                if place.body == body:
                    seats.append(np.array(place[1:]))
                    if not (isinstance(shape, Wheel) and (shape.toothed or shape.internal)):
                        polygons.append(circle(seats[-1], abs(radius), 64))
            if isinstance(shape, Profile) and any(p.body == body for p in shape.curve):
                polygons += [*_profile_body(shape, held_places(picture, body), size)]
                seats.append(np.zeros(2))
    others = np.concatenate([np.array(seats).reshape(-1, 2), held_places(picture, body)])
    seats += [_nearest(bar, others.mean(axis=0) if len(others) else np.zeros(2)) for bar in bars]
    polygons += [*_links(picture, body, np.array(seats).reshape(-1, 2))]
    return tuple(tuple((float(x), float(y)) for x, y in polygon) for polygon in polygons)


def _middle_and_halves(ends: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Centre, direction and half length of a straight line (2, 2)."""
    reach = ends[1] - ends[0]
    return ends.mean(axis=0), unit(reach), float(np.hypot(*reach)) / 2


def _nearest(bar: FloatArray, point: FloatArray) -> FloatArray:
    """The place on a straight line (2, 2) that is nearest to a point."""
    reach = bar[1] - bar[0]
    square = float(reach @ reach)
    share = float((point - bar[0]) @ reach) / square if square > 0 else 0.0
    return np.asarray(bar[0] + np.clip(share, 0.0, 1.0) * reach)


def _links(picture: Picture, body: int, seats: FloatArray) -> Iterator[FloatArray]:
    """Bars and plates between the places of a body, and the disc of a pendulum."""
    size = picture.size
    held = np.concatenate([held_places(picture, body), seats])
    held = distinct(held[np.all(np.isfinite(held), axis=1)], SAME * size)
    apart = len(held) == 1 and np.hypot(*held[0]) > SAME * size
    if len(held) == 0:
        yield circle(np.zeros(2), PARTICLE * size)
    elif apart and not len(seats):
        yield rounded_hull(np.array([held[0], [0.0, 0.0]]), 0.75 * BAR * size)
        yield circle(np.zeros(2), BOB * size)
    elif len(held) == 1 and not len(seats):
        yield circle(held[0], BOB * size)
    elif len(held) > 1:
        spread = float(np.max(np.hypot(*(held - held.mean(axis=0)).T)))
        if len(held) > 2 and np.hypot(*held.mean(axis=0)) < spread:
            held = np.concatenate([held, np.zeros((1, 2))])
        yield rounded_hull(held, BAR * size)


def _profile_body(shape: Profile, held: FloatArray, size: float) -> Iterator[FloatArray]:
    """The inside of a closed profile; an open one is a line alone, with bars to its middle."""
    curve = np.array([p[1:] for p in shape.curve], dtype=float)
    if is_closed(curve):
        yield curve
        return
    middle = curve[len(curve) // 2]
    for place in held if len(held) else np.zeros((1, 2)):
        if np.hypot(*(place - middle)) > SAME * size:
            yield rounded_hull(np.array([place, middle]), 0.75 * BAR * size)


def is_closed(curve: FloatArray) -> bool:
    """Whether the ends of a sampled curve (k, 2) are no farther apart than its samples are."""
    steps = np.hypot(*np.diff(curve, axis=0).T)
    return len(curve) > 3 and float(np.hypot(*(curve[-1] - curve[0]))) <= 2 * float(np.max(steps))
