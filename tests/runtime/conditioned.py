"""Elements whose numbers are parameters: what each asks of them is judged before each run.

Scenes
------
turned
    Two gears on bearings, one of them driven; a driven cam lifts a flat follower and a roller.
thrown
    A particle on a spring rubs on the ground and falls on a floor.
hung
    The particle at rest on the spring alone.
"""

from sympy import cos

from codegen import Model, alpha, t

model = Model("conditioned", gravity=(0, -9.81))

r1, r2 = model.parameter("r1", 0.2, "m"), model.parameter("r2", 0.3, "m")
one, other, cam = (model.body(name, mass=1.0, inertia=1.0) for name in ("one", "other", "cam"))
model.revolute("A", model.ground.at(0, 0), one.at(0, 0))
model.revolute("B", model.ground.at(0.5, 0), other.at(0, 0))
model.gear("mesh", one.at(0, 0), other.at(0, 0), r1, r2)
model.driver("motor", one.phi, 0.3 * t)

eccentricity = model.parameter("eccentricity", 0.01, "m")
follower = model.body("follower", mass=1.0, inertia=1.0)
model.revolute("C", model.ground.at(0, 0), cam.at(0, 0))
model.driver("turn", cam.phi, 0.2 * t)
model.translational("guide", model.ground.at(0, 0), follower.at(0, 0), axis=(0, 1))
profile = cam.polar(0.1 + eccentricity * cos(alpha))
model.cam_flat_follower("lift", profile, follower.at(0, 0), axis=(1, 0))
width, depth = model.parameter("width", 0.02, "m"), model.parameter("depth", 0.004, "m")
roller = model.body("roller", mass=1.0, inertia=1.0)
model.translational("rail", model.ground.at(0, 0), roller.at(0, 0), axis=(1, 0))
waves = cam.polar(0.05 + depth * cos(4 * alpha))
model.cam_follower("roll", waves, roller.circle(width))

stiffness, shift = model.parameter("stiffness", 100.0), model.parameter("shift", 0.0)
pressing, gain = model.parameter("pressing", 5.0), model.parameter("gain", 1.0)
mu, mu_static = model.parameter("mu", 0.2), model.parameter("mu_static", 0.3)
e, where = model.parameter("e", 0.5), model.parameter("where", 1.0)
p = model.particle("p", mass=gain * 2 - 1)
model.spring("coil", model.ground.at(0, 1), p, stiffness=stiffness + shift, free_length=0.5)
model.dry_friction("rub", slip=p.vx, normal=pressing - shift, coefficient=mu, static=mu_static)
model.contact("floor", gap=p.y, restitution=e)
table = model.table("table", [0, 1, 2, 3], [1, 2, 1, 3])
model.force("push", p, table(where))

machines = ["one", "other", "cam", "follower", "roller"]
model.scene("turned", drivers=["motor", "turn"], without=["p"], guess={roller.x: 0.074})
model.scene("thrown", ["gravity", "coil", "rub", "floor", "push"], without=machines,
            start={p.x: 0.0, p.y: 0.5})  # fmt: skip
model.scene("hung", ["gravity", "coil"], without=machines, start={p.x: 0.1, p.y: 0.5})
