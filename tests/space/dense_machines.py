"""Machines in space with references, as plain numbers for the dense equations."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_loops import rows, vector
from tests.random_mechanisms.spatial_parts import GROUND, Law, SpatialBody, SpatialMechanism
from tests.space.closed_forms import FlyballGovernor

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)
BRICARD = (ORIGIN, X, (1.0, -1.0, 0.0), (1.0, -1.0, 1.0), (0.0, -1.0, 1.0), Z)  # its hinges


def principal(*moments: float) -> parts.Matrix:
    """J′ of principal moments."""
    return rows(np.diag(moments))


def block(mass: float, x: float, y: float, z: float) -> parts.Matrix:
    """J′ of a block with given sides."""
    squares = np.square([x, y, z])
    return rows(np.diag(mass / 12.0 * (squares.sum() - squares)))


def heavy_top() -> SpatialMechanism:
    """15 kg at 1 m from the fixed point, lying along y at the drawing."""
    top = SpatialBody("top", 15.0, principal(0.234375, 0.46875, 0.234375), Y)
    joint = parts.Spherical("O", GROUND, 0, ORIGIN)
    return SpatialMechanism((top,), (joint,), (parts.Gravity("gravity"),))


def bricard() -> SpatialMechanism:
    """IFToMM A04: five bars, six hinges, one row too many."""
    bodies = []
    for k in range(5):
        begin, end = np.array(BRICARD[k]), np.array(BRICARD[k + 1])
        sides = np.where(begin == end, 0.1, 1.0)
        bodies.append(
            SpatialBody(f"b{k + 1}", 1.0, block(1.0, *sides), vector(0.5 * (begin + end)))
        )
    ends = [(GROUND, 0), (0, 1), (1, 2), (2, 3), (3, 4), (4, GROUND)]
    joints = tuple(
        parts.Revolute(f"J{k + 1}", i, j, at, axis)
        for k, ((i, j), at, axis) in enumerate(zip(ends, BRICARD, (Y, Z, X, Y, Z, X), strict=True))
    )
    return SpatialMechanism(tuple(bodies), joints, (parts.Gravity("gravity", (0.0, -9.81, 0.0)),))


def flyball_governor(tilt: float = np.pi / 6) -> SpatialMechanism:
    """IFToMM A05: shaft, slider and two rods with a mass at the tip of each."""
    slim, tip, arm = 3000.0 * 1e-4, 5.0, 1.0
    mass = slim + tip
    centre = (0.5 * slim + tip) * arm / mass
    across = slim / 12.0 * (1 + 1e-4) + slim * (centre - 0.5) ** 2 + tip * (arm - centre) ** 2
    inertia = principal(slim * 2e-4 / 12.0, across, across)
    bodies = [
        SpatialBody("shaft", slim, block(slim, 0.01, 0.01, 1.0), (0.0, 0.0, 0.5)),
        SpatialBody("slider", 3.0, block(3.0, 0.1, 0.1, 0.1), (0.0, 0.0, 0.5)),
    ]
    joints: list[parts.SpatialJoint] = [
        parts.Revolute("bearing", GROUND, 0, ORIGIN, Z),
        parts.Translational("guide", 0, 1, (0.0, 0.0, 0.5), Z),
    ]
    effects: list[parts.SpatialEffect] = [parts.Gravity("gravity")]
    for k, side in enumerate((1.0, -1.0)):
        along = np.array([side * np.cos(tilt), 0.0, -np.sin(tilt)])
        hinge, axes = (
            np.array([0.05 * side, 0.0, 1.0]),
            np.column_stack([along, Y, np.cross(along, Y)]),
        )
        body, name = 2 + k, f"rod{k + 1}"
        bodies.append(SpatialBody(name, mass, inertia, vector(hinge + centre * along), rows(axes)))
        joints.append(parts.Revolute(f"hinge{k + 1}", 0, body, vector(hinge), (0.0, side, 0.0)))
        ends = (0.05 * side, 0.0, 0.5), vector(hinge + 0.5 * along)
        effects.append(parts.Spring(f"spring{k + 1}", 1, body, *ends, 8e5, 0.5, 4e4))
    return SpatialMechanism(tuple(bodies), tuple(joints), tuple(effects))


def slider_crank(
    length: float = 0.3, rod_moments: Any = (4e-4, 4e-3, 4e-3), speed: float | None = -2 * np.pi
) -> SpatialMechanism:  # fmt: skip
    """Haug 12.2, with the crank's pin above its pivot; driven at `speed` about x, or free."""
    B = np.array([0.0, 0.1, 0.2])
    C = np.array([np.sqrt(length**2 - 0.05), 0.0, 0.0])
    along = (C - B) / length
    across = np.cross(X, along) / np.linalg.norm(np.cross(X, along))
    axes = np.column_stack([along, across, np.cross(along, across)])
    turn = Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()
    bodies = (
        SpatialBody("crank", 0.12, principal(1e-4, 1e-5, 1e-4), (0.0, 0.1, 0.12), rows(turn)),
        SpatialBody("rod", 0.5, principal(*rod_moments), vector(0.5 * (B + C)), rows(axes)),
        SpatialBody("slider", 2.0, principal(1e-4, 1e-4, 1e-4), vector(C)),
    )
    joints: list[parts.SpatialJoint] = [
        parts.Revolute("A", GROUND, 0, (0.0, 0.1, 0.12), X),
        parts.Spherical("B", 0, 1, vector(B)),
        parts.Universal("C", 2, 1, vector(C), X, vector(across)),
        parts.Translational("D", GROUND, 2, vector(C), X),
    ]
    if speed is not None:
        joints.append(parts.AngleDriver("drive", "A", Law(rate=speed)))
    return SpatialMechanism(bodies, tuple(joints), (parts.Gravity("gravity"),))


