r"""Two gear-slider mechanisms, after Haug, *Computer-Aided Kinematics and Dynamics*, section 5.5.

The section's data are not to be had: arrangement, dimensions and masses are assumed (C).

The train: a pinion drives a wheel of twice its size, and a rod from a pin on the wheel moves a
slider along a line 0.03 m above the wheel's centre; two turns of the pinion are one stroke and the
return.

        .-.   pinion, R = 0.05
       ( o )  A (0, 0.15)
        `-`
      .`   `.   0.06    rod, 0.25        y = 0.03
     /   o---o P---------------------o C [slider]
     \   B   /
      `.___.`   wheel, R = 0.1, B (0, 0)

The planetary gear (Cardan): a carrier of 0.06 m rolls a planet of R = 0.06 m within a ring on the
ground of twice its size. A point of the planet's pitch circle then runs along a diameter of the
ring, x = 0.12 cos φ: the slider on it needs no guide, only to be kept upright.

Steel of 10 mm, about: pinion 0.6, wheel 2.5, planet 0.9 kg, uniform disks; rod 0.3, carrier 0.2
kg, uniform bars; slider 1 kg. Gravity acts along -y.

Scenes
------
train_kinematics, planetary_kinematics
    The pinion, or the carrier, at constant speed.
train_inverse_dynamics, planetary_inverse_dynamics
    The torque that it takes.
train_running
    From rest under a constant torque on the pinion.
"""

from sympy import pi

from codegen import Model, t

PINION, WHEEL, CRANK, ROD, PLANET = 0.05, 0.1, 0.06, 0.25, 0.06
model = Model("gear_slider", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
drive_speed = model.parameter("drive_speed", float(4 * pi), unit="rad/s")
offset = model.parameter("offset", 0.03, unit="m")
pinion_torque = model.parameter("pinion_torque", 0.2, unit="N m")

# Bodies, with their centres of mass at their origins: disks and uniform bars.
pinion = model.body("pinion", mass=0.6, inertia=0.6 * PINION**2 / 2)
wheel = model.body("wheel", mass=2.5, inertia=2.5 * WHEEL**2 / 2)
rod = model.body("rod", mass=0.3, inertia=0.3 * ROD**2 / 12)
carrier = model.body("carrier", mass=0.2, inertia=0.2 * PLANET**2 / 12)
planet = model.body("planet", mass=0.9, inertia=0.9 * PLANET**2 / 2)
slider = model.body("slider", mass=1.0, inertia=1e-3)

# The train.
model.revolute("A", model.ground.at(0, PINION + WHEEL), pinion.at(0, 0))
model.revolute("B", model.ground.at(0, 0), wheel.at(0, 0))
model.gear("mesh", pinion, wheel, PINION, WHEEL)
model.revolute("P", wheel.at(CRANK, 0), rod.at(-ROD / 2, 0))
model.revolute("C", rod.at(ROD / 2, 0), slider.at(0, 0))
model.translational("guide", model.ground.at(0, offset), slider, axis=(1, 0))

# The planetary gear; the ring is internal, hence its negative radius.
model.revolute("O", model.ground.at(0, 0), carrier.at(-PLANET / 2, 0))
model.revolute("axle", carrier.at(PLANET / 2, 0), planet.at(0, 0))
model.gear("ring", model.ground.at(0, 0), planet, -2 * PLANET, PLANET)
model.revolute("pin", planet.at(PLANET, 0), slider.at(0, 0))
model.absolute("upright", slider, "phi", 0)

model.driver("pinion_drive", pinion.phi, drive_speed * t)
model.driver("carrier_drive", carrier.phi, drive_speed * t)
model.torque("motor", on=pinion, value=pinion_torque)

# What stays out of the one and the other, and about where the parts are at t = 0.
no_planetary = [carrier, planet, "upright"]
no_train = [pinion, wheel, rod, "guide"]
meshed = {pinion.y: 0.15, rod.x: 0.18, rod.y: 0.015, rod.phi: 0.1, slider.x: 0.3, slider.y: 0.03}
rolled = {carrier.x: 0.03, planet.x: 0.06, slider.x: 0.12}

model.scene("train_kinematics", drivers=["pinion_drive"], without=no_planetary, guess=meshed,
            analysis="kinematics")  # fmt: skip
model.scene("train_inverse_dynamics", ["gravity"], ["pinion_drive"], without=no_planetary,
            guess=meshed)  # fmt: skip
model.scene("train_running", ["gravity", "motor"], without=no_planetary, guess=meshed,
            start={pinion.phi: 0.0, pinion.omega: 0.0})  # fmt: skip
model.scene("planetary_kinematics", drivers=["carrier_drive"], without=no_train, guess=rolled,
            analysis="kinematics")  # fmt: skip
model.scene("planetary_inverse_dynamics", ["gravity"], ["carrier_drive"], without=no_train,
            guess=rolled)  # fmt: skip
