"""A Stewart platform: a plate on six legs, whose lengths set its place and its attitude.

                 ______ plate ______
               o`---- o      o ----`o       joints on a circle of 0.35 m
              / \\    / \\    / \\    / \\
             /   \\  /   \\  /   \\  /   \\     six legs
            o     oo     oo     oo     o
          //////// base: a circle of 0.6 m, 0.7 m below

Neighbouring joints of the base are 20° apart, those of the plate 100°. The legs are massless, with
ball joints at their ends.

Dimensions and masses are those of no machine in particular (C).

Scenes
------
legs
    The lengths of the legs are driven: where is the plate, and which forces do the legs exert?
pose
    The plate is driven: which lengths have the legs?
springs
    The legs are springs with dampers, and the plate is let go 0.05 m beside its rest.
"""

from sympy import cos, pi, sin, sqrt

from codegen import Model, disc, extruded, t

model = Model("stewart_platform", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
stroke = model.parameter("stroke", 0.04, unit="m", sign="nonnegative")
mass = model.parameter("mass", 40.0, unit="kg", sign="positive")
stiffness = model.parameter("stiffness", 2e4, unit="N/m", sign="nonnegative")
damping = model.parameter("damping", 200.0, unit="N s/m", sign="nonnegative")

height = 0.7
plate = model.body("plate", mass, (1.3, 1.1, 2.3), at=(0, 0, height),
                   draw=extruded(disc(0.4), 0.03, at=(0, 0, 0.02)))  # fmt: skip
model.draw_ground(extruded(disc(0.72), 0.03, at=(0, 0, -0.1)))
legs = []
for k in range(6):
    middle, side = 2 * pi / 3 * (k // 2), (-1) ** k
    at, on = middle + side * pi / 18, middle + side * 5 * pi / 18
    base = model.ground.at(0.6 * cos(at), 0.6 * sin(at), 0)
    legs.append((base, plate.at(0.35 * cos(on), 0.35 * sin(on), 0)))
rest = sqrt(height**2 + 0.6**2 + 0.35**2 - 2 * 0.6 * 0.35 * cos(2 * pi / 9))

lengths = {}
for k, (i, j) in enumerate(legs, 1):
    model.distance_driver(f"leg_{k}", i, j, rest + stroke * sin(2 * pi * t + k))
    model.spring(f"strut_{k}", i, j, stiffness=stiffness, free_length=float(rest), damping=damping)
    lengths[f"length_{k}"] = sqrt((j.x - i.x) ** 2 + (j.y - i.y) ** 2 + (j.z - i.z) ** 2)

# A path of the plate: its place, and the vector part of its Euler parameters.
path = {
    plate.x: stroke * sin(2 * pi * t), plate.y: stroke * cos(2 * pi * t),
    plate.z: height + stroke * sin(4 * pi * t) / 2, plate.e1: stroke * cos(2 * pi * t),
    plate.e2: stroke * sin(4 * pi * t), plate.e3: 2 * stroke * sin(2 * pi * t),
}  # fmt: skip
guides = [model.driver(f"guide_{k}", q, law) for k, (q, law) in enumerate(path.items(), 1)]

still = {f"plate.{v}": 0.0 for v in ("vx", "vy", "vz", "omega_x", "omega_y", "omega_z")}
upright = {"plate.x": 0.05, "plate.y": 0.0, "plate.z": height, "plate.e1": 0.0, "plate.e2": 0.0,
           "plate.e3": 0.0}  # fmt: skip
model.scene("legs", ["gravity"], [f"leg_{k}" for k in range(1, 7)])
model.scene("pose", ["gravity"], guides, outputs=["default", lengths])
model.scene("springs", ["gravity", *(f"strut_{k}" for k in range(1, 7))], start=still | upright)
