"""Forces and stiffness of a constrained machine at rest, in its independent coordinates.

With dependent coordinates u, independent v and H = -Phi_u^-1 Phi_v, the generalized force on the
independent coordinates at rest is Q_v + H^T Q_u; for forces with a potential it is
-(V_v + H^T V_u). Coordinates are divided by a typical change each: all entries are energies.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.assembly.joint_closing import CLOSED, Task, refine
from runtime.constraints.partitioning import order_by_pivots
from runtime.mechanism.dense_equations import Equations, FloatArray

BALANCED = 1e-10  # accuracy: part of the forces; a gradient below it counts as balanced
# accuracy: scaled steps of the difference quotients, finer at an edge
_DIFFERENCES = (3e-5, 3e-7, 3e-9)
# accuracy: error of a gradient, in parts of stiffness times coordinate: 64 roundings
_ROUNDING = 1.5e-14
# accuracy: scaled residual of a redundant constraint, which rounding of the others may leave
_REDUNDANT_GAP = 1e-7
_REACH = 30.0  # safety: scaled change of a dependent coordinate that is no correction any more


class Partition(NamedTuple):
    """Indices of the dependent and the independent coordinates, and of the rows in use."""

    dependent: npt.NDArray[np.int64]
    independent: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]


class Stiffness(NamedTuple):
    """Derivative of the gradient."""

    matrix: FloatArray  # (f, f), in J
    # conditions that change within rounding of the position, in some direction
    edges: tuple[int, ...]


class StaticEquations:
    """The equations of statics at time t, reduced to independent coordinates."""

    def __init__(self, equations: Equations, t: float, scale: FloatArray) -> None:
        self.equations, self.t, self.scale = equations, t, scale
        self.evaluations = 0  # of the gradient
        states = [state.column for state in equations.description.states]
        self.states = np.array(states, dtype=np.int64)  # columns that are no positions

    def partition(self, q: FloatArray) -> Partition:
        """Choose independent coordinates at q by full pivoting.

        Redundant constraints take no part: off the others they would appear independent.
        """
        equations = self.equations
        suffice = equations.independent
        rows, columns = np.zeros(len(suffice), np.int64), np.zeros(equations.n, np.int64)
        dense = equations.jacobian(self.t, q)[suffice]
        rank = int(order_by_pivots(dense, self.scale, rows, columns))
        free = np.setdiff1d(columns[rank:], self.states)
        return Partition(np.sort(columns[:rank]), free, np.sort(suffice[rows[:rank]]))

    def close(self, q: FloatArray, part: Partition) -> FloatArray | None:
        """Newton's method for the dependent coordinates; None where the machine does not close.

        Redundant constraints must hold in the end: beyond a position in which branches of the
        motion cross, those in use may have led to a branch that the others exclude.
        """
        if len(part.dependent) == 0:
            return q
        equations, rows = self.equations, part.rows
        sizes = np.abs(equations.jacobian(self.t, q) * self.scale).max(axis=1)
        sizes = np.where(sizes > 0.0, sizes, 1.0)
        weight = np.ones_like(q)
        task = Task(equations, self.t, self.scale, sizes, [], rows, part.dependent, weight)
        closed = refine(task, q)
        gaps = np.abs(equations.constraints(self.t, closed) / sizes)
        if not (gaps[rows].max() <= CLOSED and gaps.max() <= _REDUNDANT_GAP):
            return None
        return closed if np.abs((closed - q) / self.scale).max() < _REACH else None

    def displaced(
        self, q: FloatArray, part: Partition, step: npt.NDArray[np.floating[Any]]
    ) -> FloatArray | None:
        """The closed position after a scaled step of the independent coordinates; see `close`.

        Newton's method starts on the tangent of the motion: across a position in which branches
        of the motion cross, the dependent coordinates would otherwise stay on the near side, and
        close on another branch or not at all.
        """
        return self.close(q + self.motions(q, part) @ step, part)

    def motions(self, q: FloatArray, part: Partition) -> FloatArray:
        """dq for a unit (scaled) change of each independent coordinate, shape (n, f)."""
        matrix = self.equations.jacobian(self.t, q) * self.scale
        motions = np.zeros((self.equations.n, len(part.independent)))
        motions[part.independent, np.arange(len(part.independent))] = 1.0
        if len(part.dependent):
            slopes = matrix[part.rows]
            motions[part.dependent] = -np.linalg.solve(
                slopes[:, part.dependent], slopes[:, part.independent]
            )
        return motions * self.scale[:, None]

    def gradient(self, q: FloatArray, part: Partition) -> FloatArray:
        """-(Q_v + H^T Q_u), scaled, in J; shape (f,)."""
        self.evaluations += 1
        return -self.motions(q, part).T @ self._forces(q)[0]

    def energy(self, q: FloatArray) -> float:
        """V in J."""
        return self.equations.potential(self.t, q, self.equations.rest_modes(self.t, q))

    def _forces(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Q at rest, and dV/dq, each (n,)."""
        equations, modes = self.equations, self.equations.rest_modes(self.t, q)
        force = equations.forces(self.t, q, equations.still, modes)
        force[self.states] = 0.0
        return force, equations.potential_gradient(self.t, q, modes)

    def effort(self, q: FloatArray) -> float:
        """Size of the forces, against which their balance is judged, in J."""
        force, slope = self._forces(q)
        return float(np.abs(np.concatenate([force, slope]) * np.tile(self.scale, 2)).max())

    def floor(self, q: FloatArray, stiffness: Stiffness) -> FloatArray:
        """Least size of the forces in each direction that the rounding of q resolves, (f,), in J.

        Where a spring carries a weight the forces cancel in `effort`; their residual at rest is the
        stiffness times the rounding of the coordinates.
        """
        reach = max(1.0, float(np.abs(q / self.scale).max()))
        floor: FloatArray = np.abs(stiffness.matrix).sum(axis=1) * (reach * _ROUNDING / BALANCED)
        return floor

    def without_potential(self, q: FloatArray, effort: float) -> bool:
        """Whether forces act at rest that the potential does not account for."""
        force, slope = self._forces(q)
        return bool(np.abs((force + slope) * self.scale).max() > 1e-9 * effort)

    def stiffness(self, q: FloatArray, part: Partition) -> Stiffness:
        """Derivative of the gradient by differences: central, one-sided at the edge of a mode."""
        count = len(part.independent)
        matrix = np.zeros((count, count))
        edges: set[int] = set()
        here = self.gradient(q, part)
        modes = self.equations.rest_modes(self.t, q)
        for column, unit in enumerate(np.eye(count)):
            changed = set[int]()
            for step in _DIFFERENCES:
                slopes, changed, sides = [], set[int](), list[FloatArray]()
                for change in (step, -step):
                    closed = self.displaced(q, part, change * unit)
                    if closed is None:
                        continue
                    there = self.equations.rest_modes(self.t, closed)
                    changed |= set(np.flatnonzero(there != modes).tolist())
                    sides.append(self.gradient(closed, part))
                    if (there == modes).all():
                        slopes.append((sides[-1] - here) / change)
                if not slopes and len(sides) == 2:  # on the surface of a balanced condition
                    slopes = [(sides[0] - sides[1]) / (2.0 * step)]
                if slopes:
                    matrix[:, column] = np.mean(slopes, axis=0)
                if not changed:
                    break
            edges |= changed
        return Stiffness(matrix, tuple(sorted(edges)))

    def inertia(self, q: FloatArray, part: Partition) -> FloatArray:
        """Mass matrix of the independent coordinates, scaled, (f, f)."""
        motions = self.motions(q, part)
        return motions.T @ self.equations.mass(q) @ motions
