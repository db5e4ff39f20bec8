"""Forces at rest: what holds, and how functions that slide on one freedom share its load."""

import numpy as np
import pytest

from runtime.core import function_table_slots as ft
from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options, Problem
from runtime.integrate.wiring import wire
from tests.runtime.hybrid.drivers import solve_least
from tests.runtime.hybrid.systems import BLOCK
from tests.runtime.integrate.systems import integrate, relay


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


def solve(matrix, right, reach, slack=1e-11):
    count = len(right)
    system, p = relay(*[(0.0,) * 7] * count)
    wiring = wire(system, "dopri5", p, 1)
    wiring.table[ft.SLIDING_COUNT] = count
    arrays = wiring.arrays
    arrays["sliding_functions"][:] = np.arange(count)
    arrays["response_copy"][:] = np.ravel(matrix)
    arrays["right_side"][:], arrays["response_column"][:] = right, reach
    return solve_least(wiring.table, slack), arrays["right_side"]


def test_independent_functions_have_one_solution():
    matrix = np.array([[2.0, 1.0], [1.0, 3.0]])
    code, x = solve(matrix, [3.0, 5.0], [1.0, 1.0])
    assert code == 0
    np.testing.assert_allclose(matrix @ x, [3.0, 5.0], rtol=1e-13)


@pytest.mark.parametrize("reach", [(1.0, 1.0), (1.0, 3.0), (5.0, 0.2)])
def test_frictions_of_one_freedom_bear_the_same_part_of_their_reach(reach):
    code, x = solve([[1.0, 1.0], [1.0, 1.0]], [2.0, 2.0], reach)
    assert code == 0
    assert x.sum() == pytest.approx(2.0, rel=1e-13)
    assert x[0] / reach[0] == pytest.approx(x[1] / reach[1], rel=1e-12)


def test_contradicting_functions_have_no_solution():
    assert solve([[1.0, 1.0], [1.0, 1.0]], [2.0, 1.0], [1.0, 1.0])[0] == 1
