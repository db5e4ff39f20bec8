"""A spatial mechanism as plain numbers: what is declared, and what the dense equations are made of.

Lengths are in m, masses in kg, times in s, angles in rad. A body is named by its index in
`SpatialMechanism.bodies`; `GROUND` is the frame that does not move. Every point (`at`) and axis is
given in global axes at the drawing, where all joints are closed, and is fixed in the bodies that
the joint names. Joints go from body i to body j: j is what moves, and what feels the reaction.
"""

from dataclasses import dataclass, field

from tests.random_mechanisms.parts import GROUND, Law

__all__ = ["GROUND", "Law"]

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
REST = Law()


@dataclass(frozen=True)
class SpatialBody:
    """A rigid body at the drawing.

    `inertia` is J′, about the centre of mass in the body's axes; `r` the centre of mass; `A` turns
    body axes into global ones.
    """

    name: str
    mass: float
    inertia: Matrix
    r: Vector = (0.0, 0.0, 0.0)
    A: Matrix = IDENTITY


@dataclass(frozen=True)
class SpatialJoint:
    """A joint or driver; the classes below add their numbers."""

    name: str


@dataclass(frozen=True)
class TwoBodyJoint(SpatialJoint):
    """A joint between two bodies."""

    i: int
    j: int


@dataclass(frozen=True)
class Spherical(TwoBodyJoint):
    """The points that lie at `at` coincide."""

    at: Vector


@dataclass(frozen=True)
class Weld(TwoBodyJoint):
    """No relative motion."""

    at: Vector


@dataclass(frozen=True)
class Revolute(TwoBodyJoint):
    """Body j turns relative to body i about `axis` through `at`."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class Translational(TwoBodyJoint):
    """Body j slides along `axis`, fixed in body i, and does not turn relative to it."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class Cylindrical(TwoBodyJoint):
    """Body j slides along `axis` and turns about it."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class Universal(TwoBodyJoint):
    """The points at `at` coincide; `axis_i` of body i stays at right angles to `axis_j` of j."""

    at: Vector
    axis_i: Vector
    axis_j: Vector


@dataclass(frozen=True)
class Planar(TwoBodyJoint):
    """Body j slides on a plane of body i through `at`, of the normal `axis`, and turns on it."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class PointInPlane(TwoBodyJoint):
    """The point of body j at `at` stays in a plane of body i of the normal `axis`."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class PointOnLine(TwoBodyJoint):
    """The point of body j at `at` stays on a line of body i along `axis`."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class Strut(PointOnLine):
    """A massless rod slides in body i, with a ball joint to body j."""


@dataclass(frozen=True)
class ParallelAxes(TwoBodyJoint):
    """A direction of each body stays parallel to the other; `at` is a place for the torque."""

    at: Vector
    axis: Vector


@dataclass(frozen=True)
class Screw(TwoBodyJoint):
    """Body j turns about `axis` and slides along it by `lead` a turn."""

    at: Vector
    axis: Vector
    lead: float


@dataclass(frozen=True)
class RevoluteSpherical(TwoBodyJoint):
    """A massless link on a hinge of body i at `at_i`, with a ball joint to body j at `at_j`."""

    at_i: Vector
    at_j: Vector
    axis: Vector


@dataclass(frozen=True)
class RevoluteRevolute(RevoluteSpherical):
    """A massless link between two hinges along `axis`."""


@dataclass(frozen=True)
class RevoluteCylindrical(TwoBodyJoint):
    """A massless sleeve on a line of body i along `axis`, hinged to body j about `hinge`."""

    at: Vector
    axis: Vector
    hinge: Vector


@dataclass(frozen=True)
class RevoluteTranslational(RevoluteCylindrical):
    """A massless block in a guide of body i along `axis`, hinged to body j about `hinge`."""


@dataclass(frozen=True)
class SphericalSpherical(TwoBodyJoint):
    """A massless link: two points keep the distance that they have at the drawing."""

    at_i: Vector
    at_j: Vector


