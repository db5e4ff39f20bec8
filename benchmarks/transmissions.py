"""Samples of belts, screws, discs, gears with backlash, stops and clearances."""

from benchmarks.element_sample import Sample, force, joint
from benchmarks.hand import forces, joints, transmissions

AXIS = (forces.UX, forces.UY)

TRANSMISSIONS = (
    Sample(
        "belt",
        "belt",
        lambda m, i, j: m.belt("e", i.body, j.body, 0.2, 0.3),
        {"jacobian": transmissions.belt_jacobian},
    ),
    joint(
        "screw",
        lambda m, i, j: m.screw("e", m.ground, i, j.body, 0.05, AXIS),
        transmissions.screw_jacobian,
        transmissions.screw_rhs,
    ),
    joint(
        "rolling disc",
        lambda m, i, j: m.rolling_disc("e", j.body, i, joints.RADIUS, AXIS),
        joints.rack_and_pinion_jacobian,
        joints.rack_and_pinion_rhs,
    ),
    force(
        "elastic belt",
        lambda m, i, j: m.elastic_belt("e", i.body, j.body, 0.2, 0.3, stiffness=500, pretension=20),
        transmissions.elastic_belt,
    ),
    force(
        "gear with backlash",
        lambda m, i, j: m.gear_with_backlash(
            "e", i.body, j.body, 0.2, 0.3, backlash=0.04, stiffness=500
        ),
        transmissions.gear_with_backlash,
    ),
    force(
        "stop", lambda m, i, j: m.stop("e", j.body.x, -0.1, 0.3, stiffness=500), transmissions.stop
    ),
    force(
        "clearance joint",
        lambda m, i, j: m.clearance_joint("e", i, j, 0.1, 700, exponent=2, damping=0.3),
        transmissions.clearance,
    ),
    force(
        "one-way clutch",
        lambda m, i, j: m.one_way_clutch("e", i.body, j.body, 40 + 5 * j.body.x**2 + 3 * j.body.y),
        transmissions.one_way_clutch,
    ),
)
