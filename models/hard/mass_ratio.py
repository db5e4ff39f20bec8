"""A four-bar linkage whose coupler is almost nothing, or almost everything.

A Grashof linkage with bars of 1, 3, 3 and 3 m, crank and rocker uniform bars of 1 kg; the coupler's
mass is `ratio` kg. In the system of equations of motion the coupler's rows stand beside the others
with numbers `ratio` times as large, and an elimination that divides by the wrong ones loses as many
digits as the ratio has.

Scenes
------
turning
    Under gravity from φ1 = 0, fast enough to turn all around whatever the coupler weighs.
"""

from codegen import Model

model = Model("mass_ratio", gravity=(0, -9.81))

AB, BC, CD, AD = 1.0, 3.0, 3.0, 3.0
ratio = model.parameter("ratio", 1e-8, unit="kg", sign="positive")

crank = model.body("crank", mass=1.0, inertia=AB**2 / 12)
coupler = model.body("coupler", mass=ratio, inertia=ratio * BC**2 / 12)
rocker = model.body("rocker", mass=1.0, inertia=CD**2 / 12)

model.revolute("A", model.ground.at(0, 0), crank.at(-AB / 2, 0))
model.revolute("B", crank.at(AB / 2, 0), coupler.at(-BC / 2, 0))
model.revolute("C", coupler.at(BC / 2, 0), rocker.at(CD / 2, 0))
model.revolute("D", model.ground.at(AD, 0), rocker.at(-CD / 2, 0))

# Open assembly: the coupler lies above the line of centres at φ1 = 0.
drawn = {crank.x: 0.5, coupler.x: 2.0, coupler.y: 1.4, coupler.phi: 1.23,
         rocker.x: 2.5, rocker.y: 1.4, rocker.phi: 1.9}  # fmt: skip

model.scene("turning", ["gravity"], start={crank.phi: 0.0, crank.omega: 12.0}, guess=drawn)
