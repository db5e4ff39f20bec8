"""The pose of a body in space at the drawing: rotations in numbers, vectors as expressions."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.rotation_entries import RotationEntry

Array = npt.NDArray[np.float64]
SMALL = 1e-12  # accuracy: the sine of two axes that count as parallel; a length that is none


def rotation_of(p: tuple[float, ...]) -> Array:
    """A of Euler parameters, 3 × 3."""
    return np.array([[float(RotationEntry(i, k, *p)) for k in range(3)] for i in range(3)])


def attitude_of_vector(vector: Array) -> tuple[float, ...]:
    """Euler parameters of a rotation vector, whose length is the angle, rad."""
    angle = float(np.linalg.norm(vector))
    part = math.sin(angle / 2) / angle if angle > 0.0 else 0.5
    return (math.cos(angle / 2), *(part * vector).tolist())


def attitude_of_axes(x: Array, y: Array) -> tuple[float, ...] | None:
    """Euler parameters of a frame by its x' axis and its x'-y' plane; None of parallel axes.

    They follow from the sums and differences of entries of A that hold the largest of them.
    """
    z = np.cross(x, y)
    if not np.linalg.norm(z) > SMALL * np.linalg.norm(x) * np.linalg.norm(y):
        return None
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    a = np.column_stack([x, np.cross(z, x), z])
    skew = np.array([a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]])  # 4 e0 e
    squares = 1.0 + 2.0 * np.diag(a) - np.trace(a)  # 4 e_k²
    products = np.block([[1.0 + np.trace(a), skew], [skew[:, None], a + a.T]])  # 4 p pᵀ
    products[1:, 1:][np.diag_indices(3)] = squares
    p = products[int(np.argmax(np.diag(products)))]
    return tuple((p / np.linalg.norm(p)).tolist())


def perpendicular(h: Array) -> Array:
    """A unit vector perpendicular to a unit vector, along an axis of the frame if h is."""
    f = np.cross(np.eye(3)[(int(np.argmax(np.abs(h))) + 2) % 3], h)
    return np.asarray(f / np.linalg.norm(f))


def symbolic(vector: Any) -> Any:
    """Numbers of a vector as expressions, whole where rounding alone makes them other ones."""
    numbers = np.asarray(vector, float)
    size = max(1.0, float(np.abs(numbers).max()))
    whole = (round(x) if abs(x - round(x)) < SMALL * size else x for x in numbers.tolist())
    return tuple(sympy.sympify(x) for x in whole)
