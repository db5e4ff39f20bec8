"""Backward differentiation formulas of variable order 1 to 5 and variable step.

The formulas are the numerical differentiation formulas, BDF with the last difference added, in the
quasi-constant step implementation of L. F. Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM
Journal on Scientific Computing 18, 1997: the past is kept as backward differences of all
coordinates and velocities at equal distances, and interpolated anew where the step changes. The
differences of dependent coordinates are as smooth as those of independent ones, so that a change of
the partition costs neither order nor a restart.

The step ends at t₁ with u̇ - ψ̇ - c ü = 0 and u - ψ - c u̇ = 0, c = h / α_k; see `implicit` for how
this is solved.
"""

from fractions import Fraction

import numpy as np

from runtime.compiled import compiled, inner
from runtime.constraints.correction import FAILED
from runtime.integrate.implicit import (
    C_FACTORED,
    CHANGE,
    COUNTS,
    CURRENT,
    ENOUGH,
    EQUAL,
    FREEDOMS,
    H_BASE,
    HIGHER,
    ITERATIONS,
    LOWER,
    NEXT_ORDER,
    RATE,
    REJECTED,
    SLOPE,
    SLOW,
    STEP_ERROR,
    STEP_ORDER,
    TOLERANCE,
    arrive,
    calm,
    counts,
    differentiate,
    factor_real,
    filtered,
    floats,
    line,
    matrix,
    memory,
    tolerate,
    unknowns,
)
from runtime.integrate.linear import solve
from runtime.integrate.nested import nesting
from runtime.integrate.signatures import (
    DENSE,
    ERROR,
    HOOK,
    PROPOSE,
    STAGES,
    Integers,
    Vector,
)
from runtime.integrate.views import view
from runtime.integrate.workspace import ROWS, STAGE, Y0, Y1, F, K, Run

__all__ = ["accepted", "dense", "error", "memory", "propose", "restart", "stages"]

ORDER = 2  # power of the step in the error of the first order, with which every start begins
ERROR_ORDER = 1
STAGE_CALLS = 0  # counted where they happen
LAST = 1
DENSE_ROWS = 6
DENSE_CALLS = 0
BETA = 0.0
SHRINK, GROW = 0.2, 10.0

HIGHEST = 5
KAPPA = np.array([0.0, -0.1850, -1.0 / 9.0, -0.0823, -0.0415, 0.0])
GAMMA = np.concatenate([[0.0], np.cumsum(1.0 / np.arange(1, HIGHEST + 1))])
ALPHA = (1.0 - KAPPA) * GAMMA
ERROR_CONSTANT = np.append(KAPPA * GAMMA + 1.0 / np.arange(1, HIGHEST + 2), 1.0)

# Rows of MEMORY: backward differences of the past, the same at this step's length, and a step's.
PAST, NOW, FORESEEN, PSI, CORRECTIONS, RESIDUAL = 0, 8, 16, 17, 18, 19

_SHARE = 0.3
_NEWTON = 1e-2  # how far Newton's method is taken, over the tolerance asked
_ITERATIONS = 4
_SAME = 1.1  # a step that could grow by less stays as it is, and with it the matrix
_FAILURES = 3  # rejections in a row after which higher differences say nothing


def _basis() -> list[list[Fraction]]:
    """Polynomials in x = (t - t₀)/h that go with ∇⁰ … ∇⁵ at t₁ = t₀ + h, by powers of x."""
    found, last = [], [Fraction(1)]
    for m in range(HIGHEST + 1):
        found.append(last)
        times = [Fraction(0), *last]  # last (x - 1 + m) / (m + 1)
        for i, value in enumerate(last):
            times[i] += (m - 1) * value
        last = [value / (m + 1) for value in times]
    return found


