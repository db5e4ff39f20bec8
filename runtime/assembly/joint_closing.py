"""Close the joints: Haug's growing-penalty minimisation, then Newton's method to rounding.

Minimise (q - q0)ᵀ W (q - q0) + r Φᵀ Φ for growing r, by Levenberg-Marquardt with the exact
Jacobian. Lengths are measured in a length typical of the mechanism, angles in rad.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.core.arrays import EPS
from runtime.linalg.least_norm import solve_by_newton
from runtime.linalg.unit_euler_parameters import normalise
from runtime.mechanism.dense_equations import Equations, FloatArray

CLOSED = 1e-10  # accuracy: largest scaled gap of joints that are closed
# measured: growing penalties r of (q - q0)ᵀ W (q - q0) + r Φᵀ Φ
PENALTIES = tuple(float(r) for r in 10.0 ** np.arange(0, 9, 2))
# measured: the next ones, for a position near to a singular one, which the first do not leave
_STRONGER = (1e10, 1e12)
ROUGH = 1e-3  # measured: scaled gap from which on a penalty leads Newton's method
DIGITS = 4.0  # safety: units of rounding of its terms by which a constraint may be open
_HALVES = 12  # accuracy: halvings of a gap in the search for the part that must stay open
_RESTARTS = 6  # safety: random starts after the given one has failed


Selection = npt.NDArray[np.bool_ | np.int64]  # a mask, or indices where joints are refined only


class Closing(NamedTuple):
    """Result of closing the joints: q, and the largest scaled gap beyond rounding."""

    q: FloatArray
    gap: float

    @property
    def closed(self) -> bool:
        """Whether all joints close."""
        return self.gap <= CLOSED


class Task(NamedTuple):
    """A closure problem: active rows, free coordinates, and the weights of their changes."""

    equations: Equations
    t: float
    scale: FloatArray
    row_scale: FloatArray
    rows: Selection
    free: Selection
    weight: FloatArray
    offset: FloatArray | float = 0.0  # the values at which constraints count as closed

    def gaps(self, q: FloatArray) -> FloatArray:
        """Scaled constraint values of the chosen rows."""
        values = self.equations.constraints(self.t, q) - self.offset
        phi: FloatArray = values / self.row_scale
        return phi[self.rows]

    def slopes(self, q: FloatArray) -> FloatArray:
        """Their derivatives by the scaled free coordinates."""
        matrix = self.equations.jacobian(self.t, q) * self.scale / self.row_scale[:, None]
        return matrix[np.ix_(self.rows, self.free)]

    def matrix(self, q: FloatArray) -> FloatArray | Any:
        """As `slopes`; of large machines SciPy's sparse matrix."""
        if not self.equations.is_large:
            return self.slopes(q)
        return self.scaled(self.equations.slopes(self.t, q))[self.rows][:, self.free]

    def scaled(self, slopes: FloatArray) -> Any:
        """The sparse matrix of the non-zeros of Φ_q, (nnz,), scaled; all rows and coordinates."""
        description = self.equations.description
        rows, columns = description.jacobian_rows, description.jacobian_columns
        scaled = slopes * self.scale[columns] / self.row_scale[rows]
        return self.equations.sparse_jacobian(scaled)

    def term_sizes(self, q: FloatArray) -> FloatArray:
        """What coordinates are in the scaled constraints, Σ |Φ_q| |q|, (m,)."""
        if self.equations.is_large:
            slopes = self.scaled(self.equations.slopes(self.t, q))
            sizes: FloatArray = np.abs(slopes) @ np.abs(q / self.scale)
            return sizes
        dense = np.abs(self.equations.jacobian(self.t, q)) / self.row_scale[:, None]
        return dense @ np.abs(q)


def close(task: Task, start: FloatArray) -> Closing:
    """Close the joints from `start`.

    Retries move coordinates without a given start value, and where that does not help guesses, too.
    """
    best = _attempt(task, start)
    unknown = task.free & (task.weight < 1.0)
    random = np.random.default_rng(1)
    guesses = task.free & (not task.equations.is_large)
    for moving in (*[unknown] * _RESTARTS, *[guesses] * _RESTARTS):
        if best.closed:
            break
        if moving.any():
            moved = start.copy()
            moved[moving] += random.normal(size=int(moving.sum())) * task.scale[moving]
            best = min(best, _attempt(task, moved), key=lambda closing: closing.gap)
    return best


