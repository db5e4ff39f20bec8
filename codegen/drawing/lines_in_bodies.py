"""The strokes that are fixed in bodies: pins, supports, guides, wheels, racks, profiles."""

from typing import Any

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contacts import surfaces
from codegen.drawing.guides import (
    Meshing,
    below,
    circles_of,
    gear_profile,
    guide_of,
    held_places,
    rack_ends,
    rack_profile,
    rack_side,
    rail_ends,
    slot_ends,
)  # fmt: skip
from codegen.drawing.picture import HATCH, PIN, SAME, SLOT, Picture
from codegen.drawing.plane_geometry import (
    ROUND,
    Points,
    box,
    circle,
    contains,
    convex_hull,
    distance_to_edge,
    distinct,
    hatching,
    is_closed,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.shapes import Place
from codegen.drawing.styles import Stroke

SUPPORT = 0.046  # layout: height of the triangle below a pin on the ground, in typical lengths
TRACK = 0.045  # layout: half length of the ground at a fixing
HUB = 1.5  # layout: radius of a wheel's hub, in pins
EYE = 0.6  # layout: radius of the eye of a spring, in pins
SWINGS = 0.1  # layout: a spring on the ground that turns by more, rad, has a support and no wall


def lines_in_bodies(picture: Picture) -> list[Stroke]:
    """The strokes that are fixed in a body, in its frame: all but springs, belts and the like."""
    lines = _Lines(picture)
    for symbol in picture.symbols:
        lines.element = symbol.element
        lines.draw(symbol.shape)
    lines.add_spokes_of_discs()
    for surface in surfaces(picture, fixed=True):
        lines.element = surface.element
        for style, points in surface.lines(picture.size):
            lines.add(style, 0, points)
    return lines.once()


class _Lines:
    """Gathers the strokes of one element after the other."""

    def __init__(self, picture: Picture) -> None:
        self.picture, self.pin = picture, PIN * picture.size
        self.meshing = Meshing(picture)
        self.element = ""
        self.found: list[Stroke] = []

    def once(self) -> list[Stroke]:
        """The strokes; of those at one place the first, and of elements that come and go."""
        passing = {symbol.element for symbol in self.picture.symbols if symbol.spans}
        kept: dict[Any, Stroke] = {}
        for one in self.found:
            at = tuple(np.round(one.points / (SAME * self.picture.size)))
            own = one.element if one.element in passing else ""
            kept.setdefault((one.style, one.body, at, own), one)
        return list(kept.values())

    def add(self, style: str, body: int, points: Points, closed: bool = False) -> None:
        self.found.append(Stroke(style, body, points, closed, self.element))

    def add_circle(self, style: str, place: Place, radius: float, corners: int = ROUND) -> None:
        self.add(style, place.body, circle(place.point, radius, corners), True)

    def add_ground(self, body: int, ends: Points, side: float = -1.0, before: str = "") -> None:
        """A line of the ground, and its hatching on a side."""
        self.add(f"{before}rail", body, ends)
        for stroke in hatching(ends[0], ends[1], side, HATCH * self.picture.size):
            self.add(f"{before}hatch", body, stroke)

    def draw(self, shape: shapes.Shape) -> None:
        """Add the strokes of a shape."""
        picture, pin = self.picture, self.pin
        match shape:
            case shapes.Pin(i, j):
                before = "bracket-" if self._covers(i) or self._covers(j) else ""
                self._support(i, before)
                self._support(j, before)
                self.add_circle("pin", j if picture.is_ground(i.body) else i, pin)
            case shapes.Bearing(i, j, clearance):
                self._support(i)
                self.add_circle("hole", i, 1.25 * (pin + min(clearance, 4 * pin)))
                self.add_circle("pin", j, pin)
            case shapes.Rod(i, j):
                for place in (i, j):
                    self._support(place)
                    self.add_circle("pin", place, pin)
            case shapes.Slide():
                guide = guide_of(picture, shape)
                if picture.is_ground(guide.body):
                    self.add_ground(guide.body, rail_ends(picture, guide))
            case shapes.Slot():
                guide, half_width = guide_of(picture, shape), SLOT * picture.size
                ends = slot_ends(picture, guide)
                self.add("slot", guide.body, rounded_hull(ends, half_width), True)
                if picture.is_ground(guide.body):
                    self.add_ground(guide.body, below(ends, half_width))
                self.add_circle("pin", guide.block, pin)
            case shapes.Fixing(i, j):
                self._fixing(*((j, i) if picture.is_ground(j.body) else (i, j)))
            case shapes.Spring(i, j):
                self._spring_end(i, j)
                self._spring_end(j, i)
            case shapes.Wheel():
                self._wheel(shape)
            case shapes.Rack():
                self._rack(shape)
            case shapes.Profile((body, points)):
                self.add("profile", body, points, is_closed(points))
            case shapes.Mark(at) | shapes.Trace(at):
                for way in (1 + 1j, 1 - 1j):
                    self.add("mark", at.body, at.point + 0.6 * pin * way * np.array([-1, 1]))

    def _covers(self, place: Place) -> bool:
        """Whether a body hides more than half of a support below its pin in all its positions."""
        if self.picture.is_ground(place.body):
            return False
        at, needed = place.point, 0.6 * SUPPORT * self.picture.size
        wheels = [
            circle(center.point, radius)
            for symbol in self.picture.symbols
            for center, radius in circles_of(symbol.shape)
            if center.body == place.body
        ]
        polygons = [*self.picture.bodies[place.body].outlines, *wheels]
        return any(contains(one, at) and distance_to_edge(one, at) > needed for one in polygons)

    def _support(self, place: Place, before: str = "") -> None:
        """The triangle below a pin on the ground, and its hatching."""
        if not self.picture.is_ground(place.body):
            return
        height = SUPPORT * self.picture.size
        base, half = place.point - 1j * height, 0.62 * height
        peak = circle(place.point, 1.5 * self.pin)
        hull = convex_hull(np.append(peak, [base - half, base + half]))
        self.add(f"{before}support", place.body, hull, True)
        self.add_ground(place.body, base + 1.45 * half * np.array([-1, 1]), before=before)

    def _spring_end(self, place: Place, other: Place) -> None:
        """An eye on a body that moves; the ground across the spring, or a support if it swings."""
        if self.picture.is_ground(place.body):
            toward = self.picture.path(other) - self.picture.at(place)
            toward = toward[abs(toward) > SAME * self.picture.size]
            if not len(toward):
                return
            if np.ptp(np.unwrap(np.angle(toward))) <= SWINGS:
                self._wall(place, toward[0])
                return
            self._support(place)
        self.add_circle("pin", place, EYE * self.pin)

    def _wall(self, place: Place, toward: complex) -> None:
        """The ground across a direction."""
        across = 1j * unit(toward) * TRACK * self.picture.size
        self.add_ground(place.body, place.point + across * np.array([1, -1]))

    def _fixing(self, place: Place, other: Place) -> None:
        """A clamp on the ground, a square of weld between bodies that move."""
        picture, at, half = self.picture, place.point, 1.1 * self.pin
        if not picture.is_ground(place.body):
            self.add("fixing", place.body, box(at, 1.0, half, half), True)
            return
        every = (one for symbol in picture.symbols for one in shapes.places(symbol.shape))
        held = [picture.at(one) for one in every if one.body == other.body]
        far = max(held, key=lambda point: abs(point - at))
        is_apart = abs(far - at) > SAME * picture.size
        self._wall(place, (far if is_apart else picture.placed(0j, other.body)) - at)

    def _wheel(self, wheel: shapes.Wheel) -> None:
        center, body, module = wheel.center.point, wheel.center.body, self.meshing.module
        radius = abs(wheel.radius)
        if wheel.toothed:
            phase = self.meshing.phases.get(wheel, 0.0)
            teeth = center + gear_profile(radius, module, phase, wheel.is_ring)
            if wheel.is_ring:
                rim = circle(center, radius + 3 * module, 96)
                ring = np.concatenate([rim, rim[:1], teeth[:1], teeth[::-1]])
                for style, points in (("ring", ring), ("profile", teeth), ("profile", rim)):
                    self.add(style, body, points, True)
            else:
                self.add("gear", body, teeth, True)
            self.add_circle("pitch", wheel.center, radius, 96)
        elif wheel.is_ring:
            self.add_circle("profile", wheel.center, radius, 96)
        if not wheel.is_ring:
            if not self.picture.is_ground(body):
                self._spoke(body, center, radius - (1.5 * module if wheel.toothed else 0.0))
            self.add_circle("hub", wheel.center, min(HUB * self.pin, 0.4 * radius))

    def _spoke(self, body: int, center: complex, radius: float) -> None:
        """The line on a disc by which its turning is seen: towards x' of its body."""
        self.add("spoke", body, center + radius * np.array([0.35, 0.92]))

    def add_spokes_of_discs(self) -> None:
        """Spokes of bodies that are one disc about their pin, so that they are seen to turn."""
        wheels = {wheel.center.body for _, wheel in self.picture.having(shapes.Wheel)}
        for number, body in enumerate(self.picture.bodies):
            held = distinct(held_places(self.picture, number), SAME * self.picture.size)
            if body.is_derived and len(body.outlines) == len(held) == 1 and number not in wheels:
                radii = abs(body.outlines[0] - held[0])
                if len(radii) > ROUND // 2 and np.ptp(radii) < 1e-6 * radii.max():
                    self.element = body.name
                    self._spoke(number, held[0], radii.max())

    def _rack(self, rack: shapes.Rack) -> None:
        body, ends = rack.i.body, rack_ends(self.picture, rack)
        side = rack_side(self.picture, rack)
        if rack.toothed:
            phase = self.meshing.phases.get(rack, 0.0)
            self.add("gear", body, rack_profile(rack, ends, self.meshing.module, side, phase), True)
        elif self.picture.is_ground(body):
            self.add_ground(body, ends, -side)
        else:
            self.add("rack", body, ends)
