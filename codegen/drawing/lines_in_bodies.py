"""The strokes that are fixed in bodies: pins, supports, guides, wheels, racks, profiles."""

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.body_outlines import is_closed
from codegen.drawing.contacts import surfaces
from codegen.drawing.gears import Meshing, gear_profile, rack_profile
from codegen.drawing.guides import (
    guide_ends,
    guide_of,
    rack_ends,
    rack_side,
    rail_offset,
    slot_ends,
)  # fmt: skip
from codegen.drawing.held_places import circles_of, held_places
from codegen.drawing.line_styles import Stroke
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import (
    ROUND,
    FloatArray,
    Points,
    box,
    circle,
    contains,
    convex_hull,
    distance_to_edge,
    distinct,
    hatching,
    placed,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.proportions import HATCH, PIN, SAME, SLOT
from codegen.drawing.shapes import Place, places

SUPPORT = 0.046  # layout: height of the triangle below a pin on the ground, in typical lengths
TRACK = 0.045  # layout: half length of the ground at a fixing
HUB = 1.5  # layout: radius of a wheel's hub, in pins
EYE = 0.6  # layout: radius of the eye of a spring, in pins
SWINGS = 0.1  # layout: a spring on the ground that turns by more, rad, has a support and no wall


def lines_in_bodies(picture: Picture, motion: FloatArray | None = None) -> list[Stroke]:
    """The strokes that are fixed in a body, in its frame: all but springs, belts and the like.

    Parameters
    ----------
    motion
        Poses of a motion, shape (instants, bodies, 3), for the lengths of guides, slots and racks.
    """
    lines = _Lines(picture, motion)
    for symbol in picture.symbols:
        lines.element = symbol.element
        lines.draw(symbol.shape)
    lines.add_spokes_of_discs()
    for surface in surfaces(picture, fixed=True, motion=motion):
        lines.element = surface.element
        for style, points in surface.lines(picture.size):
            lines.add(style, 0, points)
    return lines.once()


def rail(ends: Points, offset: float) -> Points:
    """A line (2,) of the ground below another: to the right, or down where it is upright."""
    along = unit(ends[1] - ends[0])
    if along.real < -1e-9 or (abs(along.real) <= 1e-9 and along.imag > 0):
        ends, along = ends[::-1], -along
    return ends + offset * 1j * along


class _Lines:
    """Gathers the strokes of one element after the other."""

    def __init__(self, picture: Picture, motion: FloatArray | None) -> None:
        self.picture, self.motion = picture, motion
        self.poses = picture.poses[None] if motion is None else motion
        self.pin_radius = PIN * picture.size
        self.meshing = Meshing(picture)
        self.element = ""
        self.found: list[Stroke] = []

    def once(self) -> list[Stroke]:
        """The strokes without those that an earlier element has drawn at the same place."""
        seen, kept = set(), []
        for stroke in self.found:
            at = complex(np.round(stroke.points.mean() / (SAME * self.picture.size)))
            key = stroke.style, stroke.body, len(stroke.points), at
            if key not in seen or stroke.style in ("hatch", "rail", "rack"):
                kept.append(stroke)
            seen.add(key)
        return kept

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
        picture = self.picture
        match shape:
            case shapes.Pin():
                self._pin(shape)
            case shapes.Bearing():
                self._support(shape.i)
                hole = self.pin_radius + min(shape.clearance, 4 * self.pin_radius)
                self.add_circle("hole", shape.i, 1.25 * hole)
                self.add_circle("pin", shape.j, self.pin_radius)
            case shapes.Rod():
                for place in (shape.i, shape.j):
                    self._support(place)
                    self.add_circle("pin", place, self.pin_radius)
            case shapes.Slide():
                guide = guide_of(picture, shape)
                if picture.is_ground(guide.body):
                    below = rail_offset(picture, guide, self.meshing.module)
                    self.add_ground(
                        guide.body, rail(guide_ends(picture, guide, self.motion), -below)
                    )
            case shapes.Slot():
                self._slot(shape)
            case shapes.Fixing():
                self._fixing(shape)
            case shapes.Spring():
                self._spring_end(shape.i, shape.j)
                self._spring_end(shape.j, shape.i)
            case shapes.Wheel():
                self._wheel(shape)
            case shapes.Rack():
                self._rack(shape)
            case shapes.Profile():
                points = np.array([place.point for place in shape.curve])
                self.add("profile", shape.curve[0].body, points, is_closed(points))
            case shapes.Mark() | shapes.Trace():
                for way in (1 + 1j, 1 - 1j):
                    arm = 0.6 * self.pin_radius * way * np.array([-1, 1])
                    self.add("mark", shape.at.body, shape.at.point + arm)

    def _pin(self, pin: shapes.Pin) -> None:
        ends = pin.i, pin.j
        before = "bracket-" if any(map(self._covers, ends)) else ""
        for place in ends:
            self._support(place, before)
        moving = [place for place in ends if not self.picture.is_ground(place.body)]
        self.add_circle("pin", (moving or ends)[0], self.pin_radius)

    def _covers(self, place: Place) -> bool:
        """Whether a body hides more than half of a support below its pin in all its positions."""
        if self.picture.is_ground(place.body):
            return False
        at, needed = place.point, 0.6 * SUPPORT * self.picture.size
        polygons = self.picture.bodies[place.body].polygons + [
            circle(center.point, radius)
            for symbol in self.picture.symbols
            for center, radius in circles_of(symbol.shape)
            if center.body == place.body
        ]
        return any(contains(one, at) and distance_to_edge(one, at) > needed for one in polygons)

    def _support(self, place: Place, before: str = "") -> None:
        """The triangle below a pin on the ground, and its hatching."""
        if not self.picture.is_ground(place.body):
            return
        height = SUPPORT * self.picture.size
        base, half = place.point - 1j * height, 0.62 * height
        peak = rounded_hull(np.array([place.point]), 1.5 * self.pin_radius)
        hull = convex_hull(np.append(peak, [base - half, base + half]))
        self.add(f"{before}support", place.body, hull, True)
        self.add_ground(place.body, base + 1.45 * half * np.array([-1, 1]), before=before)

    def _slot(self, slot: shapes.Slot) -> None:
        guide = guide_of(self.picture, slot)
        ends, half_width = slot_ends(self.picture, guide, self.motion), SLOT * self.picture.size
        self.add("slot", guide.body, rounded_hull(ends, half_width), True)
        if self.picture.is_ground(guide.body):
            self.add_ground(guide.body, rail(ends, -half_width))
        self.add_circle("pin", guide.block, self.pin_radius)

    def _spring_end(self, place: Place, other: Place) -> None:
        """An eye on a body that moves; the ground across the spring, or a support if it swings."""
        picture, eye = self.picture, EYE * self.pin_radius
        if not picture.is_ground(place.body):
            self.add_circle("pin", place, eye)
            return
        toward = placed(other.point, self.poses[:, other.body]) - picture.at(place)
        toward = toward[abs(toward) > SAME * picture.size]
        if not len(toward):
            return
        if np.ptp(np.unwrap(np.angle(toward))) > SWINGS:
            self._support(place)
            self.add_circle("pin", place, eye)
        else:
            self._wall(place, toward[0])

    def _wall(self, place: Place, toward: complex) -> None:
        """The ground across a direction."""
        across = 1j * unit(toward) * TRACK * self.picture.size
        self.add_ground(place.body, place.point + across * np.array([1, -1]))

    def _fixing(self, shape: shapes.Fixing) -> None:
        """A clamp on the ground, a square of weld between bodies that move."""
        picture, ground, moving = self.picture, shape.i, shape.j
        if picture.is_ground(moving.body):
            ground, moving = moving, ground
        at, half = ground.point, 1.1 * self.pin_radius
        if not picture.is_ground(ground.body):
            self.add("fixing", ground.body, box(at, 1.0, half, half), True)
            return
        held = [
            picture.at(place)
            for symbol in picture.symbols
            for place in places(symbol.shape)
            if place.body == moving.body
        ]
        far = max(held, key=lambda p: abs(p - at), default=at)
        is_apart = abs(far - at) > SAME * picture.size
        self._wall(ground, far - at if is_apart else picture.placed(0j, moving.body) - at)

    def _wheel(self, wheel: shapes.Wheel) -> None:
        center, body, module = wheel.center.point, wheel.center.body, self.meshing.module
        radius, is_internal = abs(wheel.radius), wheel.internal or wheel.radius < 0
        if wheel.toothed:
            phase = self.meshing.phase(wheel)
            teeth = center + gear_profile(radius, module, phase, is_internal)
            if is_internal:
                rim = circle(center, radius + 3 * module, 96)
                ring = np.concatenate([rim, rim[:1], teeth[:1], teeth[::-1]])
                self.add("ring", body, ring, True)
                self.add("profile", body, teeth, True)
                self.add("profile", body, rim, True)
            else:
                self.add("gear", body, teeth, True)
            self.add_circle("pitch", wheel.center, radius, 96)
        elif is_internal:
            self.add_circle("profile", wheel.center, radius, 96)
        if not is_internal:
            if not self.picture.is_ground(body):
                self._spoke(body, center, radius - (1.5 * module if wheel.toothed else 0.0))
            self.add_circle("hub", wheel.center, min(HUB * self.pin_radius, 0.4 * radius))

    def _spoke(self, body: int, center: complex, radius: float) -> None:
        """The line on a disc by which its turning is seen: towards x' of its body."""
        self.add("spoke", body, center + radius * np.array([0.35, 0.92]))

    def add_spokes_of_discs(self) -> None:
        """Spokes of bodies that are one disc about their pin, so that they are seen to turn."""
        wheels = {wheel.center.body for _, wheel in self.picture.having(shapes.Wheel)}
        for number, body in enumerate(self.picture.bodies):
            held = distinct(held_places(self.picture, number), SAME * self.picture.size)
            if body.is_derived and len(body.outlines) == len(held) == 1 and number not in wheels:
                radii = abs(body.polygons[0] - held[0])
                if len(radii) > ROUND // 2 and np.ptp(radii) < 1e-6 * radii.max():
                    self.element = body.name
                    self._spoke(number, held[0], radii.max())

    def _rack(self, rack: shapes.Rack) -> None:
        body, ends = rack.i.body, rack_ends(self.picture, rack, self.motion)
        side = rack_side(self.picture, rack)
        if rack.toothed:
            phase = self.meshing.rack_phase(rack)
            self.add("gear", body, rack_profile(rack, ends, self.meshing.module, side, phase), True)
        elif self.picture.is_ground(body):
            self.add_ground(body, ends, -side)
        else:
            self.add("rack", body, ends)
