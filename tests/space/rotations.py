"""Rotations by hand: matrices, Euler parameters, and random axes."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def tilde(a: Array) -> Array:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rotation(p: Array) -> Array:
    e0, e = p[0], p[1:]
    return (2 * e0**2 - 1) * np.eye(3) + 2 * (np.outer(e, e) + e0 * tilde(e))


def matrix_g(p: Array) -> Array:
    return np.column_stack([-p[1:], p[0] * np.eye(3) - tilde(p[1:])])


def about(axis: Array, angle: float) -> Array:
    """The rotation about a unit axis (Rodrigues)."""
    k = tilde(axis)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def unit(rng: np.random.Generator) -> Array:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def parameters_of(a: Array) -> Array:
    """Euler parameters of any rotation matrix: by the eigenvector of the eigenvalue 3."""
    whole = np.array([
        [np.trace(a), a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]],
        [0, a[0, 0] - a[1, 1] - a[2, 2], a[0, 1] + a[1, 0], a[0, 2] + a[2, 0]],
        [0, 0, a[1, 1] - a[0, 0] - a[2, 2], a[1, 2] + a[2, 1]],
        [0, 0, 0, a[2, 2] - a[0, 0] - a[1, 1]],
    ])  # fmt: skip
    p = np.linalg.eigh(whole + np.triu(whole, 1).T)[1][:, -1]
    return np.asarray(p if p[0] >= 0 else -p)
