"""The shapes of which the picture of a machine in space consists, beside those of the plane.

Springs, rods, marks and traces are those of the plane, between places of three numbers.
"""

from dataclasses import dataclass
from typing import Any

from codegen.drawing.shapes import Number, Pair, PointOrPlace, Shape


@dataclass(frozen=True)
class SpaceJoint(Pair):
    """Two places that a joint holds together, but for where it slides.

    Its form is "ball", "hinge", "shaft" (a hinge that slides), "bead" (a ball that slides), "rail"
    (a block on it), "plate" (a ball on it), "cross" (of a universal joint) or "clamp". An axis is a
    direction of body i, or of body j, as the place to which it leads from the body's origin.
    """

    kind = "joint"
    form: str
    axis: PointOrPlace = None
    axis_j: PointOrPlace = None

    @property
    def slides(self) -> bool:
        """Whether place j may leave place i along the axis."""
        return self.form in ("shaft", "bead", "rail")


@dataclass(frozen=True)
class Bulk(Shape):
    """A body that nothing holds, as a box of its mass and inertia."""

    kind = "bulk"
    at: PointOrPlace
    mass: Number
    jxx: Number
    jyy: Number
    jzz: Number
    jxy: Number
    jxz: Number
    jyz: Number


@dataclass(frozen=True)
class Form(Shape):
    """A mesh, as its text, in the frame of the body of a place."""

    kind = "form"
    at: PointOrPlace
    mesh: str


@dataclass(frozen=True)
class Push(Shape):
    """A force at a place, N, or with `turns` a torque, N m, in global axes."""

    kind = "push"
    at: PointOrPlace
    x: Number
    y: Number
    z: Number
    turns: bool = False


@dataclass(frozen=True)
class SpaceDrive(Shape):
    """The direction in global axes along which a driver pushes a place, or about which it turns."""

    kind = "drive in space"
    at: PointOrPlace
    x: Number
    y: Number
    z: Number
    turns: bool = False
    exerts: Number | None = None  # where no series has it, N m


@dataclass(frozen=True)
class Wrench(Shape):
    """The force and the torque of a joint on its second body, at a place, by the first."""

    kind = "wrench"
    by: Any
    at: PointOrPlace


@dataclass(frozen=True)
class Pull(Shape):
    """The direction and size of gravity, m/s²."""

    kind = "pull"
    gx: Number
    gy: Number
    gz: Number
