"""Rows of joints in space, and their γ, by the formulas of Haug's sections 9.3 and 9.4, by hand.

q = (x, y, z, e0, e1, e2, e3) of body i, then of body j, with pᵀp = 1. All vectors are turned into
global axes, a = A a', and so are turns: δa = δπ × a, with the angular velocity ω = 2 E ṗ and
E = [-e, ẽ + e0 I], so that the columns of p are Φ_p = 2 Φ_π E. A row begins at `values[k]`.
"""

import math

from benchmarks.hand.signatures import woven

SI, SJ = (0.3, -0.2, 0.1), (-0.5, 0.1, 0.2)
SIX, SIY, SIZ = SI
SJX, SJY, SJZ = SJ


@woven
def doubled(p):
    """2 p."""
    return 2.0 * p[0], 2.0 * p[1], 2.0 * p[2], 2.0 * p[3]


@woven
def rotation(p, d):
    """A, row by row, with d = 2 p."""
    e1, e2, e3 = p[1], p[2], p[3]
    s = d[0] * p[0] - 1.0
    xy, xz, yz = d[1] * e2, d[1] * e3, d[2] * e3
    wx, wy, wz = d[0] * e1, d[0] * e2, d[0] * e3
    first, second = (s + d[1] * e1, xy - wz, xz + wy), (xy + wz, s + d[2] * e2, yz - wx)
    return (*first, *second, xz - wy, yz + wx, s + d[3] * e3)


@woven
def poses(q):
    """2 p and A of both bodies."""
    pi, pj = (q[3], q[4], q[5], q[6]), (q[10], q[11], q[12], q[13])
    di, dj = doubled(pi), doubled(pj)
    return di, dj, rotation(pi, di), rotation(pj, dj)


@woven
def turned(a, x, y, z):
    """A (x, y, z)."""
    return (
        a[0] * x + a[1] * y + a[2] * z,
        a[3] * x + a[4] * y + a[5] * z,
        a[6] * x + a[7] * y + a[8] * z,
    )


@woven
def relative_turn(pi, pj):
    """θ = χ n of A_iᵀ A_j, by its Euler parameters (w, u), and (1 - χ/2 cot χ/2) / χ²."""
    w = pi[0] * pj[0] + pi[1] * pj[1] + pi[2] * pj[2] + pi[3] * pj[3]
    x = pi[0] * pj[1] - pi[1] * pj[0] - pi[2] * pj[3] + pi[3] * pj[2]
    y = pi[0] * pj[2] - pi[2] * pj[0] - pi[3] * pj[1] + pi[1] * pj[3]
    z = pi[0] * pj[3] - pi[3] * pj[0] - pi[1] * pj[2] + pi[2] * pj[1]
    sine = math.sqrt(x * x + y * y + z * z)
    half = math.atan(sine / w)  # of (-w, -u) it is the same
    scale, chi = 2.0 * half / sine, 2.0 * half
    return (scale * x, scale * y, scale * z), (1.0 - half * w / sine) / (chi * chi)


@woven
def dot(a, b):
    """aᵀ b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@woven
def cross(a, b):
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@woven
def opposite(a):
    """-a."""
    return -a[0], -a[1], -a[2]


@woven
def spin(d, v):
    """ω = 2 E ṗ."""
    return (
        d[0] * v[1] - d[1] * v[0] - d[3] * v[2] + d[2] * v[3],
        d[3] * v[1] - d[2] * v[0] + d[0] * v[2] - d[1] * v[3],
        d[1] * v[2] - d[3] * v[0] - d[2] * v[1] + d[0] * v[3],
    )


@woven
def spins(v, di, dj):
    """ω of both bodies."""
    return spin(di, (v[3], v[4], v[5], v[6])), spin(dj, (v[10], v[11], v[12], v[13]))


@woven
def spread(values, k, d, n):
    """2 Eᵀ n: four columns of p from those of a turn."""
    x, y, z = n
    values[k] = -(d[1] * x + d[2] * y + d[3] * z)
    values[k + 1] = d[0] * x + d[3] * y - d[2] * z
    values[k + 2] = d[0] * y - d[3] * x + d[1] * z
    values[k + 3] = d[2] * x - d[1] * y + d[0] * z


# -- rows ---------------------------------------------------------------------------------------


@woven
def norm_rows(values, di, dj):
    """Of pᵀp = 1, at the beginning."""
    values[0], values[1], values[2], values[3] = di
    values[4], values[5], values[6], values[7] = dj


@woven
def x_row(values, k, d, a):
    """The columns of p of a turned vector's x: 2 Eᵀ (0, a_z, -a_y)."""
    y, z = a[1], a[2]
    values[k], values[k + 1] = d[3] * y - d[2] * z, d[3] * z + d[2] * y
    values[k + 2], values[k + 3] = d[0] * z - d[1] * y, -(d[1] * z + d[0] * y)


@woven
def y_row(values, k, d, a):
    """The same of its y: 2 Eᵀ (-a_z, 0, a_x)."""
    x, z = a[0], a[2]
    values[k], values[k + 1] = d[1] * z - d[3] * x, -(d[0] * z + d[2] * x)
    values[k + 2], values[k + 3] = d[3] * z + d[1] * x, d[0] * x - d[2] * z