@dataclass(frozen=True)
class PointDriver(SpatialJoint):
    """A global coordinate (``"x"``, ``"y"`` or ``"z"``) of a point of a body is the law."""

    body: int
    at: Vector
    letter: str
    law: Law


@dataclass(frozen=True)
class DistanceDriver(TwoBodyJoint):
    """The distance of two points is the law."""

    at_i: Vector
    at_j: Vector
    law: Law


@dataclass(frozen=True)
class AngleDriver(SpatialJoint):
    """The angle of a revolute or cylindrical joint, 0 at the drawing, is the law."""

    joint: str
    law: Law


@dataclass(frozen=True)
class SlideDriver(SpatialJoint):
    """The slide of a translational or cylindrical joint, 0 at the drawing, is the law."""

    joint: str
    law: Law


@dataclass(frozen=True)
class Gear(SpatialJoint):
    """The angle of joint `driven` is `ratio` times that of `joint`, both 0 at the drawing."""

    joint: str
    driven: str
    ratio: float


@dataclass(frozen=True)
class Rack(Gear):
    """The slide of joint `driven` is `ratio` times the angle of `joint`."""


DRIVERS = (PointDriver, DistanceDriver, AngleDriver, SlideDriver)
ALONG = (*DRIVERS, Gear)  # parts that exert one force or torque
TURNING = (
    *(Revolute, Cylindrical, Planar, ParallelAxes, Screw, RevoluteRevolute),
    RevoluteTranslational,
)
SLIDING = Translational, Cylindrical, PointOnLine, Screw, RevoluteCylindrical


@dataclass(frozen=True)
class SpatialEffect:
    """A force; the classes below add their numbers."""

    name: str


@dataclass(frozen=True)
class Gravity(SpatialEffect):
    """The same acceleration for all bodies, m/s²."""

    g: Vector = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Force(SpatialEffect):
    """A force at a point of a body, by its components in ``"global"`` or ``"body"`` axes, N."""

    body: int
    at: Vector
    laws: tuple[Law, Law, Law]
    frame: str = "global"


@dataclass(frozen=True)
class Torque(SpatialEffect):
    """A torque on a body, by its components in ``"global"`` or ``"body"`` axes, N m."""

    body: int
    laws: tuple[Law, Law, Law]
    frame: str = "global"


@dataclass(frozen=True)
class Spring(SpatialEffect):
    """Pulls two points together by stiffness (l - free_length) + damping l̇ + actuator."""

    i: int
    j: int
    at_i: Vector
    at_j: Vector
    stiffness: float
    free_length: float
    damping: float = 0.0
    actuator: Law = REST


@dataclass(frozen=True)
class TorsionSpring(SpatialEffect):
    """Turns j back by stiffness (θ - free_angle) + damping θ̇, θ of a joint through its turns."""

    joint: str
    stiffness: float
    free_angle: float = 0.0
    damping: float = 0.0


@dataclass(frozen=True)
class Bushing(SpatialEffect):
    """f = K z + F0 + C ż along z, in the columns of `axes`, of body j against body i."""

    i: int
    j: int
    at: Vector
    axes: Matrix
    stiffness: tuple[tuple[float, ...], ...]
    damping: tuple[tuple[float, ...], ...]
    preload: tuple[float, ...]


@dataclass(frozen=True)
class Friction(SpatialEffect):
    """A joint that turns or slides, or does both, rubs by Coulomb's law with a speed of creep."""

    joint: str
    coefficient: float
    creep: float
    radius: float | None = None
    length: float | None = None
    collar: float | None = None


@dataclass(frozen=True)
class SpatialMechanism:
    """Bodies, joints with drivers among them, and forces."""

    bodies: tuple[SpatialBody, ...]
    joints: tuple[SpatialJoint, ...]
    effects: tuple[SpatialEffect, ...] = field(default=())

    def joint(self, name: str) -> SpatialJoint:
        """The joint of a name."""
        return next(joint for joint in self.joints if joint.name == name)
