"""What the implicit methods share: their unknowns, the matrix of Newton's method, its tolerance.

The unknowns of a step are the f independent coordinates u of the partition in force and their
velocities. At every iterate the dependent coordinates and velocities follow from the constraints,
starting where the last iterate left them, and the accelerations from the equations of motion. What
is integrated is thus ü = G(t, u, u̇), and as the formulas for u̇ are linear, u is eliminated:
Newton's matrices are I - c G_u̇ - c² G_u of order f, with c real or complex (E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, section IV.8). Where nothing is recovered
from constraints, all coordinates are unknowns.
"""

import numpy as np

from runtime.compiled import compiled, inner
from runtime.constraints.correction import FAILED, WEAK
from runtime.integrate.field import field
from runtime.integrate.linear import factor, solve
from runtime.integrate.signatures import DIFFERENTIATE, Integers, Vector
from runtime.integrate.slots import (
    BENDS,
    CONSTRAINT_COUNT,
    CORRECTING,
    MEMORY,
    NOTES,
    accelerations_tangent_of,
    correct_of,
    correction_tangent_of,
)
from runtime.integrate.views import floats_at, integers_at, view
from runtime.integrate.workspace import ATOL, PARTITION, ROWS, SIZE, Y0, Run

# MEMORY: numbers, then rows of length 2 n, then matrices.
C_FACTORED = 0  # the c for which a matrix is factored
RATE = 1  # of Newton's convergence: what is still missing over the last change
STEP_ERROR = 2  # of the last trial step, over the tolerance
H_BASE = 3  # distance of a multistep method's history; length of a one-step method's last step
ERROR_BASE = 4  # error of that step
STIFFNESS = 8  # spectral radius of the derivatives, 1/s
LOWER, HIGHER = 6, 7  # the error that a multistep method would have made at other orders
ENOUGH = 5  # how far Newton's method is taken, over the tolerance of the step
CHANGE = 9  # first of 72 numbers in which a change of the step's length is worked out
NUMBERS = 82
# Rows: the first 20 are a method's; then directions for the derivatives, then the tolerance.
IN, OUT, SLOPE, TOLERANCE = 20, 21, 22, 23
LINES = 24

# NOTES: counts, then the unknowns (n), pivots (n), pivots of the complex matrix (2 n).
FREEDOMS = 0  # f
CURRENT = 1  # 1: the derivatives are of these unknowns, and Newton's method converges fast
STEP_ORDER = 2
EQUAL = 3  # steps of this length and order
NEXT_ORDER = 4
REJECTED = 5  # rejected steps up to the last accepted one
ITERATIONS = 6  # of the last step
CALM = 7  # steps in a row that an explicit method could have taken
STIFF = 8  # looks in a row that found an explicit method's steps limited by stability
COUNTS = 9

_LOOSEST = 0.03  # of the tolerance of a step: how far Newton's method is taken at least
_POWERS = 8  # iterations of the power method before the mean is taken, and in it
_QUIET, _LONG = 0.5, 30  # h ρ with which an explicit method is at ease, and steps until it returns
SLOW = 0.05  # convergence at which derivatives are taken anew for the next step
_EPS = 2.2e-16
_LEAST = 8.0 * _EPS  # rounding in a step, relative to the largest coordinate or velocity
_RECOVERED = 4.0 * _EPS  # in dependent ones, times the square of the ratio of speeds
_FASTEST = 10.0  # ratio of speeds of dependent to independent coordinates that partitions allow
_DIFFERENCE = 1e-7  # relative change by which a field along surfaces is differenced


def memory(n: int) -> tuple[int, int]:
    """Numbers that an implicit method keeps: floats and integers."""
    return NUMBERS + 2 * n * LINES + 7 * n * n, COUNTS + 4 * n


@inner
def floats(machine: Integers, n: int) -> Vector:
    """All of MEMORY."""
    found: Vector = floats_at(machine, MEMORY, NUMBERS + 2 * n * LINES + 7 * n * n)
    return found


@inner
def line(memory: Vector, index: int, n: int) -> Vector:
    """Row `index` of MEMORY."""
    found: Vector = view(memory, NUMBERS + index * 2 * n, 2 * n)
    return found


