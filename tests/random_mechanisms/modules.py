"""Loops and branches that continue a mechanism at one of its bodies: four-bars, cams, gears, ...

Each takes the builder and a host, a body that is pinned to the ground at a place, and answers the
hosts that it adds. A crank is short against the loops that hang on it, so that most of them turn
through; others swing, and some lock.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import acos, atan2, hypot, pi

from tests.random_mechanisms import parts
from tests.random_mechanisms.parts import GROUND, Pair
from tests.random_mechanisms.pose_builder import PoseBuilder, add, less, polar, turned


@dataclass(frozen=True)
class Host:
    """A body, the place of its pin on the ground, and the place for another pin, an arm apart.

    A host without a pin of the ground, such as a slider, has `pivot` None.
    """

    body: int
    pivot: Pair | None
    pin: Pair

    @property
    def arm(self) -> float:
        """Distance of the two pins, m."""
        assert self.pivot is not None
        return hypot(*less(self.pin, self.pivot))


def crank(build: PoseBuilder, near: Pair = (0.0, 0.0)) -> Host:
    """A body that turns about a pin of the ground."""
    arm = build.length(0.3, 0.6)
    pivot = add(near, polar(build.length(0.0, 0.3), build.angle()))
    pin = add(pivot, polar(arm, build.angle()))
    body = build.body(pivot, arm, "crank")
    build.pin(GROUND, body, pivot)
    return Host(body, pivot, pin)


def _meet(a: Pair, ra: float, b: Pair, rb: float, side: int) -> Pair | None:
    """A point at given distances of a and b, to the left (+1) or right of the way between."""
    dx, dy = less(b, a)
    d = hypot(dx, dy)
    ratio = (d * d + ra * ra - rb * rb) / (2 * d * ra)
    if not -0.95 < ratio < 0.95:
        return None
    return add(a, polar(ra, atan2(dy, dx) + side * acos(ratio)))


def _middle(here: Pair, there: Pair) -> Pair:
    return 0.5 * (here[0] + there[0]), 0.5 * (here[1] + there[1])


def _rod(build: PoseBuilder, i: int, here: Pair, j: int, there: Pair) -> None:
    """What connects two pins: a body, or a massless link."""
    if build.chance(0.35):
        build.link(i, j, here, there)
        return
    rod = build.body(_middle(here, there), 0.6 * hypot(*less(there, here)), "rod")
    build.pin(i, rod, here)
    build.pin(rod, j, there)


def four_bar(build: PoseBuilder, host: Host) -> Host | None:
    """A rod and a rocker; three of four turn through."""
    if host.pivot is None or host.arm == 0.0:
        return None
    turns = build.chance(0.75)
    low, high = (2.2, 3.2) if turns else (1.0, 2.5)
    rod, rocker, base = (host.arm * build.between(low, high) for _ in range(3))
    if turns:  # Grashof: the crank and the longest are together shorter than the others
        longest = max(rod, rocker, base)
        if host.arm + longest > 0.97 * (rod + rocker + base - longest):
            rod = rocker = base
    pivot = add(host.pivot, polar(base, build.angle()))
    side = 1 if build.chance(0.5) else -1
    pin = _meet(host.pin, rod, pivot, rocker, side)
    if pin is None:
        return None
    body = build.body(pivot, 0.6 * rocker, "rocker")
    build.pin(GROUND, body, pivot)
    _rod(build, host.body, host.pin, body, pin)
    further = add(pivot, turned(less(pin, pivot), build.between(-0.6, 0.6)))
    shorter = build.between(0.3, 0.8)
    dx, dy = less(further, pivot)
    return Host(body, pivot, add(pivot, (shorter * dx, shorter * dy)))


def slider(build: PoseBuilder, host: Host) -> Host | None:
    """A rod and a slider on the ground."""
    if host.pivot is None:
        return None
    direction, rod = build.angle(), host.arm * build.between(2.2, 4.0)
    height = host.arm * build.between(-0.5, 0.5)
    line = add(host.pivot, polar(height, direction + pi / 2))
    dx, dy = turned(less(host.pin, line), -direction)
    if abs(dy) > 0.8 * rod:
        return None
    ahead = dx + (rod * rod - dy * dy) ** 0.5
    pin = add(line, polar(ahead, direction))
    body = build.body(pin, 0.5 * host.arm, "slider")
    build.guide(GROUND, body, line, direction)
    _rod(build, host.body, host.pin, body, pin)
    return Host(body, None, pin)


def swinging_block(build: PoseBuilder, host: Host) -> Host | None:
    """The host's pin slides in a slot of a lever that is pinned to the ground."""
    if host.pivot is None:
        return None
    base = host.arm * build.between(1.6, 3.0)
    pivot = add(host.pivot, polar(base, build.angle()))
    lever = build.body(pivot, 0.8 * base, "lever")
    build.pin(GROUND, lever, pivot)
    dx, dy = less(host.pin, pivot)
    build.slot(lever, host.body, host.pin, atan2(dy, dx) + build.between(-0.3, 0.3))
    return Host(lever, pivot, add(pivot, polar(0.5 * base, build.angle())))


