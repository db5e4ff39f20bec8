"""Parallel four-bar linkages in a row, which pass a singular position twice a turn.

      B0 o-----------o B1----------o B2
         |           |             |
         |           |             |
      A0 o        A1 o          A2 o
        ///         ///           ///

Benchmark A02 of the IFToMM technical committee for multibody dynamics, "N-four-bar mechanism":
2 N + 1 uniform bars of 1 m and 1 kg form N square loops. Gravity acts along -y; the machine starts
upright, with its upper joints at +1 m/s, and turns over and over, twenty level positions in 20 s
with N = 2.

There all bars lie in a line and N constraints cease to be independent: each loop could go on as a
parallelogram or fold into a contra-parallelogram. Velocities are continuous only on the first.

`n_four_bar(N)` declares the machine with any number of loops; the file's own has two.

Scenes
------
fall
    The motion from the upright position.
driven
    The first crank turned at constant speed, level at the start of every half turn.
"""

from math import pi

from codegen import Model, t


def n_four_bar(loops: int) -> Model:
    """The machine with `loops` square loops."""
    model = Model(f"n_four_bar_{loops}", gravity=(0, -9.81))
    drive_speed = model.parameter("drive_speed", 2 * pi, unit="rad/s")

    # Uniform rods of 1 m and 1 kg, with their centres of mass in the middle; x' along the bar.
    cranks = [model.body(f"crank_{k}", mass=1.0, inertia=1 / 12) for k in range(loops + 1)]
    couplers = [model.body(f"coupler_{k}", mass=1.0, inertia=1 / 12) for k in range(1, loops + 1)]
    for k, crank in enumerate(cranks):
        model.revolute(f"A{k}", model.ground.at(k, 0), crank.at(-0.5, 0))
    for k, coupler in enumerate(couplers, 1):
        model.revolute(f"B{k - 1}", cranks[k - 1].at(0.5, 0), coupler.at(-0.5, 0))
        model.revolute(f"C{k}", cranks[k].at(0.5, 0), coupler.at(0.5, 0))
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
    return model


model = n_four_bar(2)
