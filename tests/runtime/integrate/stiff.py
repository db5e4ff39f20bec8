"""Systems with derivatives, for the tests of implicit methods."""

from dataclasses import replace

import numpy as np

from runtime.core.kernel_abi import SIGNATURES
from runtime.integrate.problem import Problem
from tests.runtime.integrate.systems import (
    PENDULUM,
    free_system,
    kernel,
    pendulum_correction,
    relay,
)


@kernel(SIGNATURES["correction_tangent"])
def free_correction_tangent(t, q, v, p, w, dq_in, dv_in, dq, dv):
    dq[:] = 0.0
    dv[:] = 0.0


@kernel(SIGNATURES["accelerations_tangent"])
def relay_tangent(t, q, v, p, modes, dq, dv, da):
    da[0] = p[1] * dq[0] + p[2] * dv[0]
    for k in range(modes.size):
        if modes[k] != 0:
            da[0] += p[4 + 7 * k] * dq[0] + p[5 + 7 * k] * dv[0]


def smooth_relay(*switches, **coefficients):
    """As `relay`, with derivatives."""
    system, p = relay(*switches, **coefficients)
    return replace(
        system, accelerations_tangent=relay_tangent, correction_tangent=free_correction_tangent
    ), p


@kernel(SIGNATURES["accelerations_tangent"])
def pendulum_accelerations_tangent(t, q, v, p, modes, dq, dv, da):
    m, J, L, g = p[0], p[1], p[2], p[3]
    c, s = np.cos(q[2]), np.sin(q[2])
    alpha = -m * g * L * c / (J + m * L * L)
    turn = m * g * L * s / (J + m * L * L) * dq[2]
    da[2] = turn
    da[0] = (
        -L * s * turn
        - L * c * alpha * dq[2]
        + L * s * v[2] * v[2] * dq[2]
        - 2.0 * L * c * v[2] * dv[2]
    )
    da[1] = (
        L * c * turn
        - L * s * alpha * dq[2]
        - L * c * v[2] * v[2] * dq[2]
        - 2.0 * L * s * v[2] * dv[2]
    )


@kernel(SIGNATURES["correction_tangent"])
def pendulum_correction_tangent(t, q, v, p, w, dq_in, dv_in, dq, dv):
    # A central difference: 1e-10 of the kernel that it differentiates.
    step = 1e-5
    dq_low, dv_low = np.zeros(3), np.zeros(3)
    pendulum_correction(t, q + step * dq_in, v + step * dv_in, p, w, dq, dv)
    pendulum_correction(t, q - step * dq_in, v - step * dv_in, p, w, dq_low, dv_low)
    for j in range(3):
        dq[j] = (dq[j] - dq_low[j]) / (2.0 * step)
        dv[j] = (dv[j] - dv_low[j]) / (2.0 * step)


SMOOTH_PENDULUM = replace(
    PENDULUM,
    accelerations_tangent=pendulum_accelerations_tangent,
    correction_tangent=pendulum_correction_tangent,
)


# Van der Pol's oscillator, a = mu (1 - q^2) v - q; p = mu.


@kernel(SIGNATURES["accelerations"])
def van_der_pol_accelerations(t, q, v, p, modes, a, lam):
    a[0] = p[0] * (1.0 - q[0] * q[0]) * v[0] - q[0]
    return 0


@kernel(SIGNATURES["accelerations_tangent"])
def van_der_pol_tangent(t, q, v, p, modes, dq, dv, da):
    da[0] = p[0] * (1.0 - q[0] * q[0]) * dv[0] - (2.0 * p[0] * q[0] * v[0] + 1.0) * dq[0]


VAN_DER_POL = free_system(
    accelerations=van_der_pol_accelerations,
    accelerations_tangent=van_der_pol_tangent,
    correction_tangent=free_correction_tangent,
)


# A coordinate that a stiff damped spring draws after a motion law (A. Prothero and A. Robinson,
# Mathematics of Computation 28, 1974): a = -sin t - k (q - sin t) - d (v - cos t); p = k, d.


@kernel(SIGNATURES["accelerations"])
def drawn_accelerations(t, q, v, p, modes, a, lam):
    a[0] = -np.sin(t) - p[0] * (q[0] - np.sin(t)) - p[1] * (v[0] - np.cos(t))
    return 0


@kernel(SIGNATURES["accelerations_tangent"])
def drawn_tangent(t, q, v, p, modes, dq, dv, da):
    da[0] = -p[0] * dq[0] - p[1] * dv[0]


DRAWN = replace(VAN_DER_POL, accelerations=drawn_accelerations, accelerations_tangent=drawn_tangent)


def one(q, v, t_end, p):
    """A problem of one coordinate."""
    return Problem(0.0, t_end, np.array([q]), np.array([v]), np.asarray(p, dtype=float), np.ones(1))
