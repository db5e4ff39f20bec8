"""A motion law whose acceleration jumps.

A cart moves along x by a law: at rest for one second, one second of acceleration, one of braking,
at rest again. A load hangs on it by a spring. Position and velocity of the law are continuous, its
acceleration jumps three times, and no step may reach across.

Scenes
------
aboard
    The load as seen from the cart, where the cart's acceleration is a force on it: three jumps, and
    a second of what they leave behind.
"""

from sympy import Piecewise

from codegen import Model, t

model = Model("jump_law")

acceleration = model.parameter("acceleration", 2.0, unit="m/s^2")
stiffness = model.parameter("stiffness", 400.0, unit="N/m", sign="positive")
mass = model.parameter("mass", 1.0, unit="kg", sign="positive")

load = model.body("load", mass=mass, inertia=1.0)
model.translational("guide", model.ground, load, axis=(1, 0))
model.spring("spring", model.ground, load, stiffness=stiffness, free_length=0.5)

cart = acceleration * Piecewise((0, t < 1), (1, t < 2), (-1, t < 3), (0, True))
model.force("inertia", on=load, fx=-mass * cart)

model.scene("aboard", ["spring", "inertia"], start={load.x: 0.5, load.vx: 0.0})
