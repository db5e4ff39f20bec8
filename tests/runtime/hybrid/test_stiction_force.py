"""The stiction force keeps a block at rest up to its limit, then it slides."""

import numpy as np
import pytest

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.modes import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.core.system import System
from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options, Problem
from runtime.integrate.run import integrate
from tests.runtime.integrate.systems import free_correction, free_jacobian, kernel

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


BLOCK = System(
    accelerations=block_accelerations,
    correction=free_correction,
    jacobian=free_jacobian,
    jacobian_rows=np.zeros(0, np.int64),
    jacobian_columns=np.zeros(0, np.int64),
    coordinates=1,
    constraint_count=0,
    switches=1,
    switching=slip,
    switching_rates=slip_rate,
    switched_reactions=block_reactions,
    holds=share_bounds,
    sticking=(0,),
    reaction_rows=2,
    limits=((0, 0, 1),),
    stiction=((0, 3),),
)


def push(rate, limit, t_end, **options):
    p = np.array([rate, 1.0, limit, 0.0])
    problem = Problem(0.0, t_end, np.zeros(1), np.zeros(1), p, np.ones(1))
    return integrate(BLOCK, problem, Options(rtol=1e-11, **options))


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_block_breaks_loose_where_its_stiction_force_reaches_the_limit(method, side):
    r = push(side, 2.0, 3.0, method=method)
    assert r.outcome == Outcome.OK
    assert r.events.t.tolist() == pytest.approx([2.0], abs=1e-12)
    assert r.events.direction.tolist() == [Direction.BEGAN if side > 0.0 else Direction.CEASED]
    # Then a = t - 1.
    assert r.final_v[0] == pytest.approx(1.5 * side, rel=1e-10)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("limit", [1.0, 1e-6, 1e6])
def test_block_rests_below_the_limit(method, limit):
    r = push(0.3 * limit, limit, 3.0, method=method)
    assert r.final_modes.tolist() == [SLIDING]
    assert np.abs(r.q).max() == np.abs(r.v).max() == 0.0
    assert r.events.t.size == 0
