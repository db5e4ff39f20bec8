"""The film follower of Haug, *Computer-Aided Kinematics and Dynamics*, projects 5.1 and 8.1.

A crank AB of 15 mm drives a coupler whose hook P pulls the film on by one picture a turn; the
rocker CD guides the coupler:

          P
           o            P: hook, 105 mm from B
            `
             `
        D     `
        o-----o C       D at (-30, 45) mm from A
       ///     `
                `
            o----o B
            A
           ///

Masses and inertias are those of project 8.1. The dimensions are not in chapter 8: AB 15, BC 50,
CD 30 mm, D and the hook, 105 mm from B at 2.73° from the line BC, are from one source (B).
Assumed (C): that the linkage is assembled with C to the right of D, where the hook's path has
its straight side; that x' of body 3 runs from B to C, so that a centroid "50 from B" is at C; that
the linkage lies flat, without gravity; both drives of the dynamic runs. The book's J3 = 9.2e-8
kg m² looks like a misprint of 9.2e-6, which a rod of 10 g and 105 mm has: the printed value stands,
and ``J3`` is a parameter.

Scenes
------
kinematics
    The crank driven at 2π rad/s: the path of the hook.
inverse_dynamics
    The torque that this takes.
constant_torque
    From rest under a constant torque on the crank.
motor
    From rest with a motor whose torque falls with the speed.
"""

from math import cos, radians, sin

from pint import get_application_registry
from sympy import pi

from codegen import Model, rectangle, t

model = Model("film_follower")
mm = get_application_registry().mm

# Parameters may change from run to run without a new build.
coupler_inertia = model.parameter("J3", 9.2e-8, unit="kg m^2")
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
crank_torque = model.parameter("crank_torque", 1e-6, unit="N m")
stall_torque = model.parameter("stall_torque", 5e-6, unit="N m")
idle_speed = model.parameter("idle_speed", float(4 * pi), unit="rad/s", sign="positive")

# Bodies, with their centres of mass at their origins: crank and rocker in the middle, coupler at C.
crank = model.body("crank", mass=0.0012, inertia=2.25e-8)
arm = [
    (-52, -1.5),
    (0, -2),
    (54, -1),
    (54.9, 5.0),
    (51, 2),
    (0, 2),
    (-52, 1.5),
]  # with the hook, mm
coupler = model.body("coupler", mass=0.01, inertia=coupler_inertia,
                     draw=[(x / 1000, y / 1000) for x, y in arm])  # fmt: skip
rocker = model.body("rocker", mass=0.0025, inertia=4.5e-8)

# x' runs from A to B, from B to C and from C to D.
model.revolute("A", model.ground.at(0 * mm, 0 * mm), crank.at(-7.5 * mm, 0 * mm))
model.revolute("B", crank.at(7.5 * mm, 0 * mm), coupler.at(-50 * mm, 0 * mm))
model.revolute("C", coupler.at(0 * mm, 0 * mm), rocker.at(-15 * mm, 0 * mm))
model.revolute("D", rocker.at(15 * mm, 0 * mm), model.ground.at(-30 * mm, 45 * mm))

# The hook, which no force touches: the studies follow its path.
hook = coupler.at((105 * cos(radians(2.73)) - 50) * mm, 105 * sin(radians(2.73)) * mm)

# For the eye: a film of 35 mm, laid into the plane, with pictures and perforations.
strip = rectangle(35 * mm, 78 * mm, (-35.5 * mm, 106 * mm))
pictures = [rectangle(21 * mm, 15.5 * mm, (-35.5 * mm, y * mm)) for y in (77, 96, 115, 134)]
perforations = [rectangle(2.8 * mm, 2 * mm, (x * mm, (69.2 + 4.75 * k) * mm))
                for k in range(16) for x in (-49.5, -21.5)]  # fmt: skip
model.draw_ground(strip.with_holes(*pictures, *perforations))

# Three ways to drive the crank: by the clock, evenly, and by a motor.
model.driver("crank_drive", crank.phi, drive_speed * t)
model.torque("even_torque", on=crank, value=crank_torque)
model.torque("motor_torque", on=crank, value=stall_torque * (1 - crank.omega / idle_speed))

# About where the parts are at φ1 = 0.
drawn = {crank.x: 0.0075, coupler.y: 0.048, coupler.phi: 1.88,
         rocker.x: -0.015, rocker.y: 0.046, rocker.phi: 3.23}  # fmt: skip
at_rest = {crank.phi: 0.0, crank.omega: 0.0}

model.scene("kinematics", drivers=["crank_drive"], guess=drawn, analysis="kinematics")
model.scene("inverse_dynamics", drivers=["crank_drive"], guess=drawn)
model.scene("constant_torque", ["even_torque"], start=at_rest, guess=drawn)
model.scene("motor", ["motor_torque"], start=at_rest, guess=drawn)
