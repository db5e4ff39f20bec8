"""The slider-crank without gas in the one coordinate that is left of it.

Five seconds, 160 turns; φ(5) by two independent programs in more digits than a float has.
"""

import math

import numba

from benchmarks.floor.dop853 import OPTIONS, integrator

START = (math.pi, 30.0)
PARAMETERS = (450.0, 41450.0)
DURATION = 5.0
REFERENCE = 1007.754839355
RADIUS, LENGTH, ROD, SLIDER, GRAVITY = 2.0, 3.5, 35.0, 25.0, 9.81


@numba.njit(**OPTIONS)
def slope(phi, omega, inertia, torque):
    """φ̇ and φ̈ by J φ̈ + J' φ̇²/2 = n + m₂ g x₂' + m₃ g x₃', as in `benchmarks.hand`."""
    ratio = RADIUS / LENGTH
    s, c = math.sin(phi), math.cos(phi)
    sin2 = -ratio * s
    cos2 = math.sqrt(1.0 - sin2 * sin2)
    inverse = 1.0 / cos2
    turn = -ratio * c * inverse
    bend = (sin2 * turn * turn - sin2) * inverse
    rs, rc = RADIUS * s, RADIUS * c
    arm = LENGTH * (sin2 * turn)
    bow = LENGTH * (cos2 * turn * turn + sin2 * bend)
    x2, y2, x3 = -rs - 0.5 * arm, 0.5 * rc, -rs - arm
    x2_, y2_, x3_ = -rc - 0.5 * bow, -0.5 * rs, -rc - bow
    mass = inertia + ROD * (x2 * x2 + y2 * y2) + ROD * (turn * turn) + SLIDER * (x3 * x3)
    change = ROD * (x2 * x2_ + y2 * y2_) + ROD * (turn * bend) + SLIDER * (x3 * x3_)
    force = torque + ROD * GRAVITY * x2 + SLIDER * GRAVITY * x3
    return omega, (force - change * (omega * omega)) / mass


run = integrator(slope, ("phi", "omega"), ("inertia", "torque"))


def answer(tolerance: float) -> tuple[float, int, int]:
    """φ after the run, and accepted and rejected steps."""
    phi, _, steps, rejected = run(*START, 0.0, DURATION, 1e-3, tolerance, *PARAMETERS)
    return phi, steps, rejected
