"""One small model an element: two bodies, the element between them, and its hand-written twins."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from sympy import cos, sin

from benchmarks import elements_in_space
from benchmarks.element_sample import RHS, Sample, joint
from benchmarks.hand import cams, drivers, forces, joints, space, space_forces
from benchmarks.transmissions import TRANSMISSIONS
from benchmarks.twins import Generated, States, Twin, generate
from codegen import Model, alpha, t
from codegen.declare.body import Body

STATES = 64
AWAY = 0.2
"""How far two bodies are from half a turn against each other, in cosines of half their angle."""
MEAN, MOST = 1.0, 1.3
"""What a generated kernel may take of its twin's time: in the geometric mean, and each."""
S_I, S_J, AXIS = (0.3, -0.2), (-0.5, 0.1), (0.6, 0.8)
LAW = 0.4 + 0.3 * sin(2 * t)


def _ellipse(body: Body) -> Any:
    return body.curve(0.2 * cos(alpha), 0.1 * sin(alpha))


JOINTS = (
    joint(
        "absolute",
        lambda m, i, j: m.absolute("e", j, "x", 0.4),
        joints.absolute_jacobian,
        joints.absolute_rhs,
        "absolute x",
    ),
    joint(
        "relative",
        lambda m, i, j: m.relative("e", i, j, "x", 0.4),
        joints.relative_jacobian,
        joints.relative_rhs,
        "relative x",
    ),
    joint(
        "distance",
        lambda m, i, j: m.distance("e", i, j, 1.5),
        joints.distance_jacobian,
        joints.distance_rhs,
    ),
    joint(
        "revolute",
        lambda m, i, j: m.revolute("e", i, j),
        joints.revolute_jacobian,
        joints.revolute_rhs,
    ),
    joint(
        "translational",
        lambda m, i, j: m.translational("e", i, j, AXIS, 0.2),
        joints.translational_jacobian,
        joints.translational_rhs,
    ),
    joint("weld", lambda m, i, j: m.weld("e", i, j, 0.2), joints.weld_jacobian, joints.weld_rhs),
    joint(
        "revolute-revolute",
        lambda m, i, j: m.revolute_revolute("e", i, j, 1.5),
        joints.distance_jacobian,
        joints.distance_rhs,
    ),
    joint(
        "revolute-translational",
        lambda m, i, j: m.revolute_translational("e", i, j, AXIS, 0.1),
        joints.revolute_translational_jacobian,
        joints.revolute_translational_rhs,
    ),
    joint(
        "gear",
        lambda m, i, j: m.gear("e", i.body, j.body, 0.3, 0.2, line=0.7),
        joints.gear_jacobian,
        joints.gear_rhs,
    ),
    joint(
        "rack-and-pinion",
        lambda m, i, j: m.rack_and_pinion("e", j.body, i, 0.25, AXIS),
        joints.rack_and_pinion_jacobian,
        joints.rack_and_pinion_rhs,
    ),
    joint(
        "constraint",
        lambda m, i, j: m.constraint("e", j.body.y - 2 * i.body.x**2),
        joints.parabola_jacobian,
        joints.parabola_rhs,
        "constraint, y = 2 x²",
    ),
    joint(
        "cam and flat-faced follower",
        lambda m, i, j: m.cam_flat_follower("e", i.body.circle(0.1, (0.02, 0.01)), j, AXIS),
        cams.flat_jacobian,
        cams.flat_rhs,
    ),
    joint(
        "cam and follower",
        lambda m, i, j: m.cam_follower("e", _ellipse(i.body), j.body.circle(0.05)),
        cams.roller_jacobian,
        cams.roller_rhs,
        "cam and roller",
    ),
    joint(
        "point follower",
        lambda m, i, j: m.point_follower("e", _ellipse(i.body), j),
        cams.point_jacobian,
        cams.point_rhs,
    ),
)

