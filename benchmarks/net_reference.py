"""The net's motion in the angles of its first row and column, by SciPy.

A knot lies at the sum of a place on the row and one on the column, so that its velocity is linear
in the speeds of both polygons. The row ends at a fixed point: two constraints, whose second
derivatives are solved with the equations of motion.
"""

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from benchmarks.problems import GRAVITY
from models.hard.net import KNOT, column_angles, row_angles

Array = npt.NDArray[np.float64]


def free_knots(side: int) -> list[tuple[int, int]]:
    """Place along the row and along the column of every knot that is not held."""
    held = {(0, 0), (side - 1, 0)}
    return [(i, j) for i in range(side) for j in range(side) if (i, j) not in held]


def knots_of_net(side: int, t_end: float, tolerance: float = 1e-11) -> Array:
    """x and y of all free knots after the time `t_end`, s, from rest; (knots, 2), m."""
    sides = side - 1
    below = np.tri(side, sides, -1)  # the sides of a polygon that lead to a corner
    at = np.array(free_knots(side))
    leads = np.hstack([below[at[:, 0]], below[at[:, 1]]])

    def slope(t: float, state: Array) -> Array:
        angles, speeds = np.split(state, 2)
        c, s = np.cos(angles), np.sin(angles)
        along_x, along_y = -leads * s, leads * c
        turning_x, turning_y = -(leads * c) @ speeds**2, -(leads * s) @ speeds**2
        masses = KNOT * (along_x.T @ along_x + along_y.T @ along_y)
        force = -KNOT * (along_x.T @ turning_x + along_y.T @ (GRAVITY + turning_y))
        closing = np.zeros((2, angles.size))
        closing[:, :sides] = -s[:sides], c[:sides]
        inward = np.stack([c[:sides], s[:sides]]) @ speeds[:sides] ** 2
        matrix = np.block([[masses, closing.T], [closing, np.zeros((2, 2))]])
        solution = np.linalg.solve(matrix, np.concatenate((force, inward)))
        return np.concatenate((speeds, solution[: angles.size]))

    start = np.array([*row_angles(side), *column_angles(side)])
    start = np.concatenate((start, np.zeros_like(start)))
    found = solve_ivp(slope, (0.0, t_end), start, "DOP853", rtol=tolerance, atol=tolerance)
    angles = found.y[: 2 * sides, -1]
    return np.stack([leads @ np.cos(angles), leads @ np.sin(angles)], axis=1)
