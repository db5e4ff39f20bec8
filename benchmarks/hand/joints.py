"""Joints between two bodies i and j by Haug's formulas of section 3.3, written out by hand.

q = (x_i, y_i, φ_i, x_j, y_j, φ_j). With a = A s' the way from a body's centre to its point, B s' is
(-a_y, a_x). Lines and racks have the axis u' = (0.6, 0.8) of body i, u = A_i u', its normal
n = (-u_y, u_x), and e = r_j + A_j s'_j - r_i; what s'_i adds to u'd and n'd is constant.
"""

import math

from benchmarks.hand.signatures import position, small, velocity

SIX, SIY, SJX, SJY = 0.3, -0.2, -0.5, 0.1
UX, UY = 0.6, 0.8
RADIUS, SHARE_I, SHARE_J, LINE = 0.25, 0.6, 0.4, 0.7


@small
def rotated(phi, x, y):
    """A (x, y)."""
    c, s = math.cos(phi), math.sin(phi)
    return c * x - s * y, s * x + c * y


@position
def absolute_jacobian(t, q, p, values):
    values[0] = 1.0
    values[1] = -(math.sin(q[5]) * SJX + math.cos(q[5]) * SJY)


@velocity
def absolute_rhs(t, q, v, p, gamma):
    gamma[0] = v[5] * v[5] * (math.cos(q[5]) * SJX - math.sin(q[5]) * SJY)


@position
def relative_jacobian(t, q, p, values):
    values[0] = -1.0
    values[1] = math.sin(q[2]) * SIX + math.cos(q[2]) * SIY
    values[2] = 1.0
    values[3] = -(math.sin(q[5]) * SJX + math.cos(q[5]) * SJY)


@velocity
def relative_rhs(t, q, v, p, gamma):
    on_i = math.cos(q[2]) * SIX - math.sin(q[2]) * SIY
    on_j = math.cos(q[5]) * SJX - math.sin(q[5]) * SJY
    gamma[0] = v[5] * v[5] * on_j - v[2] * v[2] * on_i


@position
def revolute_jacobian(t, q, p, values):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    values[0] = 1.0
    values[1] = -iy
    values[2] = -1.0
    values[3] = jy
    values[4] = 1.0
    values[5] = ix
    values[6] = -1.0
    values[7] = -jx


@velocity
def revolute_rhs(t, q, v, p, gamma):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2] * v[2], v[5] * v[5]
    gamma[0] = ix * wi - jx * wj
    gamma[1] = iy * wi - jy * wj


@position
def weld_jacobian(t, q, p, values):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    values[0] = 1.0
    values[1] = -iy
    values[2] = -1.0
    values[3] = jy
    values[4] = 1.0
    values[5] = ix
    values[6] = -1.0
    values[7] = -jx
    values[8] = -1.0
    values[9] = 1.0


@velocity
def weld_rhs(t, q, v, p, gamma):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2] * v[2], v[5] * v[5]
    gamma[0] = ix * wi - jx * wj
    gamma[1] = iy * wi - jy * wj
    gamma[2] = 0.0


@position
def distance_jacobian(t, q, p, values):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    dx = 2.0 * (q[3] + jx - q[0] - ix)
    dy = 2.0 * (q[4] + jy - q[1] - iy)
    values[0] = -dx
    values[1] = -dy
    values[2] = dx * iy - dy * ix
    values[3] = dx
    values[4] = dy
    values[5] = dy * jx - dx * jy


@velocity
def distance_rhs(t, q, v, p, gamma):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    dx, dy = q[3] + jx - q[0] - ix, q[4] + jy - q[1] - iy
    vx = v[3] - wj * jy - v[0] + wi * iy
    vy = v[4] + wj * jx - v[1] - wi * ix
    wi, wj = wi * wi, wj * wj
    bend = dx * (wi * ix - wj * jx) + dy * (wi * iy - wj * jy)
    gamma[0] = -2.0 * (vx * vx + vy * vy + bend)


