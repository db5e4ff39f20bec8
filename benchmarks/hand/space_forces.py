"""Generalized forces in space by the formulas of Haug's section 11, written out by hand.

q, points and helpers are those of `benchmarks.hand.space`. A torque n about the centre of mass in
global axes has Q_p = 2 Eᵀ n, a point's force F the torque a × F. All of Q is written, with the
centrifugal force of the rotations, Q_p = -4 Ġᵀ J' ω' - 4 tr(J') (ṗᵀṗ) p.
"""

import math

from benchmarks.hand.signatures import force, woven
from benchmarks.hand.space import (
    SIX,
    SIY,
    SIZ,
    SJX,
    SJY,
    SJZ,
    cross,
    dot,
    doubled,
    less,
    opposite,
    poses,
    relative_turn,
    rotation,
    spins,
    turned,
    way,
    way_rate,
)

MASS_I, MASS_J = 2.0, 3.0
J_I, J_J = (0.1, 0.2, 0.3), (0.2, 0.3, 0.4)  # principal moments
BODIES = ("i", MASS_I, J_I), ("j", MASS_J, J_J)
XI, YI, ZI = J_I
XJ, YJ, ZJ = J_J
GX, GY, GZ = 1.0, 2.0, -9.81
FX, FY, FZ = 4.0, -7.0, 2.0
UX, UY, UZ = 2 / 7, 3 / 7, 6 / 7


@woven
def centrifugal(Q, k, p, d, v, jx, jy, jz):
    """Q_p of a body's rotation, from Q[k] on."""
    x = -4.0 * jx * (d[0] * v[1] - d[1] * v[0] + d[3] * v[2] - d[2] * v[3])
    y = -4.0 * jy * (d[0] * v[2] - d[2] * v[0] - d[3] * v[1] + d[1] * v[3])
    z = -4.0 * jz * (d[0] * v[3] - d[3] * v[0] + d[2] * v[1] - d[1] * v[2])
    s = -4.0 * (jx + jy + jz) * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3])
    Q[k] = s * p[0] - v[1] * x - v[2] * y - v[3] * z
    Q[k + 1] = s * p[1] + v[0] * x - v[3] * y + v[2] * z
    Q[k + 2] = s * p[2] + v[3] * x + v[0] * y - v[1] * z
    Q[k + 3] = s * p[3] - v[2] * x + v[1] * y + v[0] * z


@woven
def resting(q, v, Q):
    """The centrifugal forces of both bodies, and no other."""
    pi, pj = (q[3], q[4], q[5], q[6]), (q[10], q[11], q[12], q[13])
    ri, rj = (v[3], v[4], v[5], v[6]), (v[10], v[11], v[12], v[13])
    Q[0] = Q[1] = Q[2] = 0.0
    centrifugal(Q, 3, pi, doubled(pi), ri, XI, YI, ZI)
    Q[7] = Q[8] = Q[9] = 0.0
    centrifugal(Q, 10, pj, doubled(pj), rj, XJ, YJ, ZJ)


@woven
def turn(Q, k, d, n):
    """A torque about global axes: 2 Eᵀ n."""
    x, y, z = n
    Q[k] -= d[1] * x + d[2] * y + d[3] * z
    Q[k + 1] += d[0] * x + d[3] * y - d[2] * z
    Q[k + 2] += d[0] * y - d[3] * x + d[1] * z
    Q[k + 3] += d[2] * x - d[1] * y + d[0] * z


@woven
def pull(Q, di, dj, ai, aj, f):
    """A force f on the point of i, and -f on that of j."""
    Q[0], Q[1], Q[2] = f
    turn(Q, 3, di, cross(ai, f))
    Q[7], Q[8], Q[9] = opposite(f)
    turn(Q, 10, dj, cross(f, aj))


@woven
def turned_back(a, u):
    """Aᵀ u."""
    return (
        a[0] * u[0] + a[3] * u[1] + a[6] * u[2],
        a[1] * u[0] + a[4] * u[1] + a[7] * u[2],
        a[2] * u[0] + a[5] * u[1] + a[8] * u[2],
    )


