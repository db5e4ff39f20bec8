"""Joints in space with a coupler without mass; axes as in `benchmarks.hand.space_joints`.

A block slides along the line u' of body i, with m' and n' across it, of which m' has no y'.
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
    centripetal,
    cross,
    departing,
    dot,
    dot_row,
    length_row,
    less,
    norm_rhs,
    norm_rows,
    poses,
    span_row,
    spins,
    turned,
    way,
    way_rate,
)
from benchmarks.hand.space_joints import HX, HY, HZ, KX, KY, KZ, across, level

LINE = (0.36, 0.48, 0.8)
MX, MZ = 0.8 / math.hypot(0.8, 0.36), -0.36 / math.hypot(0.8, 0.36)  # ŷ × LINE, of length 1
NX, NY, NZ = np.cross(LINE, (MX, 0.0, MZ)).tolist()


@woven
def link_rhs(q, v, wi, wj, ai, aj, h):
    """γ of h_iᵀ d and of dᵀ d: with d the first is 2 ω_iᵀ (h × ḋ) and what bends h and the arms."""
    ci, cj = centripetal(wi, ai), centripetal(wj, aj)
    d, rate = less(way(q, aj), ai), less(way_rate(v, wj, aj), cross(wi, ai))
    bend, c, b = less(cj, ci), centripetal(wi, d), cross(rate, wi)
    k = c[0] + 2.0 * b[0] + bend[0], c[1] + 2.0 * b[1] + bend[1], c[2] + 2.0 * b[2] + bend[2]
    return -dot(h, k), -2.0 * (dot(rate, rate) + dot(d, bend))


@position
def revolute_spherical_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, turned(a, HX, HY, HZ), e, aj)
    x, y, z = less(e, ai)
    length_row(values, 22, di, dj, ai, aj, (2.0 * x, 2.0 * y, 2.0 * z))


@velocity
def revolute_spherical_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    ai, aj, h = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ), turned(a, HX, HY, HZ)
    gamma[2], gamma[3] = link_rhs(q, v, wi, wj, ai, aj, h)


@position
def revolute_revolute_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    (f, g), h, e = across(a), turned(b, KX, KY, KZ), way(q, aj)
    dot_row(values, 8, di, dj, f, h)
    dot_row(values, 16, di, dj, g, h)
    span_row(values, 24, di, dj, turned(a, HX, HY, HZ), e, aj)
    x, y, z = less(e, ai)
    length_row(values, 38, di, dj, ai, aj, (2.0 * x, 2.0 * y, 2.0 * z))


@velocity
def revolute_revolute_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    ai, aj, h = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ), turned(a, HX, HY, HZ)
    gamma[4], gamma[5] = link_rhs(q, v, wi, wj, ai, aj, h)


@position
def revolute_cylindrical_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), aj = across(a), turned(b, SJX, SJY, SJZ)
    e = way(q, aj)
    span_row(values, 8, di, dj, f, e, aj)
    span_row(values, 22, di, dj, g, e, aj)
    dot_row(values, 36, di, dj, turned(a, HX, HY, HZ), turned(b, KX, KY, KZ))


@velocity
def revolute_cylindrical_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    gamma[4] = -dot(turned(a, HX, HY, HZ), bending(wi, wj, turned(b, KX, KY, KZ)))


@position
def revolute_translational_jacobian(t, q, p, values):
    di, dj, a, b = poses(q)
    norm_rows(values, di, dj)
    (f, g), h, aj = across(a), turned(b, KX, KY, KZ), turned(b, SJX, SJY, SJZ)
    dot_row(values, 8, di, dj, f, h)
    dot_row(values, 16, di, dj, g, h)
    e = way(q, aj)
    span_row(values, 24, di, dj, level(a, MX, MZ), e, aj)
    span_row(values, 38, di, dj, turned(a, NX, NY, NZ), e, aj)


@velocity
def revolute_translational_rhs(t, q, v, p, gamma):
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    norm_rhs(v, gamma)
    (f, g), k = across(a), bending(wi, wj, turned(b, KX, KY, KZ))
    gamma[2] = -dot(f, k)
    gamma[3] = -dot(g, k)
    k = departing(q, v, wi, wj, turned(b, SJX, SJY, SJZ))
    gamma[4] = -dot(level(a, MX, MZ), k)
    gamma[5] = -dot(turned(a, NX, NY, NZ), k)
