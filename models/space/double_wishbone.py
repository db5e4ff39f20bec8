"""A double wishbone with a steering rack: the suspension of a left front wheel.

Seen from behind; x is forward, y to the left, z up:

        chassis         strut
           //o  . . . . o
           //o=====/======o    upper wishbone
           //     /       |\\
           //    /        | \\ wheel
    [rack]=o----/---------o |    tie rod
           //  /          | /
           //o=o==========o/    lower wishbone
                          |

Each wishbone hangs in a hinge of the chassis, whose axis is nearly along x; ball joints hold the
upright between them. The tie rod from the rack holds it against turning, and steers it. A spring
with a damper stands on the lower wishbone.

Dimensions and masses are those of no car in particular (C).

Scenes
------
guided
    The wheel is lifted and the rack moved: camber, toe, and the force at the wheel.
bounce
    The wheel carries a quarter of the car, and is let go below its rest.
"""

import numpy as np
from sympy import asin, atan2, pi, sin

from codegen import Model, disc, extruded, t

model = Model("double_wishbone", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
lift = model.parameter("lift", 0.06, unit="m", sign="nonnegative")
steer = model.parameter("steer", 0.03, unit="m")
load = model.parameter("load", 3000.0, unit="N")

lower_outer, upper_outer, tie_outer = (0.0, 0.75, 0.18), (-0.02, 0.70, 0.50), (-0.14, 0.72, 0.28)
lower_axis, upper_axis = (0.35, 0.0, -0.02), (0.27, 0.0, 0.02)
lower_hinge, upper_hinge = (-0.02, 0.35, 0.21), (-0.02, 0.42, 0.47)
wheel_centre, rack_end = (0.0, 0.80, 0.32), (-0.12, 0.36, 0.27)


def between(centre, *pairs):
    """Rods between places of the drawing, in the frame of a body with this centre of mass."""
    for start, end in (np.array(pair) - centre for pair in pairs):
        along = end - start
        across = np.cross(along, np.eye(3)[np.argmin(abs(along))])
        long = float(np.linalg.norm(along))
        yield extruded(disc(0.013), long, (start + end) / 2, (across, np.cross(along, across)))


def legs(hinge, axis, ball, centre):
    """The form of a wishbone: two legs, from either end of its hinge to the ball joint."""
    ends = [[p + side * 0.5 * u for p, u in zip(hinge, axis, strict=True)] for side in (-1, 1)]
    return [*between(centre, (ends[0], ball), (ends[1], ball), ends)]


at_lower, at_upper = (-0.01, 0.58, 0.19), (-0.02, 0.58, 0.485)
tyre = extruded(disc(0.32).with_holes(disc(0.2)), 0.18, axes=((1, 0, 0), (0, 0, 1)))
spokes = between(
    wheel_centre,
    (lower_outer, upper_outer),
    (tie_outer, wheel_centre),
    ((0, 0.8, 0.12), (0, 0.8, 0.52)),
    ((-0.2, 0.8, 0.32), (0.2, 0.8, 0.32)),
)
lower = model.body("lower", 4.0, (0.05, 0.04, 0.08), at=at_lower,
                   draw=legs(lower_hinge, lower_axis, lower_outer, at_lower))  # fmt: skip
upper = model.body("upper", 2.0, (0.02, 0.01, 0.03), at=at_upper,
                   draw=legs(upper_hinge, upper_axis, upper_outer, at_upper))  # fmt: skip
upright = model.body("upright", 30.0, (0.8, 1.2, 0.8), at=wheel_centre, draw=[tyre, *spokes])
rack = model.body("rack", 2.0, (0.06, 1e-3, 0.06), at=(-0.12, 0.0, 0.27))

model.revolute("lower_hinge", model.ground, lower, at=lower_hinge, axis=lower_axis)
model.revolute("upper_hinge", model.ground, upper, at=upper_hinge, axis=upper_axis)
model.spherical("lower_ball", lower, upright, at=lower_outer)
model.spherical("upper_ball", upper, upright, at=upper_outer)
guide = model.translational("guide", model.ground, rack, at=(-0.12, 0.0, 0.27), axis=(0, 1, 0))


def on(body, place):
    """The point of a body, which has the global axes at the drawing, at a place of the drawing."""
    return body.at(*(p - c for p, c in zip(place, body.place, strict=True)))


model.distance("tie_rod", on(rack, rack_end), on(upright, tie_outer))
model.spring("strut", on(lower, (0.0, 0.62, 0.19)), model.ground.at(0.0, 0.48, 0.62),
             stiffness=4e4, free_length=0.55, damping=2e3)  # fmt: skip
model.force("car", upright, (0, 0, load))

model.point_driver("road", upright, "z", wheel_centre[2] + lift * sin(2 * pi * t))
model.translation_driver("steering", guide, steer * sin(4 * pi * t))
model.translation_driver("straight", guide, 0)

# The wheel turns about y' of the upright.
axle = upright.A[:, 1]
angles = {"camber": asin(axle[2]), "toe": atan2(axle[0], axle[1])}
model.scene("guided", ["gravity", "strut"], ["road", "steering"], outputs=["default", angles])
model.scene("bounce", ["gravity", "strut", "car"], ["straight"],
            start={"upright.z": 0.26, "upright.vz": 0.0})  # fmt: skip
