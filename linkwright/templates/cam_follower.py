"""NAME: an eccentric cam that lifts a follower with a flat face against a spring.

        [spring]
           |
        -------   follower
         ( o )    cam, about A
          ///

    linkwright check NAME.py                                   is it sound?
    linkwright draw NAME.py --out NAME.png                     what does it look like?
    linkwright simulate NAME.py --t-end 1                      how does it move?
    linkwright report NAME.py --t-end 1 --out NAME.html        can I watch it, in a browser?
    linkwright inverse NAME.py --scene driven --t-end 0.1      does the cam have to pull?

Units are SI: m, kg, s, N, rad.

Scenes
------
running
    A constant torque turns the cam, a brake of the shaft limits its speed.
driven
    A motor turns the cam at constant speed.
"""

from math import pi

from linkwright import Model, t

# Gravity acts in scenes that name the effect "gravity".
model = Model("NAME", gravity=(0, -9.81))

# A parameter may change from run to run without a new build: --set eccentricity=0.002
radius = model.parameter("radius", 0.020, unit="m", sign="positive")
eccentricity = model.parameter("eccentricity", 0.005, unit="m", sign="positive")
stiffness = model.parameter("stiffness", 2000.0, unit="N/m", sign="nonnegative")
torque = model.parameter("torque", 0.4, unit="N m")
brake = model.parameter("brake", 0.01, unit="N m s", sign="nonnegative")
speed = model.parameter("speed", 20 * pi, unit="rad/s")

# Bodies. The origin of a body is its centre of mass; its coordinates are x, y and phi, its
# velocities vx, vy and omega. The follower is 0.1 m long, with its face at its lower end.
cam = model.body("cam", mass=0.5, inertia=5e-4)
follower = model.body("follower", mass=0.2, inertia=2e-4)

# Joints connect points, each given in the frame of its body. A revolute joint is a pin; a
# translational joint guides the follower along an axis. The joint of cam and face keeps them in
# touch, also where the cam would have to pull: the sign of the reaction shows it.
model.revolute("A", model.ground.at(0, 0), cam.at(0, 0))
model.translational("guide", model.ground.at(0, 0), follower.at(0, 0), axis=(0, 1))
outline = cam.circle(radius, center=(eccentricity, 0))
model.cam_flat_follower("lift", outline, follower.at(0, -0.05))

# Effects exert forces. A value may depend on coordinates, velocities, parameters and the time t.
model.spring("spring", model.ground.at(0, 0.2), follower.at(0, 0.05), stiffness, free_length=0.1)
model.torque("drive", on=cam, value=torque)
model.torque("shaft_brake", on=cam, value=-brake * cam.omega)

# Drivers prescribe a motion.
model.driver("motor", cam.phi, speed * t)

# A guess says about where the bodies are at the start; assembly moves them until the joints close.
drawn = {follower.y: 0.07}

# A scene names the effects and drivers that act. Its start values hold exactly.
model.scene("running", effects=["gravity", "spring", "drive", "shaft_brake"], guess=drawn,
            start={cam.phi: 0.0, cam.omega: 10 * pi})  # fmt: skip
model.scene("driven", effects=["gravity", "spring"], drivers=["motor"], guess=drawn)
