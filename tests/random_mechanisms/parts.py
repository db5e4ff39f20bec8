"""A planar mechanism as plain numbers: what is declared, and what the dense equations are made of.

Lengths are in m, masses in kg, times in s, angles in rad. A body is named by its index in
`Mechanism.bodies`; `GROUND` is the frame that does not move.
"""

from dataclasses import dataclass
from math import sin

GROUND = -1
Pair = tuple[float, float]


@dataclass(frozen=True)
class Body:
    """A rigid body in its pose at t = 0; a particle has no inertia and no orientation."""

    name: str
    mass: float
    inertia: float | None
    pose: tuple[float, float, float]


@dataclass(frozen=True)
class End:
    """A point of a body, in the body's frame."""

    body: int
    s: Pair


@dataclass(frozen=True)
class Law:
    """offset + rate t + amplitude (sin(frequency t + phase) - sin(phase))."""

    offset: float = 0.0
    rate: float = 0.0
    amplitude: float = 0.0
    frequency: float = 1.0
    phase: float = 0.0

    def __call__(self, t: float) -> float:
        """The value at an instant."""
        swing = sin(self.frequency * t + self.phase) - sin(self.phase)
        return self.offset + self.rate * t + self.amplitude * swing


@dataclass(frozen=True)
class Profile:
    """r(α) = size (1 + Σ a cos(k α + p)) about a centre, for harmonics (k, a, p)."""

    size: float
    harmonics: tuple[tuple[int, float, float], ...] = ()
    centre: Pair = (0.0, 0.0)


@dataclass(frozen=True)
class Joint:
    """A joint or driver; the classes below add their numbers."""

    name: str


@dataclass(frozen=True)
class Revolute(Joint):
    """Two points coincide."""

    i: End
    j: End


@dataclass(frozen=True)
class Weld(Joint):
    """Two points coincide, and the angle between the bodies is kept."""

    i: End
    j: End
    angle: float


@dataclass(frozen=True)
class Translational(Joint):
    """Point j lies on a line of body i, and the angle between the bodies is kept."""

    i: End
    j: End
    axis: Pair
    angle: float


@dataclass(frozen=True)
class Link(Joint):
    """A massless link between two points."""

    i: End
    j: End
    length: float


@dataclass(frozen=True)
class Slot(Joint):
    """Point j keeps its distance from a line of body i."""

    i: End
    j: End
    axis: Pair
    distance: float


@dataclass(frozen=True)
class Gear(Joint):
    """Two pitch circles roll on each other."""

    i: End
    j: End
    radii: Pair
    line: float


@dataclass(frozen=True)
class Rack(Joint):
    """A pinion rolls along a rack."""

    pinion: End
    rack: End
    radius: float
    axis: Pair
    offset: float


@dataclass(frozen=True)
class Absolute(Joint):
    """x, y of a point or φ of a body keeps a value."""

    on: End
    letter: str
    value: float


@dataclass(frozen=True)
class FlatFollower(Joint):
    """A profile touches a straight face; `alpha` is the contact at t = 0."""

    cam: int
    profile: Profile
    face: End
    axis: Pair
    alpha: float


@dataclass(frozen=True)
class RollerFollower(Joint):
    """A profile touches a circle of another body."""

    cam: int
    profile: Profile
    follower: int
    roller: Profile
    alpha: float
    beta: float


@dataclass(frozen=True)
class PointFollower(Joint):
    """A point moves along a profile."""

    cam: int
    profile: Profile
    point: End
    alpha: float


@dataclass(frozen=True)
class PointDriver(Joint):
    """x, y of a point or φ of a body follows a law."""

    on: End
    letter: str
    law: Law


@dataclass(frozen=True)
class RelativeDriver(Joint):
    """x, y of point j or φ of its body, less that of i, follows a law."""

    i: End
    j: End
    letter: str
    law: Law


@dataclass(frozen=True)
class TranslationDriver(Joint):
    """How far point j is ahead of i along an axis of body i follows a law."""

    i: End
    j: End
    axis: Pair
    law: Law


@dataclass(frozen=True)
class DistanceDriver(Joint):
    """The distance of two points follows a law."""

    i: End
    j: End
    law: Law


DRIVERS = (PointDriver, RelativeDriver, TranslationDriver, DistanceDriver)


@dataclass(frozen=True)
class Effect:
    """A force; the classes below add their numbers."""

    name: str


@dataclass(frozen=True)
class Gravity(Effect):
    """Uniform gravity."""

    g: Pair


@dataclass(frozen=True)
class Spring(Effect):
    """k (ℓ - ℓ0) + c ℓ̇ + F between two points."""

    i: End
    j: End
    stiffness: float
    free_length: float
    damping: float
    actuator: Law


@dataclass(frozen=True)
class TorsionSpring(Effect):
    """k (θ - θ0) + c θ̇ between two bodies."""

    i: int
    j: int
    stiffness: float
    free_angle: float
    damping: float


@dataclass(frozen=True)
class Bushing(Effect):
    """Springs and dampers along the axes of body i, and about the normal."""

    i: End
    j: End
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float]
    free_angle: float


@dataclass(frozen=True)
class Force(Effect):
    """A force at a point, in axes of the ground or of the body, that varies in time."""

    on: End
    fx: Law
    fy: Law
    frame: str


@dataclass(frozen=True)
class Torque(Effect):
    """A torque on a body that varies in time, less a drag times the body's speed."""

    on: int
    law: Law
    drag: float


@dataclass(frozen=True)
class JointFriction(Effect):
    """Coulomb friction in a revolute (`radius`), translational or slot joint."""

    joint: str
    coefficient: float
    creep: float | None
    radius: float | None
    length: float | None
    static: float | None = None  # of one that sticks, without creep


@dataclass(frozen=True)
class DryFriction(Effect):
    """Coulomb friction under a given normal force along an axis of body i."""

    i: End
    j: End
    axis: Pair
    normal: float
    coefficient: float
    creep: float | None
    static: float | None = None


@dataclass(frozen=True)
class RigidContact(Effect):
    """No gap along a direction of body i is ever negative; impacts after Newton."""

    i: End
    j: End
    direction: Pair
    free_length: float
    restitution: float


@dataclass(frozen=True)
class Contact(Effect):
    """k g + c ġ while the gap g along a direction of body i is negative."""

    i: End
    j: End
    direction: Pair
    free_length: float
    stiffness: float
    damping: float


@dataclass(frozen=True)
class Mechanism:
    """All parts of a mechanism, and its velocities at t = 0 by name of the coordinate."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    effects: tuple[Effect, ...] = ()
    velocities: tuple[tuple[str, float], ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names, body by body and then of the places of contacts."""
        names = []
        for body in self.bodies:
            letters = ("x", "y") if body.inertia is None else ("x", "y", "phi")
            names += [f"{body.name}.{letter}" for letter in letters]
        for joint in self.joints:
            for letter in ("alpha", "beta"):
                if hasattr(joint, letter):
                    names.append(f"{joint.name}.{letter}")
        return tuple(names)

    @property
    def pose(self) -> tuple[float, ...]:
        """The coordinates' values at t = 0."""
        values: list[float] = []
        for body in self.bodies:
            values += body.pose[:2] if body.inertia is None else body.pose
        for joint in self.joints:
            values += [getattr(joint, k) for k in ("alpha", "beta") if hasattr(joint, k)]
        return tuple(values)
