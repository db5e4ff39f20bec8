"""The quick-return shaper of Haug, *Computer-Aided Kinematics and Dynamics*, section 8.3.

A crank with a flywheel turns about B. Its pin P carries a block that slides along a rocker, which
swings about A, and a rod from the rocker's tip D moves the slider with the tool along y = 4 m. The
tool cuts on its way to the left; it returns quickly, while the block passes close to A:

     ----[slider]--------------------- y = 4
                `-.._  1.9
                     `-o D
                      /
                    =o= P, the block on the rocker
             1.5 .` /
              .`   /
          B o`    /  4
            |    /
            |   /
          2 |  /
            | /
          A o` → x
        //////////

Dimensions, masses, inertias and the driver φ3 = 0.44 + ωt agree with tables 8.3.1 and 8.3.2 of the
book. Deduced rather than printed (B):

- the cutting force of figure 8.3.1: 200 kN while ẋ6 < 0 and -4.0 ≤ x6 ≤ 1.2 m. Over these 5.2 m it
  does the 10.4e5 N m of the book;
- runs begin where the cut ends, at x6 = -4.0 m and φ3 = 2.9955 rad.

Assumed (C):

- the flywheel begins at 5 rad/s: this gives the book's 2.2, 1.8 and 1.5 cycles a second, where 2π
  gives 2.3, 2.0 and 1.7;
- gravity acts in all scenes with forces and not at rest alone; it moves the driving torque by less
  than 2.4 kN m.

Scenes
------
gravity_equilibrium
    Section 8.3.2: where does it rest? Table 8.3.2.
kinematics, kinematics_composite
    Section 5.4: the crank driven. In model 2 two composite joints replace the rod and the block.
inverse_dynamics, inverse_dynamics_of_inertia
    Section 8.3.3: what torque drives it at constant speed, in all, and for the inertia of the
    bodies alone? Figure 8.3.2. m6 = 25, 50, 100 kg.
shaper
    Section 8.3.4: how does it run? Figures 8.3.3 to 8.3.5. J3 = 1000, 2000, 4000 kg m².
"""

from sympy import And, pi

from codegen import Model, disc, rectangle, t

model = Model("quick_return", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
flywheel_inertia = model.parameter("J3", 2000.0, unit="kg m^2")
slider_mass = model.parameter("m6", 50.0, unit="kg")
motor_torque = model.parameter("T3", 165521.0, unit="N m")
drive_start = model.parameter("drive_start", 0.44, unit="rad")
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
cutting_force = model.parameter("cutting_force", 200e3, unit="N", sign="nonnegative")

# Bodies 2 to 6, with their centres of mass at their origins.
rocker = model.body("rocker", mass=100.0, inertia=100.0)
crank = model.body("crank", mass=1000.0, inertia=flywheel_inertia, draw=disc(1.8))
block = model.body("block", mass=5.0, inertia=0.05)
rod = model.body("rod", mass=30.0, inertia=10.0)
tool = [(-3.8, -0.3), (-3.8, -0.6), (-4, -1), (-4.3, -0.6), (-4.3, 0.3)]  # on the ram
slider = model.body("slider", mass=slider_mass, inertia=1.5,
                    draw=[(0.8, 0.3), (0.8, -0.3), *tool])  # fmt: skip
model.draw_ground(rectangle(4.8, 1.2, (-5.5, 2.4)))  # the workpiece

# Places on them.
tip, foot = rocker.at(2, 0), rocker.at(-2, 0)
pin = crank.at(1.5, 0)

# Joints. Where a scene leaves the rod and the block out, massless ones stand for them (model 2).
model.revolute("A", model.ground.at(0, 0), foot)
model.revolute("B", model.ground.at(0, 2), crank.at(0, 0))
model.revolute("P", pin, block.at(0, 0))
model.translational("slot", rocker, block, axis=(1, 0))
model.revolute("C", slider.at(0, 0), rod.at(-0.95, 0))
model.revolute("D", rod.at(0.95, 0), tip)
model.translational("guide", model.ground.at(0, 4), slider, axis=(1, 0))
model.revolute_translational("sliding_pin", rocker, pin, axis=(1, 0), instead_of=block)
model.revolute_revolute("link", slider.at(0, 0), tip, 1.9, instead_of=rod)

# The crank at constant speed, or turned by a motor.
model.driver("crank_drive", crank.phi, drive_start + drive_speed * t)
model.torque("motor", on=crank, value=motor_torque)

# The workpiece holds the tool back on its way to the left (figure 8.3.1).
cutting = And(slider.vx < 0, slider.x >= -4.0, slider.x <= 1.2)
model.force("cut", on=slider, fx=cutting_force, when=cutting)

# Positions from which assembly finds the machine: at rest, at φ3 = 0.44, and just after the cut.
resting = {rocker.x: 1.5, rocker.y: 1.3, rocker.phi: 0.7, crank.y: 2.0, crank.phi: -0.8,
           block.x: 1.0, block.y: 0.9, block.phi: 0.7, rod.x: 2.3, rod.y: 3.3, rod.phi: -0.8,
           slider.x: 1.7, slider.y: 4.0}  # fmt: skip
driven_composite = {rocker.x: 0.9, rocker.y: 1.8, rocker.phi: 1.1, crank.y: 2.0, crank.phi: 0.44,
                    slider.x: 0.0, slider.y: 4.0}  # fmt: skip
driven = driven_composite | {block.x: 1.4, block.y: 2.6, block.phi: 1.1,
                             rod.x: 0.9, rod.y: 3.8, rod.phi: -0.2}  # fmt: skip
after_cut = {rocker.x: -1.1, rocker.y: 1.7, rocker.phi: 2.2, crank.y: 2.0, crank.phi: 2.9955,
             block.x: -1.5, block.y: 2.2, block.phi: 2.2, rod.x: -3.1, rod.y: 3.7, rod.phi: -0.4,
             slider.x: -4.0, slider.y: 4.0}  # fmt: skip
running = {q: value for q, value in after_cut.items() if q != slider.x}

model.scene("gravity_equilibrium", ["gravity"], guess=resting)
model.scene("kinematics", drivers=["crank_drive"], guess=driven, analysis="kinematics")
model.scene("kinematics_composite", drivers=["crank_drive"], without=[block, rod],
            guess=driven_composite, analysis="kinematics")  # fmt: skip
model.scene("inverse_dynamics", ["gravity", "cut"], ["crank_drive"], guess=after_cut,
            parameters={drive_start: 2.9955})  # fmt: skip
model.scene("inverse_dynamics_of_inertia", [], ["crank_drive"], guess=after_cut,
            parameters={drive_start: 2.9955})  # fmt: skip
model.scene("shaper", ["gravity", "cut", "motor"], start={slider.x: -4.0, crank.omega: 5.0},
            guess=running)  # fmt: skip