@woven
def bent(theta, u, half, b):
    """u ± θ × u / 2 + b θ × (θ × u)."""
    c = cross(theta, u)
    d = cross(theta, c)
    return (
        u[0] + half * c[0] + b * d[0],
        u[1] + half * c[1] + b * d[1],
        u[2] + half * c[2] + b * d[2],
    )


@force
def gravity(t, q, v, p, modes, Q):
    resting(q, v, Q)
    Q[0] = MASS_I * GX
    Q[1] = MASS_I * GY
    Q[2] = MASS_I * GZ
    Q[7] = MASS_J * GX
    Q[8] = MASS_J * GY
    Q[9] = MASS_J * GZ


@force
def applied(t, q, v, p, modes, Q):
    resting(q, v, Q)
    pj = q[10], q[11], q[12], q[13]
    d = doubled(pj)
    a = turned(rotation(pj, d), SJX, SJY, SJZ)
    Q[7] = FX
    Q[8] = FY
    Q[9] = FZ
    turn(Q, 10, d, (a[1] * FZ - a[2] * FY, a[2] * FX - a[0] * FZ, a[0] * FY - a[1] * FX))


@force
def following(t, q, v, p, modes, Q):
    """A force fixed in the body; its torque in body axes, s' × F', is constant: Q_p = 2 Gᵀ n'."""
    resting(q, v, Q)
    pj = q[10], q[11], q[12], q[13]
    d = doubled(pj)
    Q[7], Q[8], Q[9] = turned(rotation(pj, d), FX, FY, FZ)
    x, y, z = SJY * FZ - SJZ * FY, SJZ * FX - SJX * FZ, SJX * FY - SJY * FX
    Q[10] -= d[1] * x + d[2] * y + d[3] * z
    Q[11] += d[0] * x - d[3] * y + d[2] * z
    Q[12] += d[3] * x + d[0] * y - d[1] * z
    Q[13] += d[1] * y - d[2] * x + d[0] * z


@force
def torque(t, q, v, p, modes, Q):
    resting(q, v, Q)
    turn(Q, 10, doubled((q[10], q[11], q[12], q[13])), (FX, FY, FZ))


@force
def torsion_spring(t, q, v, p, modes, Q):
    """n = 120 (θ - 0.4) + 9 θ̇ + 5 between bodies whose joint counts θ."""
    resting(q, v, Q)
    Q[14] = -(120.0 * (q[14] - 0.4) + 9.0 * v[14] + 5.0)


@force
def spring(t, q, v, p, modes, Q):
    """f = 120 (ℓ - 0.8) + 9 ℓ̇ + 5."""
    resting(q, v, Q)
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    d, rate = less(way(q, aj), ai), less(way_rate(v, wj, aj), cross(wi, ai))
    length = math.sqrt(dot(d, d))
    inverse = 1.0 / length
    f = inverse * (120.0 * (length - 0.8) + 9.0 * (inverse * dot(d, rate)) + 5.0)
    pull(Q, di, dj, ai, aj, (f * d[0], f * d[1], f * d[2]))


@force
def line_force(t, q, v, p, modes, Q):
    """f = 40 ℓ + 3."""
    resting(q, v, Q)
    di, dj, a, b = poses(q)
    ai, aj = turned(a, SIX, SIY, SIZ), turned(b, SJX, SJY, SJZ)
    d = less(way(q, aj), ai)
    length = math.sqrt(dot(d, d))
    f = (40.0 * length + 3.0) / length
    pull(Q, di, dj, ai, aj, (f * d[0], f * d[1], f * d[2]))


