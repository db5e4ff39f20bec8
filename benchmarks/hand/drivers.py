"""Drivers by the formulas of Haug's section 3.5, written out by hand; γ gains C̈ of the law C(t).

q = (x_i, y_i, φ_i, x_j, y_j, φ_j). The laws are C = 0.4 + 0.3 sin 2t, for the distance
1.5 + 0.3 sin 2t; points, axis and names as in `benchmarks.hand.joints`.
"""

import math

from benchmarks.hand.signatures import position, small, velocity

SIX, SIY, SJX, SJY = 0.3, -0.2, -0.5, 0.1
UX, UY = 0.6, 0.8


@small
def rotated(phi, x, y):
    """A (x, y)."""
    c, s = math.cos(phi), math.sin(phi)
    return c * x - s * y, s * x + c * y


@position
def motion_jacobian(t, q, p, values):
    values[0] = 1.0


@velocity
def motion_rhs(t, q, v, p, gamma):
    gamma[0] = -1.2 * math.sin(2.0 * t)


@position
def point_jacobian(t, q, p, values):
    values[0] = 1.0
    values[1] = -(math.sin(q[5]) * SJX + math.cos(q[5]) * SJY)


@velocity
def point_rhs(t, q, v, p, gamma):
    on_j = math.cos(q[5]) * SJX - math.sin(q[5]) * SJY
    gamma[0] = v[5] * v[5] * on_j - 1.2 * math.sin(2.0 * t)


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
    gamma[0] = v[5] * v[5] * on_j - v[2] * v[2] * on_i - 1.2 * math.sin(2.0 * t)


@position
def translation_jacobian(t, q, p, values):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    values[0] = -ux
    values[1] = -uy
    values[2] = ux * (q[4] + jy - q[1]) - uy * (q[3] + jx - q[0])
    values[3] = ux
    values[4] = uy
    values[5] = uy * jx - ux * jy


@velocity
def translation_rhs(t, q, v, p, gamma):
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    along = ux * (q[3] + jx - q[0]) + uy * (q[4] + jy - q[1])
    aside = ux * (v[4] + wj * jx - v[1]) - uy * (v[3] - wj * jy - v[0])
    turning = wi * (wi * along - 2.0 * aside) + wj * wj * (ux * jx + uy * jy)
    gamma[0] = turning - 1.2 * math.sin(2.0 * t)


@position
def distance_jacobian(t, q, p, values):
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    dx, dy = q[3] + jx - q[0] - ix, q[4] + jy - q[1] - iy
    inverse = 1.0 / math.sqrt(dx * dx + dy * dy)
    dx, dy = inverse * dx, inverse * dy
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
    vx, vy = v[3] - wj * jy - v[0] + wi * iy, v[4] + wj * jx - v[1] - wi * ix
    wi, wj = wi * wi, wj * wj
    inverse = 1.0 / math.sqrt(dx * dx + dy * dy)
    aside = inverse * (dx * vy - dy * vx)  # d'd + v'v - (d'v)² / d'd needs only what is across
    bend = dx * (wi * ix - wj * jx) + dy * (wi * iy - wj * jy)
    gamma[0] = -inverse * (aside * aside + bend) - 1.2 * math.sin(2.0 * t)
