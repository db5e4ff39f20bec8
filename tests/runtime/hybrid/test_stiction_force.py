"""The stiction force keeps a block at rest up to its limit, then it slides."""

import numpy as np
import pytest

from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options, Problem
from runtime.integrate.run import integrate
from tests.runtime.hybrid.systems import BLOCK


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
