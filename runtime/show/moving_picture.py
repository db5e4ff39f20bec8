"""The moving picture of a result: bodies, poses and shapes at all of its instants."""

from collections import Counter
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import MovingPicture, Symbol
from codegen.errors import InputError
from runtime.mechanism.companion_modules import Geometry, geometry
from runtime.mechanism.mechanism import Mechanism, sibling_named

if TYPE_CHECKING:
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]


def moving_picture(result: "Result") -> MovingPicture:
    """The moving picture of a result at its instants.

    Raises
    ------
    InputError
        If the result has no instants, or comes from no machine that is known.
    """
    mechanism, title = result._mechanism, result.description.title
    if mechanism is None:
        raise InputError(f"{title}: the machine of this result is not known; load it and run it.")
    if not len(result.t):
        raise InputError(f"{title}: the result has no instants to draw ({result.message})")
    spans = _spans(result, mechanism)
    found = [_of_span(result, known, rows) for known, rows in spans]
    first = found[0].layout.picture(found[0].numbers[0], found[0].curves)
    poses = np.concatenate([one.layout.poses(one.numbers) for one in found])
    symbols, numbers, active = _joined(found, [rows for _, rows in spans], result.t)
    moving = {key: values for key, values in numbers.items() if _varies(values)}
    picture = complete_picture(replace(first, symbols=symbols), poses)
    return MovingPicture(result.t, picture, poses, moving, active, poses)


def moving_picture_at(result: "Result", instants: float | FloatArray) -> MovingPicture:
    """The moving picture at other instants of a result, s, as `moving_picture_of_part` has it.

    Raises
    ------
    InputError
        As `moving_picture`; and if an instant is outside the result.
    """
    return moving_picture_of_part(result, result.at(instants))


def moving_picture_of_part(result: "Result", part: "Result") -> MovingPicture:
    """The moving picture of a part of a result, with outlines, size and motion of the whole.

    A body keeps its outline where a joint that held it has been released, and guides their length.

    Raises
    ------
    InputError
        As `moving_picture`.
    """
    whole, some = moving_picture(result), moving_picture(part)
    picture = replace(some.picture, bodies=whole.picture.bodies, size=whole.picture.size)
    return replace(some, picture=picture, motion=whole.motion)


def _varies(values: FloatArray) -> bool:
    """Whether a number takes several values, or one, and at some instants none."""
    known = values[np.isfinite(values)]
    return len(known) > 0 and (len(known) < len(values) or float(np.ptp(known)) > 0.0)


def _spans(result: "Result", mechanism: Mechanism) -> list[tuple[Mechanism, slice]]:
    """The scenes of the result one after the other, and the rows of their instants."""
    motion, t = result._motion, result.t
    if motion is None or not mechanism.description.watched:
        return [(mechanism, slice(0, len(t)))]
    scenes = [motion.scene(float(instant)) for instant in t]
    bounds = [0, *(k for k in range(1, len(t)) if scenes[k] != scenes[k - 1]), len(t)]
    return [
        (sibling_named(mechanism, scenes[first]) or mechanism, slice(first, last))
        for first, last in pairwise(bounds)
    ]


def _of_span(result: "Result", mechanism: Mechanism, rows: slice) -> Geometry:
    """The geometry while one set of joints acts."""
    samples, here, there = result.samples, mechanism.description, result.description
    places = {name: k for k, name in enumerate(there.coordinates.names)}
    columns = [places[name] for name in here.coordinates.names]
    p = np.array([result.parameters.get(row.name, row.default) for row in here.parameters])
    q, v = samples.q[rows][:, columns], samples.v[rows][:, columns]
    return geometry(mechanism, p, samples.t[rows], q, v)


def _joined(
    found: list[Geometry], spans: list[slice], t: FloatArray
) -> tuple[
    tuple[Symbol, ...],
    dict[tuple[int, str], FloatArray],
    dict[int, tuple[tuple[float, float], ...]],
]:
    """The symbols of all spans, their numbers over time, and when those act that come or go.

    While a symbol does not act, its numbers are those of its first instant.
    """
    symbols: dict[tuple[str, str, int], Symbol] = {}
    numbers: dict[tuple[int, str], FloatArray] = {}
    acts: dict[int, tuple[tuple[float, float], ...]] = {}
    ends = [*t, np.nextafter(t[-1], np.inf)]
    for one, rows in zip(found, spans, strict=True):
        seen = Counter[tuple[str, str]]()
        drawn = one.layout.picture(one.numbers[0], one.curves)
        for k, symbol in enumerate(drawn.symbols):
            pair = symbol.element, symbol.shape.kind
            key = *pair, seen[pair]
            seen[pair] += 1
            symbols.setdefault(key, symbol)
            index = [*symbols].index(key)
            acts[index] = (*acts.get(index, ()), (float(ends[rows.start]), float(ends[rows.stop])))
            for field, slot in one.layout.slots(k).items():
                still = np.full(len(t), one.numbers[0, slot])
                numbers.setdefault((index, field), still)[rows] = one.numbers[:, slot]
    active = {k: spells for k, spells in acts.items() if len(spells) < len(spans)}
    return tuple(symbols.values()), numbers, active