@force
def bushing(t, q, v, p, modes, Q):
    """f = K z + C ż of z = (s, θ), in the axes of i, with K = (900, 700, 800, 50, 60, 70).

    With the relative angular velocity ω in them, ω = H θ̇ and H⁻¹ = I - θ̃/2 + b θ̃², where
    b = (1 - χ/2 cot χ/2) / χ²; the virtual work τᵀ δθ is that of the torque H⁻ᵀ τ.
    """
    resting(q, v, Q)
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    aj = turned(b, SJX, SJY, SJZ)
    e, rate = way(q, aj), way_rate(v, wj, aj)
    s, slip = turned_back(a, e), turned_back(a, less(rate, cross(wi, e)))
    theta, bend = relative_turn((q[3], q[4], q[5], q[6]), (q[10], q[11], q[12], q[13]))
    x, y, z = bent(theta, turned_back(a, less(wj, wi)), -0.5, bend)
    f = turned(
        a,
        900.0 * (s[0] - SIX) + 8.0 * slip[0],
        700.0 * (s[1] - SIY) + 6.0 * slip[1],
        800.0 * (s[2] - SIZ) + 7.0 * slip[2],
    )
    tau = 50.0 * theta[0] + 0.4 * x, 60.0 * theta[1] + 0.5 * y, 70.0 * theta[2] + 0.6 * z
    x, y, z = bent(theta, tau, 0.5, bend)
    n = turned(a, x, y, z)
    c, d = cross(e, f), cross(f, aj)
    Q[0], Q[1], Q[2] = f
    turn(Q, 3, di, (c[0] + n[0], c[1] + n[1], c[2] + n[2]))
    Q[7], Q[8], Q[9] = opposite(f)
    turn(Q, 10, dj, less(d, n))


@woven
def push(Q, di, dj, u, e, aj, f):
    """A force f u on i along the face u of i, at the point of j, and its opposite on j."""
    force = f * u[0], f * u[1], f * u[2]
    Q[0], Q[1], Q[2] = force
    turn(Q, 3, di, cross(e, force))
    Q[7], Q[8], Q[9] = opposite(force)
    turn(Q, 10, dj, cross(force, aj))


@force
def contact(t, q, v, p, modes, Q):
    """f = 5000 g + 30 ġ while g = uᵀd - 0.1 is negative; what a_i adds to uᵀd is constant."""
    closed = modes[0]
    resting(q, v, Q)
    di, dj, a, b = poses(q)
    wi, wj = spins(v, di, dj)
    u, aj = turned(a, UX, UY, UZ), turned(b, SJX, SJY, SJZ)
    e, rate = way(q, aj), way_rate(v, wj, aj)
    if closed:
        gap = dot(u, e) - (UX * SIX + UY * SIY + UZ * SIZ + 0.1)
        f = 5000.0 * gap + 30.0 * dot(u, less(rate, cross(wi, e)))
    else:
        f = 0.0
    push(Q, di, dj, u, e, aj, f)


@force
def rigid_contact(t, q, v, p, modes, Q):
    """A unit of force, the weight of both bodies, along u while the gap is closed."""
    closed = modes[0]
    resting(q, v, Q)
    di, dj, a, b = poses(q)
    u, aj = turned(a, UX, UY, UZ), turned(b, SJX, SJY, SJZ)
    push(Q, di, dj, u, way(q, aj), aj, 0.0 if closed else -9.81 * (MASS_I + MASS_J))


@force
def dry_friction(t, q, v, p, modes, Q):
    """f = -0.4 · 30 N along x, against the slip of the centres of mass."""
    resting(q, v, Q)
    f = -12.0 if modes[0] else 12.0
    Q[0] = -f
    Q[7] = f


@force
def stop(t, q, v, p, modes, Q):
    """500 N/m below -0.1 m and above 0.3 m of z_j."""
    low, high, z = modes[0], modes[1], q[9]
    resting(q, v, Q)
    f = (500.0 * (z + 0.1) if low else 0.0) + (500.0 * (z - 0.3) if high else 0.0)
    Q[9] = -f


@force
def potential(t, q, v, p, modes, Q):
    """A user's own: V = 6 (x_i² + y_i²)²."""
    resting(q, v, Q)
    f = -24.0 * (q[0] * q[0] + q[1] * q[1])
    Q[0] = f * q[0]
    Q[1] = f * q[1]


@force
def generalized(t, q, v, p, modes, Q):
    """A user's own: a drag -3 ż_i √(ż_i² + 0.01)."""
    resting(q, v, Q)
    Q[2] = -3.0 * v[2] * math.sqrt(v[2] * v[2] + 0.01)
