"""The spatial four-bar of Haug, *Computer-Aided Kinematics and Dynamics*, section 12.3.

A wheel turns about the x axis, a rocker swings about an axis parallel to y, and a long link joins
its pin B to the rocker's tip C:

      B o (0, 0, 2)               z
        | `-._  link, 12.2 m      |
        |      `-._               |
        |           `-._          +------ x, axis of the wheel
      A o               `o C       `
        wheel            /          ` y
                        / rocker, 7.4 m
                       /
                      o D (-4, -8.5, 0), axis parallel to y

Model 1 has the link as a body, on a universal joint at B and a ball joint at C. Model 2 has a
distance in its place.

Dimensions, masses and moments agree with the book's. Assumed (C): the book has 0 for each third
moment, which no body has; here it is the larger one, as of slender rods and a wheel.

Scenes
------
inverse_dynamics, inverse_dynamics_without_link
    Section 12.3: the torque that drives the wheel at π rad/s, by models 1 and 2.
"""

from sympy import pi

from codegen import Model, disc, extruded, t

model = Model("spatial_four_bar", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
speed = model.parameter("speed", float(pi), unit="rad/s")

# Bodies at the drawing, with their centres of mass at their origins; y' is along link and rocker.
B, D = (0, 0, 2), (-4, -8.5, 0)
BC, DC = (-7.491, -8.5, 4.525), (-3.491, 0, 6.525)
cross = (0.75, -0.662, 0)  # the axis of the universal joint on the wheel
rim = disc(2.2).with_holes(*(disc(0.5, place) for place in ((1, 0), (-1, 0), (0, -1), (0, 1))))
wheel = model.body("wheel", 2.0, (4.0, 2.0, 2.0),
                   draw=extruded(rim, 0.15, axes=((0, 1, 0), (0, 0, 1))))  # fmt: skip
link = model.body("link", 1.0, (12.4, 0.01, 12.4), at=(-3.7455, -4.25, 4.2625), axes=(cross, BC))
rocker = model.body("rocker", 1.0, (4.54, 0.01, 4.54), at=(-5.7455, -8.5, 3.2625),
                    axes=((0, 1, 0), DC))  # fmt: skip
pin, tip = wheel.at(*B), rocker.at(0, 3.7, 0)

hinge = model.revolute("A", model.ground, wheel, at=(0, 0, 0), axis=(1, 0, 0))
model.universal("B", pin, link.at(0, -6.1, 0), axes=(wheel.along(*cross), link.along(0, 0, 1)))
model.spherical("C", link.at(0, 6.1, 0), tip)
model.distance("BC", pin, tip, 12.2)
model.revolute("D", model.ground.at(*D), rocker.at(0, -3.7, 0),
               axis=(model.ground.along(0, 1, 0), rocker.along(1, 0, 0)))  # fmt: skip
model.rotation_driver("drive", hinge, speed * t)

model.scene("inverse_dynamics", ["gravity"], ["drive"], without=["BC"])
model.scene("inverse_dynamics_without_link", ["gravity"], ["drive"], without=[link])
