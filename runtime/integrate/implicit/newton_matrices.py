"""Newton's method inside implicit steps: its matrices, its tolerance, errors seen through it."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import COORDINATES, method_floats_of, method_integers_of
from runtime.core.jit import inner
from runtime.core.rounding import EPS
from runtime.core.workspace import ATOL, PARTITION, SIZE, Y0, row_of
from runtime.integrate.implicit.method_memory import (
    COUNTS,
    CURRENT,
    ENOUGH,
    FREEDOMS,
    IN,
    ITERATIONS,
    OUT,
    PARTITIONED,
    RATE,
    SETTLED,
    SLOPE,
    TOLERANCE,
    line,
    matrix,
)
from runtime.integrate.implicit.state_space_form import carry
from runtime.linalg.lu import factor, solve

DONE, GOING, DIVERGING = 0, 1, 2
# measured: rate of convergence above which derivatives are taken anew for the next step
SLOW = 0.05
_LOOSEST = 0.03  # measured: of the tolerance of a step; how far Newton's method is taken at least
# accuracy: rounding in a difference of high order, relative to a step's change
_ROUNDED = 64.0 * EPS
# accuracy: in such a difference of velocities, where stiff forces hold a position
_STIFF = 16.0 * EPS
_SOLVED = 4.0 * EPS  # accuracy: rounding in Newton's residual
# accuracy: in the past of dependent coordinates, relative to the largest coordinate
_LEAST = 8.0 * EPS
_RECOVERED = 4.0 * EPS  # accuracy: and this times the square of the ratio of speeds
# safety: largest ratio of speeds of dependent to independent coordinates that counts
_FASTEST = 10.0


@inner
def factor_real(context: Integers, n: int, c: float) -> int:
    """Factor I - c G_u̇ - c² G_u; 1 where it is singular, else 0."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    f = notes[FREEDOMS]
    by_u, by_rate, a = matrix(memory, 0, n), matrix(memory, 1, n), matrix(memory, 2, n)
    for i in range(f):
        for j in range(f):
            at = i * f + j
            a[at] = (1.0 if i == j else 0.0) - c * (by_rate[at] + c * by_u[at])
    return int(factor(a, f, view(notes, COUNTS + n, n)))


@inner
def factor_complex(context: Integers, n: int, c: float, d: float) -> int:
    """Factor I - (c + i d) G_u̇ - (c + i d)² G_u as a real matrix of order 2 f, real parts first."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    f = notes[FREEDOMS]
    by_u, by_rate, a = matrix(memory, 0, n), matrix(memory, 1, n), matrix(memory, 3, n)
    for i in range(f):
        for j in range(f):
            at = i * f + j
            real = (1.0 if i == j else 0.0) - c * by_rate[at] - (c * c - d * d) * by_u[at]
            imaginary = -d * by_rate[at] - 2.0 * c * d * by_u[at]
            a[i * 2 * f + j] = real
            a[i * 2 * f + f + j] = -imaginary
            a[(f + i) * 2 * f + j] = imaginary
            a[(f + i) * 2 * f + f + j] = real
    return int(factor(a, 2 * f, view(notes, COUNTS + 2 * n, 2 * n)))


@inner
def tolerate(
    context: Integers,
    relative: float,
    asked: float,
    newton: float,
    remembered: int,
    c: float,
    ahead: Vector,
) -> float:
    """Fill row TOLERANCE: what the error of the step may be, from its ends Y0 and `ahead`.

    Not less than rounding. States are carried on with what rounding cuts off them (row LOW), so
    that it is that of their change over the step. Only in coordinates that were dependent until
    lately the past is as rough as their recovery left it. Returns how far Newton's method is to be
    taken, over this tolerance.

    Parameters
    ----------
    relative
        Relative tolerance to be held to.
    asked
        Relative tolerance asked for, of which the absolute ones in row ATOL are the companions.
    newton
        How far Newton's method is taken, over the tolerance asked.
    remembered
        Steps for which the method remembers the past.
    c
        Of the matrix I - c G_u̇ - c² G_u. Where it is stiff, the last digit of a position is a force
        that the next velocity has to undo.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    y0 = row_of(context, Y0)
    atol = row_of(context, ATOL)
    size = row_of(context, SIZE)
    allowed = line(memory, TOLERANCE, n)
    held, carried, moved = 0.0, 0.0, 0.0
    for j in range(n, length):
        carried = max(carried, abs(y0[j]) / size[j])
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        held = max(held, abs(y0[n + j]) / size[n + j])
        moved = max(moved, abs(ahead[j] - y0[j]) / size[j])
        moved = max(moved, abs(ahead[n + j] - y0[n + j]) / size[n + j])
    ratio = min(_FASTEST, carried / max(held, 1e-300))
    rough = _LEAST + _RECOVERED * ratio * ratio if notes[SETTLED] < remembered else 0.0
    for half in range(2):
        largest = 0.0
        for j in range(half * n, half * n + n):
            largest = max(largest, abs(y0[j]) / size[j])
        for j in range(half * n, half * n + n):
            value = relative * (atol[j] / asked + max(abs(y0[j]), abs(ahead[j])))
            allowed[j] = value + (_ROUNDED * moved + rough * largest) * size[j]
    f = notes[FREEDOMS]
    by_u = matrix(memory, 0, n)
    for i in range(f):
        force, stiff = 0.0, 0.0
        j = notes[COUNTS + i]
        for k in range(f):
            other = notes[COUNTS + k]
            entry = abs(by_u[i * f + k])
            force += entry * abs(y0[other])
            stiff += c * c * entry * size[other] / size[j]
        allowed[n + j] += _STIFF * c * force * stiff / (1.0 + stiff) ** 2
    at_rounding = _SOLVED * moved / (relative + _ROUNDED * moved)
    return float(max(at_rounding, min(_LOOSEST, newton * asked / relative)))


