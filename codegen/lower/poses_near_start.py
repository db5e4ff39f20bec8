"""Positions of a mechanism before it is compiled: where its joints close, at the start and near by.

The interpreter evaluates the constraints with the default parameters at t = 0, and Gauss-Newton
steps of least norm close them. Coordinates are counted in units of the machine's size.

In a large machine least norms and left null vectors come from the quasidefinite matrix
[[α I, Aᵀ], [A, -δ I]], whose factors have few non-zeros where A has. (R. J. Vanderbei, Symmetric
quasidefinite matrices, SIAM Journal on Optimization 5, 1995.)
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.lower.graph import Graph
from codegen.lower.interpreter import LevelEvaluation, evaluate
from codegen.lower.lowered_scene import Lowered
from codegen.lower.program import Kernel, Program, store

FloatArray = npt.NDArray[np.float64]
Array = FloatArray
_STEPS = 25  # safety: of Gauss-Newton, in which no coordinate moves by more than its reach
_LAST = 1e-12  # accuracy: a shorter step is the last one
_CLOSED = 1e-9  # accuracy: of the machine's size; a larger residual leaves joints open
WALK = 8  # measured: poses along the motion on each side of the start
_STRIDE = 0.4  # measured: distance of neighbouring poses, in units of the machine's size
_NEAR = 0.75  # safety: of a stride; a position nearer to the start than that ends a cycle
SPARSE_FROM = 300  # measured: coordinates, from which on the Jacobian is no dense matrix
_DAMPING = 1e-12  # accuracy: δ of least norms, over the largest squared length of a row
_REFINEMENTS = 6  # safety: steps of refinement by the residual
_SMALL = 1e-6  # accuracy: α of null vectors; singular values of 1e-8 stand out from δ
_NULL = 1e-14  # accuracy: δ of null vectors, near the rounding of rows of length 1
_ITERATIONS = 3  # measured: of inverse iteration, each of which gains four digits or more
_BLOCK = 4  # measured: null vectors that are sought at first


class Poses:
    """Positions of one scene."""

    def __init__(self, lowered: Lowered) -> None:
        self.program, self.description = lowered.program, lowered.description
        self.is_sparse = len(self.description.coordinates) >= SPARSE_FROM
        self._levels: dict[str, LevelEvaluation] = {}
        known = {name: value for name, value, _ in self.description.start}  # what is fixed is last
        names = [name for name, *_ in self.description.coordinates]
        self.guess = np.array([known.get(name, 0.0) for name in names])
        fixed = {name for name, _, role in self.description.start if role == "fixed"}
        self.free = np.array([float(name not in fixed) for name in names])
        is_length = np.array([unit == "m" for *_, unit in self.description.coordinates])
        self.size = self._longest_arm(is_length)
        self.unit = np.where(is_length, self.size, 1.0)
        # A step turns a body by 1 rad at most, and shifts it by as many arms as a chain of half
        # the bodies has: in a long chain all must move by many arms. A body in space has four Euler
        # parameters, and a turn by 1 rad moves them by half as much.
        turning = [first for _, first in self.description.turning]
        arms = max(1.0, (np.count_nonzero(~is_length) - 3 * len(turning)) / 2)
        self.reach = np.where(is_length, arms, 1.0)
        for first in turning:
            self.reach[first : first + 4] = 0.5

    def closed_near(
        self, q: Array, moved: Array | float = 1.0, kept: Array | float = 1.0
    ) -> tuple[Array, Any]:
        """A position near q whose constraints hold if there is one, and Φ_q there in these units.

        Φ_q, (m, n), is a sparse matrix of a large machine.

        `moved`, (n,), is 1 for the coordinates that may change and 0 for others; `kept`, (m,), the
        same of the constraints that must hold.
        """
        rows = np.ones(len(self.description.constraints)) * kept
        q = self._with_unit_parameters(q)
        jacobian = self.jacobian(q)
        for _ in range(_STEPS):
            if not is_finite(jacobian):
                break
            slopes = self.scaled(jacobian, self.unit * moved, rows)
            step = _least_norm(slopes, -rows * self.residual(q), 1e-10)
            q = self._with_unit_parameters(q + self.unit * np.clip(step, -self.reach, self.reach))
            jacobian = self.jacobian(q)
            if np.linalg.norm(step) < _LAST:
                break
        return q, self.scaled(jacobian, self.unit)

    def _with_unit_parameters(self, q: Array) -> Array:
        """A position whose Euler parameters have length 1, near which Φ_q tells of their turns."""
        for _, first in self.description.turning:
            p = q[first : first + 4]
            q = np.concatenate([q[:first], p / (np.linalg.norm(p) or 1.0), q[first + 4 :]])
        return q

    def scaled(self, jacobian: Any, columns: Array, rows: Array | None = None) -> Any:
        """Φ_q with its columns, and its rows, times numbers."""
        if not self.is_sparse:
            scaled = jacobian * columns
            return scaled if rows is None else rows[:, None] * scaled
        entries = jacobian.tocoo()
        factors = columns[entries.col] * (1.0 if rows is None else rows[entries.row])
        entries.data = entries.data * factors
        return entries.tocsr()

    def start(self, kept: Array | float = 1.0) -> tuple[Array, Any] | None:
        """The start and Φ_q there, in these units; None where the joints do not close near it."""
        start, jacobian = self.closed_near(self.guess, self.free, kept)
        if not self.holds(start, kept):
            start, jacobian = self.closed_near(self.guess, kept=kept)
        return (start, jacobian) if self.holds(start, kept) else None

    def along_motion(self, kept: Array | float = 1.0, most: int = WALK) -> list[Array]:
        """Positions that hold, (n,) each: the start, and some to which the joints let it move.

        `kept`, (m,), is 1 for the constraints that must hold, as above. There are at most so many
        positions on each side of the start, and a cycle is gone round once: p stands for -p.
        """
        closed = self.start(kept)
        if closed is None:
            return []
        start, jacobian = closed
        found, direction = [start], np.random.default_rng(0).standard_normal(len(start))
        for way in (1.0, -1.0):
            q, rows, ahead = start, jacobian, way * direction
            for _ in range(most):
                ahead = self.allowed(rows, ahead, kept)
                length = float(np.linalg.norm(ahead))
                if length < _CLOSED:
                    break
                ahead /= length
                q, rows = self.closed_near(q + _STRIDE * self.unit * ahead, kept=kept)
                if not self.holds(q, kept):
                    break
                found.append(q)
                apart = float(np.linalg.norm((np.abs(q) - np.abs(start)) / self.unit))
                if apart < _NEAR * _STRIDE:
                    return found
        return found

    def allowed(self, jacobian: Any, ahead: Array, kept: Array | float = 1.0) -> Array:
        """The part of a displacement that joints allow whose Φ_q is this one, in these units."""
        rows = np.ones(len(self.description.constraints)) * kept
        slopes = self.scaled(jacobian, np.ones(len(ahead)), rows)
        return ahead - _least_norm(slopes, slopes @ ahead, 1e-6)

    def values(self, graph: Graph, numbers: Sequence[int], q: Array) -> Array:
        """Values of a graph at a position; nan throughout where they are undefined."""
        kernel = Kernel("values", "", (), store("out", list(numbers), [""] * len(numbers)))
        return self._flat("values", "out", q, Program(tuple(graph.values), (kernel,), (), 0.0))

    def residual(self, q: Array) -> Array:
        """Φ at a position, (m,)."""
        return self._flat("constraints", "phi", q)

    def holds(self, q: Array, kept: Array | float = 1.0) -> bool:
        """Whether the constraints hold at a position, or those that are `kept`, as above."""
        return bool(np.abs(self.residual(q) * kept).max(initial=0.0) <= _CLOSED * self.size)

    def jacobian(self, q: Array) -> Any:
        """Φ_q at a position, (m, n); a sparse matrix of a large machine."""
        pattern, values = self.description.jacobian, self._flat("jacobian", "values", q)
        shape = len(self.description.constraints), len(q)
        if self.is_sparse:
            from scipy.sparse import csr_array  # small machines load none of it

            return csr_array((values, (pattern.rows, pattern.columns)), shape=shape)
        dense = np.zeros(shape)
        dense[list(pattern.rows), list(pattern.columns)] = values
        return dense

    def _longest_arm(self, is_length: npt.NDArray[np.bool_]) -> float:
        """The longest arm of a constraint, m, which is the machine's size."""
        pattern = self.description.jacobian
        rows, columns = np.array(pattern.rows, int), np.array(pattern.columns, int)
        sizes = np.abs(self._flat("jacobian", "values", self.guess))
        moved, turned = np.zeros((2, len(self.description.constraints)))
        for at, largest in ((is_length[columns], moved), (~is_length[columns], turned)):
            np.fmax.at(largest, rows[at], sizes[at])
        arms = [float(a / b) for a, b in zip(turned, moved, strict=True) if a > 0 and b > 0]
        longest = max(arms, default=1.0)
        return longest if math.isfinite(longest) else 1.0

    def _flat(self, name: str, array: str, q: Array, program: Program | None = None) -> Array:
        """The array that a kernel writes, or nan throughout where it is undefined."""
        parameters = [value for _, value, *_ in self.description.parameters]
        if self.is_sparse and program is None:
            if name not in self._levels:
                (kernel,) = (k for k in self.program.kernels if k.name == name)
                self._levels[name] = LevelEvaluation(self.program, kernel)
            if self._levels[name].suits:
                return self._levels[name](0.0, q, np.array(parameters))
        program = program or self.program
        try:
            arguments = {"t": 0.0, "q": q.tolist(), "p": parameters}
            slots = evaluate(program, name, arguments, math).get(array, {})
        except (ZeroDivisionError, ValueError, OverflowError):
            (undefined,) = (k for k in program.kernels if k.name == name)
            return np.full(len(undefined.outputs), np.nan)
        return np.array([slots[k] for k in range(len(slots))])