def gear_pair(build: PoseBuilder, host: Host) -> Host | None:
    """A gear on the ground that meshes with the host, from outside or inside."""
    if host.pivot is None:
        return None
    ratio, size = build.between(0.4, 2.5), build.length(0.15, 0.4)
    radii = (size, ratio * size)
    if build.chance(0.25):  # the larger one is internal
        big, small = max(radii) * 1.6, min(radii)
        radii = (-big, small) if build.chance(0.5) else (small, -big)
    centre = add(host.pivot, polar(abs(radii[0] + radii[1]), build.angle()))
    gear = build.body(centre, 0.8 * abs(radii[1]), "gear")
    build.pin(GROUND, gear, centre)
    build.mesh(build.end(host.body, host.pivot), build.end(gear, centre), radii)
    return Host(gear, centre, add(centre, polar(0.8 * abs(radii[1]), build.angle())))


def planet(build: PoseBuilder, host: Host) -> Host | None:
    """A planet on the host, which carries it round a sun of the ground."""
    if host.pivot is None or host.arm == 0.0:
        return None
    share = build.between(0.3, 0.7)
    radii = (share * host.arm, (1 - share) * host.arm)
    if build.chance(0.3):  # a ring instead of the sun
        radii = (-1.5 * host.arm, 0.5 * host.arm)
    wheel = build.body(host.pin, 0.8 * radii[1], "planet")
    build.pin(host.body, wheel, host.pin)
    build.mesh(build.end(GROUND, host.pivot), build.end(wheel, host.pin), radii)
    return None


def rack(build: PoseBuilder, host: Host) -> Host | None:
    """A rack that slides on the ground and meshes with the host."""
    if host.pivot is None:
        return None
    direction, radius = build.angle(), build.length(0.1, 0.4)
    foot = add(host.pivot, polar(-radius, direction + pi / 2))
    body = build.body(foot, 2 * radius, "bar")
    build.rack(build.end(host.body, host.pivot), body, radius, direction)
    # The mesh keeps the distance from the pinion, so that a guide would keep it a second time.
    angle = build.pose(body)[1]
    build.join(parts.Absolute(build.name("upright"), build.end(body, foot), "phi", angle))
    return Host(body, None, foot)


def _profile(build: PoseBuilder, convex: bool) -> parts.Profile:
    """An eccentric circle, or a base circle with a few harmonics, which `convex` keeps small."""
    size = build.length(0.2, 0.5)
    if build.chance(0.35):
        centre = polar(build.between(0.1, 0.5) * size, build.angle())
        return parts.Profile(size, (), centre)
    harmonics = []
    left = 0.5
    for _ in range(int(build.random.integers(1, 3))):
        k = int(build.random.integers(1, 4 if convex else 5))
        a = build.between(0.2, 0.9) * left / (k * k + 1)
        left -= a * (k * k + 1)
        harmonics.append((k, a, build.angle()))
    return parts.Profile(size, tuple(harmonics))


def _follower(build: PoseBuilder, spot: Pair, direction: float, reach: float) -> Host:
    """A body near a contact, guided along a direction or pivoted beside it."""
    if build.chance(0.6):
        body = build.body(spot, reach, "follower")
        build.guide(GROUND, body, spot, direction + build.between(-0.3, 0.3))
        return Host(body, None, spot)
    side = direction + (pi / 2 if build.chance(0.5) else -pi / 2)
    pivot = add(spot, polar(reach * build.between(2.5, 4.0), side))
    body = build.body(pivot, reach, "lever")
    build.pin(GROUND, body, pivot)
    return Host(body, pivot, add(pivot, polar(reach, build.angle())))


def flat_cam(build: PoseBuilder, host: Host) -> Host | None:
    """A follower with a flat face on a profile of the host."""
    if host.pivot is None:
        return None
    profile, alpha = _profile(build, convex=True), build.angle()
    spot, tangent = build.contact_of(host.body, profile, alpha)
    outward = tangent - pi / 2
    follower = _follower(
        build, add(spot, polar(0.3 * profile.size, outward)), outward, profile.size
    )
    phi = build.pose(follower.body)[1]
    face = build.end(follower.body, add(spot, polar(build.length(-0.2, 0.2), tangent)))
    axis = polar(build.spread(0.3), outward - pi / 2 - phi)
    name = build.name("lift")
    build.join(parts.FlatFollower(name, host.body, profile, face, axis, alpha))
    return follower


