"""The web cutter of Haug, *Computer-Aided Kinematics and Dynamics*, projects 5.2 and 8.2.

A crank-rocker linkage with a knife on the coupler and one on the rocker; once a turn the tips pass
each other where the web runs through, and shear it off:

            C
            o------______
           / `           `----- tips of the knives on BC, above, and on CD, below
          /   `          _-`/
         /     `     _-`   /
      B o      _`-`       /
        |       `        /
      A o         `     /
       ///          `  /
                      o D
                     ///

A (0, 0), D (0.26, -0.04) m, AB 0.04, BC 0.28, CD 0.40 m; in the frame of body 3, at C with x' from
B to C, the tip is at (0.04, -0.24); in that of body 4, at C with x' from C to D, the centroid is at
(0.14, 0.07) and the tip at (0.14, 0.20). Masses and inertias are those of project 8.2, and its
driver turns at 2π rad/s. Assumed (C): the cutting force, from another text, 1000 N, vertical,
equal and opposite on the tips, while the gap between them is positive, below 2 mm and closing;
gravity along -y; the motor of the dynamic run.

Scenes
------
kinematics
    Paths and speeds of the tips.
inverse_dynamics
    The torque at constant speed; ``cut_force`` = 0 runs idle.
running
    With a motor whose torque falls with the speed; a gain below 4.93 N m s stops it in
    the web.
"""

from sympy import And, pi

from codegen import Model, disc, rectangle, t

model = Model("web_cutter", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
cut_force = model.parameter("cut_force", 1000.0, unit="N", sign="nonnegative")
web = model.parameter("web_thickness", 0.002, unit="m", sign="positive")
motor_gain = model.parameter("motor_gain", 20.0, unit="N m s")

# Bodies, with their centres of mass at their origins.
crank = model.body("crank", mass=0.1, inertia=1.5e-5)
coupler = model.body(
    "coupler", mass=1.0, inertia=0.03,
    draw=[(-0.288, -0.008), (-0.01, -0.012), (0.012, -0.11), (0.04, -0.24), (0.052, -0.11),
          (0.014, 0.01), (-0.288, 0.008)],
)  # fmt: skip
rocker = model.body(
    "rocker", mass=2.0, inertia=0.04,
    draw=[(-0.152, -0.08), (0.272, -0.082), (0.27, -0.058), (0.06, -0.03), (0.016, 0.03),
          (0, 0.13), (-0.016, 0.03), (-0.05, -0.03), (-0.152, -0.056)],
)  # fmt: skip

model.revolute("A", model.ground.at(0, 0), crank.at(-0.02, 0))
model.revolute("B", crank.at(0.02, 0), coupler.at(-0.28, 0))
model.revolute("C", coupler.at(0, 0), rocker.at(-0.14, -0.07))
model.revolute("D", rocker.at(0.26, -0.07), model.ground.at(0.26, -0.04))

# For the eye: the web from its roll through feeding rollers, and sheets that were cut off.
roll = disc(0.1, (0.68, 0.19)).with_holes(disc(0.03, (0.68, 0.19)))
rollers = [disc(0.035, (0.47, y)) for y in (0.2495, 0.3305)]
sheets = [rectangle(0.13, 0.008, (x, 0.29)) for x in (0.235, 0.085, -0.065, -0.215)]
model.draw_ground([roll, *rollers, *sheets, rectangle(0.36, 0.008, (0.5, 0.29))])

# The knives push the web, and the web pushes back, until the tips have met.
upper = coupler.at(0.04, -0.24)
lower = rocker.at(0, 0.13)
gap = upper.y - lower.y
cutting = And(gap > 0, gap < web, upper.vy - lower.vy < 0)
model.force("cut_above", on=upper, fy=cut_force, when=cutting)
model.force("cut_below", on=lower, fy=-cut_force, when=cutting)

# The crank at constant speed, or on a motor that holds this speed as well as it can.
model.driver("crank_drive", crank.phi, drive_speed * t)
model.torque("motor", on=crank, value=motor_gain * (drive_speed - crank.omega))

# About where the parts are at φ1 = 0.
drawn = {crank.x: 0.02, coupler.x: 0.20, coupler.y: 0.23, coupler.phi: 1.0,
         rocker.x: 0.30, rocker.y: 0.17, rocker.phi: -1.4}  # fmt: skip
web_acts = ["gravity", "cut_above", "cut_below"]

model.scene("kinematics", drivers=["crank_drive"], guess=drawn, analysis="kinematics")
model.scene("inverse_dynamics", web_acts, ["crank_drive"], guess=drawn)
model.scene("running", [*web_acts, "motor"], guess=drawn,
            start={crank.phi: 0.0, crank.omega: float(2 * pi)})  # fmt: skip
