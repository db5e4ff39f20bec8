"""The quick-return shaper as an equation of motion in the crank's angle φ₃ alone, derived by hand.

The rocker turns about A, the crank's pin P is 1.5 m from B, 2 m above A, and the rocker's tip D is
4 m from A on the line A P. With a dash for d/dφ₃,

    ρ² = |P|² = 6.25 + 6 sin φ₃,   φ₂' = P × P' / ρ² = 1/2 - 0.875 / ρ²,   φ₂'' = 5.25 cos φ₃ / ρ⁴
    D = 4 P / ρ,   D' = φ₂' D⊥,   D'' = φ₂'' D⊥ - φ₂'² D
    l_y = D_y - 4,   l_x = √(1.9² - l_y²),   φ₅' = D_y' / l_x,   φ₅'' = (D_y'' + l_y φ₅'²) / l_x
    x₆' = D_x' + l_y φ₅',   x₆'' = D_x'' + l_x φ₅'² + l_y φ₅''
    J φ̈₃ + (J'/2) φ̇₃² = n - V' + F x₆'

Rocker and block turn together; the rod's centre of mass is midway between D and the slider.

Arrays are read before the first branch, conditions among them: see `benchmarks.hand.slider_crank`.
"""

import math

from benchmarks.hand.signatures import solution

G = 9.81
ROCKER, BLOCK, ROD = 100.0, 5.0, 30.0
J_B = BLOCK * 1.5**2
J_2 = 100.0 + ROCKER * 2.0**2 + 0.05
J_5 = 10.0


@solution
def quick_return(t, q, v, p, modes, a, lam):
    """φ̈₃ of the crank into a[5]; p = J3, m6, T3, cutting_force."""
    cut = modes[0] & modes[1] & modes[2]
    J_3, slider, torque, force, omega = p[0], p[1], p[2], p[3], v[5]
    s, c = math.sin(q[5]), math.cos(q[5])
    inverse = 1.0 / (6.25 + 6.0 * s)
    reach = 4.0 * math.sqrt(inverse)
    x, y = reach * (1.5 * c), reach * (2.0 + 1.5 * s)
    w2, a2 = 0.5 - 0.875 * inverse, 5.25 * c * (inverse * inverse)
    x_, y_ = -w2 * y, w2 * x
    x__, y__ = -a2 * y - w2 * w2 * x, a2 * x - w2 * w2 * y
    ly = y - 4.0
    lx = math.sqrt(1.9 * 1.9 - ly * ly)
    inverse = 1.0 / lx
    w5 = y_ * inverse
    a5 = (y__ + ly * (w5 * w5)) * inverse
    x6, x6_ = x_ + ly * w5, x__ + lx * (w5 * w5) + ly * a5
    x5, x5_ = 0.5 * (x6 + x_), 0.5 * (x6_ + x__)
    inertia = J_3 + J_B + J_2 * (w2 * w2) + J_5 * (w5 * w5)
    inertia += ROD * (x5 * x5) + 0.25 * ROD * (y_ * y_) + slider * (x6 * x6)
    slope = J_2 * (w2 * a2) + J_5 * (w5 * a5)
    slope += ROD * (x5 * x5_) + 0.25 * ROD * (y_ * y__) + slider * (x6 * x6_)
    torque -= G * (ROCKER + ROD) / 2.0 * y_ + G * BLOCK * 1.5 * c
    if cut:
        torque += force * x6
    a[5] = (torque - slope * (omega * omega)) / inertia
    return 0