def roller_cam(build: PoseBuilder, host: Host) -> Host | None:
    """A follower with a roller on a profile of the host."""
    if host.pivot is None:
        return None
    profile, alpha = _profile(build, convex=True), build.angle()
    spot, tangent = build.contact_of(host.body, profile, alpha)
    outward, radius = tangent - pi / 2, profile.size * build.between(0.15, 0.4)
    centre = add(spot, polar(radius, outward))
    follower = _follower(build, add(centre, polar(radius, outward)), outward, profile.size)
    phi = build.pose(follower.body)[1]
    roller = parts.Profile(radius, (), build.end(follower.body, centre).s)
    beta = outward + pi - phi
    name = build.name("lift")
    build.join(parts.RollerFollower(name, host.body, profile, follower.body, roller, alpha, beta))
    return follower


def point_cam(build: PoseBuilder, host: Host) -> Host | None:
    """A follower whose point moves along a profile of the host, which need not be convex."""
    if host.pivot is None:
        return None
    profile, alpha = _profile(build, convex=False), build.angle()
    spot, tangent = build.contact_of(host.body, profile, alpha)
    follower = _follower(build, spot, tangent - pi / 2, profile.size)
    point = build.end(follower.body, spot)
    build.join(parts.PointFollower(build.name("lift"), host.body, profile, point, alpha))
    return follower


def pendulum(build: PoseBuilder, host: Host) -> Host | None:
    """A body that hangs on the host by a pin."""
    centre = add(host.pin, polar(build.length(0.3, 0.8), build.angle()))
    body = build.body(centre, 0.4 * build.scales.length, "arm")
    build.pin(host.body, body, host.pin)
    return Host(body, None, build.somewhere(body, 0.5 * build.scales.length))


def carriage(build: PoseBuilder, host: Host) -> Host | None:
    """A body that slides along the host."""
    at = add(host.pin, polar(build.length(0.0, 0.3), build.angle()))
    body = build.body(at, build.length(0.2, 0.4), "carriage")
    build.guide(host.body, body, host.pin, build.angle())
    return Host(body, None, build.somewhere(body, 0.4 * build.scales.length))


def bob(build: PoseBuilder, host: Host) -> Host | None:
    """A particle on a massless link."""
    at = add(host.pin, polar(build.length(0.4, 1.0), build.angle()))
    body = build.particle(at)
    build.link(host.body, body, host.pin, at)
    return Host(body, None, at)


def attached(build: PoseBuilder, host: Host) -> Host | None:
    """A body that is welded to the host."""
    at = add(host.pin, polar(build.length(0.1, 0.3), build.angle()))
    body = build.body(at, build.length(0.2, 0.4), "part")
    angle = build.pose(body)[1] - build.pose(host.body)[1]
    ends = build.end(host.body, host.pin), build.end(body, host.pin)
    build.join(parts.Weld(build.name("seam"), *ends, angle))
    return Host(body, None, build.somewhere(body, 0.4 * build.scales.length))


def five_bar(build: PoseBuilder, host: Host) -> Host | None:
    """Another crank, and two rods that meet: a loop with a freedom more."""
    if host.pivot is None:
        return None
    span = build.length(1.5, 2.5)
    other = crank(build, add(host.pivot, polar(span, build.angle())))
    apart = hypot(*less(other.pin, host.pin))
    rods = (apart * build.between(0.65, 1.1), apart * build.between(0.65, 1.1))
    pin = _meet(host.pin, rods[0], other.pin, rods[1], 1 if build.chance(0.5) else -1)
    if pin is None:
        return None
    rod = build.body(_middle(host.pin, pin), 0.6 * rods[0], "rod")
    build.pin(host.body, rod, host.pin)
    _rod(build, rod, pin, other.body, other.pin)
    return other


Module = Callable[[PoseBuilder, Host], Host | None]
LOOPS: dict[str, Module] = {
    "four-bar": four_bar,
    "slider-crank": slider,
    "swinging block": swinging_block,
    "five-bar": five_bar,
}
WHEELS: dict[str, Module] = {"gear pair": gear_pair, "planet": planet, "rack": rack}
CAMS: dict[str, Module] = {"flat cam": flat_cam, "roller cam": roller_cam, "point cam": point_cam}
BRANCHES: dict[str, Module] = {
    "pendulum": pendulum,
    "carriage": carriage,
    "bob": bob,
    "attached body": attached,
}
ALL = LOOPS | WHEELS | CAMS | BRANCHES