@position
def revolute_translational_jacobian(t, q, p, values):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    values[0] = uy
    values[1] = -ux
    values[2] = -(ux * (q[3] + jx - q[0]) + uy * (q[4] + jy - q[1]))
    values[3] = -uy
    values[4] = ux
    values[5] = uy * jy + ux * jx


@velocity
def revolute_translational_rhs(t, q, v, p, gamma):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    across = ux * (q[4] + jy - q[1]) - uy * (q[3] + jx - q[0])
    along = ux * (v[3] - wj * jy - v[0]) + uy * (v[4] + wj * jx - v[1])
    gamma[0] = wi * (wi * across + 2.0 * along) + wj * wj * (ux * jy - uy * jx)


@position
def translational_jacobian(t, q, p, values):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    values[0] = uy
    values[1] = -ux
    values[2] = -(ux * (q[3] + jx - q[0]) + uy * (q[4] + jy - q[1]))
    values[3] = -uy
    values[4] = ux
    values[5] = uy * jy + ux * jx
    values[6] = -1.0
    values[7] = 1.0


@velocity
def translational_rhs(t, q, v, p, gamma):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    across = ux * (q[4] + jy - q[1]) - uy * (q[3] + jx - q[0])
    along = ux * (v[3] - wj * jy - v[0]) + uy * (v[4] + wj * jx - v[1])
    gamma[0] = wi * (wi * across + 2.0 * along) + wj * wj * (ux * jy - uy * jx)
    gamma[1] = 0.0


@position
def gear_jacobian(t, q, p, values):
    angle = LINE + SHARE_I * q[2] + SHARE_J * q[5]
    s, c = math.sin(angle), math.cos(angle)
    along = c * (q[3] - q[0]) + s * (q[4] - q[1])
    values[0] = -s
    values[1] = c
    values[2] = SHARE_I * along
    values[3] = s
    values[4] = -c
    values[5] = SHARE_J * along


@velocity
def gear_rhs(t, q, v, p, gamma):
    angle = LINE + SHARE_I * q[2] + SHARE_J * q[5]
    turn = SHARE_I * v[2] + SHARE_J * v[5]
    s, c = math.sin(angle), math.cos(angle)
    across = s * (q[3] - q[0]) - c * (q[4] - q[1])
    along = c * (v[3] - v[0]) + s * (v[4] - v[1])
    gamma[0] = turn * (turn * across - 2.0 * along)


@position
def rack_and_pinion_jacobian(t, q, p, values):
    ux, uy = rotated(q[2], UX, UY)
    ex, ey = q[3] - q[0], q[4] - q[1]
    values[0] = uy
    values[1] = -ux
    values[2] = -(ux * ex + uy * ey)
    values[3] = -uy
    values[4] = ux
    values[5] = -ux
    values[6] = -uy
    values[7] = ux * ey - uy * ex - RADIUS
    values[8] = ux
    values[9] = uy
    values[10] = RADIUS


@velocity
def rack_and_pinion_rhs(t, q, v, p, gamma):
    ux, uy = rotated(q[2], UX, UY)
    ex, ey = q[3] - q[0], q[4] - q[1]
    vx, vy = v[3] - v[0], v[4] - v[1]
    w = v[2]
    gamma[0] = w * (w * (ux * ey - uy * ex) + 2.0 * (ux * vx + uy * vy))
    gamma[1] = w * (w * (ux * ex + uy * ey) - 2.0 * (ux * vy - uy * vx))


@position
def parabola_jacobian(t, q, p, values):
    """A user's own equation: y_j - 2 x_i² = 0."""
    values[0] = -4.0 * q[0]
    values[1] = 1.0


@velocity
def parabola_rhs(t, q, v, p, gamma):
    gamma[0] = 4.0 * (v[0] * v[0])
