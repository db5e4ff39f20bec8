"""NAME: a pendulum, a bar that hangs on a pin.

      ///
    A  o
        `
         `  bar
          `

    linkwright check NAME.py                                   is it sound?
    linkwright draw NAME.py --out NAME.png                     what does it look like?
    linkwright simulate NAME.py --t-end 10                     how does it move?
    linkwright report NAME.py --t-end 10 --out NAME.html       can I watch it, in a browser?
    linkwright equilibrium NAME.py                             where does it rest?

Units are SI: m, kg, s, N, rad.

Scenes
------
swing
    The bar is let go level; gravity moves it, and the pin brakes it.
free_swing
    The same without the brake: the energy stays as it is.
"""

from linkwright import Model

# Gravity acts in scenes that name the effect "gravity".
model = Model("NAME", gravity=(0, -9.81))

# A parameter may change from run to run without a new build: --set length=0.8
length = model.parameter("length", 1.0, unit="m", sign="positive")
mass = model.parameter("mass", 2.0, unit="kg", sign="positive")
damping = model.parameter("damping", 0.1, unit="N m s", sign="nonnegative")

# A body. Its origin is its centre of mass, its coordinates are x, y and phi, its velocities vx, vy
# and omega. The x axis of this one runs along the bar, away from the pin.
bar = model.body("bar", mass=mass, inertia=mass * length**2 / 12)

# A joint connects points, each given in the frame of its body. A revolute joint is a pin.
model.revolute("A", model.ground.at(0, 0), bar.at(-length / 2, 0))

# An effect exerts a force or torque. Its value may depend on coordinates, velocities, parameters
# and the time, `from linkwright import t`.
model.torque("brake", on=bar, value=-damping * bar.omega)

# A guess says about where a body is at the start; assembly moves it until the joints close.
drawn = {bar.x: 0.5, bar.y: 0.0}

# A scene names the effects that act. Its start values hold exactly.
level = {bar.phi: 0.0, bar.omega: 0.0}
model.scene("swing", effects=["gravity", "brake"], guess=drawn, start=level)
model.scene("free_swing", effects=["gravity"], guess=drawn, start=level)
