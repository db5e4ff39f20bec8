"""A mechanism of three coordinates whose motions cross in the origin, all of it known by hand.

Φ₁ = u + x y and Φ₂ = x² - y² + c u + gap + k x³ + d x t leave, u eliminated, the curve

    G(x, y, t) = x² - y² - c x y + gap + k x³ + d x t = 0,

a saddle: with gap = 0 two branches cross in the origin at t = 0, where Φ_q has lost a row. The
kernel of the constraints notes each place where it is called.
"""

import numpy as np

from runtime.core.arrays import Matrix, Vector, integers, none, vector
from runtime.core.jit import compiled
from runtime.core.kernel_abi import SIGNATURES
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.search_function_table import unit_residuals

C, GAP, K, D, CALLS, PLACES = 0, 1, 2, 3, 4, 5
ROWS = np.array([0, 0, 0, 1, 1, 1])
COLUMNS = np.array([0, 1, 2, 0, 1, 2])


@compiled(SIGNATURES["constraints"])
def constraints(t: float, q: Vector, p: Vector, phi: Vector) -> None:
    x, y, u = q[0], q[1], q[2]
    phi[0] = u + x * y
    phi[1] = x**2 - y**2 + p[C] * u + p[GAP] + p[K] * x**3 + p[D] * x * t
    at = PLACES + 4 * int(p[CALLS])
    if at + 4 <= p.size:
        p[at], p[at + 1], p[at + 2], p[at + 3] = x, y, u, t
        p[CALLS] += 1.0


@compiled(SIGNATURES["jacobian"])
def jacobian(t: float, q: Vector, p: Vector, values: Vector) -> None:
    x, y = q[0], q[1]
    values[0], values[1], values[2] = y, x, 1.0
    values[3], values[4], values[5] = 2 * x + 3 * p[K] * x**2 + p[D] * t, -2 * y, p[C]


@compiled(SIGNATURES["constraints"])
def velocity_rhs(t: float, q: Vector, p: Vector, nu: Vector) -> None:
    nu[0], nu[1] = 0.0, -p[D] * q[0]


@compiled(none(integers, vector, vector))
def gaps_by_place(table: Vector, z: Vector, gaps: Vector) -> None:
    unit_residuals(table, z, gaps)


def mechanism(
    c: float = 0.5,
    gap: float = 0.0,
    k: float = 0.0,
    d: float = 0.0,
    scale: tuple[float, ...] = (1.0, 1.0, 1.0),
    places: int = 60,
) -> ScaledConstraints:
    """The constraints with these parameters, and room to note so many places."""
    p = np.zeros(PLACES + 4 * places)
    p[:CALLS] = c, gap, k, d
    return ScaledConstraints(
        constraints, jacobian, velocity_rhs, ROWS, COLUMNS, p, np.array(scale), np.arange(2), 2
    )


def noted(scaled: ScaledConstraints) -> Matrix:
    """Places (x, y, u, t) at which the constraints were evaluated, in that order."""
    return scaled.p[PLACES : PLACES + 4 * int(scaled.p[CALLS])].reshape(-1, 4)


def closed(x: float, y: float) -> Vector:
    """The position with these x and y that Φ₁ allows."""
    return np.array([x, y, -x * y])


def branch_slopes(c: float) -> Vector:
    """dy/dx of the two branches in the origin with d = 0: s² + c s - 1 = 0."""
    return (-c + np.array([1.0, -1.0]) * np.sqrt(c * c + 4.0)) / 2.0
