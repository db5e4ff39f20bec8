"""States of the slider-crank that satisfy its constraints, as many as a measurement needs."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
RADIUS = 2.0


def consistent(phi: Array, omega: Array, length: float) -> tuple[Array, Array]:
    """q and v, each (states × 9), for crank angles and speeds (Haug's figure 8.2.1)."""
    zero = np.zeros_like(phi)
    s, c = RADIUS * np.sin(phi), RADIUS * np.cos(phi)
    rod = -np.arcsin(s / length)
    turn = -c * omega / (length * np.cos(rod))
    half_x, half_y = 0.5 * length * np.cos(rod), 0.5 * length * np.sin(rod)
    q = np.stack([zero, zero, phi, c + half_x, s + half_y, rod, c + 2 * half_x, zero, zero], axis=1)
    vx, vy = -s * omega - half_y * turn, c * omega + half_x * turn
    v = np.stack([zero, zero, omega, vx, vy, turn, vx - half_y * turn, zero, zero], axis=1)
    return np.ascontiguousarray(q), np.ascontiguousarray(v)


def modes_at(q: Array, v: Array) -> npt.NDArray[np.int64]:
    """The gas force's modes in the order of the generated module, (states × 4)."""
    x, vx = q[:, 6], v[:, 6]
    modes = np.stack([x < 1.5, x <= 5, x <= 5.5, vx > 0], axis=1)
    return np.ascontiguousarray(modes.astype(np.int64))


def turn_of_the_crank(count: int, length: float) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """q, v and modes over a whole turn at about the speed of the run."""
    phi = np.linspace(0, 2 * np.pi, count, endpoint=False)
    q, v = consistent(phi, 25 + 5 * np.sin(phi), length)
    return q, v, modes_at(q, v)
