"""A plan replayed gives the pivots that elimination by rows gives in the same order."""

import numpy as np
import pytest

from runtime.linalg.symbolic_elimination import plan_capacity
from tests.runtime.linalg.drivers import eliminate_rows, fill_unit_rows, replay_plan, write_plan

M, N = 9, 12


@pytest.fixture
def sparse():
    random = np.random.default_rng(5)
    dense = np.where(random.random((M, N)) < 0.25, random.normal(size=(M, N)), 0.0) + np.eye(M, N)
    rows, columns = (np.ascontiguousarray(places) for places in np.nonzero(dense))
    p = np.concatenate([dense[rows, columns], random.normal(size=rows.size)])
    return rows, columns, p, random.uniform(0.5, 2.0, N)


def by_rows(sparse, t, order, search):
    rows, columns, p, scale = sparse
    values, dense, pivots = np.zeros(rows.size), np.zeros((M, N)), np.zeros(M)
    fill_unit_rows(t, p, scale, rows, columns, values, dense)
    eliminate_rows(dense, order, pivots, search)
    return pivots, values


def replayed(sparse, t, plan, lengths):
    rows, columns, p, scale = sparse
    pivots = np.zeros(M)
    found = replay_plan(
        t, p, scale, rows, columns, np.zeros(rows.size), np.full(M * N, np.nan), plan, lengths,
        pivots,
    )  # fmt: skip
    return found, pivots


def test_pivots_are_those_of_the_elimination(sparse):
    rows, columns, _, scale = sparse
    order, lengths = np.zeros(M, np.int64), np.zeros(M)
    plan = np.zeros(plan_capacity(M, rows.size), np.int64)
    first, values = by_rows(sparse, 0.0, order, 1)
    write_plan(order, rows, columns, values, scale, np.zeros((M, N)), plan, lengths)
    assert 0 < plan[0] < plan.size
    found, pivots = replayed(sparse, 0.0, plan, lengths)
    assert found == 1
    np.testing.assert_allclose(pivots, first, rtol=1e-12)
    # Elsewhere the rows are divided by the lengths that they had: the signs are what counts.
    for t in (0.03, -0.5):
        later, _ = by_rows(sparse, t, order, 0)
        found, pivots = replayed(sparse, t, plan, lengths)
        assert found == 1
        np.testing.assert_array_equal(np.sign(pivots), np.sign(later))
        grown = pivots / later
        assert np.all((grown > 0.2) & (grown < 5.0))


def test_a_row_that_follows_from_others_is_reported(sparse):
    rows, columns, p, scale = sparse
    order, lengths = np.zeros(M, np.int64), np.zeros(M)
    plan = np.zeros(plan_capacity(M, rows.size), np.int64)
    _, values = by_rows(sparse, 0.0, order, 1)
    write_plan(order, rows, columns, values, scale, np.zeros((M, N)), plan, lengths)
    last = rows == M - 1
    p[: rows.size][last] = 0.0
    assert replayed(sparse, 0.0, plan, lengths)[0] == 0


def test_a_plan_too_long_for_its_room_is_none(sparse):
    rows, columns, p, scale = sparse
    plan = np.ones(20, np.int64)
    values = np.ascontiguousarray(p[: rows.size])
    order = np.arange(M)
    write_plan(order, rows, columns, values, scale, np.zeros((M, N)), plan, np.zeros(M))
    assert plan[0] == 0
