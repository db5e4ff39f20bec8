"""A four-bar linkage, the machine of section 5.3 of Haug's book: Hoeken's straight-line linkage.

                        P
                      o
                   .
               C .
               o
            .  |
        B .    |
        o      |
      A o      o D
       ///    ///

The crank AB turns about A (0, 0), the rocker CD about D (2, 0); C is in the middle of the coupler
BP. The proportions AB : AD : BC : CD = 1 : 2 : 2.5 : 2.5 are Hoeken's, published and not the
book's, whose numbers are not to be had (C): over half a turn P runs along the line y = 4 m, and
meets it at φ1 = 90°, 180° and 270° exactly. The bars are uniform rods of 1 kg/m, the coupler of
length 2 BC (C).

By Grashof's rule the crank turns all around while shortest + longest ≤ the other two bars. With BC
and CD of 1.4 m each, 1 + 2 > 2.8: the crank stops where B is 2.8 m from D.

Scenes
------
kinematics
    The crank driven: the path of P, and the lock-up with other lengths.
inverse_dynamics
    The torque that turns the crank at constant speed, against gravity.
constant_torque
    A constant torque on the crank, and gravity.
"""

from sympy import pi

from codegen import Model, rectangle, t

model = Model("four_bar", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
AB = model.parameter("AB", 1.0, unit="m", sign="positive")
BC = model.parameter("BC", 2.5, unit="m", sign="positive")
CD = model.parameter("CD", 2.5, unit="m", sign="positive")
AD = model.parameter("AD", 2.0, unit="m", sign="positive")
density = model.parameter("density", 1.0, unit="kg/m", sign="positive")
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
crank_torque = model.parameter("crank_torque", 5.0, unit="N m")

# Uniform rods, with their centres of mass in the middle; x' from A to B, B to P and D to C.
crank = model.body("crank", mass=density * AB, inertia=density * AB**3 / 12)
coupler = model.body("coupler", mass=2 * density * BC, inertia=density * (2 * BC) ** 3 / 12,
                     draw=rectangle(2.08 * BC, 0.2))  # fmt: skip
rocker = model.body("rocker", mass=density * CD, inertia=density * CD**3 / 12)

model.revolute("A", model.ground.at(0, 0), crank.at(-AB / 2, 0))
model.revolute("B", crank.at(AB / 2, 0), coupler.at(-BC, 0))
model.revolute("C", coupler.at(0, 0), rocker.at(CD / 2, 0))
model.revolute("D", model.ground.at(AD, 0), rocker.at(-CD / 2, 0))

model.driver("crank_drive", crank.phi, drive_speed * t)
model.torque("even_torque", on=crank, value=crank_torque)

# About where the bars are at φ1 = 0.
drawn = {crank.x: 0.5, coupler.x: 1.5, coupler.y: 2.45, coupler.phi: 1.37,
         rocker.x: 1.75, rocker.y: 1.22, rocker.phi: 1.77}  # fmt: skip

model.scene("kinematics", drivers=["crank_drive"], guess=drawn, analysis="kinematics")
model.scene("inverse_dynamics", ["gravity"], ["crank_drive"], guess=drawn)
model.scene("constant_torque", ["gravity", "even_torque"], guess=drawn,
            start={crank.phi: 0.0, crank.omega: float(2 * pi)})  # fmt: skip
