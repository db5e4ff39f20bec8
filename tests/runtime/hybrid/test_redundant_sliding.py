"""Functions that slide on one freedom share its load by what each can bear."""

import numpy as np
import pytest

from runtime.core import function_table_slots as ft
from runtime.integrate.wiring import wire
from tests.runtime.hybrid.drivers import solve_least
from tests.runtime.integrate.systems import relay


def solve(matrix, right, reach, slack=1e-11):
    count = len(right)
    system, p = relay(*[(0.0,) * 7] * count)
    wiring = wire(system, "dopri5", p, 1)
    arrays, wiring.table[ft.SLIDING_COUNT] = wiring.arrays, count
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