@inner
def converged(
    context: Integers, iteration: int, left: int, size: float, before: float, slowest: float
) -> int:
    """Whether Newton's iteration is `DONE`, `GOING` or `DIVERGING` after a change of this size.

    Parameters
    ----------
    iteration, left
        Iterations before this one, and those that may follow it.
    size, before
        Of this change and the one before, over the tolerance.
    slowest
        Ratio of the two from which on it is given up.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    enough = memory[ENOUGH]
    notes[ITERATIONS] = iteration + 1
    if size == 0.0:
        return DONE
    if iteration > 0:
        ratio = size / before
        if not ratio < slowest:
            return DIVERGING
        memory[RATE] = ratio / (1.0 - ratio)
        if ratio > SLOW:
            notes[CURRENT] = 0
        if ratio**left * memory[RATE] * size > enough:
            return DIVERGING
    if memory[RATE] * size <= enough:
        return DONE
    return GOING if np.isfinite(size) else DIVERGING


@inner
def measured(change: Vector, allowed: Vector) -> float:
    """Root mean square of a change over the tolerance."""
    total = 0.0
    for i in range(change.size):
        ratio = change[i] / allowed[i]
        total += ratio * ratio
    return float(np.sqrt(total / change.size))


@inner
def filtered(context: Integers, t: float, state: int, c: float) -> float:
    """Size of (I - c J)⁻¹ (x, y) over the tolerance, over all coordinates and velocities.

    x and y, changes of the unknowns and of their rates, are in the second and in the first half of
    row SLOPE and are used up. Row IN receives the result, completed by the change of the
    dependent coordinates at the state in row `state`. The matrix takes out what stiff forces do
    not permit, and turns an error of a position that they hold into that of its velocity.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    f = notes[FREEDOMS]
    by_u = matrix(memory, 0, n)
    change, y, out = line(memory, IN, n), line(memory, SLOPE, n), line(memory, OUT, n)
    x = view(y, n, n)
    for i in range(f):
        for k in range(f):
            y[i] += c * by_u[i * f + k] * x[k]
    solve(matrix(memory, 2, n), f, view(notes, COUNTS + n, n), y)
    for j in range(2 * n):
        change[j] = 0.0
    for i in range(f):
        j = notes[COUNTS + i]
        change[n + j] = y[i]
        change[j] = x[i] + c * y[i]
    dq, dv = view(change, 0, n), view(change, n, n)
    carry(context, t, state, dq, dv, view(out, 0, n), view(out, n, n))
    return float(measured(change, line(memory, TOLERANCE, n)))


@inner
def uneven(context: Integers, raw: Vector, allowed: Vector) -> float:
    """Size of an error `raw` of all coordinates, over the tolerance, of the dependent ones alone.

    At the ends of steps these follow from the constraints and have no error of their own. But they
    are foreseen, and interpolated between. Where drivers move them the independent ones say nothing
    of how, and Newton's method for them might come to another way to assemble the machine.
    Velocities are left out: where a stiff force holds a position they are not smooth.
    """
    notes = method_integers_of(context)
    partition = row_of(context, PARTITION)
    if notes[PARTITIONED] == 0:
        return 0.0
    n = context[COORDINATES]
    length = 2 * n
    total = 0.0
    for j in range(n):
        if partition[j] != 0.0:
            total += (raw[j] / allowed[j]) ** 2
    return float(np.sqrt(total / length))
