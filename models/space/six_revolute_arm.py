"""An arm with six hinges: waist, shoulder, elbow, and three of the wrist.

                     elbow
           shoulder   o----------o--o-[tool]    wrist: turn, bend, turn
              o------`          4  5  6
              |
              | waist
            /////

At the drawing the upper arm and the forearm are stretched along x. Each hinge is driven by a smooth
law; the drivers' reactions are the torques of the motors. Links are declared by a table: place of
the hinge, its axis, mass, centre of mass, moments.

Dimensions and masses are those of no robot in particular (C).

Scenes
------
inverse_dynamics
    The torques of the motors along the motion.
"""

from sympy import pi, sin

from codegen import Model, t

model = Model("six_revolute_arm", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
payload = model.parameter("payload", 2.0, unit="kg", sign="nonnegative")
speed = model.parameter("speed", float(pi), unit="rad/s")

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
LINKS = {
    # name: hinge, axis, mass, centre of mass, principal moments, amplitude of the angle
    "column": ((0, 0, 0), Z, 20.0, (0, 0, 0.3), (0.7, 0.7, 0.2), 1.2),
    "upper_arm": ((0, 0.12, 0.6), Y, 15.0, (0.2, 0.12, 0.6), (0.05, 0.4, 0.4), 0.5),
    "forearm": ((0.45, 0.12, 0.6), Y, 8.0, (0.6, 0.08, 0.6), (0.02, 0.15, 0.15), -0.8),
    "wrist": ((0.7, 0.06, 0.6), X, 2.0, (0.8, 0.06, 0.6), (3e-3, 5e-3, 5e-3), 1.5),
    "hand": ((0.85, 0.06, 0.6), Y, 1.0, (0.88, 0.06, 0.6), (1e-3, 2e-3, 2e-3), 0.9),
    "tool": ((0.92, 0.06, 0.6), X, 0.5 + payload, (1.0, 0.06, 0.58), (4e-3, 5e-3, 4e-3), -2.0),
}

before = model.ground
for k, (name, (hinge, axis, mass, centre, moments, amplitude)) in enumerate(LINKS.items(), 1):
    link = model.body(name, mass, moments, at=centre)
    joint = model.revolute(f"J{k}", before, link, at=hinge, axis=axis)
    model.rotation_driver(f"motor_{k}", joint, amplitude * sin(speed * t) ** 2)
    before = link

model.scene("inverse_dynamics", ["gravity"], [f"motor_{k}" for k in range(1, 7)])
