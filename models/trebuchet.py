"""A trebuchet with a hinged counterweight and a sling, from its trigger to the ball's landing.

                                        o B
                                     . [ ]
                                  .    [ ] counterweight
                              o A
                           .  /\\
               beam     .    /  \\
                     .      /    \\
                  .        /      \\
          tip  o----------o ball---\\----- y = 0

The beam turns about A (0, 5), 6.5 m from its tip and 1.5 m from the hinge B of the counterweight.
Everything starts at rest, tip, sling and ball on the trough y = 0. The beam draws the ball along
the trough until the sling lifts it off; the ball swings about the tip, the sling lets go where its
angle from the line of the long arm has fallen to `release_angle`, and the ball flies until it lands
at y = 0, while beam and counterweight swing on. All that is one run: the trough is a rigid contact,
which opens by itself, and the sling a joint that is released.

Dimensions and masses are those of no machine in particular (C). The sling is a massless link; its
reaction shows that it pulls at all times.

Scenes
------
throw
    From the trigger to the landing.
"""

from math import asin

from sympy import And, atan2, cos, pi, sin

from codegen import Model, bar, disc, rectangle

model = Model("trebuchet", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
ball_mass = model.parameter("ball_mass", 50.0, unit="kg", sign="positive")
load = model.parameter("load", 4000.0, unit="kg", sign="positive")
sling_length = model.parameter("sling_length", 5.5, unit="m", sign="positive")
release_angle = model.parameter("release_angle", 0.6, unit="rad")

# The beam's centre of mass is its middle; x' from the tip to B.
tapered = [(-4, -0.1), (2.5, -0.25), (4.2, -0.2), (4.2, 0.2), (2.5, 0.25), (-4, 0.1)]
beam = model.body("beam", mass=300.0, inertia=1600.0, draw=tapered)
box = [rectangle(1.6, 1.4, (0, -0.2)), bar(1.2, 0.25, angle=pi / 2)]
counterweight = model.body("counterweight", mass=load, inertia=700.0, draw=box)
ball = model.particle("ball", mass=ball_mass, draw=disc(0.28))
tip = beam.at(-4, 0)

# For the eye: the frame, two legs and what they stand on.
legs = [bar(5.4, 0.4, (x, 0), atan2(5, -x)) for x in (-2, 2)]
model.draw_ground([*legs, rectangle(6, 0.3, (0, -0.15)), rectangle(2.6, 0.25, (0, 1.8))])

model.revolute("A", model.ground.at(0, 5), beam.at(2.5, 0))
model.revolute("B", beam.at(4, 0), counterweight.at(0, 1.2))
sling = model.distance("sling", tip, ball, sling_length)
model.contact("trough", model.ground, ball, direction=(0, 1), restitution=0)

# Angle of the sling from the line of the long arm, from its components along and across x'.
dx, dy, c, s = ball.x - tip.x, ball.y - tip.y, cos(beam.phi), sin(beam.phi)
angle = atan2(dx * s - dy * c, -dx * c - dy * s)
model.release(sling, when=angle < release_angle)
model.label(angle < release_angle, "sling lets go")

resting = {beam.phi: asin(5 / 6.5), beam.omega: 0.0, counterweight.phi: 0.0,
           counterweight.omega: 0.0, ball.y: 0.0, ball.vy: 0.0}  # fmt: skip
drawn = {ball.x: 1.3}

model.scene("throw", ["gravity", "trough"], start=resting, guess=drawn,
            outputs=["default", "force(trough)"],
            until={"landed": And(ball.y <= 0, ball.x > 20)})  # fmt: skip
