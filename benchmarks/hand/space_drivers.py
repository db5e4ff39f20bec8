"""Drivers in space: γ gains C̈ of the law C = 0.4 + 0.3 sin 2t, of the distance 1.5 + 0.3 sin 2t."""

import math

from benchmarks.hand.signatures import position, velocity
from benchmarks.hand.space import (
    SIX,
    SIY,
    SIZ,
    SJX,
    SJY,
    SJZ,
    centripetal,
    dot,
    doubled,
    length_bend,
    length_row,
    less,
    norm_rhs,
    norm_rows,
    poses,
    rotation,
    spin,
    spins,
    turned,
    way,
    x_row,
    y_row,
    z_row,
)
from benchmarks.hand.space_counting import angle_rhs, angle_row, upright_rhs


@position
def point_driver_jacobian(t, q, p, values):
    pj = q[10], q[11], q[12], q[13]
    dj = doubled(pj)
    norm_rows(values, doubled((q[3], q[4], q[5], q[6])), dj)
    values[8] = 1.0
    z_row(values, 9, dj, turned(rotation(pj, dj), SJX, SJY, SJZ))


@velocity
def point_driver_rhs(t, q, v, p, gamma):
    """C = 0.4 + 0.3 sin 2t."""
    pj = q[10], q[11], q[12], q[13]
    dj = doubled(pj)
    w = spin(dj, (v[10], v[11], v[12], v[13]))
    norm_rhs(v, gamma)
    c = centripetal(w, turned(rotation(pj, dj), SJX, SJY, SJZ))
    gamma[2] = -1.2 * math.sin(2.0 * t) - c[2]


@position
def rotation_driver_jacobian(t, q, p, values):
    """Body j keeps its z' axis upright; its angle follows the law."""
    pj = q[10], q[11], q[12], q[13]
    dj = doubled(pj)
    norm_rows(values, doubled((q[3], q[4], q[5], q[6])), dj)
    b = rotation(pj, dj)
    h = b[2], b[5], b[8]
    x_row(values, 8, dj, h)
    y_row(values, 12, dj, h)
    angle_row(values, 16, pj, dj, q[14])
    values[21] = 1.0


@velocity
def rotation_driver_rhs(t, q, v, p, gamma):
    pj, rj = (q[10], q[11], q[12], q[13]), (v[10], v[11], v[12], v[13])
    dj = doubled(pj)
    b = rotation(pj, dj)
    norm_rhs(v, gamma)
    gamma[2], gamma[3] = upright_rhs(spin(dj, rj), (b[2], b[5], b[8]))
    gamma[4] = angle_rhs(pj, rj, q[14], v[14])
    gamma[5] = -1.2 * math.sin(2.0 * t)


@position
def distance_driver_jacobian(t, q, p, values):
    """ℓ = 1.5 + 0.3 sin 2t."""
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    x, y, z = less(way(q, aj), ai)
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    length_row(values, 8, di, dj, ai, aj, (inverse * x, inverse * y, inverse * z))


@velocity
def distance_driver_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    bend, d, rate = length_bend(q, v, wi, wj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    inverse = 1.0 / math.sqrt(dot(d, d))
    speed = inverse * dot(d, rate)
    gamma[2] = -1.2 * math.sin(2.0 * t) - inverse * (bend - speed * speed)
