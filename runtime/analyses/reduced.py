"""Rest of a constrained machine in its independent coordinates.

With dependent coordinates u, independent v and H = -Phi_u^-1 Phi_v, the generalized force on the
independent coordinates at rest is Q_v + H^T Q_u; for forces with a potential it is
-(V_v + H^T V_u). Coordinates are divided by a typical change each: all entries are energies.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.analyses.equations import Equations, FloatArray
from runtime.constraints.partition import eliminate

_DIFFERENCE = 3e-5  # scaled step of the difference quotients


class Partition(NamedTuple):
    """Indices of the dependent and the independent coordinates, and of the rows in use."""

    dependent: npt.NDArray[np.int64]
    independent: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]


class Rest:
    """A machine at rest at time t."""

    def __init__(self, equations: Equations, t: float, scale: FloatArray) -> None:
        self.equations = equations
        self.t = t
        self.scale = scale
        self.evaluations = 0

    def partition(self, q: FloatArray) -> Partition:
        """Choose independent coordinates at q by full pivoting."""
        equations = self.equations
        dense = equations.jacobian(self.t, q)
        rows = np.zeros(equations.m, dtype=np.int64)
        columns = np.zeros(equations.n, dtype=np.int64)
        rank = int(eliminate(dense, self.scale, rows, columns))
        return Partition(np.sort(columns[:rank]), np.sort(columns[rank:]), np.sort(rows[:rank]))

    def close(self, q: FloatArray, part: Partition) -> FloatArray | None:
        """Newton's method for the dependent coordinates; None where it does not converge."""
        if len(part.dependent) == 0:
            return q
        q = q.copy()
        dependent = part.dependent
        previous = np.inf
        for _ in range(25):
            phi = self.equations.constraints(self.t, q)[part.rows]
            slopes = self.equations.jacobian(self.t, q)[np.ix_(part.rows, dependent)]
            try:
                step = np.linalg.solve(slopes * self.scale[dependent], -phi)
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if not size < 1e3 or (size > 1e-9 and size > 0.7 * previous):
                return None
            q[dependent] += step * self.scale[dependent]
            if size <= 1e-15 or (size <= 1e-9 and size > 0.25 * previous):
                return q
            previous = size
        return None

    def motions(self, q: FloatArray, part: Partition) -> FloatArray:
        """dq for a unit (scaled) change of each independent coordinate, shape (n, f)."""
        matrix = self.equations.jacobian(self.t, q) * self.scale
        found = np.zeros((self.equations.n, len(part.independent)))
        found[part.independent, np.arange(len(part.independent))] = 1.0
        if len(part.dependent):
            slopes = matrix[part.rows]
            found[part.dependent] = -np.linalg.solve(
                slopes[:, part.dependent], slopes[:, part.independent]
            )
        return found * self.scale[:, None]

    def gradient(self, q: FloatArray, part: Partition) -> FloatArray:
        """-(Q_v + H^T Q_u), scaled, in J; shape (f,)."""
        self.evaluations += 1
        modes = self.equations.rest_modes(self.t, q)
        force = self.equations.forces(self.t, q, np.zeros(len(q)), modes)
        return -self.motions(q, part).T @ force

    def energy(self, q: FloatArray) -> float:
        """V in J."""
        return self.equations.potential(self.t, q, self.equations.rest_modes(self.t, q))

    def effort(self, q: FloatArray) -> float:
        """Size of the forces, against which their balance is judged, in J."""
        equations = self.equations
        modes = equations.rest_modes(self.t, q)
        force = equations.forces(self.t, q, np.zeros(len(q)), modes)
        slope = equations.potential_gradient(self.t, q, modes)
        return float(np.abs(np.concatenate([force, slope]) * np.tile(self.scale, 2)).max())

    def without_potential(self, q: FloatArray) -> bool:
        """Whether forces act at rest that the potential does not account for."""
        equations = self.equations
        modes = equations.rest_modes(self.t, q)
        rest = equations.forces(self.t, q, np.zeros(len(q)), modes)
        rest = rest + equations.potential_gradient(self.t, q, modes)
        return bool(np.abs(rest * self.scale).max() > 1e-9 * self.effort(q))

    def stiffness(self, q: FloatArray, part: Partition) -> FloatArray:
        """Derivative of the gradient by central differences, (f, f)."""
        count = len(part.independent)
        matrix = np.zeros((count, count))
        for column, index in enumerate(part.independent):
            ends = []
            for sign in (1.0, -1.0):
                moved = q.copy()
                moved[index] += sign * _DIFFERENCE * self.scale[index]
                closed = self.close(moved, part)
                ends.append(None if closed is None else self.gradient(closed, part))
            here = self.gradient(q, part)
            up, down = ends
            if up is not None and down is not None:
                matrix[:, column] = (up - down) / (2.0 * _DIFFERENCE)
            elif up is not None:
                matrix[:, column] = (up - here) / _DIFFERENCE
            elif down is not None:
                matrix[:, column] = (here - down) / _DIFFERENCE
        return matrix

    def inertia(self, q: FloatArray, part: Partition) -> FloatArray:
        """Mass matrix of the independent coordinates, scaled, (f, f)."""
        motions = self.motions(q, part)
        return motions.T @ self.equations.mass(q) @ motions
