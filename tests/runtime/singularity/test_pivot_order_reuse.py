"""How many constraints are weak, and when an order of pivots serves again."""

import numpy as np
import pytest

from runtime.singularity.schur_complement import PivotOrders, count_weak
from runtime.singularity.search_function_table import set_units, unit_jacobian_entries
from tests.runtime.singularity.crossing import closed, mechanism


@pytest.mark.parametrize(
    ("values", "weak"),
    [
        ([1.0, 0.9, 0.8], 0),
        ([1.0, 0.9, 0.02], 1),
        ([1.0, 0.02, 0.01], 2),
        ([1.0, 0.2, 0.001], 1),  # 0.2 is small, but 0.001 lies apart from it
        ([1.0, 0.35, 0.29], 0),  # small, and not apart from the others
        ([0.1, 0.01], 2),
        ([1.0, 1e-12, 1e-15], 2),  # rounding is not told apart
        ([], 0),
    ],
)
def test_weak_singular_values_lie_apart_from_the_others(values, weak):
    assert count_weak(np.array(values)) == weak


def entries(scaled, x, y):
    z, values = np.append(closed(x, y), 0.0), np.empty(8)
    set_units(scaled.layout.table, 1.0, z)
    unit_jacobian_entries(scaled.layout.table, z, values)
    return values


def test_the_order_puts_what_is_weak_last():
    scaled = mechanism(d=0.1)
    orders = PivotOrders(scaled)
    near = orders.near(entries(scaled, 0.02, 0.01))
    assert near.weak == 1
    assert near.column_order[0] == 2
    assert sorted(near.row_order) == [0, 1]
    assert sorted(near.column_order) == [0, 1, 2, 3]
    assert orders.near(entries(scaled, 1.0, -0.8)).weak == 0


def test_a_jacobian_that_hardly_differs_shares_its_order():
    scaled = mechanism()
    orders = PivotOrders(scaled)
    first = orders.near(entries(scaled, 0.5, 0.3))
    assert orders.near(entries(scaled, 0.501, 0.3)) is first
    others = [orders.near(entries(scaled, x, 0.3)) for x in (0.6, 0.7, 0.8)]
    assert len({id(found) for found in [first, *others]}) == 4
    assert orders.near(entries(scaled, 0.5, 0.3)) is first
    orders.near(entries(scaled, 0.9, 0.3))  # of which four are remembered
    assert orders.near(entries(scaled, 0.5, 0.3)) is not first
