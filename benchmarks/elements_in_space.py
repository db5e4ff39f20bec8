"""One small model an element in space: two bodies, the element between them, and its twins."""

from types import ModuleType
from typing import Any

from sympy import sin, sqrt

from benchmarks.element_sample import RHS, Declare, Sample
from benchmarks.hand import space_counting as counting
from benchmarks.hand import space_couplers as couplers
from benchmarks.hand import space_drivers as drivers
from benchmarks.hand import space_forces as forces
from benchmarks.hand import space_friction as friction
from benchmarks.hand import space_joints as joints
from codegen import t
from codegen.declare.space_body import SpacePoint

LAW = 0.4 + 0.3 * sin(2 * t)
H, K, LINE, Z = (2, 3, 6), joints.HJ, couplers.LINE, (0, 0, 1)
F = forces.FX, forces.FY, forces.FZ


def _axes(i: SpacePoint, j: SpacePoint) -> Any:
    """The axis of body i, and that of body j, which is another one at the drawing."""
    return i.body.along(*H), j.body.along(*K)


def _upright(m: Any, name: str, point: SpacePoint) -> Any:
    """A joint of the ground that counts the angle of a body about the z axis."""
    return m.parallel_axes(name, m.ground, point.body, axis=Z)


def _sliding(m: Any, name: str, point: SpacePoint) -> Any:
    """A joint of the ground that counts the way of a point along the z axis."""
    return m.point_on_line(name, m.ground, point, axis=Z)


def _named(kind: str) -> str:
    return f"{kind.removesuffix(' in space')} in space"


def _joint(kind: str, twins: ModuleType, word: str, declare: Declare) -> Sample:
    pair = {"jacobian": getattr(twins, f"{word}_jacobian"), RHS: getattr(twins, f"{word}_rhs")}
    return Sample(kind, _named(kind), declare, pair, space=True)


def _force(kind: str, twin: Any, declare: Declare, label: str = "") -> Sample:
    return Sample(kind, _named(label or kind), declare, {"applied_forces": twin}, space=True)


def _friction(where: str, twin: Any, declare: Declare) -> Sample:
    label = f"friction in space, in {where}"
    return Sample("friction in space", label, declare, {"powers": twin}, space=True)


def _rubbing(m: Any, joint: Any, **sizes: float) -> Any:
    of = friction
    return m.friction("e", joint, of.MU, of.CREEP, of.RADIUS, **sizes)


JOINTS = (
    _joint("spherical", joints, "spherical", lambda m, i, j: m.spherical("e", i, j)),
    _joint(
        "revolute in space", joints, "revolute",
        lambda m, i, j: m.revolute("e", i, j, axis=_axes(i, j)),
    ),
    _joint(
        "universal", joints, "universal",
        lambda m, i, j: m.universal("e", i, j, axes=_axes(i, j), angle=1.2),
    ),
    _joint("weld in space", joints, "weld", lambda m, i, j: m.weld("e", i, j)),
    _joint(
        "parallel axes", joints, "parallel",
        lambda m, i, j: m.parallel_axes("e", i.body, j.body, axis=_axes(i, j)),
    ),
    _joint("distance in space", joints, "distance", lambda m, i, j: m.distance("e", i, j, 1.5)),
    _joint(
        "point in plane", joints, "in_plane",
        lambda m, i, j: m.point_in_plane("e", i, j, axis=i.body.along(*H)),
    ),
    _joint(
        "point on line", joints, "on_line",
        lambda m, i, j: m.point_on_line("e", i, j, axis=i.body.along(*H)),
    ),
    _joint("strut", joints, "on_line", lambda m, i, j: m.strut("e", i, j, axis=i.body.along(*H))),
    _joint(
        "cylindrical", joints, "cylindrical",
        lambda m, i, j: m.cylindrical("e", i, j, axis=_axes(i, j)),
    ),
    _joint(
        "translational in space", joints, "translational",
        lambda m, i, j: m.translational("e", i, j, axis=_axes(i, j)),
    ),
    _joint("planar", joints, "planar", lambda m, i, j: m.planar("e", i, j, axis=_axes(i, j))),
    _joint(
        "revolute-spherical", couplers, "revolute_spherical",
        lambda m, i, j: m.revolute_spherical("e", i, j, 1.5, axis=i.body.along(*H)),
    ),
    _joint(
        "revolute-revolute in space", couplers, "revolute_revolute",
        lambda m, i, j: m.revolute_revolute("e", i, j, 1.5, axis=_axes(i, j)),
    ),
    _joint(
        "revolute-cylindrical", couplers, "revolute_cylindrical",
        lambda m, i, j: m.revolute_cylindrical(
            "e", i, j, axis=i.body.along(*H), hinge=j.body.along(*K), angle=1.2
        ),
    ),
    _joint(
        "revolute-translational in space", couplers, "revolute_translational",
        lambda m, i, j: m.revolute_translational(
            "e", i, j, axis=i.body.along(*LINE), hinge=_axes(i, j)
        ),
    ),
    _joint(
        "screw in space", counting, "screw", lambda m, i, j: m.screw("e", i, j, 0.05, axis=H)
    ),
    _joint(
        "gear in space", counting, "gear",
        lambda m, i, j: m.gear("e", _upright(m, "A", i), _upright(m, "B", j), -1.5),
    ),
    _joint(
        "rack in space", counting, "rack",
        lambda m, i, j: m.rack_and_pinion("e", _upright(m, "A", i), _sliding(m, "B", j), 0.25),
    ),
    _joint(
        "constraint", counting, "parabola",
        lambda m, i, j: m.constraint("e", j.body.z - 2 * i.body.x**2),
    ),
)  # fmt: skip

