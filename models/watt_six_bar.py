"""A Watt six-bar linkage: a four-bar linkage whose coupler and rocker carry two links more.

                   G o
                   /   \\
                  /      \\
              E o          o F
               /  `.     .'  |
              /     `o C     |
             /   . '   \\    |
          B o .          \\  |
          .                \\|
        A o                 o D
         ///               ///

The crank AB turns about A (0, 0), the rocker about D (3, 0). Coupler BCE and rocker DCF are
triangles with a common pin C; the links EG and GF close the second loop. BC is 3 m, DC 2.5 m, the
links are 2 m long. By Grashof's rule the crank of 1 m turns all around. Dimensions and masses are
those of no machine in particular (C).

Scenes
------
kinematics
    The crank driven at constant speed.
inverse_dynamics
    The torque that turns it so, against gravity and a spring at G, and the forces in the pins.
constant_torque
    A constant torque on the crank, gravity, and the spring.
"""

from sympy import pi

from codegen import Model, t

model = Model("watt_six_bar", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
crank_torque = model.parameter("crank_torque", 60.0, unit="N m")
stiffness = model.parameter("stiffness", 150.0, unit="N/m", sign="nonnegative")

# Centres of mass in the middle of bars, and in the centroid of triangles.
crank = model.body("crank", mass=2.0, inertia=1.5)
coupler = model.body("coupler", mass=6.0, inertia=4.0)
rocker = model.body("rocker", mass=5.0, inertia=3.0)
left = model.body("left", mass=2.0, inertia=0.7)
right = model.body("right", mass=2.0, inertia=0.7)

model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
model.revolute("B", crank.at(1, 0), coupler.at(-2.2, -0.5))
model.revolute("C", coupler.at(0.8, -0.5), rocker.at(0.6, 0.3))
model.revolute("D", model.ground.at(3, 0), rocker.at(-1.9, 0.3))
model.revolute("E", coupler.at(1.4, 1.0), left.at(-1, 0))
model.revolute("F", rocker.at(1.3, -0.6), right.at(-1, 0))
model.revolute("G", left.at(1, 0), right.at(1, 0))

model.driver("crank_drive", crank.phi, drive_speed * t)
model.torque("even_torque", on=crank, value=crank_torque)
model.spring("tie", model.ground.at(1, 6), left.at(1, 0), stiffness, free_length=1.0)

# About where the bars are at φ1 = 0.
drawn = {coupler.x: 2.2, coupler.y: 2.2, coupler.phi: 1.0, rocker.x: 2.7, rocker.y: 1.8,
         rocker.phi: 1.7, left.x: 2.0, left.y: 4.5, left.phi: 1.5, right.x: 3.0, right.y: 4.5,
         right.phi: 2.0}  # fmt: skip

model.scene("kinematics", drivers=["crank_drive"], guess=drawn, analysis="kinematics")
model.scene("inverse_dynamics", ["gravity", "tie"], ["crank_drive"], guess=drawn)
model.scene("constant_torque", ["gravity", "tie", "even_torque"], guess=drawn,
            start={crank.phi: 0.0, crank.omega: float(2 * pi)})  # fmt: skip
