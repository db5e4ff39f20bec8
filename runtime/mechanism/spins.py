"""Angular velocities and rotations of bodies in space, from Euler parameters and their rates."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
UNTURNED = 1e-9  # accuracy: sine of half an angle, below which its axis is rounding
SPINS = tuple(f"omega_{axis}" for axis in "xyz")


def matrix_g(p: Array) -> Array:
    """G of ω' = 2 G ṗ and ṗ = ½ Gᵀ ω', for Euler parameters (…, 4); (…, 3, 4)."""
    e0, e1, e2, e3 = np.moveaxis(p, -1, 0)
    rows = [[-e1, e0, e3, -e2], [-e2, -e3, e0, e1], [-e3, e2, -e1, e0]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def spins(p: Array, rates: Array) -> Array:
    """ω' in body axes, rad/s, (…, 3)."""
    return np.asarray(2.0 * (matrix_g(p) @ rates[..., None])[..., 0])


def rotation_matrices(p: Array) -> Array:
    """A = E Gᵀ from body axes to global ones, E = [-e, ẽ + e0 I]; (…, 3, 3)."""
    outer = matrix_g(p * np.array([1.0, -1.0, -1.0, -1.0]))
    outer[..., 0] *= -1.0
    return np.asarray(outer @ np.swapaxes(matrix_g(p), -1, -2))


def axes_and_angles(p: Array) -> tuple[Array, Array]:
    """Axes, (k, 3), and angles, rad, (k,), of Euler parameters (k, 4), as `axis_angle` says."""
    p = _steady(np.where(p[:1, :1] < 0.0, -p, p))  # p and -p are one attitude
    e = p[:, 1:]
    known = np.flatnonzero(np.linalg.norm(e, axis=1) > UNTURNED)
    axes = e[known] if len(known) else np.array([[0.0, 0.0, 1.0]])
    axes = _steady(axes / np.linalg.norm(axes, axis=1, keepdims=True))
    axes = axes[np.maximum(np.searchsorted(known, np.arange(len(p)), side="right") - 1, 0)]
    return axes, np.asarray(2.0 * np.unwrap(np.arctan2(np.sum(e * axes, axis=1), p[:, 0])))


def _steady(rows: Array) -> Array:
    """Rows, each with the sign that it needs to be the nearest to the one before it."""
    turned = np.sum(rows[1:] * rows[:-1], axis=1) < 0.0
    return np.asarray(rows * np.cumprod(np.append(1.0, 1.0 - 2.0 * turned))[: len(rows), None])


def spin_places(turning: Sequence[tuple[str, int]]) -> dict[str, tuple[int, int]]:
    """Name of a component of ω' → column of its body's e0, and its axis."""
    return {f"{body}.{spin}": (first, k) for body, first in turning for k, spin in enumerate(SPINS)}
