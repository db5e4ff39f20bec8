"""Cholesky factors of normal equations, against numpy."""

import numpy as np

from tests.runtime.linalg.drivers import factor_gram, orthonormalise, solve_cholesky

VECTORS = np.random.default_rng(4).normal(size=(9, 4))
VECTORS[2] = 0.0


def test_the_factor_is_that_of_the_gram_matrix():
    lower = np.zeros((4, 4))
    assert factor_gram(VECTORS, lower) == 1
    gram = VECTORS.T @ VECTORS
    np.testing.assert_allclose(np.tril(lower), np.linalg.cholesky(gram), rtol=1e-12)
    x = np.arange(1.0, 5.0)
    solve_cholesky(lower, x)
    np.testing.assert_allclose(gram @ x, np.arange(1.0, 5.0), rtol=1e-12)


def test_columns_become_orthonormal_and_span_the_same():
    lower, q = np.zeros((4, 4)), VECTORS.copy()
    factor_gram(VECTORS, lower)
    orthonormalise(lower, q)
    np.testing.assert_allclose(q.T @ q, np.eye(4), atol=1e-14)
    np.testing.assert_allclose(q @ (q.T @ VECTORS), VECTORS, atol=1e-13)
    assert np.all(np.diag(q.T @ VECTORS) > 0.0)


def test_dependent_columns_have_no_factor():
    vectors = np.array([[1.0, 2.0], [2.0, 4.0], [0.0, 0.0]])
    assert factor_gram(vectors, np.zeros((2, 2))) == 0
