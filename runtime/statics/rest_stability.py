"""The stability of a rest: what follows a small push, by masses, stiffness and damping."""

from enum import StrEnum
from typing import NamedTuple

import numpy as np

from runtime.mechanism.dense_equations import FloatArray
from runtime.statics.energy_minimisation import RestPosition, StaticEquations

_FLAT = 1e-8  # accuracy: part of the largest stiffness; a smaller one is indifferent
_GROWING = 1e-6  # accuracy: part of the fastest rate; a slower growth is rounding
_MOVED = 1e-3  # accuracy: part of the largest motion in an indifferent direction; less is none


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
    frequencies: FloatArray = np.zeros(0)  # rad/s
    flutter: bool = False
    fed: bool = False  # whether only forces that depend on velocities let a push grow
    loose: tuple[str, ...] = ()  # bodies in space that indifferent directions move


def judge(statics: StaticEquations, position: RestPosition) -> Judgement:
    """Eigenvalues of M^-1 K over the independent coordinates; all positive means stable.

    Pairs of complex eigenvalues are oscillations that grow: no natural frequencies. Where forces
    depend on velocities, the solutions of M ẍ + C ẋ + K x = 0 tell what grows. Where a condition
    changes at the position, K is that of one side, which says nothing of the other.
    """
    motions = statics.motions(position.q, position.part)
    root = np.linalg.cholesky(motions.T @ statics.equations.mass(position.q) @ motions)
    matrix, damping = (
        np.linalg.solve(root, np.linalg.solve(root, slopes).T).T
        for slopes in (position.stiffness, statics.damping(position, motions))
    )
    if not np.isfinite(matrix + damping).all():  # forces end there
        return Judgement(Stability.UNKNOWN, np.full(len(matrix), np.nan))
    largest = float(np.abs(matrix).max(initial=0.0))
    if float(np.abs(matrix - matrix.T).max(initial=0.0)) <= 1e-6 * largest:
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        real = np.ones(len(values), dtype=np.bool_)
    else:
        pairs, vectors = np.linalg.eig(matrix)
        order = np.argsort(pairs.real)
        pairs, vectors = pairs[order], vectors[:, order]
        real = np.abs(pairs.imag) <= 1e-6 * np.abs(pairs).max()
        values = pairs.real
    flutter = not bool(real.all())
    light = float(np.linalg.eigvalsh(root @ root.T).max())
    flat = np.full(len(values), max(_FLAT * largest, 1e-9 * float(position.effort.max()) / light))
    description = statics.equations.description
    modes = np.linalg.solve(root.T, vectors)
    if description.turning:  # a thin rod about its axis: what differences leave, over no inertia
        stiffest = float(np.abs(position.stiffness).max(initial=0.0))
        flat = np.maximum(flat, _FLAT * stiffest * np.sum(np.abs(modes) ** 2, axis=0))
    squares: FloatArray = np.array(values, dtype=np.float64)
    if position.edges:
        return Judgement(Stability.UNKNOWN, squares, flutter=flutter)
    grows, falls, some_flat = flutter, (values < -flat)[real].any(), (values <= flat)[real].any()
    if damping.any():
        still, unit = np.zeros_like(matrix), np.eye(len(matrix))
        rates = np.linalg.eigvals(np.block([[still, unit], [-matrix, -damping]]))
        least = max(_GROWING * np.abs(rates).max(), some_flat * np.sqrt(flat.max()))
        grows = bool((rates.real > least).any())
        flutter &= grows
    if grows or falls:
        stability = Stability.UNSTABLE
    else:
        stability = Stability.INDIFFERENT if some_flat else Stability.STABLE
    moved = np.abs(motions / statics.scale[:, None] @ modes[:, values <= flat])
    moved = (moved / moved.max(axis=0, initial=1e-300)).max(axis=1, initial=0.0)
    loose = tuple(n for n, k in description.turning if moved[k - 3 : k + 4].max() > _MOVED)
    frequencies = np.sqrt(squares[real & (squares > flat)])
    fed = grows and not (flutter or bool(falls))
    return Judgement(stability, squares, frequencies, flutter, fed, loose)
