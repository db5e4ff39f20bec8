"""A block on a moving belt, held by a spring: it rides along, tears loose, and catches up again.

         k
    |~~~~~~~[ m ]
    ===================>  belt

While it sticks the spring is drawn out with the speed v of the belt, up to k s = μ_s m g. Then it
slides, by m s̈ = μ m g - k s, until its speed is that of the belt once more. With w = √(k/m) and
u = (μ_s - μ) m g/k it slides for 2 (π - arctan(u w/v))/w, and rides for 2 u/v.

Scenes
------
riding
    Coulomb's law, from the spring's free length, with the speed of the belt.
creeping
    The same with the law that is made smooth below 1 mm/s, and knows one coefficient only.
"""

from codegen import Model, bar, disc, rectangle

model = Model("belt_block")

mass = model.parameter("mass", 1.0, unit="kg")
stiffness = model.parameter("stiffness", 100.0, unit="N/m")
kinetic = model.parameter("kinetic", 0.2)
static = model.parameter("static", 0.3)
speed = model.parameter("speed", 0.1, unit="m/s")

block = model.body("block", mass=mass, inertia=0.01, draw=rectangle(0.2, 0.12))
drums = [disc(0.1, (x, -0.18)) for x in (-0.4, 0.6)]
model.draw_ground([*drums, bar(1, 0.24, (-0.4, -0.18)).with_holes(bar(1, 0.21, (-0.4, -0.18)))])
anchor = model.ground.at(-1, 0)

model.translational("track", model.ground, block, axis=(1, 0))
model.spring("spring", anchor, block, stiffness, free_length=1.0)

weight = 9.81 * mass
model.dry_friction("belt", slip=block.vx - speed, normal=weight,
                   coefficient=kinetic, static=static)  # fmt: skip
model.dry_friction("smooth", slip=block.vx - speed, normal=weight,
                   coefficient=kinetic, creep=1e-3)  # fmt: skip

riding = {block.x: 0.0, block.vx: 0.1}
model.scene("riding", ["spring", "belt"], start=riding)
model.scene("creeping", ["spring", "smooth"], start=riding)
