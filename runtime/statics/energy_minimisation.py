"""Equilibrium as a minimum of the total potential energy over the independent coordinates.

With dependent coordinates u, independent v and H = -Phi_u^-1 Phi_v, the generalized force on the
independent coordinates at rest is Q_v + H^T Q_u; for forces with a potential it is
-(V_v + H^T V_u). Coordinates are divided by a typical change each: all entries are energies.

Newton's method with the exact reduced gradient; directions in which the energy falls off are
followed downhill. Forces without a potential enter through their reduced generalized force: then a
root is searched for, downhill first, and classified afterwards.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.assembly.joint_closing import CLOSED, Task, refine
from runtime.constraints.partitioning import order_by_pivots
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.progress_bar import Progress

_BALANCED = 1e-10  # accuracy: part of the forces; a gradient below it counts as balanced
# accuracy: scaled steps of the difference quotients, finer at an edge
_DIFFERENCES = (3e-5, 3e-7, 3e-9)
_PUSH = 1e-3  # accuracy: scaled velocity, 1/s, of the difference quotients by velocities
# accuracy: error of a gradient, in parts of stiffness times coordinate: 64 roundings
_ROUNDING = 1.5e-14
# accuracy: scaled residual of a redundant constraint, which rounding of the others may leave
_REDUNDANT_GAP = 1e-7
_CORRECTION = 30.0  # safety: scaled change of a dependent coordinate that is no correction
# measured: largest scaled change in one iteration; lengths may go on where K predicts it
_REACH = 0.3
_PREDICTED = 0.1  # measured: part of the force by which K may err in predicting the next one
_ITERATIONS = 300  # safety: Newton iterations of one search
AWAY = 1e9  # safety: scaled distance from the start from which no machine comes back
_TINY = 1e-300  # safety: keeps quotients from 0 / 0


class Partition(NamedTuple):
    """Indices of the dependent and the independent coordinates, and of the rows in use."""

    dependent: npt.NDArray[np.int64]
    independent: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]


class RestPosition(NamedTuple):
    """A position, its partition, and the reduced force and stiffness there."""

    q: FloatArray
    part: Partition
    gradient: FloatArray  # (f,), in J
    stiffness: FloatArray  # its derivative, (f, f), in J
    edges: tuple[int, ...]  # conditions that change within rounding of q, in some direction
    effort: FloatArray  # size of the forces along each independent coordinate, (f,), in J
    iterations: int

    @property
    def unbalanced(self) -> float:
        """Largest unbalanced force as a share of the forces that act."""
        return float((np.abs(self.gradient) / self.effort).max(initial=0.0))

    @property
    def balanced(self) -> bool:
        """Whether the forces balance to rounding."""
        return self.unbalanced <= _BALANCED


class StaticEquations:
    """The equations of statics at time t, reduced to independent coordinates."""

    def __init__(self, equations: Equations, t: float, scale: FloatArray) -> None:
        self.equations, self.t, self.scale = equations, t, scale
        self.evaluations = 0  # of the gradient
        # columns that are no positions
        self.states = np.array([row.column for row in equations.description.states], np.int64)

    def position(self, q: FloatArray, iterations: int = 0) -> RestPosition:
        """Reduced force, stiffness and effort at a position.

        Where a spring carries a weight the forces cancel, and their residual at rest is the
        stiffness times the rounding of the coordinates: no force resolves less.
        """
        part = self.partition(q)
        matrix, edges = self._stiffness(q, part)
        force, slope = self._forces(q)
        size = float(np.abs(np.concatenate([force, slope]) * np.tile(self.scale, 2)).max())
        reach = max(1.0, float(np.abs(q / self.scale).max()))
        resolved = np.abs(matrix).sum(axis=1) * (reach * _ROUNDING / _BALANCED)
        effort = np.maximum(max(size, _TINY), resolved)
        return RestPosition(q, part, self.gradient(q, part), matrix, edges, effort, iterations)

    def partition(self, q: FloatArray) -> Partition:
        """Choose independent coordinates at q by full pivoting.

        Redundant constraints take no part: off the others they would appear independent.
        """
        suffice = self.equations.independent
        rows, columns = np.zeros(len(suffice), np.int64), np.zeros(len(q), np.int64)
        dense = self.equations.jacobian(self.t, q)[suffice]
        rank = int(order_by_pivots(dense, self.scale, rows, columns))
        free = np.setdiff1d(columns[rank:], self.states)
        return Partition(np.sort(columns[:rank]), free, np.sort(suffice[rows[:rank]]))

    def displaced(
        self, q: FloatArray, part: Partition, step: npt.NDArray[np.floating[Any]]
    ) -> FloatArray | None:
        """The closed position after a scaled step of the independent coordinates; None: none.

        Newton's method for the dependent coordinates starts on the tangent of the motion: across a
        position in which branches of the motion cross, they would otherwise stay on the near side,
        and close on another branch or not at all. Redundant constraints must hold in the end:
        beyond such a position those in use may have led to a branch that the others exclude.
        """
        begin = q + self.motions(q, part) @ step
        if len(part.dependent) == 0:
            return begin
        equations, rows = self.equations, part.rows
        sizes = np.abs(equations.jacobian(self.t, begin) * self.scale).max(axis=1)
        sizes = np.where(sizes > 0.0, sizes, 1.0)
        weight = np.ones_like(q)
        task = Task(equations, self.t, self.scale, sizes, rows, part.dependent, weight)
        closed = refine(task, begin)
        gaps = np.abs(equations.whole.constraints(self.t, closed) / sizes)
        if not (gaps[rows].max() <= CLOSED and gaps.max() <= _REDUNDANT_GAP):
            return None
        return closed if np.abs((closed - begin) / self.scale).max() < _CORRECTION else None

    def motions(self, q: FloatArray, part: Partition) -> FloatArray:
        """dq for a unit (scaled) change of each independent coordinate, shape (n, f)."""
        matrix = self.equations.jacobian(self.t, q) * self.scale
        motions = np.zeros((len(q), len(part.independent)))
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

    def damping(self, position: RestPosition, motions: FloatArray) -> FloatArray:
        """Slopes of the gradient by velocities along `motions`, (f, f), in J s; 0 if rounding."""
        equations, t, q = self.equations, self.t, position.q
        still, modes = equations.at_rest(t, q), equations.rest_modes(t, q)
        slopes = np.zeros_like(position.stiffness)
        for column, motion in enumerate(_PUSH * motions.T):
            sides = [equations.forces(t, q, still + sign * motion, modes) for sign in (1.0, -1.0)]
            slopes[:, column] = motions.T @ (sides[1] - sides[0]) / (2.0 * _PUSH)
        rounding = _ROUNDING / _PUSH * float(position.effort.max(initial=0.0))
        return np.where(np.abs(slopes) <= rounding, 0.0, slopes)

    def energy(self, q: FloatArray) -> float:
        """V in J."""
        return self.equations.potential(self.t, q, self.equations.rest_modes(self.t, q))

    def without_potential(self, q: FloatArray, effort: float) -> bool:
        """Whether forces act at rest that the potential does not account for."""
        force, slope = self._forces(q)
        return bool(np.abs((force + slope) * self.scale).max() > 1e-9 * effort)

    def _forces(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Q at rest, and dV/dq, each (n,)."""
        equations, modes = self.equations, self.equations.rest_modes(self.t, q)
        force = equations.forces(self.t, q, equations.at_rest(self.t, q), modes)
        force[self.states] = 0.0
        return force, equations.potential_gradient(self.t, q, modes)

    def _stiffness(self, q: FloatArray, part: Partition) -> tuple[FloatArray, tuple[int, ...]]:
        """Slopes of the gradient, one-sided at the edge of a mode, and what changes there."""
        count = len(part.independent)
        matrix, edges = np.zeros((count, count)), set[int]()
        here, modes = self.gradient(q, part), self.equations.rest_modes(self.t, q)
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
        return matrix, tuple(sorted(edges))


