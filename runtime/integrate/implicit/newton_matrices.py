"""The matrices I - c G_u̇ - c² G_u of Newton's method, and errors of a step seen through them."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import COORDINATES, method_integers_of
from runtime.core.jit import inner
from runtime.core.workspace_rows import PARTITION, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.state_space_form import complete_direction
from runtime.linalg.lu import factor, solve


@inner
def factor_real(context: Integers, c: float) -> int:
    """Factor I - c G_u̇ - c² G_u; 1 where it is singular, else 0."""
    f = method_integers_of(context)[mem.FREEDOMS]
    by_u, by_rate = mem.matrix(context, mem.BY_U), mem.matrix(context, mem.BY_RATE)
    a = mem.matrix(context, mem.REAL)
    for i in range(f):
        for j in range(f):
            at = i * f + j
            a[at] = (1.0 if i == j else 0.0) - c * (by_rate[at] + c * by_u[at])
    return int(factor(a, f, mem.pivots(context, mem.REAL), 0.0))


@inner
def factor_complex(context: Integers, c: float, d: float) -> int:
    """Factor I - (c + i d) G_u̇ - (c + i d)² G_u as a real matrix of order 2 f, real parts first."""
    f = method_integers_of(context)[mem.FREEDOMS]
    by_u, by_rate = mem.matrix(context, mem.BY_U), mem.matrix(context, mem.BY_RATE)
    a = mem.matrix(context, mem.COMPLEX)
    for i in range(f):
        for j in range(f):
            at = i * f + j
            real = (1.0 if i == j else 0.0) - c * by_rate[at] - (c * c - d * d) * by_u[at]
            imaginary = -d * by_rate[at] - 2.0 * c * d * by_u[at]
            a[i * 2 * f + j] = real
            a[i * 2 * f + f + j] = -imaginary
            a[(f + i) * 2 * f + j] = imaginary
            a[(f + i) * 2 * f + f + j] = real
    return int(factor(a, 2 * f, mem.pivots(context, mem.COMPLEX), 0.0))


@inner
def solve_real(context: Integers, x: Vector) -> None:
    """Overwrite the right side `x`, (f,), by the solution with the real matrix."""
    f = method_integers_of(context)[mem.FREEDOMS]
    solve(mem.matrix(context, mem.REAL), f, mem.pivots(context, mem.REAL), x)


@inner
def solve_complex(context: Integers, x: Vector) -> None:
    """Overwrite the right side `x`, (2 f,), real parts first, by that with the complex matrix."""
    f = method_integers_of(context)[mem.FREEDOMS]
    solve(mem.matrix(context, mem.COMPLEX), 2 * f, mem.pivots(context, mem.COMPLEX), x)


@inner
def filtered_error(context: Integers, t: float, state: int, c: float) -> float:
    """Size of (I - c J)⁻¹ (x, y) over the tolerance, over all coordinates and velocities.

    x and y, changes of the unknowns and of their rates, are in the second and in the first half of
    row SLOPE and are used up. Row IN receives the result, completed by the change of the dependent
    coordinates at the state in row `state`. The matrix takes out what stiff forces do not permit,
    and turns an error of a position that they hold into that of its velocity.
    """
    n, f = context[COORDINATES], method_integers_of(context)[mem.FREEDOMS]
    by_u, unknown = mem.matrix(context, mem.BY_U), mem.unknowns(context)
    change, allowed = mem.row(context, mem.IN), mem.row(context, mem.TOLERANCE)
    y, x = mem.first_half(context, mem.SLOPE), mem.second_half(context, mem.SLOPE)
    for i in range(f):
        for k in range(f):
            y[i] += c * by_u[i * f + k] * x[k]
    solve_real(context, y)
    for j in range(2 * n):
        change[j] = 0.0
    for i in range(f):
        j = unknown[i]
        change[n + j] = y[i]
        change[j] = x[i] + c * y[i]
    complete_direction(context, t, state)
    total = 0.0
    for j in range(2 * n):
        total += (change[j] / allowed[j]) ** 2
    return float(np.sqrt(total / (2 * n)))


@inner
def dependent_error(context: Integers, raw: Vector) -> float:
    """Size of an error `raw` of all coordinates, over the tolerance, of the dependent ones alone.

    At the ends of steps these follow from the constraints and have no error of their own. But they
    are foreseen, and interpolated between. Where drivers move them the independent ones say nothing
    of how, and Newton's method for them might come to another way to assemble the machine.
    Velocities are left out: where a stiff force holds a position they are not smooth.
    """
    if method_integers_of(context)[mem.PARTITIONED] == 0:
        return 0.0
    n = context[COORDINATES]
    partition, allowed = row_of(context, PARTITION), mem.row(context, mem.TOLERANCE)
    total = 0.0
    for j in range(n):
        if partition[j] != 0.0:
            total += (raw[j] / allowed[j]) ** 2
    return float(np.sqrt(total / (2 * n)))
