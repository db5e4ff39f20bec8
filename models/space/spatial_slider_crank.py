"""The spatial slider-crank of Haug, *Computer-Aided Kinematics and Dynamics*, section 12.2.

A crank turns about an axis parallel to x, at A (0, 0.1, 0.12). Its pin B carries a ball joint, and
a rod moves the slider C along the x axis, which lies below and beside the crank:

       z
       |      o B
       |     /   `-._  rod, 0.3 m
       |    o A       `-._
       |   (0.1, 0.12)     `-._
       |                        `o
      -+---------------------[slider]--------- x
     y ,`                       C

A rod shorter than |OA| + |AB| = 0.236205 m does not let the crank turn.

Dimensions, masses and inertias agree with the book's. Model 1 has the rod as a body; it is held by
a cross at C, with one axis along the slider's line. Model 2 has a distance in its place. At the
start the pin is above A; the crank turns about -x.

Deduced rather than printed (B): the rod's moments are 4e-4 about its line and 4e-3 kg m² across.
The torques of the book's figures follow from 4e-3 along and 4e-4 across, with the third axis at
4e-3.

Scenes
------
kinematics
    The crank driven at 2π rad/s.
inverse_dynamics, inverse_dynamics_without_rod
    Section 12.2.3: the torque that drives it, by models 1 and 2. Rods of 0.30, 0.27 and 0.24 m.
free, free_without_rod
    Section 12.2.4: it runs freely from 6 rad/s, by models 1 and 2.
"""

from sympy import pi

from codegen import Model, t

model = Model("spatial_slider_crank", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
length = model.parameter("length", 0.3, unit="m", sign="positive")
speed = model.parameter("speed", float(2 * pi), unit="rad/s")
along = model.parameter("J_along", 4e-4, unit="kg m^2", sign="positive")
across = model.parameter("J_across", 4e-3, unit="kg m^2", sign="positive")

# Bodies at the drawing, with their centres of mass at their origins.
crank = model.body("crank", 0.12, (1e-4, 1e-5, 1e-4), at=(0, 0.1, 0.12), axes=(pi / 2, 0, 0))
rod = model.body("rod", 0.5, (along, across, 4e-3), at=(0.1, 0.05, 0.1),
                 axes=((0.2, -0.1, -0.2), (0, 2, -1)))  # fmt: skip
slider = model.body("slider", 2.0, (1e-4, 1e-4, 1e-4), at=(0.2, 0, 0))
pin = crank.at(0, 0.08, 0)

hinge = model.revolute("A", model.ground, crank, at=(0, 0.1, 0.12), axis=(1, 0, 0))
model.spherical("B", pin, rod.at(-length / 2, 0, 0))
model.universal("C", rod.at(length / 2, 0, 0), slider,
                axes=(rod.along(0, 1, 0), slider.along(1, 0, 0)))  # fmt: skip
model.distance("BC", pin, slider, length)
model.translational("D", model.ground, slider, at=(0.2, 0, 0), axis=(1, 0, 0))
model.rotation_driver("drive", hinge, -speed * t)

running = {hinge.angle: 0.0, hinge.rate: -6.0}
model.scene("kinematics", drivers=["drive"], without=["BC"], analysis="kinematics")
model.scene("inverse_dynamics", ["gravity"], ["drive"], without=["BC"])
model.scene("inverse_dynamics_without_rod", ["gravity"], ["drive"], without=[rod])
model.scene("free", ["gravity"], without=["BC"], start=running)
model.scene("free_without_rod", ["gravity"], without=[rod], start=running)
