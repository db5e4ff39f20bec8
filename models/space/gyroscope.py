"""A gyroscope in two gimbals, with a weight on its axis.

              z
              o  outer hinge
         .----+----.
        |  .-----.  |
        | |       | |
        o-o [===] o-o   inner hinges, along y
        | |   rotor---- x, with the weight
        |  `-----`  |
         `----+----`
              o

The rotor turns in the inner ring about x', the inner ring in the outer one about y', the outer one
in the frame about z. All three are balanced, but for a weight at 0.2 m on the axis of the inner
ring. With the axis level, the rings do not disturb the steady precession Ω = m g l / (J ω), with
J ω the rotor's angular momentum about its axis.

Dimensions and masses are those of no machine in particular (C).

Scenes
------
precession
    From rest of the rings, or any rates: the axis nods and precesses.
"""

from codegen import Model, disc, extruded

model = Model("gyroscope", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
weight = model.parameter("weight", 0.1, unit="kg", sign="positive")

# Rings and rotor, as they are drawn: the plane of each by two axes.
XY, YZ, XZ = ((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)), ((1, 0, 0), (0, 0, 1))
holes = (disc(0.013, (0.04 * x, 0.04 * y)) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))
frame = [extruded(disc(0.14).with_holes(disc(0.122)), 0.016, axes=YZ),
         extruded(disc(0.006), 0.035, (0, 0.112, 0), XZ)]  # fmt: skip
ring = [extruded(disc(0.1).with_holes(disc(0.084)), 0.016, axes=XY),
        extruded(disc(0.006), 0.13, (0.135, 0, 0), YZ)]  # fmt: skip
wheel = [extruded(disc(0.066).with_holes(*holes), 0.024, axes=YZ),
         extruded(disc(0.006), 0.17, axes=YZ)]  # fmt: skip

outer = model.body("outer", 0.6, (4e-3, 2e-3, 2.5e-3), draw=frame)
inner = model.body("inner", 0.4, (1e-3, 1.5e-3, 1.2e-3), draw=ring)
rotor = model.body("rotor", 1.0, (2e-3, 1.2e-3, 1.2e-3), draw=wheel)
load = model.body("load", weight, (2e-5, 2e-5, 2e-5), at=(0.2, 0, 0))

turning = model.revolute("turning", model.ground, outer, at=(0, 0, -0.14), axis=(0, 0, 1))
tilting = model.revolute("tilting", outer, inner, at=(0, -0.11, 0), axis=(0, 1, 0))
spinning = model.revolute("spinning", inner, rotor, at=(-0.08, 0, 0), axis=(1, 0, 0))
model.weld("nut", inner, load, at=(0.2, 0, 0))

model.scene("precession", ["gravity"],
            start={turning.angle: 0.0, tilting.angle: 0.0, spinning.angle: 0.0, turning.rate: 0.0,
                   tilting.rate: 0.0, spinning.rate: 300.0})  # fmt: skip
