"""A spring of 1e9 N/m beside one of 1 N/m.

Two masses in a row on a guide, the first held to the ground by the stiff spring, the second to the
first by the soft one. The start is the soft mode alone: the stiff one, 5000 Hz, is asleep, but an
explicit method must step as if it were awake.

Scenes
------
soft_mode
    The second mass let go 0.1 m from rest, the first where the soft mode has it.
"""

from math import sqrt

from codegen import Model

STIFF, SOFT, REST = 1e9, 1.0, 1.0
AMPLITUDE = 0.1

model = Model("stiff_soft")

first = model.body("first", mass=1.0, inertia=1.0)
second = model.body("second", mass=1.0, inertia=1.0)
for body in (first, second):
    model.translational(f"guide_{body.name}", model.ground, body, axis=(1, 0))

model.spring("stiff", model.ground, first, stiffness=STIFF, free_length=REST)
model.spring("soft", first, second, stiffness=SOFT, free_length=REST)

# ω² of the soft mode is the smaller root of (K + k - ω²)(k - ω²) = k² for masses of 1 kg, in the
# form that does not cancel; its shape follows from the first row.
both = STIFF + 2 * SOFT
slow = 2 * STIFF * SOFT / (both + sqrt(both**2 - 4 * STIFF * SOFT))
share = SOFT / (STIFF + SOFT - slow)

model.scene("soft_mode", ["stiff", "soft"],
            start={first.x: REST + share * AMPLITUDE, second.x: 2 * REST + AMPLITUDE,
                   first.vx: 0.0, second.vx: 0.0})  # fmt: skip
