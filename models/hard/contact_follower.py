"""An eccentric cam under a free pushrod with a flat face: it lifts off, and comes down again.

The face of the pushrod stands R + e sin φ above the cam's axis while they touch. A spring holds it
down; beyond the speed ω at which m (e ω² - g) is its force at the top, 232 rad/s here, the rod
leaves the cam, and returns with an impact, and with many after it.

Scenes
------
touching
    The cam is driven slowly enough: the contact never opens, its force is a reaction.
thrown
    At more than twice the speed of separation.
"""

from math import pi

from codegen import Model, disc, rectangle, t

model = Model("contact_follower", gravity=(0, -9.81))

omega = model.parameter("omega", 150.0, unit="rad/s")
eccentricity = model.parameter("eccentricity", 0.0025, unit="m")
restitution = model.parameter("restitution", 0.4)
stiffness = model.parameter("stiffness", 1000.0, unit="N/m")

R = 0.0125
length = 0.15

foot = rectangle(2 * R, 0.004, center=(0, 0.002 - length / 2))
cam = model.body("cam", mass=0.3, inertia=4e-5, draw=disc(R, center=(eccentricity, 0)))
pushrod = model.body("pushrod", mass=0.2, inertia=4e-4, draw=[rectangle(0.008, length), foot])

model.revolute("shaft", model.ground.at(0, 0), cam.at(0, 0))
model.translational("guide", model.ground, pushrod, axis=(0, 1))
model.driver("motor", cam.phi, -pi / 2 + omega * t)

# 20 N where the rod is lowest: the seat of the spring is 40 mm off the rod's top there.
seat = R - 0.0025 + length + 0.04
model.spring("spring", model.ground.at(0, seat), pushrod.at(0, length / 2), stiffness,
             free_length=0.06)  # fmt: skip

centre = cam.at(eccentricity, 0)
model.contact("face", gap=pushrod.at(0, -length / 2).y - centre.y - R, restitution=restitution)

low = {pushrod.y: R - 0.0025 + length / 2, pushrod.vy: 0.0}
model.scene("touching", ["gravity", "spring", "face"], ["motor"], start=low)
model.scene("thrown", ["gravity", "spring", "face"], ["motor"], start=low,
            parameters={omega: 600.0})  # fmt: skip
