"""Bodies that strike each other: several at once, in a corner, between walls, on a rubbing base.

Scenes
------
cradle
    A ball against two that touch.
corner
    A ball in a right-angled corner.
fitting
    A ball pushed to and fro between two walls without clearance.
tray
    A block slides on a tray, which sticks to the ground; at the tray's end it strikes a stop.
arms
    A double pendulum between a floor under its tip and a wall beside its elbow.
"""

from sympy import sin, sqrt

from codegen import Model, t

model = Model("colliding", gravity=(0, -9.81))

e = model.parameter("e", 0.5)
push = model.parameter("push", 30.0, unit="N")

length = model.parameter("length", 1.0, unit="m")  # of the ball's room less its own

balls = [model.particle(f"ball{k}", mass=1.0) for k in range(3)]
for k in range(2):
    model.contact(f"pair{k}", gap=balls[k + 1].x - balls[k].x - 0.1, restitution=e)
still = {c: 0.0 for ball in balls for c in (ball.x, ball.y, ball.vx, ball.vy)}
model.scene("cradle", ["pair0", "pair1"],
            start=still | {balls[0].x: -1.0, balls[0].vx: 1.0, balls[1].x: 0.1,
                           balls[2].x: 0.2})  # fmt: skip

ball = balls[0]
model.contact("left", gap=(ball.x + ball.y) / sqrt(2), restitution=e)
model.contact("right", gap=(ball.y - ball.x) / sqrt(2), restitution=e)
model.scene("corner", ["gravity", "left", "right"], start=still | {ball.y: 1.0})

model.contact("here", gap=ball.x, restitution=e)
model.contact("there", gap=1 - ball.x - length, restitution=e)
model.force("shove", ball, push * sin(3 * t))
model.scene("fitting", ["shove", "here", "there"], start=still)

tray = model.body("tray", mass=1.0, inertia=0.01)
block = model.body("block", mass=2.0, inertia=0.01)
model.translational("rail", model.ground, tray, axis=(1, 0))
groove = model.translational("groove", tray, block, axis=(1, 0))
model.friction("rubs", groove, 0.3)
model.dry_friction("sticks", slip=tray.vx, normal=3 * 9.81, coefficient=0.3)
model.force("pull", block, push * sin(3 * t))
model.contact("stop", gap=1 - (block.x - tray.x), restitution=e)
model.scene("tray", ["gravity", "pull", "rubs", "sticks", "stop"],
            start={tray.x: 0.0, tray.vx: 0.0, block.x: 0.0, block.vx: 0.0})  # fmt: skip

arm, forearm = (model.body(name, mass=1.0, inertia=0.1) for name in ("arm", "forearm"))
model.revolute("shoulder", model.ground.at(0, 0), arm.at(-0.5, 0))
model.revolute("elbow", arm.at(0.5, 0), forearm.at(-0.5, 0))
model.contact("floor", gap=forearm.at(0.5, 0).y + 1.2, restitution=0.5)
model.contact("wall", gap=arm.at(0.5, 0).x + 0.2, restitution=0.9)
model.scene("arms", ["gravity", "floor", "wall"],
            start={arm.phi: 0.5, forearm.phi: 0.2, arm.omega: 0.0, forearm.omega: 0.0})  # fmt: skip