DRIVERS = (
    _joint(
        "driver", drivers, "rotation_driver",
        lambda m, i, j: m.rotation_driver("e", _upright(m, "A", j), LAW),
    ),
    _joint(
        "point driver in space", drivers, "point_driver",
        lambda m, i, j: m.point_driver("e", j, "z", LAW),
    ),
    _joint(
        "distance driver", drivers, "distance_driver",
        lambda m, i, j: m.distance_driver("e", i, j, 1.1 + LAW),
    ),
)  # fmt: skip

FORCES = (
    _force(
        "gravity in space", forces.gravity,
        lambda m, i, j: m.gravity("e", (forces.GX, forces.GY, forces.GZ)),
    ),
    _force("force in space", forces.applied, lambda m, i, j: m.force("e", j, F)),
    _force(
        "force in space", forces.following, lambda m, i, j: m.force("e", j, F, frame="body"),
        "force fixed in the body",
    ),
    _force("torque in space", forces.torque, lambda m, i, j: m.torque("e", j.body, F)),
    _force(
        "torsion spring in space", forces.torsion_spring,
        lambda m, i, j: m.torsion_spring(
            "e", m.parallel_axes("A", i.body, j.body, axis=_axes(i, j)), 120, 0.4, 9, 5
        ),
    ),
    _force("spring", forces.spring, lambda m, i, j: m.spring("e", i, j, 120, 0.8, 9, 5)),
    _force(
        "line force", forces.line_force,
        lambda m, i, j: m.line_force("e", i, j, lambda length, rate: 40 * length + 3),
    ),
    _force(
        "bushing in space", forces.bushing,
        lambda m, i, j: m.bushing(
            "e", i, j, (900, 700, 800, 50, 60, 70), (8, 6, 7, 0.4, 0.5, 0.6)
        ),
    ),
    _force(
        "contact", forces.contact,
        lambda m, i, j: m.contact(
            "e", i, j, stiffness=5000, damping=30, free_length=0.1, direction=H
        ),
    ),
    _force(
        "rigid contact", forces.rigid_contact,
        lambda m, i, j: m.contact("e", i, j, direction=H, free_length=0.1, restitution=0.5),
    ),
    _force(
        "dry friction", forces.dry_friction,
        lambda m, i, j: m.dry_friction(
            "e", slip=j.body.vx - i.body.vx, normal=30.0, coefficient=0.4
        ),
    ),
    _force("stop", forces.stop, lambda m, i, j: m.stop("e", j.body.z, -0.1, 0.3, stiffness=500)),
    _force(
        "potential", forces.potential,
        lambda m, i, j: m.potential("e", 6 * (i.body.x**2 + i.body.y**2) ** 2),
    ),
    _force(
        "generalized force", forces.generalized,
        lambda m, i, j: m.generalized_force(
            "e", {i.body.z: -3 * i.body.vz * sqrt(i.body.vz**2 + 0.01)}
        ),
    ),
)  # fmt: skip

FRICTION = (
    _friction(
        "a pin", friction.revolute,
        lambda m, i, j: _rubbing(
            m, m.revolute("A", i, j, axis=_axes(i, j)), length=friction.LENGTH,
            collar=friction.COLLAR,
        ),
    ),
    _friction(
        "a guide", friction.translational,
        lambda m, i, j: _rubbing(m, m.translational("A", i, j, axis=_axes(i, j))),
    ),
    _friction(
        "a sleeve", friction.cylindrical,
        lambda m, i, j: _rubbing(m, m.cylindrical("A", i, j, axis=_axes(i, j))),
    ),
)  # fmt: skip

SAMPLES = JOINTS + DRIVERS + FORCES + FRICTION
