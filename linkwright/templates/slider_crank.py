"""NAME: a slider-crank mechanism, a flywheel that drives a press against a spring.

           B
         o
       /    ` .
    A o         o C [slider] ~~~~~~|
   ///         ///////////////////

    linkwright check NAME.py                                   is it sound?
    linkwright draw NAME.py --out NAME.png                     what does it look like?
    linkwright simulate NAME.py --t-end 2                      how does it move?
    linkwright report NAME.py --t-end 2 --out NAME.html        can I watch it, in a browser?
    linkwright inverse NAME.py --scene driven --t-end 1        what does it take to drive it?

Units are SI: m, kg, s, N, rad.

Scenes
------
running
    A constant torque turns the crank; the spring and the friction of the slider brake it.
driven
    A motor turns the crank at constant speed.
"""

from math import pi

from linkwright import Model, t

model = Model("NAME")  # it lies in a horizontal plane: Model("NAME", gravity=(0, -9.81)) has weight

# A parameter may change from run to run without a new build: --set torque=3
throw = model.parameter("throw", 0.05, unit="m", sign="positive")
rod_length = model.parameter("rod_length", 0.20, unit="m", sign="positive")
torque = model.parameter("torque", 1.0, unit="N m")
friction = model.parameter("friction", 8.0, unit="N s/m", sign="nonnegative")
stiffness = model.parameter("stiffness", 400.0, unit="N/m", sign="nonnegative")
speed = model.parameter("speed", 4 * pi, unit="rad/s")

# Bodies. The origin of a body is its centre of mass; its coordinates are x, y and phi, its
# velocities vx, vy and omega.
crank = model.body("crank", mass=2.0, inertia=0.02)  # with a flywheel, its centre on the shaft
rod = model.body("rod", mass=0.4, inertia=0.4 * 0.20**2 / 12)
slider = model.body("slider", mass=1.0, inertia=1e-3)

# Joints connect points, each given in the frame of its body. A translational joint lets the slider
# move along an axis, and keeps it from turning.
model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
model.revolute("B", crank.at(throw, 0), rod.at(-rod_length / 2, 0))
model.revolute("C", rod.at(rod_length / 2, 0), slider.at(0, 0))
model.translational("guide", model.ground.at(0, 0), slider.at(0, 0), axis=(1, 0))

# Effects exert forces. A value may depend on coordinates, velocities, parameters and the time t.
model.torque("drive", on=crank, value=torque)
model.force("slide_friction", on=slider, fx=-friction * slider.vx)
model.spring("spring", model.ground.at(0.5, 0), slider.at(0, 0), stiffness, free_length=0.3)

# Drivers prescribe a motion.
model.driver("motor", crank.phi, pi / 3 + speed * t)

# A guess says about where the bodies are at the start; assembly moves them until the joints close.
drawn = {rod.x: 0.12, rod.y: 0.02, rod.phi: -0.2, slider.x: 0.22}

# A scene names the effects and drivers that act. Its start values hold exactly.
brakes = ["slide_friction", "spring"]
model.scene("running", effects=["drive", *brakes], guess=drawn,
            start={crank.phi: pi / 3, crank.omega: 4 * pi})  # fmt: skip
model.scene("driven", effects=brakes, drivers=["motor"], guess=drawn)