DRIVERS = (
    joint(
        "driver",
        lambda m, i, j: m.driver("e", j.body.phi, LAW),
        drivers.motion_jacobian,
        drivers.motion_rhs,
        "driver of φ",
    ),
    joint(
        "point driver",
        lambda m, i, j: m.point_driver("e", j, "x", LAW),
        drivers.point_jacobian,
        drivers.point_rhs,
        "point driver of x",
    ),
    joint(
        "relative driver",
        lambda m, i, j: m.relative_driver("e", i, j, "x", LAW),
        drivers.relative_jacobian,
        drivers.relative_rhs,
        "relative driver of x",
    ),
    joint(
        "translation driver",
        lambda m, i, j: m.translation_driver("e", i, j, LAW, AXIS),
        drivers.translation_jacobian,
        drivers.translation_rhs,
    ),
    joint(
        "distance driver",
        lambda m, i, j: m.distance_driver("e", i, j, 1.1 + LAW),
        drivers.distance_jacobian,
        drivers.distance_rhs,
    ),
)

PLANAR = JOINTS + DRIVERS + forces.SAMPLES + TRANSMISSIONS
SAMPLES = PLANAR + elements_in_space.SAMPLES


def generated(sample: Sample, folder: Path) -> Generated:
    """The element's kernels, from a model with two bodies."""
    model = Model(f"sample_{SAMPLES.index(sample)}", space=sample.space)
    if sample.space:
        bodies: Any = [model.body(*of) for of in space_forces.BODIES]
        places = (space.SI, space.SJ)
        points = [body.at(*place) for body, place in zip(bodies, places, strict=True)]
    else:
        i = model.body("i", mass=forces.MASS_I, inertia=0.1)
        points = [i.at(*S_I)]
        if sample.kind != "friction":
            points.append(model.body("j", mass=forces.MASS_J, inertia=0.2).at(*S_J))
    sample.declare(model, points[0], points[-1])
    model.scene("alone", effects=model.effects, drivers=model.drivers)
    return generate(model, "alone", tuple(sample.twins), folder)


def states(module: Any) -> States:
    """Positions and velocities anywhere: the formulas hold off the constraints too.

    Euler parameters alone have the length 1, and rates that keep it; no two bodies are half a turn
    apart, where rotation vectors change their sign.

    Conditions hold in the first half of the states and not in the second, so that a processor that
    guesses branches guesses all but two right.
    """
    random, n = np.random.default_rng(7), len(module.COORDINATES)
    q, v = random.uniform(-2.0, 2.0, (2, STATES, n))
    before = np.zeros((STATES, 4))
    for _, first in getattr(module, "TURNING", ()):
        e, rates = (of[:, first : first + 4] for of in (q, v))
        e /= np.linalg.norm(e, axis=1, keepdims=True)
        e += AWAY * before * np.sign((before * e).sum(axis=1, keepdims=True))
        e /= np.linalg.norm(e, axis=1, keepdims=True)
        rates -= e * (e * rates).sum(axis=1, keepdims=True)
        before = e
    held = np.arange(STATES) < STATES // 2
    modes = np.repeat(held[:, None], len(module.SWITCHES), axis=1).astype(np.int64)
    return States(q, v, np.ascontiguousarray(modes))


def twins(samples: Sequence[Sample], folder: Path) -> list[Twin]:
    """All pairs of the samples, ready to be called."""
    found = []
    for sample in samples:
        made = generated(sample, folder)
        where = states(made.module)
        outputs = {"jacobian": len(made.module.JACOBIAN_ROWS), RHS: len(made.module.CONSTRAINTS)}
        outputs["powers"] = len(made.module.POWERS)
        for kernel, hand in sample.twins.items():
            # Of the body on its guide, the acceleration along it is the one that friction changes.
            size = 1 if kernel == "accelerations" else outputs.get(kernel, int(where.q.shape[1]))
            p = made.p
            found.append(Twin(sample.label, kernel, made, hand, where, range(size), p, p))
    return found
