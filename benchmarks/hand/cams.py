"""Joints in which curves touch, by the formulas of Haug's section 3.4, written out by hand.

q = (x_i, y_i, φ_i, x_j, y_j, φ_j, α, β). With e = (cos α, sin α) the cams are the eccentric
circle c = z + R e, in `flat`, and the ellipse c = (a cos α, b sin α), for which c'' = -c and
c''' = -c'. P is the follower's point in the cam's frame, p = P - c, and |c'(0)| = b.
"""

import math

from benchmarks.hand.signatures import position, small, velocity

R, ZX, ZY, UX, UY = 0.1, 0.02, 0.01, 0.6, 0.8
A, B = 0.2, 0.1
SX, SY = -0.5, 0.1
ROLLER = 0.05


@small
def rotated(phi, x, y):
    """A (x, y)."""
    c, s = math.cos(phi), math.sin(phi)
    return c * x - s * y, s * x + c * y


@position
def flat_jacobian(t, q, p, values):
    ci, si = math.cos(q[2]), math.sin(q[2])
    ux, uy = rotated(q[5], UX, UY)
    x, y = math.cos(q[6]), math.sin(q[6])
    ex, ey = ci * x - si * y, si * x + ci * y
    gx, gy = ci * ZX - si * ZY + R * ex, si * ZX + ci * ZY + R * ey
    normal, along = ux * ey - uy * ex, ux * ex + uy * ey
    values[0] = -uy
    values[1] = ux
    values[2] = uy * gy + ux * gx
    values[3] = uy
    values[4] = -ux
    values[5] = -(ux * (q[0] + gx - q[3]) + uy * (q[1] + gy - q[4]))
    values[6] = R * along
    values[7] = -normal
    values[8] = normal
    values[9] = -normal


@velocity
def flat_rhs(t, q, v, p, gamma):
    ci, si = math.cos(q[2]), math.sin(q[2])
    ux, uy = rotated(q[5], UX, UY)
    x, y = math.cos(q[6]), math.sin(q[6])
    ex, ey = ci * x - si * y, si * x + ci * y
    zx, zy = ci * ZX - si * ZY, si * ZX + ci * ZY
    w, turn, both = v[2], v[5], v[2] + v[6]
    rate = R * both
    hx, hy = q[0] + zx + R * ex - q[3], q[1] + zy + R * ey - q[4]
    vx, vy = v[0] - w * zy - rate * ey - v[3], v[1] + w * zx + rate * ex - v[4]
    normal, along = ux * ey - uy * ex, ux * ex + uy * ey
    gamma[0] = (
        turn * (turn * (ux * hy - uy * hx) + 2.0 * (ux * vx + uy * vy))
        + w * w * (ux * zy - uy * zx)
        + rate * both * normal
    )
    gap = turn - both
    gamma[1] = gap * gap * along


@position
def point_jacobian(t, q, p, values):
    c, s = math.cos(q[2]), math.sin(q[2])
    jx, jy = rotated(q[5], SX, SY)
    x, y = math.cos(q[6]), math.sin(q[6])
    px, py = q[3] + jx - q[0], q[4] + jy - q[1]
    px, py = c * px + s * py, c * py - s * px
    cx, cy = A / B * x, y  # c / |c'(0)|
    tx, ty = -A / B * y, x  # c' / |c'(0)|
    gx, gy = c * tx - s * ty, s * tx + c * ty
    values[0] = -gx
    values[1] = -gy
    values[2] = tx * py - ty * px
    values[3] = gx
    values[4] = gy
    values[5] = gy * jx - gx * jy
    values[6] = B * (cx * cx + cy * cy - tx * tx - ty * ty) - cx * px - cy * py
    values[7] = gy
    values[8] = -gx
    values[9] = -(tx * px + ty * py)
    values[10] = -gy
    values[11] = gx
    values[12] = gx * jx + gy * jy
    values[13] = cy * px - cx * py