def is_finite(jacobian: Any) -> bool:
    """Whether all entries are finite, of a dense or a sparse matrix."""
    entries = jacobian if isinstance(jacobian, np.ndarray) else jacobian.data
    return bool(np.all(np.isfinite(entries)))


def _least_norm(matrix: Any, right: Array, rcond: float) -> Array:
    if not is_finite(matrix):
        return np.zeros(matrix.shape[1])
    if isinstance(matrix, np.ndarray):
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=rcond)[0], np.float64)
    return least_norm(matrix, right)


def least_norm(matrix: Any, right: Array) -> Array:
    """The x of least norm, (n,), among those of the least residual of a sparse A x = `right`."""
    largest = float(matrix.multiply(matrix).sum(axis=1).max(initial=0.0)) if right.size else 0.0
    factors, n = _factors(matrix, 1.0, _DAMPING * (largest or 1.0)), matrix.shape[1]
    x, left = np.zeros(n), right
    for _ in range(1 + _REFINEMENTS):
        step = factors.solve(np.concatenate([np.zeros(n), left]))[:n]
        rest = left - matrix @ step
        if not float(rest @ rest) < float(left @ left):
            break
        x, left = x + step, rest
    return x


def rest_of_rows(matrix: Any, rows: Array) -> Array:
    """Rows, (k, n), without their part in the span of the rows of a matrix, dense or sparse."""
    if isinstance(matrix, np.ndarray):
        return rows - np.linalg.lstsq(matrix.T, rows.T, rcond=None)[0].T @ matrix
    largest = float(matrix.multiply(matrix).sum(axis=1).max(initial=1.0))
    both = np.vstack([rows.T, np.zeros((matrix.shape[0], len(rows)))])
    rest: Array = _factors(matrix, 1.0, _DAMPING * largest).solve(both)[: rows.shape[1]].T
    return rest


