"""Which gears and racks of a picture mesh, and how their teeth stand so that they do."""

import numpy as np

from codegen.drawing.guides_and_racks import wheels_of
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray, normal, unit
from codegen.drawing.shapes import Place, Rack, Wheel
from codegen.drawing.wheel_lines import common_module, meshing_phase, teeth_of

Key = tuple[int, float, float, float]  # of a wheel: its body, x', y' and radius


class Meshing:
    """The teeth of all gears of a picture.

    Attributes
    ----------
    module
        Pitch over π, m, of all teeth.
    phases
        Wheel → angle of the middle of a tooth in the wheel's body, rad.
    """

    def __init__(self, module: float) -> None:
        self.module = module
        self.phases: dict[Key, float] = {}

    def phase(self, picture: Picture, wheel: Wheel) -> float:
        """The angle of a tooth's middle in the frame of the wheel's body, rad."""
        return self.phases.get(_key(wheel), 0.0)

    def rack_phase(self, picture: Picture, rack: Rack) -> float:
        """The position of a tooth's middle along the rack from its place, m."""
        for wheel in wheels_of(picture, rack):
            origin, center = _at(picture, rack.i), _at(picture, wheel.center)
            along = _turned(np.array([rack.ux, rack.uy]), picture.poses[rack.i.body, 2])
            s = float((center - origin) @ along)
            foot = origin + s * along
            down = foot - center
            contact = float(np.arctan2(down[1], down[0]))
            phase = self.phase(picture, wheel) + picture.poses[wheel.center.body, 2]
            side = 1.0 if float((center - origin) @ normal(along)) >= 0 else -1.0
            pitch = 2 * np.pi / teeth_of(abs(float(wheel.radius)), self.module)
            ahead = (contact - phase) / pitch  # of the contact, in pitches, from a gear's tooth
            # the rim at the contact runs along the rack as the gear turns, by the rack's side
            return float(s + (0.5 - side * ahead) * np.pi * self.module)
        return 0.0


def meshing(picture: Picture) -> Meshing:
    """Teeth of one size for all gears, in phase where two gears or a gear and a rack meet.

    The phase of a gear that meets several others follows from the first; so it does in a train.
    """
    gears = [
        symbol.shape
        for symbol in picture.symbols
        if isinstance(symbol.shape, Wheel) and symbol.shape.toothed
    ]
    if not gears:
        return Meshing(0.02 * picture.size)
    result = Meshing(common_module([abs(float(wheel.radius)) for wheel in gears]))
    pairs = [pair for pair in (_pair(picture, g) for g in gears) if pair is not None]
    while pairs:
        known = next((p for p in pairs if any(_key(w) in result.phases for w in p)), pairs[0])
        pairs.remove(known)
        first, second = known
        if _key(second) in result.phases and _key(first) not in result.phases:
            first, second = second, first
        result.phases.setdefault(_key(first), 0.0)
        if _key(second) not in result.phases:
            result.phases[_key(second)] = _phase(picture, result, first, second)
    return result


def _phase(picture: Picture, known: Meshing, first: Wheel, second: Wheel) -> float:
    """The phase, in its body, of the second gear of a pair of which the first is known."""
    internal = float(first.radius) < 0 or float(second.radius) < 0
    d = _at(picture, second.center) - _at(picture, first.center)
    if internal and abs(float(second.radius)) > abs(float(first.radius)):
        d = -d  # from the ring's centre to the pinion's
    phase = meshing_phase(
        float(np.arctan2(d[1], d[0])),
        abs(float(first.radius)),
        known.phase(picture, first) + picture.poses[first.center.body, 2],
        abs(float(second.radius)),
        known.module,
        "internal" if internal else "external",
    )
    return float(phase - picture.poses[second.center.body, 2])


def _pair(picture: Picture, wheel: Wheel) -> tuple[Wheel, Wheel] | None:
    """The gears of one element, once: where `wheel` is the first of them."""
    partners = [w for w in wheels_of(picture, wheel) if w.toothed]
    if len(partners) == 2 and partners[0] is wheel:
        return partners[0], partners[1]
    return None


def _key(wheel: Wheel) -> Key:
    radius = float(wheel.radius)
    return wheel.center.body, wheel.center.x, wheel.center.y, radius


def _at(picture: Picture, place: Place) -> FloatArray:
    return np.array(picture.position(place))


def _turned(direction: FloatArray, angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    x, y = unit(direction)
    return np.array([c * x - s * y, s * x + c * y])