@velocity
def point_rhs(t, q, v, p, gamma):
    c, s = math.cos(q[2]), math.sin(q[2])
    jx, jy = rotated(q[5], SX, SY)
    x, y = math.cos(q[6]), math.sin(q[6])
    w, turn, rate = v[2], v[5], v[6]
    px, py = q[3] + jx - q[0], q[4] + jy - q[1]
    px, py = c * px + s * py, c * py - s * px
    vx, vy = v[3] - turn * jy - v[0], v[4] + turn * jx - v[1]
    vx, vy = c * vx + s * vy, c * vy - s * vx
    turn *= turn
    bx, by = turn * (c * jx + s * jy), turn * (c * jy - s * jx)
    # P'' in the cam's frame, then p, p' and p'' of p = P - c
    ax, ay = w * (2.0 * vy - w * px) - bx, -w * (2.0 * vx + w * py) - by
    cx, cy = A * x, B * y
    tx, ty = -A * y, B * x
    vx, vy = vx + w * py - rate * tx, vy - w * px - rate * ty
    px, py = px - cx, py - cy
    square = rate * rate
    ax, ay = ax + square * cx, ay + square * cy
    along = 2.0 * rate * (cx * vx + cy * vy) + square * (tx * px + ty * py) - tx * ax - ty * ay
    across = 2.0 * rate * (cx * vy - cy * vx) + square * (tx * py - ty * px) - tx * ay + ty * ax
    gamma[0] = 1.0 / B * along
    gamma[1] = 1.0 / B * across


@position
def roller_jacobian(t, q, p, values):
    c, s = math.cos(q[2]), math.sin(q[2])
    cj, sj = math.cos(q[5]), math.sin(q[5])
    x, y = math.cos(q[6]), math.sin(q[6])
    mx, my = math.cos(q[7]), math.sin(q[7])
    ex, ey = cj * mx - sj * my, sj * mx + cj * my
    px, py = q[3] + ROLLER * ex - q[0], q[4] + ROLLER * ey - q[1]
    px, py = c * px + s * py, c * py - s * px
    cx, cy = A / B * x, y
    tx, ty = -A / B * y, x
    gx, gy = c * tx - s * ty, s * tx + c * ty
    aside, along = gy * ex - gx * ey, gx * ex + gy * ey
    values[0] = -gx
    values[1] = -gy
    values[2] = tx * py - ty * px
    values[3] = gx
    values[4] = gy
    values[5] = ROLLER * aside
    values[6] = B * (cx * cx + cy * cy - tx * tx - ty * ty) - cx * px - cy * py
    values[7] = values[5]
    values[8] = gy
    values[9] = -gx
    values[10] = -(tx * px + ty * py)
    values[11] = -gy
    values[12] = gx
    values[13] = ROLLER * along
    values[14] = cy * px - cx * py
    values[15] = values[13]
    values[16] = -aside
    values[17] = aside
    values[18] = -(c * cx - s * cy) * ex - (s * cx + c * cy) * ey
    values[19] = aside


@velocity
def roller_rhs(t, q, v, p, gamma):
    c, s = math.cos(q[2]), math.sin(q[2])
    cj, sj = math.cos(q[5]), math.sin(q[5])
    x, y = math.cos(q[6]), math.sin(q[6])
    mx, my = math.cos(q[7]), math.sin(q[7])
    w, turn, rate = v[2], v[5] + v[7], v[6]
    # everything in the cam's frame
    ex, ey = cj * mx - sj * my, sj * mx + cj * my
    ex, ey = c * ex + s * ey, c * ey - s * ex
    dx, dy, vx, vy = q[3] - q[0], q[4] - q[1], v[3] - v[0], v[4] - v[1]
    px, py = c * dx + s * dy + ROLLER * ex, c * dy - s * dx + ROLLER * ey
    spin = ROLLER * turn
    vx, vy = c * vx + s * vy - spin * ey, c * vy - s * vx + spin * ex
    spin *= turn
    ax, ay = w * (2.0 * vy - w * px) - spin * ex, -w * (2.0 * vx + w * py) - spin * ey
    cx, cy = A * x, B * y
    tx, ty = -A * y, B * x
    vx, vy = vx + w * py - rate * tx, vy - w * px - rate * ty
    px, py = px - cx, py - cy
    square = rate * rate
    ax, ay = ax + square * cx, ay + square * cy
    along = 2.0 * rate * (cx * vx + cy * vy) + square * (tx * px + ty * py) - tx * ax - ty * ay
    across = 2.0 * rate * (cx * vy - cy * vx) + square * (tx * py - ty * px) - tx * ay + ty * ax
    gamma[0] = 1.0 / B * along
    gamma[1] = 1.0 / B * across
    # e turns by `turn` - w in the cam's frame, and c' / |c'(0)| by α alone
    turn -= w
    slope = (turn * turn + square) * (tx * ex + ty * ey)
    gamma[2] = 1.0 / B * (slope + 2.0 * (rate * turn) * (cx * -ey + cy * ex))
