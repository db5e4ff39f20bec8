"""The cam-driven valve of an engine of Haug, *Computer-Aided Kinematics and Dynamics*, section 8.5.

An eccentric circular cam lifts a pushrod with a flat face; the pushrod's top turns a rocker arm,
and the arm's other end presses a valve open against its spring:

          A
     o----^----o   rocker, 6 + 6 cm
     |         |
     | pushrod | valve
     | 15 cm   |
    ---        ]
    ( )  cam   ] spring, 6 cm when closed
     B        ---

Masses and inertias are table 8.5.1; cam, pushrod, rocker and free length of the spring are from
sections 5.6 and 8.5. Deduced from the inertias, which are those of thin rods: the rocker's equal
arms. Deduced from the pushrod being highest after half a turn: the eccentric points down at t = 0.
Chosen, as every choice from 4.39 to 7.23 cm has the book's outcomes: the spring is 6 cm long when
the valve is closed. Chosen without effect on any force: the rocker lies level then, and the
valve's stem is a thin rod. Gravity, about 2 N at the cam, is left out as in the book.

Scenes
------
kinematics
    Section 5.6: lift of the valve for a turn of the cam, for any eccentricity.
inverse_dynamics
    Section 8.5: the force between cam and pushrod, which cannot be negative; figures 8.5.1, 8.5.2.
free_follower
    Beyond the book: the pushrod may leave the cam, and what a negative force announces happens.
"""

from math import sqrt

import pint

from codegen import Model, disc, t

unit = pint.application_registry
cm, gram = unit.cm, unit.gram

model = Model("valve_lifter")

stiffness = model.parameter("k", 25 * unit("N/cm"), unit="N/m", sign="positive")
eccentricity = model.parameter("e", 0.25 * cm, unit="m", sign="positive")
speed = model.parameter("speed", 3000 * unit.rpm, unit="rad/s")
contact_stiffness = model.parameter("K", 2e7, unit="N/m", sign="positive")
contact_damping = model.parameter("C", 300.0, unit="N s/m", sign="nonnegative")

radius, arm, rod, stem = 1.25 * cm, 6 * cm, 15 * cm, sqrt(12 * 800 / 60) * cm
closed, level = 6 * cm, radius - 0.25 * cm + rod

cam = model.body("cam", mass=30 * gram, inertia=15 * gram * cm**2,
                 draw=disc(radius.to("m").magnitude, center=(0, -eccentricity)))  # fmt: skip
pushrod = model.body("pushrod", mass=120 * gram, inertia=2250 * gram * cm**2)
rocker = model.body("rocker", mass=150 * gram, inertia=1800 * gram * cm**2)
half = (stem / 2).to("m").magnitude  # of the stem; the head closes the seat
valve = model.body("valve", mass=60 * gram, inertia=800 * gram * cm**2,
                   draw=[(-0.003, half), (-0.003, 0.008 - half), (-0.016, -half),
                         (0.016, -half), (0.003, 0.008 - half), (0.003, half)])  # fmt: skip
ground = model.ground

model.revolute("B", ground.at(0, 0), cam.at(0, 0))
model.revolute("A", ground.at(arm, level), rocker.at(0, 0))
model.translational("pushrod_guide", ground, pushrod, axis=(0, 1))
model.translational("valve_guide", ground.at(2 * arm, 0), valve, axis=(0, 1))
model.revolute_translational("pushrod_top", rocker, pushrod.at(0, rod / 2))
model.revolute_translational("valve_top", rocker, valve.at(0, stem / 2))

# The cam carries the flat face of the pushrod, or pushes it while they touch.
eccentric, face = cam.circle(radius, center=(0, -eccentricity)), pushrod.at(0, -rod / 2)
lift = model.cam_flat_follower("lift", eccentric, face)
model.contact(
    "touch",
    gap=face.y - cam.at(0, -eccentricity).y - radius.to("m").magnitude,
    stiffness=contact_stiffness,
    damping=contact_damping,
    may_pull=False,
)
model.alternatives("follower", {"fixed": [lift], "free": ["touch"]})

seat = ground.at(2 * arm, level - stem / 2 - closed)
model.spring("valve_spring", seat, valve, stiffness=stiffness, free_length=9 * cm)

model.driver("camshaft", cam.phi, speed * t)

shut = {
    pushrod.y: level - rod / 2,
    rocker.x: arm,
    rocker.y: level,
    valve.x: 2 * arm,
    valve.y: level - stem / 2,
}

model.scene("kinematics", drivers=["camshaft"], guess=shut, analysis="kinematics")
model.scene("inverse_dynamics", ["valve_spring"], ["camshaft"], guess=shut)
model.scene("free_follower", ["valve_spring"], ["camshaft"], fidelity={"follower": "free"},
            start={pushrod.y: level - rod / 2, pushrod.vy: 0}, guess=shut)  # fmt: skip
