"""The slider-crank compressor of Haug, *Computer-Aided Kinematics and Dynamics*, section 8.2.

A crank of 2 m turns about A on the ground, a rod of 3.5 m runs from its pin B to C on the slider,
and the slider compresses gas along the x axis:

              B
             o
        2  .   ` .   3.5
         .         ` .
      A o             o C [slider] → x
     ///////////////////////////////

Dimensions, masses and inertias are tables 5.2.1, 5.2.2 and 8.2.1 of the book. Two things are
deduced rather than printed: the angular velocity 2π of the driver in 8.2.3, and that the gas force
of table 8.2.4 was taken a thousand times too small (scene ``gas_equilibrium_as_printed``).

Scenes
------
gravity_equilibrium, gas_equilibrium, gas_equilibrium_as_printed
    Section 8.2.2: where does it rest? Tables 8.2.3 and 8.2.4.
kinematics, kinematics_massless_rod
    Section 5.2.3, models 1 and 2: the crank driven, with any rod length; a rod of 1.9 m locks.
inverse_dynamics, inverse_dynamics_without_gas
    Section 8.2.3: what torque drives it at constant speed? Figure 8.2.4.
compressor, compressor_massless_rod
    Section 8.2.4: how does it run? Figures 8.2.5 to 8.2.8. J1 = 225, 450, 900 kg m².
"""

from sympy import Piecewise, cos, log, pi, sin

from codegen import Model, rectangle, t

model = Model("slider_crank")

# Parameters may change from run to run without a new build.
crank_inertia = model.parameter("J1", 450.0, unit="kg m^2")
rod_length = model.parameter("rod_length", 3.5, unit="m", sign="positive")
motor_torque = model.parameter("motor_torque", 41450.0, unit="N m")
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
gas_scale = model.parameter("gas_scale", 1.0)

# Bodies, with their centres of mass at their origins.
crank = model.body("crank", mass=200.0, inertia=crank_inertia)
rod = model.body("rod", mass=35.0, inertia=35.0)
rings = [rectangle(0.08, 1.1, (x, 0)) for x in (2.0, 2.2)]
slider = model.body("slider", mass=25.0, inertia=0.02,
                    draw=rectangle(2.8, 1.2, (1.1, 0)).with_holes(*rings))  # fmt: skip

# Joints. Where a scene leaves the rod out, a massless link stands for it (model 2).
model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
model.revolute("B", crank.at(2, 0), rod.at(-rod_length / 2, 0))
model.revolute("C", rod.at(rod_length / 2, 0), slider.at(0, 0))
model.translational("guide", model.ground, slider, axis=(1, 0))
model.revolute_revolute("link", crank.at(2, 0), slider.at(0, 0), rod_length, instead_of=rod)

# For the eye: the cylinder, and the pipes at its head.
walls = [rectangle(5.2, 0.16, (6.0, y)) for y in (-0.7, 0.7)]
pipes = [rectangle(0.8, 0.12, (9, y)) for y in (-0.5, -0.2, 0.2, 0.5)]
model.draw_ground([*walls, *pipes, rectangle(0.16, 1.56, (8.6, 0))])

# The crank at constant speed.
model.driver("crank_drive", crank.phi, pi / 4 + drive_speed * t)

# Gas: compressed from x = 1.5 m on, let out from x = 5 m on (figure 8.2.2), while moving right.
x = slider.x
compression = -282857 / (6 - x) + 62857
exhaust = -110000 * (1 - sin(2 * pi * (x - 5.25)))
model.force(
    "gas",
    on=slider,
    fx=Piecewise((0, x < 1.5), (compression, x <= 5), (exhaust, x <= 5.5), (0, True)),
    when=slider.vx > 0,
)
model.label(x > 5, "exhaust valve opens / exhaust valve closes")

# The same gas held in place, for equilibrium: minus the integral of its force.
stored = -282857 * log((6 - x) / 4.5) - 62857 * (x - 1.5)
stored_at_5 = stored.subs(x, 5)
let_out = 110000 * (x - 5 + cos(2 * pi * (x - 5.25)) / (2 * pi))
stored_at_end = stored_at_5 + let_out.subs(x, 5.5)
energy = Piecewise(
    (0, x < 1.5), (stored, x <= 5), (stored_at_5 + let_out, x <= 5.5), (stored_at_end, True)
)
model.potential("held_gas", gas_scale * energy)

model.torque("motor", on=crank, value=motor_torque)
model.gravity("gravity_down", (0, -9.81))
model.gravity("gravity_right", (9.81, 0))

# The positions that the book starts from: tables 8.2.2 and 5.2.6, and section 8.2.4.
resting = {crank.phi: 4.6, rod.x: 1.2, rod.y: -1.0, rod.phi: 0.6, slider.x: 2.67}
driven = {crank.phi: 0.7854, rod.x: 3.015, rod.y: 0.7071, rod.phi: -0.41595, slider.x: 4.6158}
running = {rod.x: -0.25, slider.x: 1.5, rod.vy: -30.0, rod.omega: 17.142857}

model.scene("compressor", ["gravity_right", "gas", "motor"],
            start={crank.phi: pi, crank.omega: 30.0}, guess=running)  # fmt: skip
model.scene("compressor_massless_rod", ["gravity_right", "gas", "motor"], without=[rod],
            start={crank.phi: pi, crank.omega: 30.0}, guess={slider.x: 1.5})  # fmt: skip
model.scene("inverse_dynamics", ["gas"], ["crank_drive"], guess=driven)
model.scene("inverse_dynamics_without_gas", [], ["crank_drive"], guess=driven)
model.scene("kinematics", drivers=["crank_drive"], guess=driven, analysis="kinematics")
model.scene("kinematics_massless_rod", drivers=["crank_drive"], without=[rod],
            guess={crank.phi: 0.7854, slider.x: 4.6158}, analysis="kinematics")  # fmt: skip
model.scene("gravity_equilibrium", ["gravity_down"], guess=resting)
model.scene("gas_equilibrium", ["gravity_down", "held_gas"], guess=resting)
model.scene("gas_equilibrium_as_printed", ["gravity_down", "held_gas"], guess=resting,
            parameters={gas_scale: 1e-3})  # fmt: skip
