"""Four-bar linkages A B C D as equations of motion in the crank's angle φ alone, derived by hand.

With the vectors r from A to B, d from B to D, k from B to C and m from D to C,

    turn = k × m = √(b² d² - s²),   s = (d² + b² - c²) / 2
    k = (s d + turn d⊥) / d²,   m = k - d
    φ₃' = -r × m / turn,   φ₄' = -r × k / turn
    φ₃'' = e·m / turn,     φ₄'' = e·k / turn,   e = r + φ₃'² k - φ₄'² m
    J φ̈ + (J'/2) φ̇² = n - V'

where a dash is d/dφ, C lies to the left of d, and J(φ) = J_A + J_D φ₄'² + J_C φ₃'²: both couplers
have their centres of mass at C, so that their masses turn with the rockers about D.

Arrays are read before the first branch, conditions among them: see `benchmarks.hand.slider_crank`.
"""

import math

import numpy as np

from benchmarks.hand.signatures import solution

G = 9.81


def four_bar_parameters(p):
    """AB, AD, (b² - c²)/2, b², J_A, J_D, J_C, torque, and weights times arms of crank and m."""
    AB, BC, CD, AD, density, torque = p[:6]
    crank, coupler, rocker = density * AB, 2 * density * BC, density * CD
    around_D = rocker * CD**2 / 3 + coupler * CD**2
    weights = G * crank * AB / 2, G * (coupler + rocker / 2)
    half = (BC**2 - CD**2) / 2
    inertias = crank * AB**2 / 3, around_D, coupler * (2 * BC) ** 2 / 12
    return np.array([AB, AD, half, BC**2, *inertias, torque, *weights])


@solution
def four_bar(t, q, v, p, modes, a, lam):
    """φ̈ of the crank into a[2], D being on the x axis; p of `four_bar_parameters`."""
    AB, J_A, J_D, J_C, omega = p[0], p[4], p[5], p[6], v[2]
    s, c = math.sin(q[2]), math.cos(q[2])
    rx, ry = AB * c, AB * s
    dx, dy = p[1] - rx, -ry
    square = dx * dx + dy * dy
    half = p[2] + 0.5 * square
    turn = math.sqrt(p[3] * square - half * half)
    inverse = 1.0 / (turn * square)
    half, across, inverse = half * (turn * inverse), turn * (turn * inverse), square * inverse
    kx, ky = half * dx - across * dy, half * dy + across * dx
    mx, my = kx - dx, ky - dy
    w3, w4 = inverse * (ry * mx - rx * my), inverse * (ry * kx - rx * ky)
    ex = rx + w3 * w3 * kx - w4 * w4 * mx
    ey = ry + w3 * w3 * ky - w4 * w4 * my
    a3, a4 = inverse * (ex * mx + ey * my), inverse * (ex * kx + ey * ky)
    inertia = J_A + J_D * (w4 * w4) + J_C * (w3 * w3)
    slope = J_D * (w4 * a4) + J_C * (w3 * a3)
    weight = p[8] * c + p[9] * (w4 * mx)
    a[2] = (p[7] - weight - slope * (omega * omega)) / inertia
    return 0


CRANK, COUPLER, ROCKER = 0.1, 1.0, 2.0
AB, BC, CD, DX, DY = 0.04, 0.28, 0.40, 0.26, -0.04
J_A = 1.5e-5 + CRANK * 0.02**2
J_D = 0.04 + ROCKER * (0.26**2 + 0.07**2) + COUPLER * CD**2
J_C = 0.03
HALF = (BC**2 - CD**2) / 2


@solution
def web_cutter(t, q, v, p, modes, a, lam):
    """φ̈ of the crank into a[2]; p = drive_speed, cut_force, web_thickness, motor_gain."""
    cut = modes[0] & modes[1] & modes[2]
    force, torque, omega = p[1], p[3] * (p[0] - v[2]), v[2]
    s, c = math.sin(q[2]), math.cos(q[2])
    rx, ry = AB * c, AB * s
    dx, dy = DX - rx, DY - ry
    square = dx * dx + dy * dy
    half = HALF + 0.5 * square
    turn = math.sqrt(BC**2 * square - half * half)
    inverse = 1.0 / (turn * square)
    half, across, inverse = half * (turn * inverse), turn * (turn * inverse), square * inverse
    kx, ky = half * dx - across * dy, half * dy + across * dx
    mx, my = kx - dx, ky - dy
    w3, w4 = inverse * (ry * mx - rx * my), inverse * (ry * kx - rx * ky)
    ex = rx + w3 * w3 * kx - w4 * w4 * mx
    ey = ry + w3 * w3 * ky - w4 * w4 * my
    a3, a4 = inverse * (ex * mx + ey * my), inverse * (ex * kx + ey * ky)
    inertia = J_A + J_D * (w4 * w4) + J_C * (w3 * w3)
    slope = J_D * (w4 * a4) + J_C * (w3 * a3)
    centre = (COUPLER + ROCKER * (0.26 / CD)) * mx + ROCKER * (0.07 / CD) * my
    torque -= G * CRANK * 0.02 * c + G * (w4 * centre)
    if cut:
        above = w4 * mx + w3 * (0.04 / BC * kx + 0.24 / BC * ky)
        below = w4 * (0.26 / CD * mx + 0.20 / CD * my)
        torque += force * (above - below)
    a[2] = (torque - slope * (omega * omega)) / inertia
    return 0
