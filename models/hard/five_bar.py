"""Five bars, two parallelograms side by side, the last crank longer by a trifle.

      B0 o-----------o B1----------o B2
         |           |             |
         | 1         | 1           | 1 + excess
         |           |             |
      A0 o        A1 o          A2 o
        ///         ///           ///

With no excess both loops are parallelograms and the machine passes its level position as they do
(see `n_four_bar`). With an excess the second loop misses that position: its motions do not cross
but bend away from one another, within about √excess of it. For a longer crank the machine turns
back; a shorter one swings over and takes the second loop into a contra-parallelogram. The bends are
fast and smooth, and must be followed; they must be neither jumped nor mistaken for a singularity.

Uniform bars of 1 m and 1 kg, gravity along -y; upright at the start, upper joints at +1 m/s (C).

Scenes
------
fall
    The motion from the upright position.
driven
    The first crank turned at constant speed. With an excess, either way, the second loop cannot
    pass: where its crank's pin comes as near to A2 as the bars' lengths differ, it locks up.
"""

from math import pi

from codegen import Model, t

model = Model("five_bar", gravity=(0, -9.81))
excess = model.parameter("excess", 0.0, unit="m")
drive_speed = model.parameter("drive_speed", 2 * pi, unit="rad/s")
last = 1 + excess

cranks = [model.body(f"crank_{k}", mass=1.0, inertia=1 / 12) for k in range(3)]
couplers = [model.body(f"coupler_{k}", mass=1.0, inertia=1 / 12) for k in (1, 2)]
for k, crank in enumerate(cranks):
    length = last if k == 2 else 1.0
    model.revolute(f"A{k}", model.ground.at(k, 0), crank.at(-length / 2, 0))
for k, coupler in enumerate(couplers, 1):
    length = last if k == 2 else 1.0
    model.revolute(f"B{k - 1}", cranks[k - 1].at(0.5, 0), coupler.at(-0.5, 0))
    model.revolute(f"C{k}", cranks[k].at(length / 2, 0), coupler.at(0.5, 0))
model.driver("crank_drive", cranks[0].phi, pi / 2 - drive_speed * t)

guess = {}
for k, crank in enumerate(cranks):
    guess |= {crank.x: k, crank.y: 0.5, crank.phi: pi / 2, crank.vx: 0.5, crank.omega: -1.0}
for k, coupler in enumerate(couplers, 1):
    guess |= {coupler.x: k - 0.5, coupler.y: 1.0, coupler.vx: 1.0}
held = {cranks[0].phi: pi / 2, cranks[0].omega: -1.0}
free = {name: value for name, value in guess.items() if name not in held}
model.scene("fall", ["gravity"], start=held, guess=free)
model.scene("driven", ["gravity"], ["crank_drive"], guess=guess)
