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

from codegen import Model

model = Model("gyroscope", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
weight = model.parameter("weight", 0.1, unit="kg", sign="positive")

outer = model.body("outer", 0.6, (4e-3, 2e-3, 2.5e-3))
inner = model.body("inner", 0.4, (1e-3, 1.5e-3, 1.2e-3))
rotor = model.body("rotor", 1.0, (2e-3, 1.2e-3, 1.2e-3))
load = model.body("load", weight, (2e-5, 2e-5, 2e-5), at=(0.2, 0, 0))

turning = model.revolute("turning", model.ground, outer, at=(0, 0, -0.14), axis=(0, 0, 1))
tilting = model.revolute("tilting", outer, inner, at=(0, -0.11, 0), axis=(0, 1, 0))
spinning = model.revolute("spinning", inner, rotor, at=(-0.08, 0, 0), axis=(1, 0, 0))
model.weld("nut", inner, load, at=(0.2, 0, 0))

model.scene("precession", ["gravity"],
            start={turning.angle: 0.0, tilting.angle: 0.0, spinning.angle: 0.0, turning.rate: 0.0,
                   tilting.rate: 0.0, spinning.rate: 300.0})  # fmt: skip
