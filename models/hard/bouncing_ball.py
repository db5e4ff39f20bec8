"""A ball that bounces on a plate, each time with less of its speed, until it rests.

A rigid contact: every impact returns the share e of the speed, so that the flights last e, e², e³ …
of the first. There is no last one: with the height h of the fall the impacts pile up at

    t = √(2h/g) (1 + e)/(1 - e),

and from then on the plate carries the ball's weight.

Scenes
------
dropped
    From rest, 1 m above the plate.
shaken
    The plate moves by A sin Ωt, with accelerations beyond gravity: the ball lies on it, is thrown,
    and comes to lie again.
"""

from sympy import sin

from codegen import Model, disc, t

model = Model("bouncing_ball", gravity=(0, -9.81))

radius = model.parameter("radius", 0.1, unit="m", sign="positive")
restitution = model.parameter("restitution", 0.5)
stroke = model.parameter("stroke", 0.02, unit="m")
frequency = model.parameter("frequency", 30.0, unit="rad/s")

ball = model.particle("ball", mass=0.4, draw=disc(radius))

model.contact("plate", model.ground, ball, direction=(0, 1), free_length=radius,
              restitution=restitution)  # fmt: skip
model.contact("table", gap=ball.y - radius - stroke * sin(frequency * t), restitution=restitution)

aside = {ball.x: 0.0, ball.vx: 0.0}
model.scene("dropped", ["gravity", "plate"], start={**aside, ball.y: 1.1, ball.vy: 0.0})
model.scene("shaken", ["gravity", "table"], start={**aside, ball.y: 0.15, ball.vy: 0.0})
