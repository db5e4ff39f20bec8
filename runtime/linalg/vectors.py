"""Vectors in compiled code: copies, sums and norms, without a temporary array."""

from typing import Any

import numpy as np

from runtime.core.arrays import Matrix, Vector
from runtime.core.jit import inner


@inner
def copy_vector(source: Any, target: Any) -> None:
    """Write `source` over the numbers of `target`, which is as long or longer."""
    for i in range(source.size):
        target[i] = source[i]


@inner
def dot(x: Vector, y: Vector) -> float:
    """xᵀ y."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@inner
def axpy(factor: float, x: Vector, y: Vector) -> None:
    """Add `factor` times x to y."""
    for i in range(x.size):
        y[i] += factor * x[i]


@inner
def multiply(a: Matrix, x: Vector, y: Vector) -> None:
    """Write A x into y."""
    for i in range(y.size):
        y[i] = dot(a[i], x)


@inner
def is_finite(a: Vector) -> bool:
    """Whether all numbers are finite."""
    finite = True
    for i in range(a.size):
        finite = finite and np.isfinite(a[i])
    return bool(finite)


@inner
def largest_magnitude(a: Vector) -> float:
    """Largest |a|; 0 of no numbers."""
    largest = 0.0
    for i in range(a.size):
        largest = max(largest, abs(a[i]))
    return largest


@inner
def largest_ratio(a: Vector, scale: Vector) -> float:
    """Largest |a| / scale; infinite where one of them is not finite, which a maximum may miss."""
    largest = 0.0
    for i in range(a.size):
        ratio = abs(a[i]) / scale[i]
        largest = max(largest, ratio if np.isfinite(ratio) else np.inf)
    return largest
