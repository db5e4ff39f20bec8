"""Second derivatives of what is lost, and the branches that follow from them, by hand."""

import numpy as np
import pytest

from runtime.singularity.search_function_table import set_units
from runtime.singularity.singular_root_search import find_branch
from tests.runtime.singularity.crossing import branch_slopes, mechanism
from tests.runtime.singularity.drivers import factor_normal_equations

C, D = 0.5, 0.8
LEFT = np.array([[-1.0], [1.0]]) / np.sqrt(2.0)  # of the rows Φ₁ and Φ₂ / c
NULL = np.ascontiguousarray(np.eye(4)[:, [0, 1, 3]])
FORM = np.array([[2.0 / C, -1.0, D / C], [-1.0, -2.0 / C, 0.0], [D / C, 0.0, 0.0]]) / np.sqrt(2.0)


@pytest.fixture
def table():
    scaled = mechanism(c=C, d=D)
    set_units(scaled.layout.table, 1.0, np.zeros(4))
    yield scaled.layout.table
    del scaled  # whose arrays the table points at


def test_the_form_is_the_second_derivative_of_what_is_lost(table):
    form, normal = np.empty((3, 3)), np.empty((3, 3))
    assert factor_normal_equations(table, np.zeros(4), LEFT, NULL, form, normal) == 1
    np.testing.assert_allclose(form, FORM, atol=1e-9)
    lower = np.tril(normal)
    np.testing.assert_allclose(lower @ lower.T, FORM.T @ FORM, atol=1e-8)


def test_nothing_is_lost_where_nothing_changes(table):
    form, normal = np.empty((3, 3)), np.empty((3, 3))
    none = np.zeros((2, 1))
    assert factor_normal_equations(table, np.zeros(4), none, NULL, form, normal) == 0


@pytest.mark.parametrize("slope", [0.3, 0.9, -0.8, -2.0])
def test_the_nearest_branch(slope):
    scaled = mechanism(c=C)
    table = scaled.layout.table
    set_units(table, 1.0, np.zeros(4))
    rate = np.array([1.0, slope, 0.0, 1.0])
    passing, x = np.empty((1, 3)), np.empty(3)
    find_branch(table, np.zeros(4), rate, LEFT, NULL, passing, x, 40)
    form = FORM * [[1, 1, 0], [1, 1, 0], [0, 0, 0]]
    np.testing.assert_allclose(passing[0], form @ NULL.T @ rate, atol=1e-9)
    direction = rate + NULL @ x
    found = direction[1] / direction[0]
    slopes = branch_slopes(C)
    away = np.abs(slope - slopes) / np.sqrt(1.0 + slopes**2)
    assert found == pytest.approx(slopes[away.argmin()], abs=1e-8)
    assert np.linalg.norm(x) < 1.2 * away.min() + 1e-9
    assert direction[3] == pytest.approx(1.0)
