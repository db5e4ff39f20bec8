"""The air compressor of Haug, *Computer-Aided Kinematics and Dynamics*, section 12.4.

A shaft along z carries a hub, tilted against it, on which a disc turns. A cross keeps the disc from
turning with the shaft, so that it wobbles, and six rods move six pistons parallel to the shaft:

            ||        ||      pistons, on a circle of 0.2 m
            []        []
             \\        \\      rods of 0.5 m
              o.       \\
                `-._    \\
               hub  `o-._ \\   tilt
                     |   `-o disc
                     |
                     | shaft, 600 rpm

Tilts of 20, 30 and 40° are in the book; here the tilt is the angle of a hinge between shaft and
hub, driven, so that it may change from run to run. All bodies are massless: the section is
kinematics.

Assumed (C): the cross has one axis along x in the housing and one along y' in the disc. The strokes
of the pistons on the y axis are then 2 R sin α.

Scenes
------
kinematics
    Section 12.4: positions and accelerations of the pistons.
"""

from sympy import cos, pi, sin

from codegen import Model, disc, extruded, t

model = Model("swash_plate_compressor", space=True)

# Parameters may change from run to run without a new build.
tilt = model.parameter("tilt", float(pi / 6), unit="rad")
speed = model.parameter("speed", float(20 * pi), unit="rad/s")
length = model.parameter("rod", 0.5, unit="m", sign="positive")

radius, count = 0.2, 6
shaft = model.body("shaft", at=(0, 0, -0.2), draw=extruded(disc(0.02), 0.3, (0, 0, 0.05)))
hub = model.body("hub", draw=extruded(disc(0.05), 0.08))
plate = model.body("disc", draw=extruded(disc(0.24).with_holes(disc(0.052)), 0.02))
turning = model.revolute("bearing", model.ground, shaft, at=(0, 0, -0.2), axis=(0, 0, 1))
tilting = model.revolute("tilting", shaft, hub, at=(0, 0, 0), axis=(0, 1, 0))
model.revolute("turning", hub, plate, at=(0, 0, 0), axis=(0, 0, 1))
model.constraint("cross", plate.A[0, 1])  # x of the housing and y' of the disc are perpendicular

bores = []
for k in range(count):
    place = 2 * pi * k / count + pi / 2
    x, y = radius * cos(place), radius * sin(place)
    piston = model.body(f"piston_{k + 1}", at=(x, y, 0.5), draw=extruded(disc(0.045), 0.07))
    model.translational(f"cylinder_{k + 1}", model.ground, piston, at=(x, y, 0.5), axis=(0, 0, 1))
    model.distance(f"rod_{k + 1}", plate.at(x, y, 0), piston, length)

    cylinder = disc(0.06).with_holes(disc(0.048))
    bores.append(extruded(cylinder, 0.16, at=(float(x), float(y), 0.66)))
model.draw_ground(bores)

model.rotation_driver("drive", turning, speed * t)
model.rotation_driver("tilted", tilting, tilt)

model.scene("kinematics", drivers=["drive", "tilted"], analysis="kinematics")