def minimise(statics: StaticEquations, q: FloatArray, progress: Progress) -> RestPosition:
    """Descend from an assembled q until the forces balance, then polish."""
    start, reach, done = q, _REACH, 0
    while done < _ITERATIONS:
        done += 1
        at = statics.position(q)
        slope, share, matrix = at.gradient, at.unbalanced, at.stiffness
        if share <= 1e-9:
            break
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        least = max(1e-12 * float(np.abs(values).max()), 1e-9 * float(at.effort.min()))
        step = -vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), least))
        angles = ~statics.equations.description.is_length[at.part.independent]
        turn = float(np.abs(step[angles]).max(initial=0.0))
        far = float(np.abs(step).max())
        step *= min(1.0, reach / far, _REACH / max(turn, _TINY))
        moved = _downhill(statics, at, step)
        if moved is None:
            reach *= 0.25
            if reach < 1e-8:
                break
            continue
        went = ((moved - q) / statics.scale)[at.part.independent]
        missed = statics.gradient(moved, at.part) - slope - matrix @ went
        predicted = np.abs(missed).max() <= _PREDICTED * np.abs(slope).max()
        reach = 4.0 * reach if predicted else min(_REACH, 2.0 * reach)
        q = moved
        if not float(np.abs((q - start) / statics.scale).max()) < AWAY:
            return statics.position(q, done)
        progress(1.0 - min(1.0, max(0.0, 1.0 + np.log10(share) / 10.0)))
    return polish(statics, q, done)


def _downhill(statics: StaticEquations, at: RestPosition, step: FloatArray) -> FloatArray | None:
    """The longest halved step that lowers the energy, or does not overshoot the force."""
    q, part, slope = at.q, at.part, at.gradient
    conservative = not statics.without_potential(q, float(at.effort.max()))
    energy, fall, size = statics.energy(q), float(slope @ step), float(np.abs(slope).max())
    for halving in range(25):
        part_of_step = 0.5**halving
        closed = statics.displaced(q, part, part_of_step * step)
        if closed is None:
            continue
        after = statics.gradient(closed, part)
        if float(np.abs(after).max()) <= 0.5 * size and fall < 0.0:
            return closed
        if conservative:
            lower = statics.energy(closed) <= energy + 1e-4 * part_of_step * fall
        else:
            lower = float(after @ step) <= 0.0
        if lower:
            return closed
    return None


def polish(statics: StaticEquations, q: FloatArray, iterations: int = 0) -> RestPosition:
    """Newton's method on the gradient for as long as it shrinks."""
    at = statics.position(q, iterations)
    for _ in range(12):
        size = float(np.abs(at.gradient).max(initial=0.0))
        if size == 0.0 or not np.isfinite(at.stiffness).all():
            break  # it balances, or forces end there, as those of a table do
        step = np.linalg.lstsq(at.stiffness, -at.gradient, rcond=1e-12)[0]
        if float(np.abs(step).max()) > 0.1:
            break
        closed = statics.displaced(at.q, at.part, step)
        if closed is None or not float(np.abs(statics.gradient(closed, at.part)).max()) < size:
            break
        at = statics.position(closed, at.iterations + 1)
    return at