@woven
def z_row(values, k, d, a):
    """The same of its z: 2 Eᵀ (a_y, -a_x, 0)."""
    x, y = a[0], a[1]
    values[k], values[k + 1] = d[2] * x - d[1] * y, d[0] * y - d[3] * x
    values[k + 2], values[k + 3] = -(d[3] * y + d[0] * x), d[2] * y + d[1] * x


@woven
def point_rows(values, k, di, dj, ai, aj):
    """Of r_i + a_i - r_j - a_j = 0: thirty entries."""
    back = opposite(aj)
    values[k], values[k + 5] = 1.0, -1.0
    values[k + 10], values[k + 15] = 1.0, -1.0
    values[k + 20], values[k + 25] = 1.0, -1.0
    x_row(values, k + 1, di, ai)
    x_row(values, k + 6, dj, back)
    y_row(values, k + 11, di, ai)
    y_row(values, k + 16, dj, back)
    z_row(values, k + 21, di, ai)
    z_row(values, k + 26, dj, back)


@woven
def dot_row(values, k, di, dj, f, h):
    """Of f_iᵀ h_j, eight entries: Φ_πi = f × h = -Φ_πj."""
    n = cross(f, h)
    spread(values, k, di, n)
    spread(values, k + 4, dj, opposite(n))


@woven
def line_row(values, k, di, dj, h, of_i, of_j):
    """The row of a force h between the bodies, with its moments: fourteen entries."""
    values[k], values[k + 1], values[k + 2] = opposite(h)
    spread(values, k + 3, di, of_i)
    values[k + 7], values[k + 8], values[k + 9] = h
    spread(values, k + 10, dj, of_j)


@woven
def span_row(values, k, di, dj, h, e, aj):
    """Of h_iᵀ d: Φ_πi = h × e with e = r_j + a_j - r_i, Φ_πj = a_j × h."""
    line_row(values, k, di, dj, h, cross(h, e), cross(aj, h))


@woven
def length_row(values, k, di, dj, ai, aj, d):
    """Of dᵀd / 2: Φ_πi = d × a_i, Φ_πj = a_j × d."""
    line_row(values, k, di, dj, d, cross(d, ai), cross(aj, d))


@woven
def way(q, aj):
    """e = r_j + a_j - r_i: what a_i adds to h_iᵀ d is constant."""
    return q[7] + aj[0] - q[0], q[8] + aj[1] - q[1], q[9] + aj[2] - q[2]


@woven
def less(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


# -- γ ------------------------------------------------------------------------------------------


@woven
def norm_rhs(v, gamma):
    """Of pᵀp = 1: -2 ṗᵀṗ."""
    gamma[0] = -2.0 * (v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6])
    gamma[1] = -2.0 * (v[10] * v[10] + v[11] * v[11] + v[12] * v[12] + v[13] * v[13])


@woven
def centripetal(w, a):
    """ω × (ω × a)."""
    along, square = dot(w, a), dot(w, w)
    return w[0] * along - square * a[0], w[1] * along - square * a[1], w[2] * along - square * a[2]


@woven
def point_rhs(gamma, k, wi, wj, ai, aj):
    """Of r_i + a_i - r_j - a_j = 0."""
    ci, cj = centripetal(wi, ai), centripetal(wj, aj)
    gamma[k], gamma[k + 1], gamma[k + 2] = less(cj, ci)


@woven
def bending(wi, wj, h):
    """k, with fᵀk the second derivative of fᵀh while f turns with ω_i and h with ω_j, constant.

    f̈ᵀh + 2 ḟᵀḣ + fᵀḧ = fᵀ (ω_i (ω_iᵀh) + ω_j (ω_jᵀh - 2 ω_iᵀh) - |ω_j - ω_i|² h).
    """
    w = less(wj, wi)
    square, of_i = dot(w, w), dot(wi, h)
    of_j = dot(wj, h) - 2.0 * of_i
    return (
        wi[0] * of_i + wj[0] * of_j - square * h[0],
        wi[1] * of_i + wj[1] * of_j - square * h[1],
        wi[2] * of_i + wj[2] * of_j - square * h[2],
    )


@woven
def way_rate(v, wj, aj):
    """ė = ṙ_j + ω_j × a_j - ṙ_i."""
    c = cross(wj, aj)
    return v[7] + c[0] - v[0], v[8] + c[1] - v[1], v[9] + c[2] - v[2]


@woven
def departing(q, v, wi, wj, aj):
    """k, with hᵀk the second derivative of h_iᵀ d, and h'' = ω_i × (ω_i × h), h' = ω_i × h in it.

    k = ω_i × (ω_i × e) + 2 ė × ω_i + ω_j × (ω_j × a_j).
    """
    e, rate = way(q, aj), way_rate(v, wj, aj)
    c, b, f = centripetal(wi, e), cross(rate, wi), centripetal(wj, aj)
    return c[0] + 2.0 * b[0] + f[0], c[1] + 2.0 * b[1] + f[1], c[2] + 2.0 * b[2] + f[2]


@woven
def length_bend(q, v, wi, wj, ai, aj):
    """The second derivative of dᵀd / 2, and d and ḋ."""
    ci, cj = centripetal(wi, ai), centripetal(wj, aj)
    d, rate = less(way(q, aj), ai), less(way_rate(v, wj, aj), cross(wi, ai))
    return dot(rate, rate) + dot(d, less(cj, ci)), d, rate
