"""Friction in joints in space: its power f ṡ from the multipliers λ of the joint, by hand.

A row Φ of a joint pushes body j with -λ Φ_r and turns it with -λ Φ_π. So a revolute joint, whose
first rows are r_i + a_i - r_j - a_j, has the force λ on j; rows dᵀf and dᵀg have the forces
-λ f and -λ g. Rows fᵀh_j and gᵀh_j have the torques λ f × h_j and λ g × h_j. Of such a torque T

    fᵀT = λ_g hᵀh_j,   gᵀT = -λ_f hᵀh_j,   hᵀT = λ_f gᵀh_j - λ_g fᵀh_j,

and the row gᵀf_j of a translational joint adds -λ fᵀf_j to the last. λ has the two norms first.
"""

import math

from benchmarks.hand.signatures import power
from benchmarks.hand.space import dot, poses, turned
from benchmarks.hand.space_joints import FJX, FJY, FJZ, HX, HY, HZ, KX, KY, KZ, across

MU, CREEP, RADIUS, LENGTH, COLLAR = 0.3, 0.01, 0.02, 0.4, 0.03


@power
def revolute(t, q, v, p, modes, lam, out):
    """Both ends of a bearing, |F_t/2 ± T × h / b|, and a thrust face."""
    _, _, a, b = poses(q)
    (f, g), h = across(a), turned(a, HX, HY, HZ)
    force, c = (lam[2], lam[3], lam[4]), (1.0 / LENGTH) * dot(h, turned(b, KX, KY, KZ))
    x, y = 0.5 * dot(f, force), 0.5 * dot(g, force)
    tx, ty = c * lam[5], c * lam[6]
    one, two = (x - tx) * (x - tx) + (y - ty) * (y - ty), (x + tx) * (x + tx) + (y + ty) * (y + ty)
    load = math.sqrt(one) + math.sqrt(two) + (COLLAR / RADIUS) * abs(dot(h, force))
    rate = v[14]
    out[0] = -(MU * RADIUS) * load * rate * math.tanh((1.0 / CREEP) * rate)


@power
def translational(t, q, v, p, modes, lam, out):
    """The force across the guide, and the torque about its axis at a radius."""
    _, _, a, b = poses(q)
    (f, g), h = across(a), turned(b, KX, KY, KZ)
    torque = lam[4] * dot(g, h) - lam[5] * dot(f, h) - lam[6] * dot(f, turned(b, FJX, FJY, FJZ))
    load = math.sqrt(lam[2] * lam[2] + lam[3] * lam[3]) + (1.0 / RADIUS) * abs(torque)
    speed = v[14]
    out[0] = -MU * load * speed * math.tanh((1.0 / CREEP) * speed)


@power
def cylindrical(t, q, v, p, modes, lam, out):
    """-μ N vᵀv / √(vᵀv + v_c²) of the slip v = (ṡ, R ω)."""
    spin, speed = RADIUS * v[14], v[15]
    square = spin * spin + speed * speed
    load = math.sqrt(lam[2] * lam[2] + lam[3] * lam[3])
    out[0] = -MU * load * square / math.sqrt(square + CREEP * CREEP)
