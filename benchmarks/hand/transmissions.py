"""Belts, screws, gears with backlash, stops and clearances by their formulas, written by hand.

q = (x_i, y_i, φ_i, x_j, y_j, φ_j), as in `benchmarks.hand.joints` and `benchmarks.hand.forces`.
"""

import math

from benchmarks.hand.forces import SIX, SIY, SJX, SJY, UX, UY, rotated
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


@force
def stop(t, q, v, p, modes, Q):
    """500 N/m below -0.1 m and above 0.3 m of x_j."""
    f = 0.0
    if modes[0]:
        f += 500.0 * (q[3] + 0.1)
    if modes[1]:
        f += 500.0 * (q[3] - 0.3)
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = -f
    Q[4] = 0.0
    Q[5] = 0.0


@force
def clearance(t, q, v, p, modes, Q):
    """700 δ² (1 + 0.3 δ̇) beyond 0.1 m."""
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    dx, dy = q[3] + jx - q[0] - ix, q[4] + jy - q[1] - iy
    vx, vy = v[3] - wj * jy - v[0] + wi * iy, v[4] + wj * jx - v[1] - wi * ix
    if modes[0]:
        e = math.sqrt(dx * dx + dy * dy)
        depth = (dx * dx + dy * dy - 0.01) / (e + 0.1)
        f = 700.0 * depth * depth * (1.0 + 0.3 * (dx * vx + dy * vy) / e) / e
    else:
        f = 0.0
    fx, fy = f * dx, f * dy
    Q[0] = fx
    Q[1] = fy
    Q[2] = ix * fy - iy * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy


@force
def one_way_clutch(t, q, v, p, modes, Q):
    """T_c = 40 + 5 x_j² + 3 y_j on j and its opposite on i while j is slower."""
    n = 40.0 + 5.0 * (q[3] * q[3]) + 3.0 * q[4] if modes[0] else 0.0
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = -n
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = n
