"""Equilibrium as a minimum of the total potential energy over the independent coordinates.

Newton's method with the exact reduced gradient; directions in which the energy falls off are
followed downhill. Forces without a potential enter through their reduced generalized force: then a
root is sought, downhill first, and judged afterwards.
"""

from typing import NamedTuple

import numpy as np

from runtime.analyses.equations import FloatArray
from runtime.analyses.reduced import Partition, Rest
from runtime.progress import Progress

_REACH = 0.3  # largest scaled change in one iteration
_ITERATIONS = 300
BALANCED = 1e-10  # a gradient below this share of the forces counts as balanced


class Found(NamedTuple):
    """Where a search ended: q, partition there, gradient, effort, iterations."""

    q: FloatArray
    part: Partition
    gradient: FloatArray
    effort: float
    iterations: int

    @property
    def balanced(self) -> bool:
        """Whether the forces balance to rounding."""
        return float(np.abs(self.gradient).max(initial=0.0)) <= BALANCED * self.effort


def minimise(rest: Rest, q: FloatArray, progress: Progress) -> Found:
    """Walk downhill from an assembled q until the forces balance, then polish."""
    done = 0
    reach = _REACH
    effort = rest.effort(q)
    for _ in range(_ITERATIONS):
        done += 1
        part = rest.partition(q)
        slope = rest.gradient(q, part)
        effort = max(rest.effort(q), 1e-300)
        size = float(np.abs(slope).max(initial=0.0))
        if size <= 1e-9 * effort:
            break
        stiffness = rest.stiffness(q, part)
        values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
        least = max(1e-6 * float(np.abs(values).max()), 1e-9 * effort)
        step = -vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), least))
        step *= min(1.0, reach / float(np.abs(step).max()))
        moved = _downhill(rest, q, part, slope, step)
        if moved is None:
            reach *= 0.25
            if reach < 1e-8:
                break
            continue
        q = moved
        reach = min(_REACH, 2.0 * reach)
        progress(1.0 - min(1.0, max(0.0, 1.0 + np.log10(size / effort) / 10.0)))
    return polish(rest, q, done)


def _downhill(
    rest: Rest, q: FloatArray, part: Partition, slope: FloatArray, step: FloatArray
) -> FloatArray | None:
    """The longest of the halved steps that lowers the energy, or does not overshoot the force."""
    conservative = not rest.without_potential(q)
    energy = rest.energy(q)
    fall = float(slope @ step)
    size = float(np.abs(slope).max())
    for halving in range(25):
        part_of_step = 0.5**halving
        trial = q.copy()
        trial[part.independent] += part_of_step * step * rest.scale[part.independent]
        closed = rest.close(trial, part)
        if closed is None:
            continue
        after = rest.gradient(closed, part)
        if float(np.abs(after).max()) <= 0.5 * size and fall < 0.0:
            return closed
        if conservative:
            if rest.energy(closed) <= energy + 1e-4 * part_of_step * fall:
                return closed
        elif float(after @ step) <= 0.0:
            return closed
    return None


def polish(rest: Rest, q: FloatArray, iterations: int = 0) -> Found:
    """Newton's method on the gradient for as long as it shrinks."""
    part = rest.partition(q)
    slope = rest.gradient(q, part)
    for _ in range(12):
        size = float(np.abs(slope).max(initial=0.0))
        if size == 0.0:
            break
        stiffness = rest.stiffness(q, part)
        step = np.linalg.lstsq(stiffness, -slope, rcond=1e-12)[0]
        if float(np.abs(step).max()) > 0.1:
            break
        trial = q.copy()
        trial[part.independent] += step * rest.scale[part.independent]
        closed = rest.close(trial, part)
        if closed is None:
            break
        after = rest.gradient(closed, part)
        if not float(np.abs(after).max()) < size:
            break
        q, slope = closed, after
        iterations += 1
    return Found(q, part, slope, max(rest.effort(q), 1e-300), iterations)
