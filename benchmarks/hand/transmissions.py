"""Belts, screws, gears with backlash, stops and clearances by their formulas, written by hand.

q = (x_i, y_i, φ_i, x_j, y_j, φ_j), as in `benchmarks.hand.joints` and `benchmarks.hand.forces`.
"""

import math

from benchmarks.hand.forces import SIX, SIY, UX, UY, rotated
from benchmarks.hand.signatures import force, position, velocity

LEAD = 0.05 / (2.0 * math.pi)


@position
def belt_jacobian(t, q, p, values):
    values[0] = -0.2
    values[1] = 0.3


@position
def screw_jacobian(t, q, p, values):
    """The nut is point i, the spindle j, the frame the ground."""
    ix, iy = rotated(q[2], SIX, SIY)
    values[0] = UX
    values[1] = UY
    values[2] = UY * ix - UX * iy
    values[3] = -LEAD


@velocity
def screw_rhs(t, q, v, p, gamma):
    ix, iy = rotated(q[2], SIX, SIY)
    gamma[0] = v[2] * v[2] * (UX * ix + UY * iy)


@force
def elastic_belt(t, q, v, p, modes, Q):
    """500 N/m and 20 N a strand, on radii of 0.2 m and 0.3 m; each strand on its own."""
    u = 0.3 * q[5] - 0.2 * q[2]
    on_i, on_j = 0.0, 0.0
    if modes[0]:
        f = 500.0 * (u + 0.04)
        on_i += 0.2 * f
        on_j -= 0.3 * f
    if modes[1]:
        f = 500.0 * (u - 0.04)
        on_i += 0.2 * f
        on_j -= 0.3 * f
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = on_i
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = on_j


@force
def gear_with_backlash(t, q, v, p, modes, Q):
    """500 N/m beyond 0.02 m, on radii of 0.2 m and 0.3 m; each flank on its own."""
    u = 0.2 * q[2] + 0.3 * q[5]
    on_i, on_j = 0.0, 0.0
    if modes[0]:
        f = 500.0 * (u - 0.02)
        on_i -= 0.2 * f
        on_j -= 0.3 * f
    if modes[1]:
        f = 500.0 * (u + 0.02)
        on_i -= 0.2 * f
        on_j -= 0.3 * f
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = on_i
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = on_j
