"""A table on more parallel cranks than it needs.

        o--------o--------o--------o
        |        |        |        |
        |        |        |        |
        o        o        o        o
       ///      ///      ///      ///

Two cranks of equal length carry the table and keep it level. The others, as long and as parallel,
repeat what these do: each adds two constraints, of which one is new, for its own coordinates are
three and one turning is left in common. The linkage moves as if they had no say, but how it shares
its load among them is not determined. One that is longer or shorter contradicts the others.

Cranks of 1 m, 1 m apart, 1 kg each, the table of 5 kg with its centre of mass above the middle (C).
`parallel_linkage(cranks)` declares any number of cranks; the file's own has four. With `carrying`
only the first so many reach up to the table; the others turn along with the first, so that with two
of them the machine is the same, and nothing in it is said twice.

Scenes
------
fall
    Let go at 60 degrees under gravity.
inverse_dynamics
    The first crank turned at constant speed.
"""

from math import cos, pi, sin

from codegen import Model, t


def parallel_linkage(cranks: int, carrying: int | None = None) -> Model:
    """The table on so many cranks, of which the first `carrying` carry it; all unless given."""
    carriers = cranks if carrying is None else carrying
    name = f"parallel_linkage_{cranks}" + (f"_{carriers}" if carriers < cranks else "")
    model = Model(name, gravity=(0, -9.81))
    last = model.parameter("last", 1.0, unit="m", sign="positive")  # length of the last crank
    drive_speed = model.parameter("drive_speed", 2 * pi, unit="rad/s")

    middle = (cranks - 1) / 2
    table = model.body("table", mass=5.0, inertia=2.0)
    bars = [model.body(f"crank_{k}", mass=1.0, inertia=1 / 12) for k in range(cranks)]
    for k, bar in enumerate(bars):
        length = last if k == cranks - 1 else 1.0
        model.revolute(f"A{k}", model.ground.at(k, 0), bar.at(-length / 2, 0))
        if k < carriers:
            model.revolute(f"B{k}", bar.at(length / 2, 0), table.at(k - middle, 0))
        else:
            model.constraint(f"along_{k}", bar.phi - bars[0].phi)
    model.driver("crank_drive", bars[0].phi, pi / 3 + drive_speed * t)

    drawn = {table.x: middle + cos(pi / 3), table.y: sin(pi / 3), table.phi: 0.0}
    for k, bar in enumerate(bars):
        drawn |= {bar.x: k + cos(pi / 3) / 2, bar.y: sin(pi / 3) / 2, bar.phi: pi / 3}
    free = {name: value for name, value in drawn.items() if name != bars[0].phi}
    model.scene("fall", ["gravity"], start={bars[0].phi: pi / 3}, guess=free)
    model.scene("inverse_dynamics", ["gravity"], ["crank_drive"], guess=drawn)
    return model


model = parallel_linkage(4)
