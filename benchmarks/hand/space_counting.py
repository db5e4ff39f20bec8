"""Joints in space that count their angles or slides; axes as in `benchmarks.hand.space_joints`."""

import math

from benchmarks.hand.signatures import position, velocity, woven
from benchmarks.hand.space import (
    SJX,
    SJY,
    SJZ,
    bending,
    centripetal,
    cross,
    departing,
    dot,
    dot_row,
    doubled,
    less,
    line_row,
    norm_rhs,
    norm_rows,
    opposite,
    poses,
    span_row,
    spins,
    turned,
    way,
    x_row,
    y_row,
    z_row,
)
from benchmarks.hand.space_joints import FX, FZ, HX, HY, HZ, across, level

LEAD = 0.05 / (2.0 * math.pi)


@woven
def quaternion(a, b):
    """The product of two quaternions."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@woven
def four(a, b):
    """aᵀ b of quaternions."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@position
def screw_jacobian(t, q, p, values):
    """The bodies share h' and f'; Φ_6 = 2 wᵀ (p̄_i p_j) with w = (-sin θ/2, h' cos θ/2).

    Of an equation that is linear in p_i, Φ_p loses its part along p_i, which is Φ.
    """
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h, aj = across(a), turned(b, HX, HY, HZ), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, f, e, aj)
    span_row(values, 22, di, dj, g, e, aj)
    dot_row(values, 36, di, dj, f, h)
    dot_row(values, 44, di, dj, g, h)
    # s = L/2π (θ + uᵀ f_j), u = g cos θ - f sin θ
    c, s = math.cos(q[14]), math.sin(q[14])
    fj, axis = level(b, FX, FZ), turned(a, HX, HY, HZ)
    u = c * g[0] - s * f[0], c * g[1] - s * f[1], c * g[2] - s * f[2]
    n = cross(u, fj)
    n = LEAD * n[0], LEAD * n[1], LEAD * n[2]
    arm = cross(aj, axis)
    back = arm[0] + n[0], arm[1] + n[1], arm[2] + n[2]
    line_row(values, 52, di, dj, axis, less(cross(axis, e), n), back)
    values[66] = LEAD * (s * dot(g, fj) + c * dot(f, fj)) - LEAD
    c, s = math.cos(0.5 * q[14]), math.sin(0.5 * q[14])
    pi, pj = (q[3], q[4], q[5], q[6]), (q[10], q[11], q[12], q[13])
    of_j = quaternion(pi, (-s, HX * c, HY * c, HZ * c))
    of_i = quaternion(pj, (-s, -HX * c, -HY * c, -HZ * c))
    phi = four(of_j, pj)
    values[67], values[68] = 2.0 * of_i[0] - phi * di[0], 2.0 * of_i[1] - phi * di[1]
    values[69], values[70] = 2.0 * of_i[2] - phi * di[2], 2.0 * of_i[3] - phi * di[3]
    values[71], values[72] = 2.0 * of_j[0] - phi * dj[0], 2.0 * of_j[1] - phi * dj[1]
    values[73], values[74] = 2.0 * of_j[2] - phi * dj[2], 2.0 * of_j[3] - phi * dj[3]
    values[75] = four(quaternion(pi, (-c, -HX * s, -HY * s, -HZ * s)), pj)


@velocity
def screw_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    along = dot(turned(a, HX, HY, HZ), k)
    k = bending(wi, wj, turned(b, HX, HY, HZ))
    gamma[4] = -dot(f, k)
    gamma[5] = -dot(g, k)
    # u turns with ω_i, and by θ' about h: u_θ = h × u
    c, s, rate, fj = math.cos(q[14]), math.sin(q[14]), v[14], level(b, FX, FZ)
    u = c * g[0] - s * f[0], c * g[1] - s * f[1], c * g[2] - s * f[2]
    slope = -(s * g[0] + c * f[0]), -(s * g[1] + c * f[1]), -(s * g[2] + c * f[2])
    bend = dot(u, bending(wi, wj, fj)) + rate * (
        2.0 * dot(slope, cross(less(wj, wi), fj)) - rate * dot(u, fj)
    )
    gamma[6] = LEAD * bend - along
    c, s = math.cos(0.5 * q[14]), math.sin(0.5 * q[14])
    pi, pj = (q[3], -q[4], -q[5], -q[6]), (q[10], q[11], q[12], q[13])
    ri, rj = (v[3], -v[4], -v[5], -v[6]), (v[10], v[11], v[12], v[13])
    turn, one, two = quaternion(pi, pj), quaternion(ri, pj), quaternion(pi, rj)
    both = quaternion(ri, rj)
    first = one[1] + two[1], one[2] + two[2], one[3] + two[3]
    first_h = HX * first[0] + HY * first[1] + HZ * first[2]
    turn_h = HX * turn[1] + HY * turn[2] + HZ * turn[3]
    both_h = HX * both[1] + HY * both[2] + HZ * both[3]
    phi = c * turn_h - s * turn[0]
    across_ = s * first_h + c * (one[0] + two[0])
    speed = 0.25 * (rate * rate) + four(ri, ri) + four(rj, rj)
    gamma[7] = 2.0 * (speed * phi + rate * across_) - 4.0 * (c * both_h - s * both[0])


