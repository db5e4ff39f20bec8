"""Andrews' squeezing mechanism in the crank's angle, twice: loops as states, and loops solved.

The version of the Test Set for IVP Solvers: 0.03 s from the closed position with Θ = 0; β(0.03) is
its published solution. Angles are those of the bodies: crank β, its rod β + Θ, the link γ, the
chains δ and Φ + δ, ε and Ω + ε. With k = dθ/dβ and l = d²θ/dβ² of each, the kinetic energy is
M(β) ω²/2, and M ω̇ = Q - M' ω²/2.

`with_angles` is the equation of eight states: β, ω and the six other angles, which are integrated
by θ̇ = k ω and never returned to their loops. `in_closed_form` has β and ω alone: each loop is two
circles that meet, three roots and no function but the sine and cosine of β.
"""

import math

import numba

from benchmarks.floor.dop853 import OPTIONS, integrator

DURATION = 0.03
REFERENCE = 15.81077119629904
TORQUE = 0.033
START = (
    -0.0617138900142764496,
    0.0,
    -0.0617138900142764496,
    0.455279819163070380,
    0.710033369709728,
    0.487364979543842550,
    1.007879054378926,
    1.230547444549821192,
)
"""β, ω, β + Θ, γ, Φ + δ, δ, Ω + ε, ε."""

XA, YA, XB, YB, XC, YC = -0.06934, -0.00227, -0.03635, 0.03273, 0.014, 0.072
RA, RR, DA, D = 0.00092, 0.007, 0.0115, 0.028
SA, SB, SC, SD, SS = 0.01874, 0.01043, 0.018, 0.02, 0.035
EA, E, TA, TB, ZT = 0.01421, 0.02, 0.02308, 0.00916, 0.04
FA, ZF, UA, UB, U = 0.01421, 0.02, 0.01228, 0.00449, 0.04
STIFFNESS, FREE_LENGTH = 4530.0, 0.07785
M2, M4, M6 = 0.00365, 0.00706, 0.00706
I2, I4, I6 = 4.410e-7, 5.667e-7, 5.667e-7
# Bodies that turn about a point of the ground, and of the others what does not change.
ABOUT_O = 0.04325 * RA**2 + 2.194e-6 + M2 * RR**2
ABOUT_B = 0.02373 * (SA**2 + SB**2) + 5.255e-6
ABOUT_5 = 0.07050 * (TA**2 + TB**2) + 1.169e-5 + M4 * ZT**2
ABOUT_7 = 0.05498 * (UA**2 + UB**2) + 1.912e-5 + M6 * U**2
W4, W6 = E - EA, ZF - FA
SELF_2, WITH_2 = M2 * DA**2 + I2, M2 * RR * DA
SELF_4, WITH_4 = M4 * W4**2 + I4, M4 * ZT * W4
SELF_6, WITH_6 = M6 * W6**2 + I6, M6 * U * W6
BX, BY = XB - XC, YB - YC
SPRING = BX**2 + BY**2 + SD**2 + SC**2


@numba.njit(**OPTIONS)
def equation(omega, s1, c1, s2, c2, sg, cg, s4, c4, sd, cd, s6, c6, se, ce, torque):
    """ω̇ and the ratios k of the six other angles, from sines and cosines of all."""
    # The loop O-E-F-B: r (-s1, c1) + d k2 (s2, -c2) = ss kg (cg, sg).
    cos_1g, sin_1g = c1 * cg + s1 * sg, s1 * cg - c1 * sg
    cos_2g, sin_2g = c2 * cg + s2 * sg, s2 * cg - c2 * sg
    inverse = 1.0 / cos_2g
    k2 = (RR / D) * cos_1g * inverse
    kg = (D * k2 * sin_2g - RR * sin_1g) * (1.0 / SS)
    l2 = (D * k2 * k2 * sin_2g - RR * sin_1g - SS * kg * kg) * inverse * (1.0 / D)
    lg = (D * (k2 * k2 * cos_2g + l2 * sin_2g) - RR * cos_1g) * (1.0 / SS)
    # F' and F'' along and across the link.
    along, across = SS * lg, SS * kg * kg
    fx, fy = SS * kg * cg, SS * kg * sg
    ax, ay = along * cg - across * sg, along * sg + across * cg
    # The chain A-G-F: zt kd (-sd, cd) + e k4 (c4, s4) = F'.
    cos_4d, sin_4d = c4 * cd + s4 * sd, s4 * cd - c4 * sd
    inverse = 1.0 / cos_4d
    kd = (fy * c4 - fx * s4) * inverse * (1.0 / ZT)
    k4 = (fx * cd + fy * sd) * inverse * (1.0 / E)
    one, two = ZT * kd * kd, E * k4 * k4
    ld = (ay * c4 - ax * s4 + one * -sin_4d - two) * inverse * (1.0 / ZT)
    l4 = (ax * cd + ay * sd + one + two * sin_4d) * inverse * (1.0 / E)
    # The chain A-H-F: u ke (ce, se) + zf k6 (-s6, c6) = F'.
    cos_e6, sin_e6 = ce * c6 + se * s6, se * c6 - ce * s6
    inverse = 1.0 / cos_e6
    ke = (fx * c6 + fy * s6) * inverse * (1.0 / U)
    k6 = (fy * ce - fx * se) * inverse * (1.0 / ZF)
    one, two = U * ke * ke, ZF * k6 * k6
    le = (ax * c6 + ay * s6 + one * sin_e6 + two) * inverse * (1.0 / U)
    l6 = (ay * ce - ax * se - one + two * -sin_e6) * inverse * (1.0 / ZF)
    # M and M'/2.
    cos_12, sin_12 = c1 * c2 + s1 * s2, s1 * c2 - c1 * s2
    mass = (
        ABOUT_O
        + k2 * (SELF_2 * k2 - 2.0 * WITH_2 * cos_12)
        + ABOUT_B * kg * kg
        + ABOUT_5 * kd * kd
        + k4 * (SELF_4 * k4 + 2.0 * WITH_4 * kd * sin_4d)
        + ABOUT_7 * ke * ke
        + k6 * (SELF_6 * k6 + 2.0 * WITH_6 * ke * sin_e6)
    )
    change = (
        l2 * (SELF_2 * k2 - WITH_2 * cos_12)
        + WITH_2 * k2 * (1.0 - k2) * sin_12
        + ABOUT_B * kg * lg
        + ABOUT_5 * kd * ld
        + SELF_4 * k4 * l4
        + WITH_4 * ((ld * k4 + kd * l4) * sin_4d + kd * k4 * (k4 - kd) * cos_4d)
        + ABOUT_7 * ke * le
        + SELF_6 * k6 * l6
        + WITH_6 * ((le * k6 + ke * l6) * sin_e6 + ke * k6 * (ke - k6) * cos_e6)
    )
    rx, ry = SD * cg + SC * sg, SD * sg - SC * cg
    length = math.sqrt(SPRING + 2.0 * (BX * rx + BY * ry))
    pull = STIFFNESS * (1.0 - FREE_LENGTH / length) * (BY * rx - BX * ry)
    return (torque - pull * kg - change * omega * omega) / mass, k2, kg, k4, kd, k6, ke


