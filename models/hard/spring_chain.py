"""A chain of twenty masses on springs, struck at its end.

The coil spring of section 8.4 with as many lumps as a finite-element model of it would have: many
coordinates, a wide spectrum, and a closed form, the sum over the chain's modes.

Scenes
------
struck
    At rest but for the last mass, which is hit.
"""

from codegen import Model

COUNT, STIFFNESS, MASS, PITCH, BLOW = 20, 200.0, 2.5, 0.2, -0.1

model = Model("spring_chain")

masses = [model.body(f"mass_{i}", mass=MASS, inertia=1.0) for i in range(1, COUNT + 1)]
for body in masses:
    model.translational(f"guide_{body.name}", model.ground, body, axis=(1, 0))

ends = zip([model.ground, *masses], masses, strict=False)
springs = [model.spring(f"spring_{i}", *pair, STIFFNESS, PITCH) for i, pair in enumerate(ends, 1)]

at_rest = {body.x: i * PITCH for i, body in enumerate(masses, 1)}

model.scene("struck", springs, start={**at_rest, masses[-1].vx: BLOW})
