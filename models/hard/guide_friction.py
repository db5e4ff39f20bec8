"""A slider-crank whose guide rubs: Coulomb's friction from the guide's own reaction.

    crank 0.3 m · rod 0.9 m · slider on y = 0, weight downwards

The force across the guide contains the weight, the inertia of the rod and what friction itself
adds through the inclined rod; where it changes sign friction does not vanish, it turns.

Scenes
------
running_down
    From 12 rad/s and without a motor: friction turns at every dead centre, and in the end holds
    the machine against the rod's weight.
rocking
    A torque that swings to and fro: the slider sticks while it is small, and else slides.
creeping
    Rocking, with the law made smooth below 1 mm/s.
"""

from sympy import sin

from codegen import Model, t

model = Model("guide_friction", gravity=(0, -9.81))

friction = model.parameter("friction", 0.3, sign="nonnegative")
torque = model.parameter("torque", 4.0, unit="N m")
frequency = model.parameter("frequency", 3.0, unit="rad/s")

r, l = 0.3, 0.9  # noqa: E741 (crank and rod in the book's letters)

crank = model.body("crank", mass=1.0, inertia=0.05)
rod = model.body("rod", mass=1.5, inertia=1.5 * l**2 / 12)
slider = model.body("slider", mass=2.0, inertia=0.01)

model.revolute("bearing", model.ground.at(0, 0), crank)
model.revolute("crank_pin", crank.at(r, 0), rod.at(-l / 2, 0))
model.revolute("wrist_pin", rod.at(l / 2, 0), slider)
guide = model.translational("guide", model.ground, slider, axis=(1, 0))

model.friction("rub", guide, friction)
model.friction("smooth", guide, friction, creep=1e-3)
model.torque("motor", crank, torque * sin(frequency * t))

upright = {crank.phi: 1.5707963267948966, crank.omega: 0.0}
drawn = {rod.x: 0.42, rod.y: 0.15, rod.phi: -0.34, slider.x: 0.85}
model.scene("running_down", ["gravity", "rub"], start={crank.phi: 0.5, crank.omega: 12.0},
            guess={rod.x: 0.7, rod.y: 0.07, rod.phi: -0.16, slider.x: 1.15})  # fmt: skip
model.scene("rocking", ["gravity", "motor", "rub"], start=upright, guess=drawn)
model.scene("creeping", ["gravity", "motor", "smooth"], start=upright, guess=drawn)