@inner
def matrix(memory: Vector, index: int, n: int) -> Vector:
    """G_u (0), G_u̇ (1), factors of the real (2) and of the complex matrix (3), flat."""
    length = (4 if index == 3 else 1) * n * n
    found: Vector = view(memory, NUMBERS + 2 * n * LINES + index * n * n, length)
    return found


@inner
def counts(machine: Integers, n: int) -> Integers:
    """All of NOTES."""
    found: Integers = integers_at(machine, NOTES, COUNTS + 4 * n)
    return found


@inner
def partitioned(machine: Integers) -> bool:
    """Whether dependent coordinates are recovered from the constraints."""
    return bool(machine[CONSTRAINT_COUNT] > 0 and machine[CORRECTING] != 0)


@inner
def unknowns(machine: Integers, w: Vector, notes: Integers) -> int:
    """List the unknowns in `notes`; returns f. Derivatives for others are no longer current."""
    n = w.size // (2 * ROWS)
    f = 0
    for j in range(n):
        if not partitioned(machine) or w[PARTITION * 2 * n + j] == 0.0:
            if notes[COUNTS + f] != j:
                notes[COUNTS + f] = j
                notes[CURRENT] = 0
            f += 1
    if notes[FREEDOMS] != f:
        notes[FREEDOMS] = f
        notes[CURRENT] = 0
    return f


@inner
def arrive(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Complete the state in row `state` by its dependent half, and write its accelerations.

    Returns the iterations that took, or `FAILED`.
    """
    n = w.size // (2 * ROWS)
    taken = 0
    if partitioned(machine):
        taken = correct_of(machine)(machine, t, state, PARTITION, w, p)
        if taken == FAILED:
            return FAILED
        taken %= WEAK
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    field(machine, t, q, v, p, modes, view(w, derivative * 2 * n + n, n), lam)
    return taken


@inner
def carry(
    machine: Integers,
    t: float,
    state: int,
    dq: Vector,
    dv: Vector,
    out_q: Vector,
    out_v: Vector,
    w: Vector,
    p: Vector,
) -> None:
    """Complete a change of independent coordinates and velocities by the dependent ones' change.

    `dq` and `dv` are zero on the dependent coordinates on entry.
    """
    n = dq.size
    if not partitioned(machine):
        return
    tangent = correction_tangent_of(machine)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    weights = view(w, PARTITION * 2 * n, n)
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dq[j] += out_q[j]
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dv[j] += out_v[j]


@inner
def along(
    machine: Integers,
    t: float,
    state: int,
    dq: Vector,
    dv: Vector,
    da: Vector,
    free: Vector,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Derivative of the accelerations at the state in row `state` along (dq, dv).

    Exact for the machine's own equations; along a surface of switching conditions, and with terms
    that stabilize, a difference. `free` is overwritten.
    """
    n = dq.size
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    if machine[BENDS] == 0:
        accelerations_tangent_of(machine)(t, q, v, p, modes, dq, dv, da)
        return
    size = view(w, SIZE * 2 * n, 2 * n)
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(dq[j]) / size[j], abs(dv[j]) / size[n + j])
    if largest == 0.0:
        for j in range(n):
            da[j] = 0.0
        return
    step = _DIFFERENCE / largest
    before = view(free, 0, n)
    moved = view(free, n, n)
    field(machine, t, q, v, p, modes, before, lam)
    for j in range(n):
        moved[j] = q[j]
        q[j] += step * dq[j]
        da[j] = v[j]
        v[j] += step * dv[j]
    # The state is put back before the accelerations overwrite what keeps its velocities.
    keep_q, keep_v = moved, da
    after = view(free, 2 * n, n)
    field(machine, t, q, v, p, modes, after, lam)
    for j in range(n):
        q[j] = keep_q[j]
        v[j] = keep_v[j]
    for j in range(n):
        da[j] = (after[j] - before[j]) / step


