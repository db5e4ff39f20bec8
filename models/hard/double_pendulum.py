"""Two bars in a chain, thrown high enough to be chaotic: how far can a run be believed?

Uniform bars of 1 m and 1 kg on two revolute joints, let go from rest above the hinge's level. Two
motions that differ in the last digit part company after a time that only the tolerance shifts; a
run is right up to there, and beyond it right about nothing but constraints and energy.

Scenes
------
thrown
    From rest at 2 rad and 1 rad above the x axis.
"""

from codegen import Model

model = Model("double_pendulum", gravity=(0, -9.81))

upper = model.body("upper", mass=1.0, inertia=1 / 12)
lower = model.body("lower", mass=1.0, inertia=1 / 12)

model.revolute("hinge", model.ground.at(0, 0), upper.at(-0.5, 0))
model.revolute("knee", upper.at(0.5, 0), lower.at(-0.5, 0))

model.scene("thrown", ["gravity"],
            start={upper.phi: 2.0, lower.phi: 1.0, upper.omega: 0.0, lower.omega: 0.0},
            guess={upper.x: -0.2, upper.y: 0.45, lower.x: -0.1, lower.y: 1.3})  # fmt: skip
