"""A ball above the ground and a block with friction, with kernels written by hand."""

from dataclasses import replace

import numpy as np

from runtime.core import workspace_rows as ws
from runtime.core.kernel_abi import SIGNATURES
from runtime.core.kinds import SLIDING
from runtime.integrate.problem import Options, Problem
from runtime.integrate.wiring import wire
from tests.runtime.hybrid import drivers
from tests.runtime.integrate.systems import free_system, integrate, kernel

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


BALL = free_system(
    accelerations=ball_accelerations,
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


# A block of unit mass, pushed by a force that grows; p = its rate, μ N, μ_s N, the stiction force.


@kernel(SIGNATURES["accelerations"])
def block_accelerations(t, q, v, p, modes, a, lam):
    friction = p[3] if modes[0] == 2 else (p[1] if modes[0] == 0 else -p[1])
    a[0] = p[0] * t + friction
    return 0


@kernel(SIGNATURES["switched_reactions"])
def block_reactions(t, q, v, p, modes, lam, out):
    out[0] = p[3] if modes[0] == 2 else (p[1] if modes[0] == 0 else -p[1])
    out[1] = p[2]


@kernel(SIGNATURES["switching"])
def slip(t, q, v, p, g):
    g[0] = v[0]


@kernel(SIGNATURES["switching_rates"])
def slip_rate(t, q, v, a, p, rate):
    rate[0] = a[0]


@kernel(SIGNATURES["holds"])
def share_bounds(p, low, high):
    low[0], high[0] = 0.5 - 0.5 * p[2] / p[1], 0.5 + 0.5 * p[2] / p[1]


SLIDER = free_system(
    accelerations=block_accelerations,
    switches=1,
    switching=slip,
    switching_rates=slip_rate,
    switched_reactions=block_reactions,
    holds=share_bounds,
    sticking=(0,),
    reaction_rows=2,
)
"""The block, with the friction of Filippov's share."""

BLOCK = replace(SLIDER, limits=((0, 0, 1),), stiction=((0, 3),))
"""The block, with an unknown stiction force."""


class Instant:
    """The table of a system at one state, as the parts of the loop find it."""

    def __init__(self, system, p, q=(0.0,), v=(0.0,), modes=(SLIDING,)):
        self.wiring = wire(system, "dopri5", np.array(p, dtype=float), 1)
        self.context, self.arrays = self.wiring
        self.p = self.arrays["parameters"]
        self.modes, self.shares = self.arrays["modes"], self.arrays["share"]
        self.states = self.arrays["workspace"].reshape(ws.ROWS, -1)
        self.switching = self.arrays["switching_rows"].reshape(ws.SWITCH_ROWS, -1)
        self.states[ws.Y0], self.modes[:] = [*q, *v], modes
        self.switching[ws.LARGEST] = 1.0
        self.arrays["settings"][:] = 1.0

    def evaluate(self, t=0.0):
        """The accelerations."""
        assert drivers.evaluate_accelerations(self.context, t) == 0
        return self.states[ws.DELTA, : len(self.states[0]) // 2].tolist()