@numba.njit(**OPTIONS)
def with_angles(beta, omega, rod, gamma, phi, delta, end, epsilon, torque):
    """The equation of eight states."""
    a, k2, kg, k4, kd, k6, ke = equation(
        omega,
        math.sin(beta),
        math.cos(beta),
        math.sin(rod),
        math.cos(rod),
        math.sin(gamma),
        math.cos(gamma),
        math.sin(phi),
        math.cos(phi),
        math.sin(delta),
        math.cos(delta),
        math.sin(end),
        math.cos(end),
        math.sin(epsilon),
        math.cos(epsilon),
        torque,
    )
    return omega, a, k2 * omega, kg * omega, k4 * omega, kd * omega, k6 * omega, ke * omega


@numba.njit(**OPTIONS)
def in_closed_form(beta, omega, torque):
    """The equation of two states: F is where circles about E and B meet; G and H likewise."""
    s1, c1 = math.sin(beta), math.cos(beta)
    x, y = RR * c1 - XB, RR * s1 - YB
    square = x * x + y * y
    share = 0.5 + (SS * SS - D * D) * 0.5 / square
    height = math.sqrt(SS * SS / square - share * share)
    fx, fy = share * x + height * y, share * y - height * x
    sg, cg = fx * (1.0 / SS), fy * (-1.0 / SS)
    c2, s2 = (x - fx) * (1.0 / D), (y - fy) * (1.0 / D)
    x, y = fx + (XB - XA), fy + (YB - YA)
    square = x * x + y * y
    inverse = 1.0 / square
    share = 0.5 + (ZT * ZT - E * E) * 0.5 * inverse
    height = math.sqrt(ZT * ZT * inverse - share * share)
    cx, cy = share * x - height * y, share * y + height * x
    cd, sd = cx * (1.0 / ZT), cy * (1.0 / ZT)
    s4, c4 = (x - cx) * (1.0 / E), (cy - y) * (1.0 / E)
    share = 0.5 + (U * U - ZF * ZF) * 0.5 * inverse
    height = math.sqrt(U * U * inverse - share * share)
    cx, cy = share * x + height * y, share * y - height * x
    se, ce = cx * (1.0 / U), cy * (-1.0 / U)
    c6, s6 = (x - cx) * (1.0 / ZF), (y - cy) * (1.0 / ZF)
    found = equation(omega, s1, c1, s2, c2, sg, cg, s4, c4, sd, cd, s6, c6, se, ce, torque)
    return omega, found[0]


ANGLES = ("beta", "omega", "rod", "gamma", "phi", "delta", "end", "epsilon")
run = integrator(with_angles, ANGLES, ("torque",))
run_closed = integrator(in_closed_form, ("beta", "omega"), ("torque",))


def answer(tolerance: float) -> tuple[float, int, int]:
    """β after the run of the eight states, and accepted and rejected steps."""
    beta, *_, steps, rejected = run(*START, 0.0, DURATION, 1e-4, tolerance, TORQUE)
    return beta, steps, rejected


def answer_closed(tolerance: float) -> tuple[float, int, int]:
    """The same of the two states."""
    beta, _, steps, rejected = run_closed(*START[:2], 0.0, DURATION, 1e-4, tolerance, TORQUE)
    return beta, steps, rejected
