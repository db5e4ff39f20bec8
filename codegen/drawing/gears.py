"""Gears and racks: outlines of their teeth, and how these stand so that they mesh."""

from collections.abc import Sequence

import numpy as np

from codegen.drawing.guides import RACK_DEPTH
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import Points, dot
from codegen.drawing.shapes import Rack, Wheel

LEAST_TEETH, MOST_TEETH = 10, 18  # layout: of the smallest gear of a picture
ADDENDUM, DEDENDUM = 0.9, 1.1  # layout: tooth above and below the pitch circle, in modules
CREST, ROOT = 0.22, 0.34  # layout: half widths of a tooth at its crest and root, in pitches
_TOOTH = np.array([-ROOT, -CREST, CREST, ROOT])  # in pitches
_LEVELS = np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM])  # in modules


def common_module(radii: Sequence[float]) -> float:
    """The module m, in m, with which the gears' numbers of teeth 2r/m come nearest to integers."""
    candidates = [2 * min(radii) / teeth for teeth in range(LEAST_TEETH, MOST_TEETH + 1)]

    def error(module: float) -> float:
        teeth = 2 * np.array(radii) / module
        return float(np.max(abs(teeth - np.round(teeth))))

    return min(candidates, key=lambda module: (round(error(module), 3), module))


def teeth_of(radius: float, module: float) -> int:
    """The number of teeth of a gear."""
    return max(4, round(2 * radius / module))


def gear_profile(
    radius: float, module: float, phase: float = 0.0, internal: bool = False
) -> Points:
    """The toothed line (k,) of a gear about the origin, closed and counterclockwise, m.

    The phase, rad, is the angle of the middle of a tooth. Teeth are straight: a drawing, not an
    involute. The teeth of an internal gear point inwards.
    """
    teeth = teeth_of(radius, module)
    levels = radius + (-module if internal else module) * _LEVELS
    angles = phase + 2 * np.pi / teeth * (np.arange(teeth)[:, None] + _TOOTH)
    return np.asarray(np.ravel(levels * np.exp(1j * angles)))


def rack_profile(
    rack: Rack, ends: Points, module: float, side: float, phase: float = 0.0
) -> Points:
    """The closed outline (k,) of a rack in the frame of its body, m.

    Its teeth point to the left (`side` 1) or right (-1), between `ends`, (2,); a tooth is `phase`
    from its place.
    """
    pitch = np.pi * module
    reach = dot(rack.along, ends - rack.i.point)
    first, last = (reach - phase) / pitch + np.array([ROOT, -ROOT])
    s = phase + pitch * (np.arange(np.ceil(first), np.floor(last) + 1)[:, None] + _TOOTH)
    teeth = np.ravel(s + 1j * side * module * _LEVELS)
    a, b = reach[:, None] - 1j * side * module * np.array([RACK_DEPTH, DEDENDUM])
    return np.asarray(rack.i.point + rack.along * np.concatenate([a, teeth, b[::-1]]))


class Meshing:
    """The teeth of all gears of a picture, in phase where two gears or a gear and a rack meet.

    The phase of a gear that meets several others follows from the first; so it does in a train.

    Attributes
    ----------
    module
        Pitch over π, m, of all teeth.
    phases
        Wheel → angle of the middle of a tooth in the wheel's body, rad.
    """

    def __init__(self, picture: Picture) -> None:
        self.picture = picture
        gears = [wheel for _, wheel in picture.having(Wheel) if wheel.toothed]
        radii = [abs(wheel.radius) for wheel in gears]
        self.module = common_module(radii) if gears else 0.02 * picture.size
        self.phases: dict[Wheel, float] = {}
        partners = [[w for w in picture.partners(gear, Wheel) if w.toothed] for gear in gears]
        pairs = [
            pair for gear, pair in zip(gears, partners, strict=True)
            if len(pair) == 2 and pair[0] is gear
        ]  # fmt: skip
        while pairs:
            is_met = [any(wheel in self.phases for wheel in pair) for pair in pairs]
            first, second = pairs.pop(is_met.index(True) if any(is_met) else 0)
            if second in self.phases and first not in self.phases:
                first, second = second, first
            self.phases.setdefault(first, 0.0)
            if second not in self.phases:
                self.phases[second] = self._meeting_phase(first, second)

    def phase(self, wheel: Wheel) -> float:
        """The angle of a tooth's middle in the frame of the wheel's body, rad."""
        return self.phases.get(wheel, 0.0)

    def _pitches_ahead(self, wheel: Wheel, heading: float) -> float:
        """How far a direction, rad in global axes, is ahead of a tooth of a wheel, in pitches."""
        angle = heading - self.phase(wheel) - self.picture.poses[wheel.center.body, 2]
        return float(angle * teeth_of(abs(wheel.radius), self.module) / (2 * np.pi))

    def _meeting_phase(self, first: Wheel, second: Wheel) -> float:
        """The phase of the second of two gears, whose teeth meet the gaps of the first."""
        to_second = self.picture.at(second.center) - self.picture.at(first.center)
        heading = float(np.angle(to_second))
        if min(first.radius, second.radius) < 0:
            if abs(second.radius) > abs(first.radius):
                heading = float(np.angle(-to_second))  # from the ring's centre to the pinion's
            meeting, there = heading, 0.5 + self._pitches_ahead(first, heading)
        else:
            meeting, there = heading + np.pi, 0.5 - self._pitches_ahead(first, heading)
        teeth = teeth_of(abs(second.radius), self.module)
        turn = self.picture.poses[second.center.body, 2]
        return float(meeting - there * 2 * np.pi / teeth - turn)

    def rack_phase(self, rack: Rack) -> float:
        """The position of a tooth's middle along the rack from its place, m."""
        for wheel in self.picture.partners(rack, Wheel):
            along = self.picture.turned(rack.along, rack.i.body)
            away = self.picture.at(wheel.center) - self.picture.at(rack.i)
            s, height = dot(along, away), dot(1j * along, away)
            contact = float(np.angle(-height * 1j * along))
            # the rim at the contact runs along the rack as the gear turns, by the rack's side
            ahead = (1.0 if height >= 0 else -1.0) * self._pitches_ahead(wheel, contact)
            return float(s + (0.5 - ahead) * np.pi * self.module)
        return 0.0
