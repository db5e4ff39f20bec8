r"""The rack and pinion of Haug, *Computer-Aided Kinematics and Dynamics*, projects 5.3 and 8.3.

A pinion turns about O on the ground and rolls along a rack, whose end C is pinned to a coupler
that turns about D. The rack slides to and fro, and rocks about the pinion as the coupler lifts its
end; the coupler can go all the way round:

                          C
                         o
                      .`  \
               __  .`  rack \  coupler, 0.07
              /  .`          \
             | o` |           \
              `__/             o D
             O, R = 0.02      ///
              ///

Masses are those of project 8.3: pinion 0.05, rack 0.1, coupler 0.05 kg. The dimensions are not to
be had; assumed (C), so that steel of sensible thickness has these masses:

- the pinion a disk of pitch radius R = 0.02 m;
- the rack a bar of 0.2 m, on whose pitch line its centre of mass and C, its end, lie;
- the coupler a bar of 0.07 m, from C to D (0.11, -0.02) m;
- φ_pinion = φ_rack with the pinion over the middle of the rack;
- gravity along -y, the laws of the drives and the torque.

As D lies on the level of the rack's pitch line under the pinion, the rack is level at both dead
centres, coupler and pitch line in line: the pinion turns from -3 to 4 rad, and stops there.

Scenes
------
kinematics, kinematics_massless_coupler
    Project 5.3: the pinion swings by sin ωt; ``swing`` of more than 3 rad locks. In the second
    model a revolute-revolute joint replaces the coupler.
inverse_dynamics, inverse_dynamics_massless_coupler
    The torque that it takes.
running, running_massless_coupler
    Project 8.3: from rest under a constant torque, ``pinion_torque``.
"""

from sympy import pi, sin

from codegen import Model, t

RADIUS, HALF_RACK, COUPLER = 0.02, 0.1, 0.07
model = Model("rack_and_pinion", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
swing = model.parameter("swing", 2.5, unit="rad")
drive_speed = model.parameter("drive_speed", float(2 * pi), unit="rad/s")
pinion_torque = model.parameter("pinion_torque", 0.05, unit="N m")

# Bodies, with their centres of mass at their origins: a disk and two uniform bars.
pinion = model.body("pinion", mass=0.05, inertia=0.05 * RADIUS**2 / 2)
rack = model.body("rack", mass=0.1, inertia=0.1 * HALF_RACK**2 / 3)
coupler = model.body("coupler", mass=0.05, inertia=0.05 * COUPLER**2 / 12)
end, pivot = rack.at(HALF_RACK, 0), model.ground.at(0.11, -0.02)

# Joints. Where a scene leaves the coupler out, a massless link stands for it.
model.revolute("O", model.ground.at(0, 0), pinion.at(0, 0))
model.rack_and_pinion("mesh", pinion, rack, RADIUS)
model.revolute("C", end, coupler.at(COUPLER / 2, 0))
model.revolute("D", coupler.at(-COUPLER / 2, 0), pivot)
model.revolute_revolute("link", end, pivot, COUPLER, instead_of=coupler)

model.driver("pinion_drive", pinion.phi, swing * sin(drive_speed * t))
model.torque("motor", on=pinion, value=pinion_torque)

# About where the parts are at φ = 0, the end of the rack above D.
lifted = {rack.x: 0.0, rack.y: -0.02, rack.phi: 0.7}
drawn = lifted | {coupler.x: 0.09, coupler.y: 0.01, coupler.phi: 2.1}
at_rest = {pinion.phi: 0.0, pinion.omega: 0.0}

for ending, without, guess in (("", [], drawn), ("_massless_coupler", [coupler], lifted)):
    model.scene(f"kinematics{ending}", drivers=["pinion_drive"], without=without, guess=guess,
                analysis="kinematics")  # fmt: skip
    model.scene(f"inverse_dynamics{ending}", ["gravity"], ["pinion_drive"], without=without,
                guess=guess)  # fmt: skip
    model.scene(f"running{ending}", ["gravity", "motor"], without=without, start=at_rest,
                guess=guess)  # fmt: skip
