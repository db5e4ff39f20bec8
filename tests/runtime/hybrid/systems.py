"""A ball above the ground, with kernels written by hand."""

import numpy as np

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.system import System
from runtime.integrate.problem import Options, Problem
from runtime.integrate.run import integrate
from tests.runtime.integrate.systems import free_correction, free_jacobian, kernel

# p = gravity, restitution; in mode 0 a contact exerts a unit of force.


@kernel(SIGNATURES["accelerations"])
def ball_accelerations(t, q, v, p, modes, a, lam):
    a[0] = -p[0] + (1.0 if modes[0] == 0 else 0.0)
    return 0


@kernel(SIGNATURES["switching"])
def ball_gap(t, q, v, p, g):
    g[0] = q[0]


@kernel(SIGNATURES["switching_rates"])
def ball_gap_rate(t, q, v, a, p, rate):
    rate[0] = v[0]


@kernel(SIGNATURES["gap_accelerations"])
def ball_gap_acceleration(t, q, v, a, p, out):
    out[0] = a[0]


@kernel(SIGNATURES["restitution"])
def ball_restitution(p, out):
    out[0] = p[1]


@kernel(SIGNATURES["holds"])
def contact_bounds(p, low, high):
    low[0], high[0] = -1.7e308, 1.0


BALL = System(
    accelerations=ball_accelerations,
    correction=free_correction,
    jacobian=free_jacobian,
    jacobian_rows=np.zeros(0, np.int64),
    jacobian_columns=np.zeros(0, np.int64),
    coordinates=1,
    constraint_count=0,
    switches=1,
    switching=ball_gap,
    switching_rates=ball_gap_rate,
    gap_accelerations=ball_gap_acceleration,
    restitution=ball_restitution,
    holds=contact_bounds,
    rigid=(0,),
)


def drop_ball(height, speed, gravity, restitution, t_end, **options):
    p = np.array([gravity, restitution])
    problem = Problem(0.0, t_end, np.array([height]), np.array([speed]), p, np.ones(1))
    return integrate(BALL, problem, Options(rtol=1e-10, **options))
