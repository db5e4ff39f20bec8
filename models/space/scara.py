"""A SCARA arm: two hinges with upright axes, and a quill that slides and turns.

             elbow          quill
        o------o--------------[]
        |  inner     outer    ||
        | shoulder            || slides along z, and turns about it
      /////                   []  tool

The quill stands in a cylindrical joint, which has two drivers: of its slide and of its angle.

Dimensions and masses are those of no robot in particular (C).

Scenes
------
inverse_dynamics
    Torques and the force of the motors, from one place to another and back.
"""

from sympy import pi, sin

from codegen import Model, bar, disc, extruded, rectangle, t

model = Model("scara", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
payload = model.parameter("payload", 3.0, unit="kg", sign="nonnegative")
speed = model.parameter("speed", float(2 * pi), unit="rad/s")

inner = model.body("inner", 6.0, (0.02, 0.12, 0.13), at=(0.2, 0, 0.5),
                   draw=extruded(bar(0.4, 0.11, (-0.2, 0)), 0.05))  # fmt: skip
outer = model.body("outer", 4.0, (0.02, 0.06, 0.06), at=(0.55, 0, 0.52),
                   draw=extruded(bar(0.35, 0.09, (-0.15, 0)), 0.05, at=(0, 0, 0.04)))  # fmt: skip
quill = model.body("quill", 1.0 + payload, (0.02, 0.02, 4e-3), at=(0.75, 0.01, 0.4),
                   draw=[extruded(disc(0.014), 0.52, (0, -0.01, 0.06)),
                         extruded(rectangle(0.09, 0.04), 0.04, at=(0, -0.01, -0.21))])  # fmt: skip
model.draw_ground([extruded(disc(0.055), 0.47, (0, 0, 0.235)),
                   extruded(rectangle(0.26, 0.26), 0.03)])  # fmt: skip

shoulder = model.revolute("shoulder", model.ground, inner, at=(0, 0, 0.5), axis=(0, 0, 1))
elbow = model.revolute("elbow", inner, outer, at=(0.4, 0, 0.5), axis=(0, 0, 1))
guide = model.cylindrical("guide", outer, quill, at=(0.75, 0, 0.5), axis=(0, 0, 1))

there_and_back = sin(speed * t / 2) ** 2
model.rotation_driver("motor_1", shoulder, 1.5 * there_and_back)
model.rotation_driver("motor_2", elbow, -2.0 * there_and_back)
model.translation_driver("motor_3", guide, 0.15 * there_and_back)
model.rotation_driver("motor_4", guide, 3.0 * there_and_back)

model.scene("inverse_dynamics", ["gravity"], [f"motor_{k}" for k in range(1, 5)])