def _attempt(task: Task, start: FloatArray) -> Closing:
    q = start.copy()
    if task.free.any() and task.rows.any():
        is_rough = np.abs(task.gaps(q)).max() > ROUGH
        if is_rough:
            for penalty in PENALTIES:
                q = _minimise(task, start, q, float(penalty))
        near, q = q, refine(task, q)
        closing = _closing(task, q)
        if is_rough and not closing.closed and closing.gap < ROUGH:
            for penalty in _STRONGER:
                near = _minimise(task, start, near, penalty)
            closing = min(closing, _closing(task, refine(task, near)), key=lambda one: one.gap)
        return closing
    return _closing(task, q)


def _closing(task: Task, q: FloatArray) -> Closing:
    # A machine far from the origin closes to the last digits of its coordinates.
    rounding = DIGITS * EPS * task.term_sizes(q)[task.rows]
    gap = float((np.abs(task.gaps(q)) - rounding).max(initial=0.0))
    return Closing(q, gap if gap < np.inf else np.inf)


def refine(task: Task, q: FloatArray) -> FloatArray:
    """Newton's method on the chosen rows, in the free coordinates."""
    scale = task.scale[task.free]

    def at(x: FloatArray) -> FloatArray:
        moved = q.copy()
        moved[task.free] += x * scale
        normalise(moved, task.equations.mechanism.shape["turning"], task.free)
        return moved

    x, _ = solve_by_newton(
        lambda x: task.gaps(at(x)), lambda x: task.matrix(at(x)), np.zeros(len(scale))
    )
    return at(x)


def nearest(task: Task, q: FloatArray) -> FloatArray:
    """About the nearest closed position to q, with equal weights."""
    even = task._replace(weight=np.ones_like(q))
    return _minimise(even, q, q, float(PENALTIES[-1]))


def least_gap(task: Task, row: int, q: FloatArray) -> float:
    """How little open one constraint can be where all others are closed, with its sign, from q on.

    The position moves on in halves of what is left of the gap.
    """
    gap, offset = task.equations.constraints(task.t, q)[row], np.zeros(task.equations.m)
    least, most = 0.0, 1.0
    for _ in range(_HALVES):
        offset[row] = 0.5 * (least + most) * gap
        tried = _attempt(task._replace(offset=offset), q)
        if tried.closed:
            q, most = tried.q, 0.5 * (least + most)
        else:
            least = 0.5 * (least + most)
    return float(most * gap)


def _minimise(task: Task, origin: FloatArray, q: FloatArray, penalty: float) -> FloatArray:
    """Levenberg-Marquardt on the penalised sum of squares."""
    root = np.sqrt(penalty)
    free, scale = task.free, task.scale[task.free]
    weight = np.sqrt(task.weight[free])

    def residual(at: FloatArray) -> FloatArray:
        return np.concatenate([weight * (at - origin)[free] / scale, root * task.gaps(at)])

    damping = 1e-6
    current = residual(q)
    for _ in range(40):
        slopes = root * task.matrix(q)
        if not np.isfinite(abs(slopes).sum()):  # where a root begins, no step is known
            break
        step = _damped_step(weight, slopes, current, damping)
        trial = q.copy()
        trial[free] += step * scale
        after = residual(trial)
        if after @ after < current @ current:
            small = float(np.abs(step).max()) < 1e-5
            q, current = trial, after
            damping = max(damping * 0.2, 1e-12)
            if small:
                break
        else:
            damping *= 8.0
            if damping > 1e8:
                break
    return q


def _damped_step(
    weight: FloatArray, slopes: FloatArray | Any, residual: FloatArray, damping: float
) -> FloatArray:
    """The step of Levenberg-Marquardt, (f,), for residuals (f + m,) with diag(weight), `slopes`."""
    if isinstance(slopes, np.ndarray):
        whole = np.vstack([np.diag(weight), slopes])
        normal = whole.T @ whole
        diagonal = np.diag(np.diag(normal) + 1e-12)
        step: FloatArray = np.linalg.solve(normal + damping * diagonal, -(whole.T @ residual))
        return step
    from scipy.sparse import diags_array  # small machines load none of it
    from scipy.sparse.linalg import spsolve

    sparse = diags_array(weight**2) + slopes.T @ slopes
    shift = diags_array(damping * (sparse.diagonal() + 1e-12))
    gradient = weight * residual[: len(weight)] + slopes.T @ residual[len(weight) :]
    normal = (sparse + shift).tocsc()
    sought: FloatArray = spsolve(normal, -gradient, permc_spec="MMD_AT_PLUS_A")
    return sought
