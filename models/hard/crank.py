"""A crank alone: turned very often, very fast, and wound up very far.

A body on a revolute joint at `arm` from its centre of mass.

Scenes
------
turned
    Balanced (arm 0), free: a million turns in a thousand seconds; the angle grows by ωt.
fast
    Arm 1 m and hardly any inertia about the centre of mass: the angle is the poorest independent
    coordinate, x and y are good ones by turns, and the partition changes four times a turn.
wound
    Balanced, a million turns on already, on a washboard: a torque of -k sin φ. What is asked of the
    angle is a part of one turn, however many lie behind it.
unwound
    The same from φ = 0.
"""

from math import pi

from sympy import sin

from codegen import Model

TURNS = 1_000_000

model = Model("crank")

arm = model.parameter("arm", 0.0, unit="m", sign="nonnegative")
J = model.parameter("J", 1.0, unit="kg m^2", sign="positive")
k = model.parameter("k", 20.0, unit="N m")

crank = model.body("crank", mass=1.0, inertia=J)
model.revolute("bearing", model.ground.at(0, 0), crank.at(-arm, 0))
model.torque("washboard", on=crank, value=-k * sin(crank.phi))

wound_up = 2 * pi * TURNS

model.scene("turned", start={crank.phi: 0.0, crank.omega: 2000 * pi})
model.scene("fast", start={crank.phi: 0.0, crank.omega: 100.0}, guess={crank.x: 1.0},
            parameters={arm: 1.0, J: 1e-3})  # fmt: skip
model.scene("wound", ["washboard"], start={crank.phi: wound_up, crank.omega: 10.0})
model.scene("unwound", ["washboard"], start={crank.phi: 0.0, crank.omega: 10.0})
