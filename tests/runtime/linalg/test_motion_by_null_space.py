"""Accelerations and multipliers by the null space against fifty digits, masses far apart."""

import mpmath as mp
import numpy as np
import pytest

from runtime.linalg.motion_by_null_space import solve_factored, solve_motion_by_null_space
from tests.runtime.linalg.test_full_pivoting import factored
from tests.runtime.linalg.test_least_multipliers import sparse


def exact(jacobian, mass, force, gamma, digits=50):
    m, n = jacobian.shape
    with mp.workdps(digits):
        matrix = mp.zeros(n + m, n + m)
        for i in range(n):
            for j in range(n):
                matrix[i, j] = mp.mpf(float(mass[i, j]))
        for i in range(m):
            for j in range(n):
                matrix[n + i, j] = matrix[j, n + i] = mp.mpf(float(jacobian[i, j]))
        x = mp.lu_solve(matrix, mp.matrix([mp.mpf(float(b)) for b in (*force, *gamma)]))
        found = np.array([float(value) for value in x])
    return found[:n], found[n:]


@pytest.mark.parametrize("decades", [0, 4, 8, 12])
@pytest.mark.parametrize("seed", range(3))
def test_masses_far_apart_cost_no_digits(seed, decades):
    random = np.random.default_rng(seed)
    n, m = 8, 6
    jacobian = np.where(random.uniform(size=(m, n)) < 0.7, random.normal(size=(m, n)), 0.0)
    mass = np.diag(10.0 ** random.uniform(-decades, decades, n))
    force, gamma = random.normal(size=n) * np.diag(mass), random.normal(size=m)
    a, lam = np.zeros(n), np.zeros(m)
    matrices = sparse(jacobian), sparse(mass)
    assert solve_motion_by_null_space(*matrices, force, gamma, a, lam) == 0
    exact_a, exact_lam = exact(jacobian, mass, force, gamma)
    condition = np.linalg.cond(jacobian)
    for found, expected in ((a, exact_a), (lam, exact_lam)):
        assert np.abs(found - expected).max() < 1e-14 * condition * np.abs(expected).max()


@pytest.mark.parametrize("heavy", [1e20, 1e40, 1e100, 1e200, 1e300])
@pytest.mark.parametrize("light", [1e-200, 1e-40, 1.0])
def test_masses_without_measure_make_no_constraint_dependent(heavy, light):
    """A pendulum, its mass against its own moment of inertia, near where one row has no arm."""
    sine, cosine = np.sin(0.02), np.cos(0.02)
    jacobian = np.array([[1.0, 0.0, sine], [0.0, 1.0, -cosine]])
    mass = np.diag([heavy, heavy, light])
    a, lam = np.zeros(3), np.zeros(2)
    force = np.array([0.0, -9.81 * heavy, 0.0])
    matrices = sparse(jacobian), sparse(mass)
    assert solve_motion_by_null_space(*matrices, force, np.zeros(2), a, lam) == 0
    angular = -9.81 * cosine  # of a point mass at 1 m
    np.testing.assert_allclose(a, [-sine * angular, cosine * angular, angular], rtol=1e-12)
    along = 9.81 * sine * heavy
    np.testing.assert_allclose(lam, [-along * cosine, -along * sine], rtol=1e-11)


@pytest.mark.parametrize("decades", [20, 30, 60, 150])
def test_masses_any_number_of_decades_apart_are_solved_or_refused(decades):
    """None of the numbers is wrong without a word, and nearly all are found."""
    random, cases, solved = np.random.default_rng(5), 40, 0
    for _ in range(cases):
        n = int(random.integers(2, 8))
        m = int(random.integers(1, n))
        jacobian = random.normal(size=(m, n))
        mass = np.diag(10.0 ** random.uniform(-decades, decades, n))
        force, gamma = random.normal(size=n) * np.sqrt(np.diag(mass)), random.normal(size=m)
        a, lam = np.zeros(n), np.zeros(m)
        if solve_motion_by_null_space(sparse(jacobian), sparse(mass), force, gamma, a, lam):
            continue
        solved += 1
        for found, expected in zip((a, lam), exact(jacobian, mass, force, gamma, 400), strict=True):
            assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    assert solved >= 0.9 * cases


def test_a_light_coordinate_that_hardly_takes_part_keeps_its_acceleration():
    jacobian, mass = np.array([[1e-8, 1.0]]), np.diag([1e-14, 1e14])
    force, gamma, a, lam = np.array([1e-14, 1e14]), np.zeros(1), np.zeros(2), np.zeros(1)
    matrices = sparse(jacobian), sparse(mass)
    assert solve_motion_by_null_space(*matrices, force, gamma, a, lam) == 0
    exact_a, exact_lam = exact(jacobian, mass, force, gamma)
    np.testing.assert_allclose(a, exact_a, rtol=1e-9)
    np.testing.assert_allclose(lam, exact_lam, rtol=1e-9)


def test_a_dependent_constraint_is_counted_and_nothing_solved():
    jacobian = np.array([[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    a, lam = np.zeros(3), np.zeros(2)
    matrices = sparse(jacobian), sparse(np.eye(3))
    assert solve_motion_by_null_space(*matrices, np.ones(3), np.ones(2), a, lam) == 1


def test_a_free_motion_that_no_mass_resists_is_refused():
    jacobian, mass = np.array([[1.0, 0.0, 0.0]]), np.diag([1.0, 1.0, 0.0])
    a, lam = np.zeros(3), np.zeros(1)
    matrices = sparse(jacobian), sparse(mass)
    assert solve_motion_by_null_space(*matrices, np.ones(3), np.ones(1), a, lam) != 0


def test_a_factored_system_gives_unknowns_without_pivot_no_value():
    matrix = np.array([[0.0, 2.0, 0.0], [4.0, 8.0, 0.0], [0.0, 0.0, 0.0]])
    rank, a, row_order, column_order = factored(matrix, 1e-10)
    x = np.full(3, 9.0)
    solve_factored(a, rank, row_order, column_order, np.array([2.0, 4.0, 0.0]), x)
    np.testing.assert_allclose(x, [-1.0, 1.0, 0.0], atol=1e-15)
