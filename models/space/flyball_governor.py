"""A flyball governor whose stiff springs hold a slider on a turning shaft.

               z
       hinge   |   hinge, at z = 1 m
          o----+----o
        ,`/    |    \\`.
      ,` /  spring   \\ `.   rods of 1 m, 30° below the horizontal
    O`  /      |      \\  `O   5 kg at each tip
        `.._ [   ] _..`
              slider, z = 0.5 m
               |
             shaft

Benchmark A05 of the IFToMM technical committee for multibody dynamics. Shaft and rods are of 1 ×
0.01 × 0.01 m, the slider is a cube of 0.1 m, all of 3000 kg/m³. Springs of 8e5 N/m with dampers of
4e4 N s/m and a free length of 0.5 m join the slider's faces and the middles of the rods. The
springs are much faster than the governor, so that implicit methods take far fewer steps. The angle
of the bearing, an output, is then integrated in the place of a coordinate that swings in each turn,
which makes the errors of fast runs several times smaller.

Scenes
------
run
    Ten seconds from 2π rad/s.
"""

from math import cos, pi, sin

from codegen import Model

model = Model("flyball_governor", space=True, gravity=(0, 0, -9.81))

# Parameters may change from run to run without a new build.
stiffness = model.parameter("stiffness", 8e5, unit="N/m", sign="nonnegative")
damping = model.parameter("damping", 4e4, unit="N s/m", sign="nonnegative")

# A rod of 0.3 kg with a point mass of 5 kg at its tip; x' along it, from the hinge.
slim, tip = 0.3, 5.0
mass = slim + tip
centre = (slim * 0.5 + tip * 1.0) / mass
turning = slim / 12 * 2e-4
across = slim / 12 * (1 + 1e-4) + slim * (centre - 0.5) ** 2 + tip * (1 - centre) ** 2

shaft = model.body("shaft", slim, (slim / 12 * (1 + 1e-4),) * 2 + (turning,), at=(0, 0, 0.5))
slider = model.body("slider", 3.0, (3.0 / 12 * 2e-2,) * 3, at=(0, 0, 0.5))
bearing = model.revolute("bearing", model.ground, shaft, at=(0, 0, 0), axis=(0, 0, 1))
model.translational("guide", shaft, slider, at=(0, 0, 0.5), axis=(0, 0, 1))
springs = []
for k, side in enumerate((1, -1), 1):
    x, z = side * cos(pi / 6), -sin(pi / 6)
    rod = model.body(f"rod{k}", mass, (turning, across, across),
                     at=(0.05 * side + centre * x, 0, 1 + centre * z),
                     axes=((x, 0, z), (0, 1, 0)))  # fmt: skip
    model.revolute(f"hinge{k}", shaft, rod, at=(0.05 * side, 0, 1), axis=(0, side, 0))
    springs.append(model.spring(f"spring{k}", slider.at(0.05 * side, 0, 0),
                                rod.at(0.5 - centre, 0, 0), stiffness=stiffness, free_length=0.5,
                                damping=damping))  # fmt: skip

model.scene("run", ["gravity", *springs], outputs=["default", bearing.angle],
            start={"shaft.omega_z": 2 * pi, "slider.z": 0.5, "slider.vz": 0.0, "rod1.omega_y": 0.0,
                   "rod2.omega_y": 0.0})  # fmt: skip
