"""A four-stroke engine with one cylinder: the pressure of its gas is a table over two turns.

              B
             o
          .    ` .
        .          ` .
      A o             o C [piston] → x | gas

The crank AB with its flywheel turns about A, a rod runs from its pin B to C on the piston, which
moves along the x axis. At φ = 0 the piston is at its top dead centre and the gas burns; the
exhaust, intake and compression follow until φ = 720°. A load whose torque grows with the speed
brakes the crank.

Scenes
------
firing
    From 100 rad/s, with the works of gas and load.
"""

from math import pi, radians

from codegen import Model, disc, rectangle

model = Model("engine", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
radius = model.parameter("radius", 0.04, unit="m", sign="positive")
rod_length = model.parameter("rod_length", 0.14, unit="m", sign="positive")
bore = model.parameter("bore", 0.08, unit="m", sign="positive")
flywheel_inertia = model.parameter("flywheel_inertia", 0.12, unit="kg m^2", sign="positive")
ambient = model.parameter("ambient", 1e5, unit="Pa", sign="positive")
load_torque = model.parameter("load_torque", 0.35, unit="N m s", sign="nonnegative")

# The pressure in the cylinder, bar, over the angle of the crank in degrees.
indicated = {
    0: 35, 10: 55, 20: 60, 30: 50, 45: 32, 60: 20, 90: 9.5, 120: 5.5, 150: 3.5, 180: 1.8,
    210: 1.15, 270: 1.05, 360: 1.0, 450: 0.92, 540: 0.95, 600: 1.5, 640: 3.2, 670: 6.5,
    690: 11.5, 705: 19, 720: 35,
}  # fmt: skip
pressure = model.table(
    "pressure",
    [radians(angle) for angle in indicated],
    [1e5 * value for value in indicated.values()],
    periodic=True,
    units=("rad", "Pa"),
)

# Bodies, with their centres of mass at their origins.
crank = model.body("crank", mass=8.0, inertia=0.004 + flywheel_inertia, draw=disc(1.5 * radius))
rod = model.body("rod", mass=0.6, inertia=0.0015)
rings = [rectangle(0.03 * bore, 0.9 * bore, (place * bore, 0)) for place in (0.18, 0.28)]
piston = model.body("piston", mass=0.5, inertia=0.0005,
                    draw=rectangle(0.8 * bore, bore).with_holes(*rings))  # fmt: skip

model.revolute("A", model.ground.at(0, 0), crank)
model.revolute("B", crank.at(radius, 0), rod.at(-rod_length / 2, 0))
model.revolute("C", rod.at(rod_length / 2, 0), piston)
model.translational("cylinder", model.ground, piston, axis=(1, 0))

# For the eye: the cylinder with its fins, the head with two valves and the spark plug.
head = radius + rod_length + 0.55 * bore
parts = [(0.15, 1.2, 0.07, 0), (0.5, 0.14, 0.2, 0)]  # widths, heights and centres, in bores
for y in (-1, 1):
    parts += [(2, 0.1, -0.9, 0.55 * y), (0.08, 0.3, -0.04, 0.26 * y), (0.6, 0.06, 0.3, 0.26 * y)]
    parts += [(0.07, 0.3, -0.2 * k, 0.7 * y) for k in range(6)]
model.draw_ground([
    rectangle(w * bore, h * bore, (head + x * bore, y * bore)) for w, h, x, y in parts
])  # fmt: skip

model.force("gas", on=piston, fx=-(pressure(crank.phi) - ambient) * pi * bore**2 / 4)
model.torque("load", on=crank, value=-load_torque * crank.omega)

drawn = {rod.x: 0.11, piston.x: 0.18}
model.scene("firing", ["gravity", "gas", "load"], start={crank.phi: 0.0, crank.omega: 100.0},
            guess=drawn, outputs=["energy", "reactions", "powers", "works"])  # fmt: skip
