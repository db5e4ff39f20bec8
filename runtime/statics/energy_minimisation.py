"""Equilibrium as a minimum of the total potential energy over the independent coordinates.

Newton's method with the exact reduced gradient; directions in which the energy falls off are
followed downhill. Forces without a potential enter through their reduced generalized force: then a
root is searched for, downhill first, and classified afterwards.
"""

from typing import NamedTuple

import numpy as np

from runtime.mechanism.dense_equations import FloatArray
from runtime.progress_bar import Progress
from runtime.statics.stiffness import (
    BALANCED,
    Partition,
    StaticEquations,
    Stiffness,
)

# measured: largest scaled change in one iteration; lengths may go on where K predicts it
_REACH = 0.3
_PREDICTED = 0.1  # measured: part of the force by which K may err in predicting the next one
_ITERATIONS = 300  # safety: Newton iterations of one search
AWAY = 1e9  # safety: scaled distance from the start from which no machine comes back
_TINY = 1e-300  # safety: keeps quotients from 0 / 0


class RestPosition(NamedTuple):
    """A position, its partition, and the reduced force and stiffness there."""

    q: FloatArray
    part: Partition
    gradient: FloatArray
    stiffness: Stiffness
    effort: FloatArray  # size of the forces along each independent coordinate, (f,), in J
    iterations: int

    @property
    def unbalanced(self) -> float:
        """Largest unbalanced force as a share of the forces that act."""
        return float((np.abs(self.gradient) / self.effort).max(initial=0.0))

    @property
    def balanced(self) -> bool:
        """Whether the forces balance to rounding."""
        return self.unbalanced <= BALANCED


def evaluate_position(statics: StaticEquations, q: FloatArray, iterations: int = 0) -> RestPosition:
    """Reduced force, stiffness and effort at a position."""
    part = statics.partition(q)
    stiffness = statics.stiffness(q, part)
    effort = np.maximum(max(statics.effort(q), _TINY), statics.floor(q, stiffness))
    return RestPosition(q, part, statics.gradient(q, part), stiffness, effort, iterations)


def minimise(statics: StaticEquations, q: FloatArray, progress: Progress) -> RestPosition:
    """Descend from an assembled q until the forces balance, then polish."""
    start, reach, done = q, _REACH, 0
    while done < _ITERATIONS:
        done += 1
        at = evaluate_position(statics, q)
        slope, share = at.gradient, at.unbalanced
        if share <= 1e-9:
            break
        matrix = at.stiffness.matrix
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
            return evaluate_position(statics, q, done)
        progress(1.0 - min(1.0, max(0.0, 1.0 + np.log10(share) / 10.0)))
    return polish(statics, q, done)


def _downhill(statics: StaticEquations, at: RestPosition, step: FloatArray) -> FloatArray | None:
    """The longest halved step that lowers the energy, or does not overshoot the force."""
    q, part, slope = at.q, at.part, at.gradient
    conservative = not statics.without_potential(q, float(at.effort.max()))
    energy = statics.energy(q)
    fall = float(slope @ step)
    size = float(np.abs(slope).max())
    for halving in range(25):
        part_of_step = 0.5**halving
        closed = statics.displaced(q, part, part_of_step * step)
        if closed is None:
            continue
        after = statics.gradient(closed, part)
        if float(np.abs(after).max()) <= 0.5 * size and fall < 0.0:
            return closed
        if conservative:
            if statics.energy(closed) <= energy + 1e-4 * part_of_step * fall:
                return closed
        elif float(after @ step) <= 0.0:
            return closed
    return None


def polish(statics: StaticEquations, q: FloatArray, iterations: int = 0) -> RestPosition:
    """Newton's method on the gradient for as long as it shrinks."""
    at = evaluate_position(statics, q, iterations)
    for _ in range(12):
        size = float(np.abs(at.gradient).max(initial=0.0))
        if size == 0.0 or not np.isfinite(at.stiffness.matrix).all():
            break  # it balances, or forces end there, as those of a table do
        step = np.linalg.lstsq(at.stiffness.matrix, -at.gradient, rcond=1e-12)[0]
        if float(np.abs(step).max()) > 0.1:
            break
        closed = statics.displaced(at.q, at.part, step)
        if closed is None or not float(np.abs(statics.gradient(closed, at.part)).max()) < size:
            break
        at = evaluate_position(statics, closed, at.iterations + 1)
    return at
