"""The slider-crank compressor, derived and written by hand.

`jacobian` and `acceleration_rhs` are Haug's formulas for revolute and translational joints
(3.3.12, 3.3.14) with every product of a zero left out. `crank_acceleration` is the equation of
motion in the one coordinate φ₁ that is left when the loop is solved by hand:

    L sin φ₂ = -r sin φ₁
    x₂ = r cos φ₁ + L/2 cos φ₂,   y₂ = r/2 sin φ₁,   x₃ = r cos φ₁ + L cos φ₂
    J(φ₁) φ̈₁ + J'(φ₁) φ̇₁² / 2 = n + m₂ g x₂' + (m₃ g + F) x₃'

where a dash is d/dφ₁ and J = J₁ + m₂ (x₂'² + y₂'²) + J₂ φ₂'² + m₃ x₃'².
All take the arguments of the generated kernels: p = J1, rod_length, motor_torque, …

Array elements are read before the first branch: numba counts references to arrays that are used
behind one, which costs more than the equation.
"""

import math
from typing import Any

import numba

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": {"contract"}}
RADIUS = 2.0
ROD_MASS, ROD_INERTIA, SLIDER_MASS, GRAVITY = 35.0, 35.0, 25.0, 9.81


@numba.njit("void(f8, f8[::1], f8[::1], f8[::1])", **OPTIONS)
def jacobian(t, q, p, values):
    """Structural non-zeros of Φ_q in the order of the generated module."""
    half = 0.5 * p[1]
    s1, c1 = RADIUS * math.sin(q[2]), RADIUS * math.cos(q[2])
    s2, c2 = half * math.sin(q[5]), half * math.cos(q[5])
    # A: ground - crank, at the crank's centre
    values[0] = -1.0
    values[1] = -1.0
    # B: crank pin - rod end
    values[2] = 1.0
    values[3] = -s1
    values[4] = -1.0
    values[5] = -s2
    values[6] = 1.0
    values[7] = c1
    values[8] = -1.0
    values[9] = c2
    # C: rod end - slider
    values[10] = 1.0
    values[11] = -s2
    values[12] = -1.0
    values[13] = 1.0
    values[14] = c2
    values[15] = -1.0
    # guide
    values[16] = 1.0
    values[17] = 1.0


@numba.njit("void(f8, f8[::1], f8[::1], f8[::1], f8[::1])", **OPTIONS)
def acceleration_rhs(t, q, v, p, gamma):
    """γ: A_i s'_i φ̇_i² - A_j s'_j φ̇_j² of each revolute joint."""
    crank, rod = RADIUS * (v[2] * v[2]), 0.5 * p[1] * (v[5] * v[5])
    rod_x, rod_y = rod * math.cos(q[5]), rod * math.sin(q[5])
    gamma[0] = 0.0
    gamma[1] = 0.0
    gamma[2] = crank * math.cos(q[2]) + rod_x
    gamma[3] = crank * math.sin(q[2]) + rod_y
    gamma[4] = rod_x
    gamma[5] = rod_y
    gamma[6] = 0.0
    gamma[7] = 0.0


@numba.njit("i8(f8, f8[::1], f8[::1], f8[::1], i8[::1], f8[::1], f8[::1])", **OPTIONS)
def crank_acceleration(t, q, v, p, modes, a, lam):
    """φ̈₁ into a[2], from φ₁ and φ̇₁ alone."""
    inertia, length, force, omega = p[0], p[1], p[2], v[2]
    closed, compressing, exhausting, outwards = modes[0], modes[1], modes[2], modes[3]
    s, c = math.sin(q[2]), math.cos(q[2])
    ratio = RADIUS / length
    sin2 = -ratio * s
    cos2 = math.sqrt(1.0 - sin2 * sin2)
    inverse = 1.0 / cos2
    turn = -ratio * c * inverse  # φ₂'
    bend = (sin2 * turn * turn - sin2) * inverse  # φ₂''
    rs, rc = RADIUS * s, RADIUS * c
    arm = length * (sin2 * turn)
    bow = length * (cos2 * turn * turn + sin2 * bend)
    x2, y2, x3 = -rs - 0.5 * arm, 0.5 * rc, -rs - arm
    x2_, y2_, x3_ = -rc - 0.5 * bow, -0.5 * rs, -rc - bow
    inertia += ROD_MASS * (x2 * x2 + y2 * y2)
    inertia += ROD_INERTIA * (turn * turn) + SLIDER_MASS * (x3 * x3)
    slope = ROD_MASS * (x2 * x2_ + y2 * y2_)
    slope += ROD_INERTIA * (turn * bend) + SLIDER_MASS * (x3 * x3_)
    gas = 0.0
    if outwards and not closed:
        x = rc + length * cos2
        if compressing:
            gas = 62857.0 - 282857.0 / (6.0 - x)
        elif exhausting:
            gas = -110000.0 * (1.0 - math.sin(2.0 * math.pi * (x - 5.25)))
    force += ROD_MASS * GRAVITY * x2 + (SLIDER_MASS * GRAVITY + gas) * x3
    a[2] = (force - slope * (omega * omega)) / inertia
    return 0
