"""A scotch yoke that pumps, with Coulomb friction in its slot and in its guide.

              |  |
         B    |  |
        o-----|--|----- slot of the yoke, upright
      .       |  |
    o A  -----|  |============= guide → x
   ///        |  |

The crank AB turns about A; its pin B slides in an upright slot of the yoke, which moves along the
x axis, x = r cos φ, and pushes a pump while it moves to the right. The pin rubs in the slot with
the force that it pushes with. The guide bears the yoke's weight, the friction in the slot, and the
moment of the pin about the guide, at both ends of a bearing.

Scenes
------
inverse_dynamics
    The torque that turns the crank at constant speed.
running
    A motor whose torque falls with the speed, from rest.
rocking
    A torque that swings to and fro: the yoke sticks while it is small.
"""

from sympy import pi, sin

from codegen import Model, disc, rectangle, t

model = Model("scotch_yoke", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
radius = model.parameter("radius", 0.1, unit="m", sign="positive")
bearing = model.parameter("bearing", 0.4, unit="m", sign="positive")
slot_friction = model.parameter("slot_friction", 0.15, sign="nonnegative")
guide_friction = model.parameter("guide_friction", 0.1, sign="nonnegative")
pump_force = model.parameter("pump_force", 60.0, unit="N", sign="nonnegative")
drive_speed = model.parameter("drive_speed", float(4 * pi), unit="rad/s")
rocking_torque = model.parameter("rocking_torque", 0.3, unit="N m")

crank = model.body("crank", mass=3.0, inertia=0.05, draw=disc(1.2 * radius))
frame, plunger = rectangle(0.07, 2 * radius + 0.08), rectangle(0.03, 0.12, (0.38, 0))
yoke = model.body("yoke", mass=2.0, inertia=0.02, draw=[frame, rectangle(0.76, 0.03), plunger])

model.revolute("A", model.ground.at(0, 0), crank)
slot = model.revolute_translational("slot", yoke, crank.at(radius, 0), axis=(0, 1))
guide = model.translational("guide", model.ground, yoke, axis=(1, 0))

# For the eye: the bearings of the rod, and the pump's cylinder.
bearings = [rectangle(0.08, 0.03, (x, y)) for x in (-0.25, 0.2) for y in (-0.032, 0.032)]
walls = [rectangle(0.26, 0.012, (0.395, y)) for y in (-0.068, 0.068)]
model.draw_ground([*bearings, *walls, rectangle(0.012, 0.148, (0.525, 0))])

model.friction("slot_rub", slot, slot_friction)
model.friction("guide_rub", guide, guide_friction, length=bearing)
model.force("pump", on=yoke, fx=-pump_force, when=yoke.vx > 0)

model.driver("crank_drive", crank.phi, pi / 6 + drive_speed * t)
model.motor("motor", on=crank, stall_torque=12.0, no_load_speed=30.0)
model.torque("rocker", on=crank, value=rocking_torque * sin(2 * t))

drawn = {yoke.x: 0.09}
frictions = ["slot_rub", "guide_rub"]
seen = ["default", "force(slot_rub)", "force(guide_rub)"]

model.scene("inverse_dynamics", ["gravity", "pump", *frictions], ["crank_drive"], guess=drawn,
            outputs=seen)  # fmt: skip
model.scene("running", ["gravity", "pump", "motor", *frictions], guess=drawn, outputs=seen,
            start={crank.phi: pi / 6, crank.omega: 0.0})  # fmt: skip
model.scene("rocking", ["gravity", "rocker", *frictions], guess=drawn, outputs=seen,
            start={crank.phi: pi / 3, crank.omega: 0.0})  # fmt: skip
