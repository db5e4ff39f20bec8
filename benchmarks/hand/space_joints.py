"""Joints in space, put together of the rows of `benchmarks.hand.space`.

Body i has the axis h' = (2, 3, 6)/7 and with it f' and g', of which f' has no y'; body j has h'_j,
and f'_j, the part of f' across it, as the bodies' frames coincide at the drawing.
"""

import math

import numpy as np

from benchmarks.hand.signatures import position, velocity, woven
from benchmarks.hand.space import (
    SIX,
    SIY,
    SIZ,
    SJX,
    SJY,
    SJZ,
    bending,
    departing,
    dot,
    dot_row,
    length_bend,
    length_row,
    less,
    norm_rhs,
    norm_rows,
    point_rhs,
    point_rows,
    poses,
    span_row,
    spins,
    turned,
    way,
)

H, HJ = (2 / 7, 3 / 7, 6 / 7), (0.48, 0.6, 0.64)
HX, HY, HZ = H
KX, KY, KZ = HJ
FX, FZ = 3.0 / math.sqrt(10.0), -1.0 / math.sqrt(10.0)  # ŷ × h', of length 1
GX, GY, GZ = np.cross(H, (FX, 0.0, FZ)).tolist()
_ACROSS = np.array([FX, 0.0, FZ]) - np.array(HJ) * (FX * KX + FZ * KZ)
FJX, FJY, FJZ = (_ACROSS / np.linalg.norm(_ACROSS)).tolist()


@woven
def level(a, x, z):
    """A (x, 0, z)."""
    return a[0] * x + a[2] * z, a[3] * x + a[5] * z, a[6] * x + a[8] * z


@woven
def across(a):
    """f and g."""
    return level(a, FX, FZ), turned(a, GX, GY, GZ)


# -- points and axes ----------------------------------------------------------------------------


@position
def spherical_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    point_rows(values, 8, di, dj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))


@velocity
def spherical_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    point_rhs(gamma, 2, wi, wj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))


@position
def revolute_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    point_rows(values, 8, di, dj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    (f, g), h = across(a), turned(b, KX, KY, KZ)
    dot_row(values, 38, di, dj, f, h)
    dot_row(values, 46, di, dj, g, h)


@velocity
def revolute_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    point_rhs(gamma, 2, wi, wj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    (f, g), k = across(a), bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[5] = -dot(f, k)
    gamma[6] = -dot(g, k)


@position
def universal_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    point_rows(values, 8, di, dj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    dot_row(values, 38, di, dj, turned(a, HX, HY, HZ), turned(b, KX, KY, KZ))


@velocity
def universal_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    point_rhs(gamma, 2, wi, wj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    gamma[5] = -dot(turned(a, HX, HY, HZ), bending(wi, wj, turned(b, KX, KY, KZ)))


@position
def weld_jacobian(t, q, p, values):
    """The frames coincide: f, g and h are the columns of A."""
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    point_rows(values, 8, di, dj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    f, g = (a[0], a[3], a[6]), (a[1], a[4], a[7])
    fj, h = (b[0], b[3], b[6]), (b[2], b[5], b[8])
    dot_row(values, 38, di, dj, f, h)
    dot_row(values, 46, di, dj, g, h)
    dot_row(values, 54, di, dj, g, fj)


@velocity
def weld_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    point_rhs(gamma, 2, wi, wj, turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ))
    f, g = (a[0], a[3], a[6]), (a[1], a[4], a[7])
    fj, h = (b[0], b[3], b[6]), (b[2], b[5], b[8])
    k = bending(wi, wj, h)
    gamma[5] = -dot(f, k)
    gamma[6] = -dot(g, k)
    gamma[7] = -dot(g, bending(wi, wj, fj))


@position
def parallel_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h = across(a), turned(b, KX, KY, KZ)
    dot_row(values, 8, di, dj, f, h)
    dot_row(values, 16, di, dj, g, h)


@velocity
def parallel_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)


@position
def distance_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    x, y, z = less(way(q, aj), ai)
    length_row(values, 8, di, dj, ai, aj, (2.0 * x, 2.0 * y, 2.0 * z))


@velocity
def distance_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    gamma[2] = -2.0 * length_bend(q, v, wi, wj, ai, aj)[0]


# -- lines and planes ---------------------------------------------------------------------------


@position
def in_plane_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    aj = turned(b, SJX, SJY, SJZ)
    span_row(values, 8, di, dj, turned(a, HX, HY, HZ), way(q, aj), aj)


@velocity
def in_plane_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    k = departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(turned(a, HX, HY, HZ), k)


@position
def on_line_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), aj = across(a), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, f, e, aj)
    span_row(values, 22, di, dj, g, e, aj)


@velocity
def on_line_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)


@position
def cylindrical_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h, aj = across(a), turned(b, KX, KY, KZ), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, f, e, aj)
    span_row(values, 22, di, dj, g, e, aj)
    dot_row(values, 36, di, dj, f, h)
    dot_row(values, 44, di, dj, g, h)


@velocity
def cylindrical_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    k = bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[4] = -dot(f, k)
    gamma[5] = -dot(g, k)


@position
def translational_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h, aj = across(a), turned(b, KX, KY, KZ), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, f, e, aj)
    span_row(values, 22, di, dj, g, e, aj)
    dot_row(values, 36, di, dj, f, h)
    dot_row(values, 44, di, dj, g, h)
    dot_row(values, 52, di, dj, g, turned(b, FJX, FJY, FJZ))


@velocity
def translational_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    k = bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[4] = -dot(f, k)
    gamma[5] = -dot(g, k)
    gamma[6] = -dot(g, bending(wi, wj, turned(b, FJX, FJY, FJZ)))


@position
def planar_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h, aj = across(a), turned(b, KX, KY, KZ), turned(b, SJX, SJY, SJZ)
    dot_row(values, 8, di, dj, f, h)
    dot_row(values, 16, di, dj, g, h)
    span_row(values, 24, di, dj, turned(a, HX, HY, HZ), way(q, aj), aj)


@velocity
def planar_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    k = departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[4] = -dot(turned(a, HX, HY, HZ), k)
