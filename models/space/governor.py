"""The governor of Haug, *Computer-Aided Kinematics and Dynamics*, section 12.6.

Two arms with balls hang at a turning spindle and swing outward with its speed. Links from the arms
lift a collar, and the engine gives the less torque, the higher the collar is:

               y
               |
        hinge  o  y = 0.2 m
              /|\\
      0.08 m o | o
            /\\ | /\\
     ball  O  \\|/  O     0.16 m from the hinge, at 45° in the drawing
              [ ]      collar, y = 0.05 m
               |  spindle

A spring and a damper act between the hinge and the collar. The engine exerts C Δl on the spindle,
with the shortening Δl = (0.2 - y) - 0.15 of the spring; a load of 25 N m comes on between 1 and
2 s.

All numbers agree with the book's: masses, moments, the spindle's 11.0174 rad/s at the start, and
gains of 7500, 12500 and 17500 N. With the third the oscillation grows; with the second it does,
too, so slowly that the ten seconds of the book do not show it.

Scenes
------
run
    Section 12.6: ten seconds with the load.
"""

from math import sqrt

from sympy import Piecewise

from codegen import Model, t

model = Model("governor", space=True, gravity=(0, -9.81, 0))

# Parameters may change from run to run without a new build.
gain = model.parameter("gain", 7500.0, unit="N")
load = model.parameter("load", 25.0, unit="N m")
damping = model.parameter("damping", 30.0, unit="N s/m")

# Bodies at the drawing, with their centres of mass at their origins; arms at 45°.
top, low, side = 0.2, 0.05, 1 / sqrt(2)
spindle = model.body("spindle", 200.0, (25.0, 50.0, 25.0), at=(0, top, 0))
collar = model.body("collar", 1.0, (0.15, 0.125, 0.15), at=(0, low, 0))
bearing = model.revolute("bearing", model.ground, spindle, at=(0, top, 0), axis=(0, 1, 0))
model.translational("guide", spindle, collar, at=(0, low, 0), axis=(0, 1, 0))
for k, x in enumerate((side, -side), 1):
    ball = model.body(f"ball_{k}", 1.0, (0.1, 0.1, 0.1), at=(0.16 * x, top - 0.16 * side, 0))
    model.revolute(f"arm_{k}", spindle, ball, at=(0, top, 0), axis=(0, 0, 1))
    model.distance(f"link_{k}", ball.at(-0.08 * x, 0.08 * side, 0), collar, 0.10922)
model.spring("spring", spindle, collar, stiffness=1000, free_length=0.15, damping=damping)

engine = gain * ((top - collar.y) - 0.15)
demand = load * Piecewise((0, t < 1), (t - 1, t < 2), (1, True))
model.torque("engine", spindle, (0, engine, 0))
model.torque("demand", spindle, (0, -demand, 0))

model.scene("run", ["gravity", "spring", "engine", "demand"],
            start={"spindle.omega_y": 11.0174, "collar.y": low, "collar.vy": 0.0})  # fmt: skip
