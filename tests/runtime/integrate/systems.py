"""Small systems with kernels written by hand, for the integrator's tests."""

import numpy as np
from numba import njit

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.system import System
from runtime.integrate.method import EXPLICIT, IMPLICIT, REGISTER
from runtime.integrate.problem import Options, Problem, Trajectory, refuse_misfits
from runtime.integrate.recording_buffers import in_order
from runtime.integrate.run import Run

# Methods that keep errors and steps as small as tests of accuracy bound them.
ACCURATE = tuple(name for name in EXPLICIT if REGISTER[name].order >= 5)
ACCURATE_IMPLICIT = tuple(name for name in IMPLICIT if REGISTER[name].order >= 5)


def integrate(system, problem, options, progress=None, change=None):
    """A run whose problem and options fit, its events in order."""
    refuse_misfits(problem, options)
    path = Run(system, problem, options).execute(progress, change)
    return path._replace(events=in_order(path.events, path.final_t, system.rigid))


def kernel(signature):
    return njit(signature, cache=True, error_model="numpy", fastmath={"contract"})


# A pendulum: mass m and inertia J at (x, y, phi), held at distance L from the origin.
# p = m, J, L, g; x = L cos(phi), y = L sin(phi).
PENDULUM_P = np.array([1.0, 0.0, 1.0, 9.81])


@kernel(SIGNATURES["accelerations"])
def pendulum_accelerations(t, q, v, p, modes, a, lam):
    m, J, L, g = p[0], p[1], p[2], p[3]
    c, s = np.cos(q[2]), np.sin(q[2])
    # x' = -L s phi', y' = L c phi': one equation in phi, then back.
    alpha = -m * g * L * c / (J + m * L * L)
    a[2] = alpha
    a[0] = -L * s * alpha - L * c * v[2] * v[2]
    a[1] = L * c * alpha - L * s * v[2] * v[2]
    lam[0] = -m * a[0]
    lam[1] = -m * g - m * a[1]
    return 0


@kernel(SIGNATURES["correction"])
def pendulum_correction(t, q, v, p, w, dq, dv):
    L = p[2]
    c, s = np.cos(q[2]), np.sin(q[2])
    r0 = -(q[0] - L * c)
    r1 = -(q[1] - L * s)
    u0 = -(v[0] + L * s * v[2])
    u1 = -(v[1] - L * c * v[2])
    # Phi_q = [[1, 0, L s], [0, 1, -L c]]
    s00 = w[0] + w[2] * L * L * s * s
    s01 = -w[2] * L * L * s * c
    s11 = w[1] + w[2] * L * L * c * c
    weak = 0
    l10 = s01 / s00
    d1 = s11 - l10 * s01
    if not s00 > 1e-12 * max(w[0], w[1], w[2]):
        weak = 1
    elif not d1 > 1e-10 * s11:
        weak = 2
    y1 = (r1 - l10 * r0) / d1
    y0 = r0 / s00 - l10 * y1
    z1 = (u1 - l10 * u0) / d1
    z0 = u0 / s00 - l10 * z1
    dq[0] = w[0] * y0
    dq[1] = w[1] * y1
    dq[2] = w[2] * (L * s * y0 - L * c * y1)
    dv[0] = w[0] * z0
    dv[1] = w[1] * z1
    dv[2] = w[2] * (L * s * z0 - L * c * z1)
    return weak


@kernel(SIGNATURES["jacobian"])
def pendulum_jacobian(t, q, p, values):
    values[0] = 1.0
    values[1] = p[2] * np.sin(q[2])
    values[2] = 1.0
    values[3] = -p[2] * np.cos(q[2])


PENDULUM = System(
    accelerations=pendulum_accelerations,
    correction=pendulum_correction,
    jacobian=pendulum_jacobian,
    jacobian_rows=np.array([0, 0, 1, 1]),
    jacobian_columns=np.array([0, 2, 1, 2]),
    coordinates=3,
    constraint_count=2,
)


