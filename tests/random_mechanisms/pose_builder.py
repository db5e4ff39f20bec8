"""Bodies and joints that fit a pose by construction: poses come first, joints follow from them.

All sizes are drawn without units and multiplied by the scales, so that a seed gives the same
mechanism in any units.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin

import numpy as np

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import curve
from tests.random_mechanisms.parts import GROUND, End, Pair


@dataclass(frozen=True)
class Scales:
    """A typical length in m, mass in kg and time in s."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0


def add(a: Pair, b: Pair) -> Pair:
    """a + b."""
    return a[0] + b[0], a[1] + b[1]


def less(a: Pair, b: Pair) -> Pair:
    """a - b."""
    return a[0] - b[0], a[1] - b[1]


def turned(a: Pair, phi: float) -> Pair:
    """The vector turned by an angle."""
    c, s = cos(phi), sin(phi)
    return c * a[0] - s * a[1], s * a[0] + c * a[1]


def polar(size: float, phi: float) -> Pair:
    """The vector of a length and a direction."""
    return size * cos(phi), size * sin(phi)


class PoseBuilder:
    """Collects bodies in their poses, and joints between them."""

    def __init__(self, random: np.random.Generator, scales: Scales) -> None:
        self.random, self.scales = random, scales
        self.bodies: list[parts.Body] = []
        self.joints: list[parts.Joint] = []
        self.effects: list[parts.Effect] = []

    # Numbers

    def between(self, low: float, high: float) -> float:
        """A number, evenly distributed."""
        return float(self.random.uniform(low, high))

    def chance(self, probability: float) -> bool:
        """Whether something happens."""
        return bool(self.random.uniform() < probability)

    def one_of(self, *choices: str) -> str:
        """One of several words."""
        return choices[int(self.random.integers(len(choices)))]

    def length(self, low: float, high: float) -> float:
        """A length, m."""
        return self.between(low, high) * self.scales.length

    def angle(self) -> float:
        """A direction, rad."""
        return self.between(-pi, pi)

    def spread(self, decades: float = 0.7) -> float:
        """A positive number about 1, evenly distributed in its logarithm."""
        return 10.0 ** self.between(-decades, decades)

    def name(self, word: str) -> str:
        """A name that no part has yet."""
        taken = [part.name for part in (*self.bodies, *self.joints, *self.effects)]
        return f"{word}{sum(name.rstrip('0123456789') == word for name in taken)}"

    # Bodies and their points

    def body(self, at: Pair, reach: float, word: str = "b") -> int:
        """A body whose centre is near a global point, in any orientation; `reach` is its size."""
        offset = polar(self.between(0.0, 0.4) * reach, self.angle())
        mass = self.scales.mass * self.spread()
        inertia = mass * (self.between(0.25, 0.6) * reach) ** 2
        pose = (*add(at, offset), self.angle())
        self.bodies.append(parts.Body(self.name(word), mass, inertia, pose))
        return len(self.bodies) - 1

    def particle(self, at: Pair) -> int:
        """A particle at a global point."""
        mass = self.scales.mass * self.spread()
        self.bodies.append(parts.Body(self.name("p"), mass, None, (*at, 0.0)))
        return len(self.bodies) - 1

    def pose(self, body: int) -> tuple[Pair, float]:
        """Centre and orientation of a body."""
        if body == GROUND:
            return (0.0, 0.0), 0.0
        x, y, phi = self.bodies[body].pose
        return (x, y), phi

    def end(self, body: int, at: Pair) -> End:
        """The body's point at a global place."""
        centre, phi = self.pose(body)
        return End(body, turned(less(at, centre), -phi))

    def place(self, end: End) -> Pair:
        """Where a body's point is."""
        centre, phi = self.pose(end.body)
        return add(centre, turned(end.s, phi))

    def is_particle(self, body: int) -> bool:
        """Whether the body has no orientation."""
        return body != GROUND and self.bodies[body].inertia is None

    def somewhere(self, body: int, reach: float) -> Pair:
        """A global point of a body, at most `reach` from its centre; a particle's own place."""
        centre = self.pose(body)[0]
        if self.is_particle(body):
            return centre
        return add(centre, polar(reach * self.between(0.3, 1.0), self.angle()))

    # Joints at global places

    def join(self, joint: parts.Joint) -> str:
        """Add a joint; answers its name."""
        self.joints.append(joint)
        return joint.name

    def pin(self, i: int, j: int, at: Pair) -> str:
        """A revolute joint."""
        return self.join(parts.Revolute(self.name("pin"), self.end(i, at), self.end(j, at)))

    def guide(self, i: int, j: int, at: Pair, direction: float) -> str:
        """A translational joint along a global direction."""
        (_, phi), (_, other) = self.pose(i), self.pose(j)
        ahead = add(at, polar(self.length(-0.5, 0.5), direction))
        ends = self.end(i, at), self.end(j, ahead)
        axis = polar(self.spread(0.3), direction - phi)
        return self.join(parts.Translational(self.name("guide"), *ends, axis, other - phi))

    def link(self, i: int, j: int, here: Pair, there: Pair) -> str:
        """A massless link between two global places."""
        length = hypot(*less(there, here))
        ends = self.end(i, here), self.end(j, there)
        return self.join(parts.Link(self.name("link"), *ends, length))

    def slot(self, i: int, j: int, at: Pair, direction: float) -> str:
        """A pin of body j at a place, in a slot of body i along a global direction."""
        distance = self.length(-0.2, 0.2)
        back = add(polar(self.length(-0.5, 0.5), direction), polar(-distance, direction + pi / 2))
        axis = polar(self.spread(0.3), direction - self.pose(i)[1])
        ends = self.end(i, add(at, back)), self.end(j, at)
        return self.join(parts.Slot(self.name("slot"), *ends, axis, distance))

    def mesh(self, i: End, j: End, radii: Pair) -> str:
        """A gear set of two centres that lie as far apart as the radii ask."""
        dx, dy = less(self.place(j), self.place(i))
        (ri, rj), total = radii, radii[0] + radii[1]
        rolled = (ri * self.pose(i.body)[1] + rj * self.pose(j.body)[1]) / total
        return self.join(parts.Gear(self.name("mesh"), i, j, radii, atan2(dy, dx) - rolled))

    def rack(self, pinion: End, rack: int, radius: float, direction: float) -> str:
        """A rack to the right of the pinion, along a global direction."""
        centre, phi = self.place(pinion), self.pose(rack)[1]
        offset = self.length(-0.5, 0.5)
        foot = add(centre, polar(-radius, direction + pi / 2))
        line = self.end(rack, add(foot, polar(-offset, direction)))
        turn = self.pose(pinion.body)[1] - phi
        axis = polar(self.spread(0.3), direction - phi)
        total = offset + radius * turn
        return self.join(parts.Rack(self.name("rack"), pinion, line, radius, axis, total))

    def contact_of(self, cam: int, profile: parts.Profile, alpha: float) -> tuple[Pair, float]:
        """Global place of the point α of a profile, and the direction of its tangent."""
        c, tangent = curve(profile, alpha)
        centre, phi = self.pose(cam)
        spot = add(centre, turned((float(c[0]), float(c[1])), phi))
        return spot, atan2(float(tangent[1]), float(tangent[0])) + phi