def dependent_rows(matrix: Any, tolerance: float) -> list[int]:
    """Rows of a sparse matrix, (m, n), that follow from earlier ones, to a tolerance.

    Each is the last row of a left null vector, as the rows are scaled to length 1.
    """
    from scipy.sparse import diags_array

    m, n = matrix.shape
    lengths = np.sqrt(matrix.multiply(matrix).sum(axis=1))
    scaled = (diags_array(1.0 / np.maximum(lengths, 1e-300)) @ matrix).tocsr()  # safety: zeros
    factors, random = _factors(scaled, _SMALL, _NULL), np.random.default_rng(0)
    count = min(_BLOCK, m)
    while True:
        vectors = np.linalg.qr(random.standard_normal((m, count)))[0]
        for _ in range(_ITERATIONS):
            right = np.vstack([np.zeros((n, count)), vectors])
            vectors = np.linalg.qr(factors.solve(right)[n:])[0]
        sizes, turned = np.linalg.svd(scaled.T @ vectors, full_matrices=False)[1:]
        null = vectors @ turned[sizes <= tolerance].T
        if null.shape[1] < count or count == m:
            return _last_rows(null)
        count = min(2 * count, m)


def _factors(matrix: Any, first: float, second: float) -> Any:
    from scipy.sparse import block_array, eye_array
    from scipy.sparse.linalg import splu

    m, n = matrix.shape
    whole = [[first * eye_array(n), matrix.T], [matrix, -second * eye_array(m)]]
    return splu(block_array(whole, format="csc"), permc_spec="COLAMD")


def _last_rows(null: Array) -> list[int]:
    """The last rows of vectors, (m, d), that are independent of later ones; in order."""
    rest, found = null.copy(), []
    for row in range(len(rest) - 1, -1, -1):
        if rest.shape[1] == 0:
            break
        size = float(np.linalg.norm(rest[row]))
        if size > _SMALL:  # an orthogonal change of the vectors leaves one with an entry here
            basis = np.linalg.qr(np.column_stack([rest[row], np.eye(rest.shape[1])]))[0]
            rest = (rest @ basis)[:, 1:]
            found.append(row)
    return found[::-1]
