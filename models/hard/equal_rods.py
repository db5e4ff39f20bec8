"""A slider-crank whose rod is as long as its crank, or nearly.

             B o
              / \\
       crank /   \\ rod
            /     \\
         A o       o--[C]--
        ///      slider ///

With equal rods two motions meet where the crank is upright and the slider stands over A: the slider
passes through A, or it stays there while rod and crank turn as one. Velocities are continuous on
either, so the first goes on as long as it is moving. A rod that is a little longer has no such
position: the slider turns round in front of A, ever more sharply. A rod that is shorter cannot let
the crank turn over: free, the machine swings back; driven, it locks up.

Crank and rod are uniform rods of 1 kg/m (C), the crank of 1 m; the slider has 1 kg. No gravity: the
kinetic energy is all there is, so that the speed follows from the position in closed form.

Scenes
------
spin
    Let go with the crank at 45 degrees and 2 rad/s.
driven
    The crank turned at constant speed.
"""

from math import pi

from codegen import Model, t

model = Model("equal_rods")
rod_length = model.parameter("rod_length", 1.0, unit="m", sign="positive")
drive_speed = model.parameter("drive_speed", 2 * pi, unit="rad/s")

crank = model.body("crank", mass=1.0, inertia=1 / 12)
rod = model.body("rod", mass=rod_length, inertia=rod_length**3 / 12)
slider = model.body("slider", mass=1.0, inertia=0.1)

model.revolute("A", model.ground.at(0, 0), crank.at(-0.5, 0))
model.revolute("B", crank.at(0.5, 0), rod.at(-rod_length / 2, 0))
model.revolute("C", rod.at(rod_length / 2, 0), slider.at(0, 0))
model.translational("guide", model.ground, slider, axis=(1, 0))
model.driver("crank_drive", crank.phi, pi / 4 + drive_speed * t)

held = {crank.phi: pi / 4, crank.omega: 2.0}
drawn = {crank.x: 0.35, crank.y: 0.35, rod.x: 1.06, rod.y: 0.35, rod.phi: -pi / 4, slider.x: 1.41}
model.scene("spin", [], start=held, guess=drawn)
model.scene("driven", [], ["crank_drive"], guess={**drawn, crank.phi: pi / 4})
