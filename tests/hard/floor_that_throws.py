"""A ball on a floor that shakes: it is thrown up, lands, and is thrown up again."""

from sympy import sin

from codegen import Model, t

model = Model("floor_that_throws", gravity=(0, -9.81))
e = model.parameter("e", 0.0)
ball = model.particle("ball", mass=1.0)
model.contact("floor", gap=ball.y - 0.1 * sin(20 * t), restitution=e)
start = {ball.x: 0.0, ball.y: 0.0, ball.vx: 0.0}
model.scene("shaken", ["gravity", "floor"], start=start, guess={ball.vy: 3.0})
