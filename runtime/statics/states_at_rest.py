"""Rest of machines with states: positions and states at which forces balance and rates vanish.

Unknown are the independent coordinates and the states. A state of first order has the equation
ẏ = 0, a value that a clock samples s(q, y) = y: its samples renew nothing any more. What conditions
renew, as latches, keeps its start value.
"""

from typing import NamedTuple

import numpy as np

from codegen.errors import AnalysisError
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.statics.energy_minimisation import AWAY, StaticEquations

_DIFFERENCE = 1e-5  # accuracy: scaled step of the central difference quotients
_BALANCED = 1e-9  # accuracy: part of the rate that unknowns of their size would cause; less is zero
_ITERATIONS = 60  # safety: of Newton's method, which takes some five
_REACH = 0.3  # measured: largest scaled change of an angle in one iteration
_HALVINGS = 25  # safety: halvings of a step that leads away from the solution


class StatesAtRest(NamedTuple):
    """The position found, and the unbalanced share of each rate, by the name of its state."""

    q: FloatArray
    unbalanced: dict[str, float]

    @property
    def balanced(self) -> bool:
        """Whether all rates vanish."""
        return max(self.unbalanced.values(), default=0.0) <= _BALANCED


def free_states(description: Description) -> tuple[str, ...]:
    """States that follow from the position of rest: all but those that conditions renew."""
    kept = {row.target for row in description.watched if row.action == "sample"}
    return tuple(name for name in description.states.names if name not in kept)


def require_expressions(description: Description) -> None:
    """Refuse values that functions of a run compute, which no equation states."""
    if description.controllers:
        names = ", ".join(description.controllers)
        raise AnalysisError(
            f"{description.title}: equilibrium solves for states by their expressions, and {names} "
            "is computed by functions that a run brings (controllers=). Simulate until rest, or "
            "declare an expression, value=."
        )


def find_rest(statics: StaticEquations, q: FloatArray) -> StatesAtRest:
    """Newton's method for independent coordinates and states, from q; states go to `still`."""
    search = _Search(statics, q)
    for _ in range(_ITERATIONS):
        residual, matrix = search.residual(search.q), search.slopes()
        size = matrix_size(matrix, search.values())
        share = np.abs(residual) / size
        if (
            not (np.isfinite(share).all() and np.isfinite(matrix).all())
            or share.max(initial=0.0) <= 1e-3 * _BALANCED
        ):
            break
        step = np.linalg.lstsq(matrix / size[:, None], -residual / size, rcond=1e-12)[0]
        turn = np.abs(step[: search.count]).max(initial=0.0)
        if not search.move(step * min(1.0, _REACH / max(turn, _REACH)), size, share):
            break
    share = np.abs(search.residual(search.q)) / matrix_size(search.slopes(), search.values())
    share = np.where(np.isfinite(share), share, np.inf)
    return StatesAtRest(
        search.q, dict(zip(search.names, share[search.count :].tolist(), strict=True))
    )


def matrix_size(matrix: FloatArray, values: FloatArray) -> FloatArray:
    """What unknowns of their own size change each equation by, (k,); 1 where nothing does.

    Not a number where a slope has no value.
    """
    size: FloatArray = np.abs(matrix) @ np.maximum(1.0, np.abs(values))
    return np.where(size == 0.0, 1.0, size)


class _Search:
    """Equations and unknowns at a position, with the states in `equations.still`."""

    def __init__(self, statics: StaticEquations, q: FloatArray) -> None:
        self.statics, self.q, self.part = statics, q, statics.partition(q)
        self.equations = statics.equations
        description = self.equations.description
        self.names = free_states(description)
        rows = [description.states[name] for name in self.names]
        self.columns = np.array([row.column for row in rows], dtype=np.int64)
        self.nominal = np.array([row.nominal for row in rows])
        self.sampled = {name: k for k, name in enumerate(description.sampled)}
        self.count = len(self.part.independent)

    def values(self) -> FloatArray:
        """The unknowns, scaled."""
        free = self.part.independent
        places = self.q[free] / self.statics.scale[free]
        return np.concatenate([places, self.equations.still[self.columns] / self.nominal])

    def residual(self, q: FloatArray) -> FloatArray:
        """Reduced forces, then rates of states or what a sample would change them by."""
        return np.concatenate([self.statics.gradient(q, self.part), self._rates(q)])

    def _rates(self, q: FloatArray) -> FloatArray:
        equations, t = self.equations, self.statics.t
        modes = equations.rest_modes(t, q)
        rates = equations.forces(t, q, equations.at_rest(t, q), modes)[self.columns]
        if self.sampled:
            due, new = np.ones(len(self.sampled), np.int64), np.zeros(len(self.sampled))
            equations.kernels.samples(t, q, equations.still, equations.p, due, new)
            for j, name in enumerate(self.names):
                if name in self.sampled:
                    rates[j] = new[self.sampled[name]] - equations.still[self.columns[j]]
        return rates

    def slopes(self) -> FloatArray:
        """Derivatives of the equations by the scaled unknowns, (k, k)."""
        columns = []
        for unit in np.eye(self.count + len(self.columns)):
            sides = []
            for change in (_DIFFERENCE, -_DIFFERENCE):
                _, there = self._at(change * unit)
                if np.isfinite(there).all():
                    sides.append((change, there))
            here = [(0.0, self.residual(self.q))] if len(sides) == 1 else []
            (a, first), (b, second) = (*sides, *here)[:2] if sides else ((1.0, np.nan), (0.0, 0.0))
            columns.append((first - second) / (a - b) * np.ones(len(unit)))
        return np.stack(columns, axis=1)

    def _at(self, step: FloatArray) -> tuple[FloatArray | None, FloatArray]:
        """The closed position after a scaled step, None: none, and the equations there, or nan."""
        still, before = self.equations.still, self.equations.still[self.columns]
        still[self.columns] = before + step[self.count :] * self.nominal
        q = self.statics.displaced(self.q, self.part, step[: self.count])
        residual = np.array([np.nan]) if q is None else self.residual(q)
        still[self.columns] = before
        return q, residual

    def move(self, step: FloatArray, size: FloatArray, share: FloatArray) -> bool:
        """Take the longest halved step that brings the equations nearer to zero, if any."""
        still, merit = self.equations.still, float(share @ share)
        for halving in range(_HALVINGS):
            part = 0.5**halving
            states = still[self.columns] + part * step[self.count :] * self.nominal
            q, after = self._at(part * step)
            after /= size
            near = float(np.abs(states / self.nominal).max(initial=0.0)) < AWAY
            if q is not None and near and float(after @ after) <= (1.0 - 1e-4 * part) * merit:
                self.q, still[self.columns] = q, states
                return True
        return False