@inner
def spectral_radius(memory: Vector, notes: Integers, n: int) -> float:
    """Largest |λ| of u̇ = y, ẏ = G_u u + G_u̇ y: the mean growth in iterations of the power method.

    An even number of them is averaged, as u and y have other units: their sizes change in turn.
    """
    f = notes[FREEDOMS]
    by_u, by_rate = matrix(memory, 0, n), matrix(memory, 1, n)
    x, y, z = line(memory, IN, n), line(memory, OUT, n), line(memory, SLOPE, n)
    for i in range(f):
        x[i] = 1.0 + 0.1 * i
        y[i] = 1.0 - 0.3 * i
    grown = 0.0
    for iteration in range(2 * _POWERS):
        largest = 0.0
        for i in range(f):
            z[i] = 0.0
            for k in range(f):
                z[i] += by_u[i * f + k] * x[k] + by_rate[i * f + k] * y[k]
        for i in range(f):
            x[i] = y[i]
            y[i] = z[i]
            largest = max(largest, abs(x[i]), abs(y[i]))
        if not (largest > 0.0 and np.isfinite(largest)):
            return 0.0
        for i in range(f):
            x[i] /= largest
            y[i] /= largest
        if iteration >= _POWERS:
            grown += np.log(largest)
    return float(np.exp(grown / _POWERS))


@inner
def calm(memory: Vector, notes: Integers, h: float, run: Run) -> int:
    """1 where an explicit method could long have taken the same steps, and may be chosen."""
    quiet = run[0].automatic != 0 and h * memory[STIFFNESS] < _QUIET
    notes[CALM] = notes[CALM] + 1 if quiet else 0
    if notes[CALM] < _LONG * run[0].patience:
        return 0
    notes[CALM] = 0
    return 1


