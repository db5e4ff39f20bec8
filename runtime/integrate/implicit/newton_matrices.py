"""The matrices I - c G_u̇ - c² G_u of Newton's method, and errors of a step seen through them."""

import numpy as np

from runtime.core.arrays import Context, Vector
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import inner
from runtime.core.workspace_rows import PARTITION, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.state_space_form import complete_direction
from runtime.linalg.dense_elimination import factor, solve


@inner
def factor_real(context: Context, c: float) -> int:
    """Factor I - c G_u̇ - c² G_u; 1 where it is singular, else 0."""
    f = context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    a = mem.factors(context, mem.REAL)
    for i in range(f):
        for j in range(f):
            a[i * f + j] = (1.0 if i == j else 0.0) - c * (by_rate[i, j] + c * by_u[i, j])
    return int(factor(a, f, mem.pivots(context, mem.REAL), 0.0))


@inner
def factor_complex(context: Context, c: float, d: float) -> int:
    """Factor I - (c + i d) G_u̇ - (c + i d)² G_u as a real matrix of order 2 f, real parts first."""
    f = context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    a = mem.factors(context, mem.COMPLEX)
    for i in range(f):
        for j in range(f):
            at = 2 * f * i + j
            real = (1.0 if i == j else 0.0) - c * by_rate[i, j] - (c * c - d * d) * by_u[i, j]
            imaginary = -d * by_rate[i, j] - 2.0 * c * d * by_u[i, j]
            a[at], a[at + f] = real, -imaginary
            a[at + 2 * f * f], a[at + 2 * f * f + f] = imaginary, real
    return int(factor(a, 2 * f, mem.pivots(context, mem.COMPLEX), 0.0))


@inner
def solve_factored(context: Context, index: int, x: Vector) -> None:
    """Overwrite the right side `x` by the solution with the matrix `REAL` or `COMPLEX`.

    That is (f,), or (2 f,) with real parts first.
    """
    order = (index - mem.REAL + 1) * context.method_integers[mem.FREEDOMS]
    solve(mem.factors(context, index), order, mem.pivots(context, index), x)


@inner
def filtered_error(context: Context, t: float, state: int, c: float, raw: Vector) -> float:
    """Size over the tolerance of (I - c J)⁻¹ (x, y), and of the dependent coordinates in `raw`.

    The larger of the two. x and y, changes of the unknowns and of their rates, are in the second
    and in the first half of row SLOPE and are used up. Row IN receives the result, completed by the
    change of the dependent coordinates at the state in row `state`. The matrix takes out what stiff
    forces do not permit, and turns an error of a position that they hold into that of its velocity.

    `raw` is the error of all coordinates as it was estimated. At the ends of steps the dependent
    ones follow from the constraints and have no error of their own. But they are foreseen, and
    interpolated between. Where drivers move them the independent ones say nothing of how, and
    Newton's method for them might come to another way to assemble the machine. Velocities are left
    out: where a stiff force holds a position they are not smooth.
    """
    n, notes = context[COORDINATES], context.method_integers
    f, unknown, rows = notes[mem.FREEDOMS], mem.unknowns(context), mem.rows(context)
    by_u, partition = mem.derivative(context, mem.BY_U), row_of(context, PARTITION)
    change, allowed = rows[mem.IN], rows[mem.TOLERANCE]
    y, x = mem.half(context, mem.SLOPE, 0), mem.half(context, mem.SLOPE, 1)
    for i in range(f):
        for k in range(f):
            y[i] += c * by_u[i, k] * x[k]
    solve_factored(context, mem.REAL, y)
    change.fill(0.0)
    for i in range(f):
        j = unknown[i]
        change[n + j] = y[i]
        change[j] = x[i] + c * y[i]
    complete_direction(context, t, state)
    total, dependent = 0.0, 0.0
    for j in range(2 * n):
        total += (change[j] / allowed[j]) ** 2
    for j in range(n):
        if notes[mem.PARTITIONED] != 0 and partition[j] != 0.0:
            dependent += (raw[j] / allowed[j]) ** 2
    return float(max(np.sqrt(total / (2 * n)), np.sqrt(dependent / (2 * n))))