@woven
def angle_row(values, k, p, d, angle):
    """Of the angle about the ground's z axis, 2 (e3 cos θ/2 - e0 sin θ/2) = 0: five entries."""
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    phi = c * p[3] - s * p[0]
    values[k] = -2.0 * s - phi * d[0]
    values[k + 1] = -phi * d[1]
    values[k + 2] = -phi * d[2]
    values[k + 3] = 2.0 * c - phi * d[3]
    values[k + 4] = -(s * p[3] + c * p[0])


@woven
def angle_rhs(p, v, angle, rate):
    """γ of it."""
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    speed = 0.25 * (rate * rate) + four(v, v)
    return 2.0 * (speed * (c * p[3] - s * p[0]) + rate * (s * v[3] + c * v[0]))


@woven
def upright_rhs(w, h):
    """γ of h_x = 0 and of h_y = 0."""
    c = centripetal(w, h)
    return -c[0], -c[1]


@position
def gear_jacobian(t, q, p, values):
    """Both wheels keep their z' axes upright and count their angles; θ_j + 1.5 θ_i = 0."""
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    hi, hj = (a[2], a[5], a[8]), (b[2], b[5], b[8])
    x_row(values, 8, di, hi)
    y_row(values, 12, di, hi)
    angle_row(values, 16, (q[3], q[4], q[5], q[6]), di, q[14])
    x_row(values, 21, dj, hj)
    y_row(values, 25, dj, hj)
    angle_row(values, 29, (q[10], q[11], q[12], q[13]), dj, q[15])
    values[34] = 1.5
    values[35] = 1.0


@velocity
def gear_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    gamma[2], gamma[3] = upright_rhs(wi, (a[2], a[5], a[8]))
    pi, ri = (q[3], q[4], q[5], q[6]), (v[3], v[4], v[5], v[6])
    gamma[4] = angle_rhs(pi, ri, q[14], v[14])
    gamma[5], gamma[6] = upright_rhs(wj, (b[2], b[5], b[8]))
    pj, rj = (q[10], q[11], q[12], q[13]), (v[10], v[11], v[12], v[13])
    gamma[7] = angle_rhs(pj, rj, q[15], v[15])
    gamma[8] = 0.0


@position
def rack_jacobian(t, q, p, values):
    """The pinion i as above; a point of j slides along the z axis; s - 0.25 θ = 0."""
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    hi, aj = (a[2], a[5], a[8]), turned(b, SJX, SJY, SJZ)
    x_row(values, 8, di, hi)
    y_row(values, 12, di, hi)
    angle_row(values, 16, (q[3], q[4], q[5], q[6]), di, q[14])
    values[21] = 1.0
    x_row(values, 22, dj, aj)
    values[26] = 1.0
    y_row(values, 27, dj, aj)
    values[31] = 1.0
    z_row(values, 32, dj, aj)
    values[36] = -1.0
    values[37] = -0.25
    values[38] = 1.0


@velocity
def rack_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    gamma[2], gamma[3] = upright_rhs(wi, (a[2], a[5], a[8]))
    pi, ri = (q[3], q[4], q[5], q[6]), (v[3], v[4], v[5], v[6])
    gamma[4] = angle_rhs(pi, ri, q[14], v[14])
    c = centripetal(wj, turned(b, SJX, SJY, SJZ))
    gamma[5], gamma[6], gamma[7] = opposite(c)
    gamma[8] = 0.0


# -- an expression ------------------------------------------------------------------------------


@position
def parabola_jacobian(t, q, p, values):
    """z_j - 2 x_i² = 0."""
    norm_rows(values, doubled((q[3], q[4], q[5], q[6])), doubled((q[10], q[11], q[12], q[13])))
    values[8] = -4.0 * q[0]
    values[9] = 1.0


@velocity
def parabola_rhs(t, q, v, p, gamma):
    norm_rhs(v, gamma)
    gamma[2] = 4.0 * (v[0] * v[0])