def universal_shafts(bend: float, speed: float = 2.0) -> SpatialMechanism:
    """Two shafts that meet at the origin under an angle, the first driven.

    The first lies along x, the second along (cos β, sin β, 0). At the drawing the arm of the cross
    on the first shaft lies in the plane of both.
    """
    second = (float(np.cos(bend)), float(np.sin(bend)), 0.0)
    turn = Rotation.from_rotvec([0, 0, bend]).as_matrix()
    bodies = (
        SpatialBody("first", 1.0, principal(0.1, 0.2, 0.3), (-0.5, 0.0, 0.0)),
        SpatialBody(
            "second", 2.0, principal(0.3, 0.2, 0.1), vector(0.5 * np.array(second)), rows(turn)
        ),
    )
    joints = (
        parts.Revolute("bearing1", GROUND, 0, (-1.0, 0.0, 0.0), X),
        parts.Universal("cross", 0, 1, ORIGIN, Y, Z),
        parts.Revolute("bearing2", GROUND, 1, second, second),
        parts.AngleDriver("drive", "bearing1", Law(rate=speed)),
    )
    return SpatialMechanism(bodies, joints)


def governor(height: float, form: FlyballGovernor | None = None) -> SpatialMechanism:
    """Haug 12.6 with its collar at a height, free to turn; neither engine nor load."""
    form = form or FlyballGovernor()
    angle, top = form.angle(height), np.array([0.0, form.top, 0.0])
    bodies = [
        SpatialBody("spindle", 200.0, principal(25.0, 50.0, 25.0), vector(top)),
        SpatialBody("collar", form.collar, principal(0.15, 0.125, 0.15), (0.0, height, 0.0)),
    ]
    joints: list[parts.SpatialJoint] = [
        parts.Revolute("bearing", GROUND, 0, vector(top), Y),
        parts.Translational("guide", 0, 1, (0.0, height, 0.0), Y),
    ]
    for k, side in enumerate((1.0, -1.0)):
        along = np.array([side * np.sin(angle), -np.cos(angle), 0.0])
        ball, pin = vector(top + form.arm * along), vector(top + form.joint * along)
        bodies.append(SpatialBody(f"ball{k + 1}", form.ball, principal(0.1, 0.1, 0.1), ball))
        joints.append(parts.Revolute(f"arm{k + 1}", 0, 2 + k, vector(top), Z))
        joints.append(parts.SphericalSpherical(f"link{k + 1}", 2 + k, 1, pin, (0.0, height, 0.0)))
    spring = parts.Spring("spring", 0, 1, vector(top), (0.0, height, 0.0), form.stiffness,
                          form.free_length, 30.0)  # fmt: skip
    effects = parts.Gravity("gravity", (0.0, -9.81, 0.0)), spring
    return SpatialMechanism(tuple(bodies), tuple(joints), effects)
