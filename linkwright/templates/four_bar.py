"""NAME: a four-bar linkage; its crank turns all around, its rocker swings.

              C
            . o
         .     `
    B o         `
     /           `
  A o             o D
   ///           ///

    linkwright check NAME.py                                   is it sound?
    linkwright draw NAME.py --out NAME.png                     what does it look like?
    linkwright simulate NAME.py --t-end 5                      how does it move?
    linkwright report NAME.py --t-end 5 --out NAME.html        can I watch it, in a browser?
    linkwright inverse NAME.py --scene driven --t-end 1        what does it take to drive it?
    linkwright equilibrium NAME.py --scene swing               where does it rest?

Units are SI: m, kg, s, N, rad.

Scenes
------
swing
    The crank is let go at rest; gravity moves it, and the bearing of the crank brakes it.
driven
    A motor turns the crank at constant speed.
"""

from math import pi

from linkwright import Model, t

# Gravity acts in scenes that name the effect "gravity".
model = Model("NAME", gravity=(0, -9.81))

# A parameter may change from run to run without a new build: --set AB=0.12
AB = model.parameter("AB", 0.10, unit="m", sign="positive")
BC = model.parameter("BC", 0.30, unit="m", sign="positive")
CD = model.parameter("CD", 0.25, unit="m", sign="positive")
AD = model.parameter("AD", 0.30, unit="m", sign="positive")
density = model.parameter("density", 1.5, unit="kg/m", sign="positive")
bearing = model.parameter("bearing", 0.02, unit="N m s", sign="nonnegative")
speed = model.parameter("speed", 2 * pi, unit="rad/s")

# Bodies. The origin of a body is its centre of mass; its coordinates are x, y and phi, its
# velocities vx, vy and omega. These are uniform rods, and their x axes run along them.
crank = model.body("crank", mass=density * AB, inertia=density * AB**3 / 12)
coupler = model.body("coupler", mass=density * BC, inertia=density * BC**3 / 12)
rocker = model.body("rocker", mass=density * CD, inertia=density * CD**3 / 12)

# Joints connect points. A point is given in the frame of its body: crank.at(AB / 2, 0) is the
# crank's right end. A revolute joint is a pin.
model.revolute("A", model.ground.at(0, 0), crank.at(-AB / 2, 0))
model.revolute("B", crank.at(AB / 2, 0), coupler.at(-BC / 2, 0))
model.revolute("C", coupler.at(BC / 2, 0), rocker.at(CD / 2, 0))
model.revolute("D", model.ground.at(AD, 0), rocker.at(-CD / 2, 0))

# Effects exert forces. A value may depend on coordinates, velocities, parameters and the time t.
model.torque("friction", on=crank, value=-bearing * crank.omega)

# Drivers prescribe a motion.
model.driver("motor", crank.phi, speed * t)

# A guess says about where the bodies are at the start; assembly moves them until the joints close.
# It also selects one of two ways to put a four-bar linkage together: here C is above the line AD.
drawn = {
    crank.x: 0.05, crank.y: 0.0, coupler.x: 0.18, coupler.y: 0.12, coupler.phi: 0.97,
    rocker.x: 0.28, rocker.y: 0.12, rocker.phi: 1.70,
}  # fmt: skip

# A scene names the effects and drivers that act. Its start values hold exactly.
model.scene("swing", effects=["gravity", "friction"], guess=drawn,
            start={crank.phi: 0.0, crank.omega: 0.0})  # fmt: skip
model.scene("driven", effects=["gravity", "friction"], drivers=["motor"], guess=drawn)