_NESTING = nesting(_basis())


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked.

    The error of a run is that of a step, h⁶ at order 5, times the number of steps.
    """
    return float(_SHARE * rtol**0.2)


@inner
def lengthen(memory: Vector, k: int, ratio: float) -> None:
    """Work out, at CHANGE, the matrix that takes differences 1 … k to another distance.

    It is R(ratio) R(1) of Shampine and Reichelt's section 2; column j belongs to the new ∇ʲ.
    """
    scaled = view(memory, CHANGE, 36)
    result = view(memory, CHANGE + 36, 36)
    for j in range(1, k + 1):
        one, other = 1.0, 1.0
        for i in range(1, k + 1):
            one *= (i - 1 - ratio * j) / i
            other *= (i - 1 - j) / i
            scaled[i * 6 + j] = one
            result[i * 6 + j] = other
    for i in range(1, k + 1):
        # Row by row in place: row i of R(ratio) is used up by row i of the product.
        for j in range(1, k + 1):
            scaled[j] = 0.0
            for m in range(1, k + 1):
                scaled[j] += scaled[i * 6 + m] * result[m * 6 + j]
        for j in range(1, k + 1):
            scaled[i * 6 + j] = scaled[j]


@inner
def look_back(memory: Vector, notes: Integers, h: float, w: Vector, run: Run) -> None:
    """Fill the rows at NOW with the differences of the past at distance `h`.

    Where the past is of no use, that is the derivative alone, and the order one.
    """
    length = w.size // ROWS
    n = length // 2
    r = run[0]
    ratio = h / memory[H_BASE]
    failures = r.rejected - notes[REJECTED]
    if notes[STEP_ORDER] > 1 and (ratio > 1.01 * GROW or failures >= _FAILURES):
        begin(memory, notes, h, w, run)
        ratio = 1.0
    k = notes[STEP_ORDER]
    if ratio != 1.0:
        lengthen(memory, k, ratio)
        notes[EQUAL] = 0
    change = view(memory, CHANGE, 36)
    for j in range(k + 3):
        past, now = line(memory, PAST + j, n), line(memory, NOW + j, n)
        if ratio == 1.0 or j == 0 or j > k:
            for i in range(length):
                now[i] = past[i]
        else:
            for i in range(length):
                now[i] = 0.0
            for m in range(1, k + 1):
                share = change[m * 6 + j]
                other = line(memory, PAST + m, n)
                for i in range(length):
                    now[i] += share * other[i]


@inner
def begin(memory: Vector, notes: Integers, h: float, w: Vector, run: Run) -> None:
    """Make the past a straight line through the state Y0 with derivative K."""
    length = w.size // ROWS
    n = length // 2
    y0 = view(w, Y0 * length, length)
    k0 = view(w, K * length, length)
    for j in range(8):
        past = line(memory, PAST + j, n)
        for i in range(length):
            past[i] = 0.0
    value, slope = line(memory, PAST, n), line(memory, PAST + 1, n)
    for i in range(length):
        value[i] = y0[i]
        slope[i] = h * k0[i]
    memory[H_BASE] = h
    notes[STEP_ORDER] = 1
    notes[NEXT_ORDER] = 1
    notes[EQUAL] = 0
    run[0].exponent = 0.5


@inner
def foresee(memory: Vector, notes: Integers, w: Vector) -> None:
    """Extrapolate the past to the end of the step: FORESEEN, also as Y1, and PSI."""
    length = w.size // ROWS
    n = length // 2
    k = notes[STEP_ORDER]
    y1 = view(w, Y1 * length, length)
    foreseen, psi = line(memory, FORESEEN, n), line(memory, PSI, n)
    for i in range(length):
        foreseen[i] = 0.0
        psi[i] = 0.0
    for j in range(k, -1, -1):
        now = line(memory, NOW + j, n)
        share = GAMMA[j] / ALPHA[k]
        for i in range(length):
            foreseen[i] += now[i]
            psi[i] += share * now[i]
    for i in range(length):
        y1[i] = foreseen[i]


@inner
def newton(
    machine: Integers,
    t: float,
    c: float,
    memory: Vector,
    notes: Integers,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Solve for the state Y1 at time `t`, the end of the step; its dependent half is not final.

    Returns calls of `correction`, or `FAILED` where the iteration does not converge.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    f = notes[FREEDOMS]
    y1 = view(w, Y1 * length, length)
    a = view(w, (K + LAST) * length + n, n)
    foreseen, psi = line(memory, FORESEEN, n), line(memory, PSI, n)
    corrections, delta = line(memory, CORRECTIONS, n), line(memory, RESIDUAL, n)
    allowed = line(memory, TOLERANCE, n)
    enough = memory[ENOUGH]
    for i in range(f):
        j = notes[COUNTS + i]
        corrections[i] = 0.0
        y1[j] = foreseen[j] + c * foreseen[n + j] - psi[j]
    taken = 0
    before = 0.0
    for iteration in range(_ITERATIONS):
        result = arrive(machine, t, Y1, K + LAST, w, p, modes, lam)
        if result == FAILED:
            return FAILED
        taken += result
        r.rhs += 1
        r.iterations += 1
        for i in range(f):
            j = notes[COUNTS + i]
            delta[i] = c * a[j] - psi[n + j] - corrections[i]
        solve(matrix(memory, 2, n), f, view(notes, COUNTS + n, n), delta)
        total = 0.0
        for i in range(f):
            j = notes[COUNTS + i]
            corrections[i] += delta[i]
            y1[n + j] = foreseen[n + j] + corrections[i]
            y1[j] = foreseen[j] + c * y1[n + j] - psi[j]
            total += (delta[i] / allowed[n + j]) ** 2 + (c * delta[i] / allowed[j]) ** 2
        size = np.sqrt(total / max(1, 2 * f))
        notes[ITERATIONS] = iteration + 1
        if size == 0.0:
            return taken
        if iteration > 0:
            ratio = size / before
            if not ratio < 1.0:
                return FAILED
            memory[RATE] = ratio / (1.0 - ratio)
            if ratio > SLOW:
                notes[CURRENT] = 0
            left = _ITERATIONS - 1 - iteration
            if ratio**left * memory[RATE] * size > enough:
                return FAILED
        if memory[RATE] * size <= enough:
            return taken
        if not np.isfinite(size):
            return FAILED
        before = size
    return FAILED


@inner
def estimate(
    machine: Integers,
    t: float,
    c: float,
    other: int,
    memory: Vector,
    notes: Integers,
    w: Vector,
    p: Vector,
) -> float:
    """Size of the filtered difference of order k + 1 + `other` at the new state.

    At an order k it is Y1 - FORESEEN = ∇ᵏ⁺¹, one lower it is that plus ∇ᵏ of the past, one higher
    that less ∇ᵏ⁺¹ of the past.

    Where stiff forces hold a position, the formula's velocity is a difference quotient of it and
    off by one power of h more than the differences of velocities say; the filter knows.
    """
    n = w.size // (2 * ROWS)
    length = 2 * n
    k = notes[STEP_ORDER]
    y1 = view(w, Y1 * length, length)
    foreseen = line(memory, FORESEEN, n)
    past = line(memory, NOW + (k if other < 0 else k + 1), n)
    sign = 0.0 if other == 0 else (1.0 if other < 0 else -1.0)
    rates = line(memory, SLOPE, n)
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        rates[n + i] = y1[j] - foreseen[j] + sign * past[j]
        rates[i] = y1[n + j] - foreseen[n + j] + sign * past[n + j]
    constant = ERROR_CONSTANT[k + other]
    return float(constant * filtered(machine, t, Y1, c, memory, notes, w, p))


@compiled(STAGES)
def stages(
    machine: Integers,
    t: float,
    h: float,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    memory, notes = floats(machine, n), counts(machine, n)
    unknowns(machine, w, notes)
    look_back(memory, notes, h, w, run)
    c = h / ALPHA[notes[STEP_ORDER]]
    for _ in range(2):
        foresee(memory, notes, w)
        y1 = view(w, Y1 * length, length)
        memory[ENOUGH] = tolerate(memory, notes, w, share(r.rtol) * r.rtol, r.rtol, _NEWTON, y1)
        fresh = notes[CURRENT] != 1
        if fresh:
            z = view(w, STAGE * length, length)
            for i in range(length):
                z[i] = y1[i]
            if arrive(machine, t + h, STAGE, K + LAST, w, p, modes, lam) == FAILED:
                return FAILED
            differentiate(machine, t + h, STAGE, w, run, p, modes, lam)
        if memory[C_FACTORED] != c:
            memory[RATE] = 1.0
            memory[C_FACTORED] = c
            r.factorizations += 1
            if factor_real(memory, notes, n, c) != 0:
                notes[CURRENT] = 0
                return FAILED
        taken = newton(machine, t + h, c, memory, notes, w, run, p, modes, lam)
        if taken != FAILED:
            k = notes[STEP_ORDER]
            t1 = t + h
            memory[STEP_ERROR] = estimate(machine, t1, c, 0, memory, notes, w, p)
            if notes[EQUAL] >= k:
                if k > 1:
                    memory[LOWER] = estimate(machine, t1, c, -1, memory, notes, w, p)
                if k < HIGHEST:
                    memory[HIGHER] = estimate(machine, t1, c, 1, memory, notes, w, p)
            return taken
        notes[CURRENT] = 0
        if fresh:
            return FAILED
    return FAILED


@compiled(ERROR)
def error(machine: Integers, h: float, rtol: float, w: Vector) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    return float(floats(machine, w.size // (2 * ROWS))[STEP_ERROR])


@compiled(PROPOSE)
def propose(machine: Integers, h: float, w: Vector, run: Run) -> float:
    """Choose the next order; ratio of the next step's length to this accepted one's.

    Both stay until k + 1 steps of one length were taken at order k, as the differences of higher
    order mean nothing before.
    """
    r = run[0]
    n = w.size // (2 * ROWS)
    memory, notes = floats(machine, n), counts(machine, n)
    k = notes[STEP_ORDER]
    notes[NEXT_ORDER] = k
    if notes[EQUAL] + 1 < k + 1:
        return 1.0
    safety = r.safety * (2 * _ITERATIONS + 1) / (2 * _ITERATIONS + notes[ITERATIONS])
    best = max(r.error, 1e-10) ** (-1.0 / (k + 1))
    if k > 1:
        ratio = max(memory[LOWER], 1e-10) ** (-1.0 / k)
        if ratio > best:
            best = ratio
            notes[NEXT_ORDER] = k - 1
    if k < HIGHEST:
        ratio = max(memory[HIGHER], 1e-10) ** (-1.0 / (k + 2))
        if ratio > best:
            best = ratio
            notes[NEXT_ORDER] = k + 1
    best *= safety
    if notes[NEXT_ORDER] == k and 1.0 / _SAME < best < _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, best)))


@compiled(HOOK)
def accepted(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Take the step into the differences, and change to the order proposed."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    memory, notes = floats(machine, n), counts(machine, n)
    k = notes[STEP_ORDER]
    y1 = view(w, Y1 * length, length)
    foreseen = line(memory, FORESEEN, n)
    newest, higher = line(memory, PAST + k + 1, n), line(memory, PAST + k + 2, n)
    last = line(memory, NOW + k + 1, n)
    for i in range(length):
        newest[i] = y1[i] - foreseen[i]
        higher[i] = newest[i] - last[i]
    for j in range(k, -1, -1):
        past, now, above = (
            line(memory, PAST + j, n),
            line(memory, NOW + j, n),
            line(memory, PAST + j + 1, n),
        )
        for i in range(length):
            past[i] = now[i] + above[i] if j > 0 else y1[i]
    memory[H_BASE] = h
    notes[EQUAL] += 1
    notes[REJECTED] = r.rejected
    if r.fixed != 0 and k < HIGHEST and notes[EQUAL] > k:
        notes[NEXT_ORDER] = k + 1
    if notes[NEXT_ORDER] != k:
        notes[STEP_ORDER] = notes[NEXT_ORDER]
        notes[EQUAL] = 0
    r.exponent = 1.0 / (notes[STEP_ORDER] + 1)
    return int(calm(memory, notes, h, run))


@compiled(HOOK)
def restart(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Forget the past: the motion goes on under other equations."""
    n = w.size // (2 * ROWS)
    memory, notes = floats(machine, n), counts(machine, n)
    begin(memory, notes, h if h > 0.0 else 1.0, w, run)
    notes[CURRENT] = 0
    notes[REJECTED] = run[0].rejected
    return 0


@compiled(DENSE)
def dense(
    machine: Integers,
    t: float,
    h: float,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Fill the coefficient rows with the polynomial of degree k through the last k + 1 states."""
    length = w.size // ROWS
    n = length // 2
    memory, notes = floats(machine, n), counts(machine, n)
    y1 = view(w, Y1 * length, length)
    foreseen = line(memory, FORESEEN, n)
    for row in range(DENSE_ROWS):
        f = view(w, (F + row) * length, length)
        for i in range(length):
            f[i] = 0.0
    for i in range(length):
        summed = y1[i] - foreseen[i]
        for j in range(notes[STEP_ORDER], -1, -1):
            summed += line(memory, NOW + j, n)[i]
            value = summed if j > 0 else y1[i]
            for row in range(DENSE_ROWS):
                w[(F + row) * length + i] += _NESTING[row, j] * value
    return 0