@compiled(DIFFERENTIATE)
def differentiate(
    machine: Integers,
    t: float,
    state: int,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Write G_u and G_u̇ at the state in row `state`, which is on the constraints.

    With e_k the change of one unknown, δq = H e_k and the change of dependent velocities that it
    causes are tangents of the recovery of dependent coordinates.
    """
    n = w.size // (2 * ROWS)
    memory, notes = floats(machine, n), counts(machine, n)
    f = notes[FREEDOMS]
    by_u, by_rate = matrix(memory, 0, n), matrix(memory, 1, n)
    dq, dv = view(line(memory, IN, n), 0, n), view(line(memory, IN, n), n, n)
    out_q, out_v = view(line(memory, OUT, n), 0, n), view(line(memory, OUT, n), n, n)
    da = view(line(memory, SLOPE, n), 0, n)
    # The complex matrix, factored after this, lends room of 3 n.
    free = view(memory, NUMBERS + 2 * n * LINES + 3 * n * n, 4 * n * n)
    for k in range(f):
        for j in range(n):
            dq[j] = 0.0
            dv[j] = 0.0
        dq[notes[COUNTS + k]] = 1.0
        carry(machine, t, state, dq, dv, out_q, out_v, w, p)
        along(machine, t, state, dq, dv, da, free, w, p, modes, lam)
        for i in range(f):
            by_u[i * f + k] = da[notes[COUNTS + i]]
        for j in range(n):
            dv[j] = dq[j]
            dq[j] = 0.0
        along(machine, t, state, dq, dv, da, free, w, p, modes, lam)
        for i in range(f):
            by_rate[i * f + k] = da[notes[COUNTS + i]]
    notes[CURRENT] = 1
    memory[C_FACTORED] = 0.0
    run[0].jacobians += 1
    if run[0].automatic != 0:
        memory[STIFFNESS] = spectral_radius(memory, notes, n)
    return 0


@inner
def factor_real(memory: Vector, notes: Integers, n: int, c: float) -> int:
    """Factor I - c G_u̇ - c² G_u; 1 where it is singular, else 0."""
    f = notes[FREEDOMS]
    by_u, by_rate, a = matrix(memory, 0, n), matrix(memory, 1, n), matrix(memory, 2, n)
    for i in range(f):
        for j in range(f):
            at = i * f + j
            a[at] = (1.0 if i == j else 0.0) - c * (by_rate[at] + c * by_u[at])
    return int(factor(a, f, view(notes, COUNTS + n, n)))


@inner
def factor_complex(memory: Vector, notes: Integers, n: int, c: float, d: float) -> int:
    """Factor I - (c + i d) G_u̇ - (c + i d)² G_u as a real matrix of order 2 f, real parts first."""
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
    memory: Vector,
    notes: Integers,
    w: Vector,
    relative: float,
    asked: float,
    newton: float,
    ahead: Vector,
) -> float:
    """Fill row TOLERANCE: what the error of the step may be, from its ends Y0 and `ahead`.

    Not less than rounding. That of the independent coordinates is magnified by the recovery of the
    dependent ones, and again by that of their velocities; it is not carried on into the next
    steps. Returns how far Newton's method is to be taken, over this tolerance.

    Parameters
    ----------
    relative
        Relative tolerance to be held to.
    asked
        Relative tolerance asked for, of which the absolute ones in row ATOL are the companions.
    newton
        How far Newton's method is taken, over the tolerance asked.
    """
    length = w.size // ROWS
    n = length // 2
    y0 = view(w, Y0 * length, length)
    atol = view(w, ATOL * length, length)
    size = view(w, SIZE * length, length)
    allowed = line(memory, TOLERANCE, n)
    held, carried = 0.0, 0.0
    for j in range(n, length):
        carried = max(carried, abs(y0[j]) / size[j])
    for i in range(notes[FREEDOMS]):
        j = n + notes[COUNTS + i]
        held = max(held, abs(y0[j]) / size[j])
    ratio = min(_FASTEST, carried / max(held, 1e-300))
    for half in range(2):
        largest = 0.0
        for j in range(half * n, half * n + n):
            largest = max(largest, abs(y0[j]) / size[j])
        for j in range(half * n, half * n + n):
            value = relative * (atol[j] / asked + max(abs(y0[j]), abs(ahead[j])))
            allowed[j] = value + (_LEAST + _RECOVERED * ratio * ratio) * largest * size[j]
        for i in range(notes[FREEDOMS]):
            j = half * n + notes[COUNTS + i]
            allowed[j] -= _RECOVERED * ratio * ratio * largest * size[j]
    return float(max(2.0 * _EPS / (relative + _LEAST), min(_LOOSEST, newton * asked / relative)))


@inner
def measured(change: Vector, allowed: Vector) -> float:
    """Root mean square of a change over the tolerance."""
    total = 0.0
    for i in range(change.size):
        ratio = change[i] / allowed[i]
        total += ratio * ratio
    return float(np.sqrt(total / change.size))


@inner
def filtered(
    machine: Integers,
    t: float,
    state: int,
    c: float,
    memory: Vector,
    notes: Integers,
    w: Vector,
    p: Vector,
) -> float:
    """Size of (I - c J)⁻¹ (x, y) over the tolerance, over all coordinates and velocities.

    x and y, changes of the unknowns and of their rates, are in the second and in the first half of
    row SLOPE of MEMORY and are used up. Row IN receives the result, completed by the change of the
    dependent coordinates at the state in row `state`. The matrix takes out what stiff forces do
    not permit, and turns an error of a position that they hold into that of its velocity.
    """
    n = w.size // (2 * ROWS)
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
    carry(machine, t, state, dq, dv, view(out, 0, n), view(out, n, n), w, p)
    return float(measured(change, line(memory, TOLERANCE, n)))


@inner
def stiffness(memory: Vector, notes: Integers, w: Vector, h: float) -> float:
    """Largest row of h² |G_u| + h |G_u̇|, each entry relative to the sizes of its coordinates."""
    length = w.size // ROWS
    n = length // 2
    f = notes[FREEDOMS]
    by_u, by_rate = matrix(memory, 0, n), matrix(memory, 1, n)
    size = view(w, SIZE * length, length)
    largest = 0.0
    for i in range(f):
        total = 0.0
        for k in range(f):
            at, row, column = i * f + k, notes[COUNTS + i], notes[COUNTS + k]
            total += h * h * abs(by_u[at]) * size[column] / size[row]
            total += h * abs(by_rate[at]) * size[n + column] / size[n + row]
        largest = max(largest, total)
    return float(largest)
