"""Machines whose energy a run has to explain.

Scenes
------
loaded
    Two particles on a damped spring, one thrown, one pulled by a point that moves.
gusty
    One of the particles meets a gust behind a line.
cancelling, constant
    One of the particles in potentials whose large terms cancel, or with large constants.
arched, rooted, tilted, turning, huge
    It starts where such a potential is flat to its last digit, or the terms are larger still.
waves, ripples
    It meets a step that no force shows, in a potential with a shape of its own.
bouncing
    One of the particles falls on a floor.
swinging
    A pendulum on a driven crank, with friction in its pin that creeps.
"""

from sympy import cos, sin, sqrt, tanh

from codegen import Model, t

model = Model("unbalanced", gravity=(0, -9.81))

force = model.parameter("force", 2.0, unit="N")
p, o = (model.particle(name, mass=1.0) for name in "po")
model.spring("coil", p, o, stiffness=40.0, free_length=1.0, damping=0.5)
model.potential("moving", 15 * (p.x - 0.3 * sin(3 * t)) ** 2 / 2)
model.force("push", p, force * sin(4 * t), force * cos(t))
model.force("gust", p, 1.0, when=p.x > 0.3)

crank = model.body("crank", mass=2.0, inertia=0.3)
bob = model.body("bob", mass=1.0, inertia=0.05)
model.revolute("pivot", model.ground.at(0, 0), crank.at(0, 0))
pin = model.revolute("pin", crank.at(0.5, 0), bob.at(-0.6, 0))
model.driver("motor", crank.phi, 2 * t + 0.3 * sin(5 * t))
model.friction("rub", pin, 0.2, radius=0.05, creep=0.05)
model.scene("loaded", ["gravity", "coil", "moving", "push"], without=["crank", "bob"],
            start={p.x: 0.0, p.y: 0.0, o.x: 1.2, o.y: 0.0, p.vx: 1.0})  # fmt: skip
model.scene("swinging", ["gravity", "rub"], ["motor"], without=["p", "o"],
            start={bob.phi: 0.5})  # fmt: skip
model.scene("gusty", ["gust"], without=["crank", "bob", "o"],
            start={p.x: 0.0, p.y: 0.0, p.vx: 1.0, p.vy: 0.0})  # fmt: skip
model.potential("far", 5 * p.x**2 + 5e9 * (p.y - 1000) ** 2)
model.potential("back", -5e9 * (p.y - 1000.0) ** 2 + 3 * p.y)
model.potential("high", 1e15 + 5 * p.x**2)
model.potential("low", -1e15 + 5 * p.y**2)
for scene, effects in (("cancelling", ["far", "back"]), ("constant", ["high", "low"])):
    model.scene(scene, effects, without=["crank", "bob", "o"],
                start={p.x: 0.5, p.y: 0.2, p.vx: 1.0, p.vy: 0.0})  # fmt: skip
flat = {
    "arched": [3 + 1e8 * (1 - cos(1e-4 * p.x))],
    "rooted": [1 + sqrt(1e16 + 2e8 * p.x**2) - 1e8],
    "tilted": [1 + sqrt(1e16 + 2e8 * p.x**2) - 1e8 + 0.1 * p.y],
    "turning": [1e13 * cos(p.x) + 5 * p.x**2, -1e13 * cos(p.x) + 5 * p.y**2],
    "huge": [1e17 + 5 * p.x**2, -1e17 + 5 * p.y**2],
}
for scene, energies in flat.items():
    effects = [f"{scene}_{k}" for k in range(len(energies))]
    for name, energy in zip(effects, energies, strict=True):
        model.potential(name, energy)
    at = {p.x: 0.5, p.y: 0.2} if len(energies) > 1 else {p.x: 0.0, p.y: 0.0}
    model.scene(scene, effects, without=["crank", "bob", "o"], start={**at, p.vx: 1.0, p.vy: 0.0})
model.contact("floor", gap=p.y, restitution=0.8)
model.scene("bouncing", ["gravity", "floor"], without=["crank", "bob", "o"],
            start={p.x: 0.0, p.y: 1.0, p.vx: 0.0, p.vy: 0.0})  # fmt: skip
step = 0.25 * tanh(1e9 * (p.x - 1.0013))
model.potential("waves", 0.02 * cos(200 * p.x) + step)
model.potential("ripples", 1e-4 * cos(3e4 * p.x) + step)
for scene in ("waves", "ripples"):
    model.scene(scene, [scene], without=["crank", "bob", "o"],
                start={p.x: 0.0, p.y: 0.0, p.vx: 5.0, p.vy: 0.0})  # fmt: skip
