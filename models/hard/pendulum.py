"""A pendulum: the simplest machine with a constraint, for as long as its clock can be read.

Problem A01 of the IFToMM library of multibody benchmarks is the point mass; its closed form is an
elliptic function, so that the phase after two thousand seconds is known to every digit.

Scenes
------
point
    A particle of 1 kg held at 1 m from the hinge, released from rest at the hinge's height on its
    left: two coordinates, one of them independent, and neither of them for long.
bar
    A body on a revolute joint, released as the particle is: its angle stays independent.
"""

from math import pi

from codegen import Model

model = Model("pendulum", gravity=(0, -9.81))

length = model.parameter("length", 1.0, unit="m", sign="positive")

bob = model.particle("bob", mass=1.0)
model.distance("rod", model.ground.at(0, 0), bob, length)

bar = model.body("bar", mass=1.0, inertia=length**2 / 12)
model.revolute("hinge", model.ground.at(0, 0), bar.at(-length / 2, 0))

model.scene("point", ["gravity"], without=[bar], start={bob.y: 0.0, bob.vx: 0.0, bob.vy: 0.0},
            guess={bob.x: -1.0})  # fmt: skip
model.scene("bar", ["gravity"], without=[bob], start={bar.phi: pi, bar.omega: 0.0},
            guess={bar.x: -0.5})  # fmt: skip
