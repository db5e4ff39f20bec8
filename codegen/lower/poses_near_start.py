"""Positions of a mechanism before it is compiled: where its joints close, at the start and near by.

The interpreter evaluates the constraints with the default parameters at t = 0, and Gauss-Newton
steps of least norm close them. Coordinates are counted in units of the machine's size.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.level_evaluation import LevelEvaluation
from codegen.lower.program import Kernel, Program, store
from codegen.lower.sparse_steps import SPARSE_FROM, least_norm

FloatArray = npt.NDArray[np.float64]
Array = FloatArray
_STEPS = 25  # safety: of Gauss-Newton, in which no coordinate moves by more than its reach
_LAST = 1e-12  # accuracy: a shorter step is the last one
_CLOSED = 1e-9  # accuracy: of the machine's size; a larger residual leaves joints open
_WALK = 8  # measured: poses along the motion on either side of the start
_STRIDE = 0.4  # measured: from one of them to the next, in units of the machine's size


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
        # the bodies has: in a long chain all must move by many arms.
        arms = max(1.0, np.count_nonzero(~is_length) / 2)
        self.reach = np.where(is_length, arms, 1.0)

    def closed_near(
        self, q: Array, moved: Array | float = 1.0, kept: Array | float = 1.0
    ) -> tuple[Array, Any]:
        """A position near q whose constraints hold if there is one, and Φ_q there in these units.

        Φ_q, (m, n), is a sparse matrix of a large machine.

        `moved`, (n,), is 1 for the coordinates that may change and 0 for others; `kept`, (m,), the
        same of the constraints that must hold.
        """
        rows = np.ones(len(self.description.constraints)) * kept
        jacobian = self.jacobian(q)
        for _ in range(_STEPS):
            if not is_finite(jacobian):
                break
            slopes = self.scaled(jacobian, self.unit * moved, rows)
            step = _least_norm(slopes, -rows * self.residual(q), 1e-10)
            q = q + self.unit * np.clip(step, -self.reach, self.reach)
            jacobian = self.jacobian(q)
            if np.linalg.norm(step) < _LAST:
                break
        return q, self.scaled(jacobian, self.unit)

    def scaled(self, jacobian: Any, columns: Array, rows: Array | None = None) -> Any:
        """Φ_q with its columns, and its rows, times numbers."""
        if not self.is_sparse:
            scaled = jacobian * columns
            return scaled if rows is None else rows[:, None] * scaled
        entries = jacobian.tocoo()
        factors = columns[entries.col] * (1.0 if rows is None else rows[entries.row])
        entries.data = entries.data * factors
        return entries.tocsr()

    def start(self) -> tuple[Array, Any] | None:
        """The start and Φ_q there, in these units; None where the joints do not close near it."""
        start, jacobian = self.closed_near(self.guess, self.free)
        if not self.holds(start):
            start, jacobian = self.closed_near(self.guess)
        return (start, jacobian) if self.holds(start) else None

    def along_motion(self) -> list[Array]:
        """Positions that hold, (n,) each: the start, and some to which the joints let it move."""
        closed = self.start()
        if closed is None:
            return []
        start, jacobian = closed
        found, direction = [start], np.random.default_rng(0).standard_normal(len(start))
        for way in (1.0, -1.0):
            q, rows, ahead = start, jacobian, way * direction
            for _ in range(_WALK):
                ahead = ahead - _least_norm(rows, rows @ ahead, 1e-6)
                length = float(np.linalg.norm(ahead))
                if length < _CLOSED:
                    break
                ahead /= length
                q, rows = self.closed_near(q + _STRIDE * self.unit * ahead)
                if not self.holds(q):
                    break
                found.append(q)
        return found

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
    if isinstance(matrix, np.ndarray):
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=rcond)[0], np.float64)
    return least_norm(matrix, right)
