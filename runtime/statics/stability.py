"""Stability of a rest position."""

from enum import StrEnum
from typing import NamedTuple

import numpy as np

from runtime.mechanism.dense_equations import FloatArray
from runtime.statics.energy_minimisation import RestPosition
from runtime.statics.stiffness import StaticEquations

_FLAT = 1e-8  # accuracy: part of the largest stiffness; a smaller one is indifferent


class Stability(StrEnum):
    """Behaviour of the machine after a small push."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    INDIFFERENT = "indifferent"
    UNKNOWN = "unknown"


class Judgement(NamedTuple):
    """Stability of a position and the numbers behind it."""

    stability: Stability
    eigenvalues: FloatArray  # of M^-1 K, 1/s^2, ascending
    frequencies: FloatArray  # rad/s
    flutter: bool


def judge(statics: StaticEquations, position: RestPosition) -> Judgement:
    """Eigenvalues of M^-1 K over the independent coordinates; all positive means stable.

    Pairs of complex eigenvalues are oscillations that grow: no natural frequencies. Where a
    condition changes at the position, K is that of one side, which says nothing of the other.
    """
    root = np.linalg.cholesky(statics.inertia(position.q, position.part))
    matrix = np.linalg.solve(root, np.linalg.solve(root, position.stiffness.matrix).T).T
    if not np.isfinite(matrix).all():  # forces end there
        return Judgement(Stability.UNKNOWN, np.full(len(matrix), np.nan), np.zeros(0), False)
    asymmetry = float(np.abs(matrix - matrix.T).max(initial=0.0))
    largest = float(np.abs(matrix).max(initial=0.0))
    if asymmetry <= 1e-6 * largest:
        values = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
        real = np.ones(len(values), dtype=np.bool_)
    else:
        pairs = np.linalg.eigvals(matrix)
        pairs = pairs[np.argsort(pairs.real)]
        real = np.abs(pairs.imag) <= 1e-6 * np.abs(pairs).max()
        values = pairs.real
    flutter = not bool(real.all())
    light = float(np.linalg.eigvalsh(root @ root.T).max())
    flat = max(_FLAT * largest, 1e-9 * float(position.effort.max()) / light)
    eigenvalues = np.array(values, dtype=np.float64)
    frequencies = np.sqrt(eigenvalues[real & (eigenvalues > flat)])
    if position.stiffness.edges:
        return Judgement(Stability.UNKNOWN, eigenvalues, np.zeros(0), flutter)
    if flutter or bool((eigenvalues < -flat).any()):
        stability = Stability.UNSTABLE
    elif bool((eigenvalues <= flat).any()):
        stability = Stability.INDIFFERENT
    else:
        stability = Stability.STABLE
    return Judgement(stability, eigenvalues, frequencies, flutter)


def unjudged(position: RestPosition) -> Judgement:
    """Of a machine with states, whose motion after a push M and K alone do not determine."""
    none = np.full(len(position.gradient), np.nan)
    return Judgement(Stability.UNKNOWN, none, np.zeros(0), False)
