"""A quarter of a car with double wishbones, seen from behind, on a road with a bump.

        chassis |   guided upright
      C o-------|-o-----------o E        upper wishbone
                |  `  strut    \\
                |    `          | upright, wheel
      D o-------|------o------o F        lower wishbone
                                |
                            ~~~~~~~~ road

The wishbones turn about C and D on the chassis and carry the upright at E and F; the strut, a
spring with a damper, runs from the lower wishbone to the chassis. The tyre is a spring with a
damper between the wheel and the road: it never pulls, and the wheel leaves the ground where the
road falls away faster than it does. The road is a table over the distance x = speed * t, with one
bump of 60 mm.

Scenes
------
bump
    Over the bump from where it rests, `m.simulate(1.0, start=m.equilibrium())`. The wheel leaves
    the ground behind the bump.
"""

from codegen import Model, disc, t

model = Model("quarter_car", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
speed = model.parameter("speed", 12.0, unit="m/s", sign="positive")
strut_stiffness = model.parameter("strut_stiffness", 40e3, unit="N/m", sign="positive")
strut_damping = model.parameter("strut_damping", 3e3, unit="N s/m", sign="nonnegative")
tyre_stiffness = model.parameter("tyre_stiffness", 200e3, unit="N/m", sign="positive")
tyre_damping = model.parameter("tyre_damping", 150.0, unit="N s/m", sign="nonnegative")

# The height of the road over the distance; the tyre's radius is that of the unloaded wheel.
road = model.table(
    "road",
    x=[0.0, 1.0, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 4.0, 6.0],
    y=[0.0, 0.0, 0.0, 0.012, 0.038, 0.060, 0.045, 0.015, 0.0, 0.0, 0.0],
    units=("m", "m"),
    beyond="hold",
)
radius = 0.3

chassis = model.body(
    "chassis", mass=300.0, inertia=50.0,
    draw=[(-0.06, -0.06), (0.33, -0.04), (0.39, 0.27), (0.48, 0.5), (0.47, 0.54), (-0.06, 0.54)],
)  # fmt: skip
lower = model.body("lower", mass=6.0, inertia=0.1)
upper = model.body("upper", mass=3.0, inertia=0.05)
upright = model.body(
    "upright",
    mass=35.0,
    inertia=1.0,
    draw=[disc(radius).with_holes(disc(0.2)), disc(0.18).with_holes(disc(0.04))],  # tyre, rim
)

# The chassis' origin is at the height of the lower pivots; x points from the car to the wheel.
model.translational("guide", model.ground, chassis, axis=(0, 1))
model.revolute("D", chassis.at(0.3, 0.0), lower.at(-0.2, 0))
model.revolute("C", chassis.at(0.35, 0.25), upper.at(-0.15, 0))
model.revolute("F", lower.at(0.2, 0), upright.at(-0.05, -0.12))
model.revolute("E", upper.at(0.15, 0), upright.at(-0.07, 0.12))

model.spring("strut", chassis.at(0.45, 0.5), lower.at(0.1, 0), strut_stiffness,
             free_length=0.62, damping=strut_damping)  # fmt: skip
model.contact("tyre", gap=upright.y - radius - road(speed * t), stiffness=tyre_stiffness,
              damping=tyre_damping, may_pull=False)  # fmt: skip

drawn = {chassis.y: 0.3, lower.x: 0.5, lower.y: 0.3, upper.x: 0.5, upper.y: 0.55,
         upright.x: 0.75, upright.y: 0.4}  # fmt: skip
seen = ["default", "force(strut)", "length(strut)", "force(tyre)", "gap(tyre)"]
model.scene("bump", ["gravity", "strut", "tyre"], guess=drawn, outputs=seen)