def pendulum_problem(phi, omega, t_end, p=PENDULUM_P, scale=(1.0, 1.0, 1e3)):
    """By default phi is heavy to hold: x or y is the independent coordinate."""
    L = p[2]
    q = np.array([L * np.cos(phi), L * np.sin(phi), phi])
    v = np.array([-L * np.sin(phi) * omega, L * np.cos(phi) * omega, omega])
    return Problem(0.0, t_end, q, v, np.asarray(p), np.array(scale))


def pendulum_residuals(result, p=PENDULUM_P):
    """Largest |Phi| and |Phi_q v| over the samples."""
    L = p[2]
    c, s = np.cos(result.q[:, 2]), np.sin(result.q[:, 2])
    phi = np.abs([result.q[:, 0] - L * c, result.q[:, 1] - L * s])
    rate = np.abs(
        [result.v[:, 0] + L * s * result.v[:, 2], result.v[:, 1] - L * c * result.v[:, 2]]
    )
    return phi.max(), rate.max()


# One coordinate, linear between switchings:
# a = p0 + p1 q + p2 v + sum over k of modes[k] (f_k + c_k q + d_k v),
# g_k = al q + be v + ga t + de,
# p = p0, p1, p2, then for each k: f, c, d, al, be, ga, de.


@kernel(SIGNATURES["accelerations"])
def relay_accelerations(t, q, v, p, modes, a, lam):
    a[0] = p[0] + p[1] * q[0] + p[2] * v[0]
    for k in range(modes.size):
        if modes[k] != 0:
            i = 3 + 7 * k
            a[0] += p[i] + p[i + 1] * q[0] + p[i + 2] * v[0]
    return 0


@kernel(SIGNATURES["correction"])
def free_correction(t, q, v, p, w, dq, dv):
    return 0


@kernel(SIGNATURES["jacobian"])
def free_jacobian(t, q, p, values):
    return


@kernel(SIGNATURES["switching"])
def relay_switching(t, q, v, p, g):
    for k in range(g.size):
        i = 6 + 7 * k
        g[k] = p[i] * q[0] + p[i + 1] * v[0] + p[i + 2] * t + p[i + 3]


@kernel(SIGNATURES["switching_rates"])
def relay_rates(t, q, v, a, p, rate):
    for k in range(rate.size):
        i = 6 + 7 * k
        rate[k] = p[i] * v[0] + p[i + 1] * a[0] + p[i + 2]


def free_system(coordinates=1, **kernels):
    """A system without constraints."""
    none = np.zeros(0, np.int64)
    return System(
        correction=free_correction,
        jacobian=free_jacobian,
        jacobian_rows=none,
        jacobian_columns=none,
        coordinates=coordinates,
        constraint_count=0,
        **kernels,
    )


def relay(*switches, constant=0.0, stiffness=0.0, damping=0.0):
    """System and parameters; a switch is (f, c, d, alpha, beta, gamma, delta)."""
    p = np.array([constant, -stiffness, -damping, *np.ravel(switches)], dtype=float)
    system = free_system(
        accelerations=relay_accelerations,
        switches=len(switches),
        switching=relay_switching,
        switching_rates=relay_rates,
    )
    return system, p


def run_relay(system_and_p, q0, v0, t_end, t0=0.0, **options) -> Trajectory:
    system, p = system_and_p
    problem = Problem(t0, t_end, np.array([q0]), np.array([v0]), p, np.ones(1))
    tolerance = options.pop("tolerance", 1e-10)
    settings = {"rtol": tolerance, "atol_q": tolerance, "atol_v": tolerance, **options}
    return integrate(system, problem, Options(**settings))


def relay_problem(p, q0, v0, t_end=10.0) -> Problem:
    return Problem(0.0, t_end, np.array([q0]), np.array([v0]), p, np.ones(1))
