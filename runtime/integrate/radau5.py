"""Radau IIA method of order 5 with exact derivatives, for the independent coordinates.

Formulas, transformation, error estimate and step control are those of E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, section IV.8. With the transformation of the three
stages Newton's method needs one real and one complex matrix, of order f each (see `implicit`): the
positions of the stages are linear in their velocities, hold exactly at every iterate, and leave
only the equation of the accelerations.

The estimate is of order h⁴ and the error of order h⁶, so that an estimate which is kept at the
tolerance gives errors that shrink faster than it. As in Hairer's program the tolerance is
therefore mapped: what the estimate is held to is `share` times what was asked.
"""

import numpy as np

from runtime.compiled import compiled, inner
from runtime.constraints.correction import FAILED
from runtime.integrate.dense import hermite_rows
from runtime.integrate.implicit import (
    C_FACTORED,
    COUNTS,
    CURRENT,
    ENOUGH,
    EQUAL,
    ERROR_BASE,
    FREEDOMS,
    H_BASE,
    IN,
    ITERATIONS,
    RATE,
    SLOPE,
    SLOW,
    STEP_ERROR,
    TOLERANCE,
    arrive,
    counts,
    differentiate,
    factor_complex,
    factor_real,
    filtered,
    floats,
    line,
    matrix,
    memory,
    stiffness,
    tolerate,
    unknowns,
)
from runtime.integrate.linear import solve
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

ORDER = 4  # power of the step in the error estimate
ERROR_ORDER = 3
STAGE_CALLS = 0  # counted where they happen
LAST = 1
DENSE_ROWS = 6
DENSE_CALLS = 0
BETA = 0.0
SHRINK, GROW = 0.2, 8.0

_S = 6.0**0.5
C1, C2 = (4.0 - _S) / 10.0, (4.0 + _S) / 10.0
NODES = (0.0, C1, C2, 1.0)  # where in a step the equations are evaluated
A11, A12, A13 = (88 - 7 * _S) / 360, (296 - 169 * _S) / 1800, (-2 + 3 * _S) / 225
A21, A22, A23 = (296 + 169 * _S) / 1800, (88 + 7 * _S) / 360, (-2 - 3 * _S) / 225
A31, A32, A33 = (16 - _S) / 36, (16 + _S) / 36, 1 / 9
E1, E2, E3 = (-13 - 7 * _S) / 3, (-13 + 7 * _S) / 3, -1 / 3
# Eigenvalues of the inverse of A, and what makes it block diagonal: T⁻¹ A⁻¹ T.
REAL = 3.0 + 3.0 ** (2 / 3) - 3.0 ** (1 / 3)
COMPLEX = 3.0 + 0.5 * (3.0 ** (1 / 3) - 3.0 ** (2 / 3))
IMAGINARY = 0.5 * (3.0 ** (5 / 6) + 3.0 ** (7 / 6))
T11, T12, T13 = 9.1232394870892942792e-2, -0.14125529502095420843, -3.0029194105147424492e-2
T21, T22, T23 = 0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779
T31 = 0.96604818261509293619
I11, I12, I13 = 4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119
I21, I22, I23 = -4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196
I31, I32, I33 = -0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497
# 1 / (COMPLEX ± i IMAGINARY): the matrices' c over h.
_NORM = COMPLEX**2 + IMAGINARY**2
C_REAL, C_COMPLEX, C_IMAGINARY = 1.0 / REAL, COMPLEX / _NORM, -IMAGINARY / _NORM

# Rows of MEMORY: the last step's polynomial; per stage the change of velocities; the right sides.
POLYNOMIAL, VELOCITIES, SIDES = 0, 3, 6
# Rows of the workspace after K: the stages' derivatives and states.
SLOPES, STATES = 2, 5

_NEWTON = 7  # iterations
_SAME = 1.2  # a step that could grow by less stays as it is, and with it the matrices
_SMOOTH = 10.0  # h² |G_u| + h |G_u̇| up to which the ends' accelerations add a sixth of their error
_ROUNDING = 2.2e-16


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked: errors of a run go with h⁵."""
    return float(0.1 * rtol**-0.2)


@inner
def foresee(memory: Vector, notes: Integers, h: float, w: Vector) -> None:
    """Fill the states of the stages: the last step's polynomial continued, or a straight line."""
    length = w.size // ROWS
    n = length // 2
    y0 = view(w, Y0 * length, length)
    k0 = view(w, K * length, length)
    ratio = h / memory[H_BASE] if notes[EQUAL] > 0 else 0.0
    for stage in range(3):
        c = C1 if stage == 0 else (C2 if stage == 1 else 1.0)
        z = view(w, (K + STATES + stage) * length, length)
        if notes[EQUAL] == 0 or ratio > GROW:
            for i in range(length):
                z[i] = y0[i] + c * h * k0[i]
        else:
            x = 1.0 + c * ratio
            f1 = line(memory, POLYNOMIAL, n)
            f2, f3 = line(memory, POLYNOMIAL + 1, n), line(memory, POLYNOMIAL + 2, n)
            for i in range(length):
                # It passes the state at x = 1, which is where this step starts.
                z[i] = y0[i] + (x - 1.0) * (f1[i] - x * (f2[i] + x * f3[i]))


@inner
def curve(w: Vector, f2: Vector, f3: Vector) -> None:
    """Coefficients F2 and F3 of the polynomial through the start and the three stages."""
    length = w.size // ROWS
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    s1 = view(w, (K + STATES) * length, length)
    s2 = view(w, (K + STATES + 1) * length, length)
    for i in range(length):
        change = y1[i] - y0[i]
        one = ((s1[i] - y0[i]) / C1 - change) / (1.0 - C1)
        two = ((s2[i] - y0[i]) / C2 - change) / (1.0 - C2)
        f3[i] = (two - one) / (C2 - C1)
        f2[i] = one - C1 * f3[i]


@inner
def place(h: float, stage: int, memory: Vector, notes: Integers, w: Vector) -> None:
    """Set the unknowns of a stage from the changes of velocity of all three."""
    length = w.size // ROWS
    n = length // 2
    y0 = view(w, Y0 * length, length)
    z = view(w, (K + STATES + stage) * length, length)
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        if stage == 0:
            z[n + j] = y0[n + j] + one[i]
            z[j] = y0[j] + h * (C1 * y0[n + j] + A11 * one[i] + A12 * two[i] + A13 * three[i])
        elif stage == 1:
            z[n + j] = y0[n + j] + two[i]
            z[j] = y0[j] + h * (C2 * y0[n + j] + A21 * one[i] + A22 * two[i] + A23 * three[i])
        else:
            z[n + j] = y0[n + j] + three[i]
            z[j] = y0[j] + h * (y0[n + j] + A31 * one[i] + A32 * two[i] + A33 * three[i])


@inner
def newton(
    machine: Integers,
    t: float,
    h: float,
    memory: Vector,
    notes: Integers,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Solve for the three stages; their dependent halves are not final.

    Returns calls of `correction`, or `FAILED` where the iteration does not converge.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    f = notes[FREEDOMS]
    y0 = view(w, Y0 * length, length)
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    real, pair = line(memory, SIDES, n), line(memory, SIDES + 1, n)
    a1 = view(w, (K + SLOPES) * length + n, n)
    a2 = view(w, (K + SLOPES + 1) * length + n, n)
    a3 = view(w, (K + SLOPES + 2) * length + n, n)
    allowed = line(memory, TOLERANCE, n)
    enough = memory[ENOUGH]
    for i in range(f):
        j = n + notes[COUNTS + i]
        one[i] = w[(K + STATES) * length + j] - y0[j]
        two[i] = w[(K + STATES + 1) * length + j] - y0[j]
        three[i] = w[(K + STATES + 2) * length + j] - y0[j]
    for stage in range(3):
        place(h, stage, memory, notes, w)
    taken = 0
    before = 0.0
    for iteration in range(_NEWTON):
        for stage in range(3):
            c = C1 if stage == 0 else (C2 if stage == 1 else 1.0)
            result = arrive(
                machine, t + c * h, K + STATES + stage, K + SLOPES + stage, w, p, modes, lam
            )
            if result == FAILED:
                return FAILED
            taken += result
            r.rhs += 1
        r.iterations += 1
        for i in range(f):
            j = notes[COUNTS + i]
            real[i] = h * C_REAL * (I11 * a1[j] + I12 * a2[j] + I13 * a3[j]) - (
                I11 * one[i] + I12 * two[i] + I13 * three[i]
            )
            re = h * (I21 * a1[j] + I22 * a2[j] + I23 * a3[j])
            im = h * (I31 * a1[j] + I32 * a2[j] + I33 * a3[j])
            pair[i] = (
                C_COMPLEX * re - C_IMAGINARY * im - (I21 * one[i] + I22 * two[i] + I23 * three[i])
            )
            pair[f + i] = (
                C_COMPLEX * im + C_IMAGINARY * re - (I31 * one[i] + I32 * two[i] + I33 * three[i])
            )
        solve(matrix(memory, 2, n), f, view(notes, COUNTS + n, n), real)
        solve(matrix(memory, 3, n), 2 * f, view(notes, COUNTS + 2 * n, 2 * n), pair)
        total = 0.0
        for i in range(f):
            j = notes[COUNTS + i]
            d1 = T11 * real[i] + T12 * pair[i] + T13 * pair[f + i]
            d2 = T21 * real[i] + T22 * pair[i] + T23 * pair[f + i]
            d3 = T31 * real[i] + pair[i]
            one[i] += d1
            two[i] += d2
            three[i] += d3
            scale = allowed[n + j]
            total += (d1 / scale) ** 2 + (d2 / scale) ** 2 + (d3 / scale) ** 2
            scale = allowed[j] / h
            total += ((A11 * d1 + A12 * d2 + A13 * d3) / scale) ** 2
            total += ((A21 * d1 + A22 * d2 + A23 * d3) / scale) ** 2
            total += ((A31 * d1 + A32 * d2 + A33 * d3) / scale) ** 2
        for stage in range(3):
            place(h, stage, memory, notes, w)
        size = np.sqrt(total / max(1, 6 * f))
        notes[ITERATIONS] = iteration + 1
        if size == 0.0:
            return taken
        if iteration > 0:
            ratio = size / before
            if not ratio < 0.99:
                return FAILED
            memory[RATE] = ratio / (1.0 - ratio)
            if ratio > SLOW:
                notes[CURRENT] = 0
            left = _NEWTON - 1 - iteration
            if ratio**left * memory[RATE] * size > enough:
                return FAILED
        if memory[RATE] * size <= enough:
            return taken
        if not np.isfinite(size):
            return FAILED
        before = size
    return FAILED


@inner
def embedded(
    machine: Integers,
    t: float,
    h: float,
    k0: Vector,
    memory: Vector,
    notes: Integers,
    w: Vector,
    p: Vector,
) -> float:
    """Size of the filtered error c (k0 + Σ e z / h), which is left in row IN of MEMORY."""
    length = w.size // ROWS
    n = length // 2
    y0 = view(w, Y0 * length, length)
    s1 = view(w, (K + STATES) * length, length)
    s2 = view(w, (K + STATES + 1) * length, length)
    s3 = view(w, (K + STATES + 2) * length, length)
    rates = line(memory, SLOPE, n)
    c = h * C_REAL
    for i in range(notes[FREEDOMS]):
        for half in range(2):
            j = half * n + notes[COUNTS + i]
            z = E1 * (s1[j] - y0[j]) + E2 * (s2[j] - y0[j]) + E3 * (s3[j] - y0[j])
            rates[(1 - half) * n + i] = c * k0[j] + C_REAL * z
    return float(filtered(machine, t, Y0, c, memory, notes, w, p))


@inner
def estimate(
    machine: Integers,
    t: float,
    h: float,
    memory: Vector,
    notes: Integers,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> float:
    """Error over the tolerance; where it is too large at a first step or again, filtered twice."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    found = embedded(machine, t, h, view(w, K * length, length), memory, notes, w, p)
    if found >= 1.0 and (r.rejected_before != 0 or notes[EQUAL] == 0):
        y0 = view(w, Y0 * length, length)
        z = view(w, STAGE * length, length)
        slope = view(w, (K + LAST) * length, length)
        change = line(memory, IN, n)
        for i in range(length):
            z[i] = y0[i] + change[i]
        if arrive(machine, t, STAGE, K + LAST, w, p, modes, lam) == FAILED:
            return found
        r.rhs += 1
        for i in range(n):
            slope[i] = z[n + i]
        found = embedded(machine, t, h, slope, memory, notes, w, p)
    return found


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
    for _ in range(2):
        foresee(memory, notes, h, w)
        last = view(w, (K + STATES + 2) * length, length)
        memory[ENOUGH] = tolerate(memory, w, share(r.rtol) * r.rtol, r.rtol, last)
        fresh = notes[CURRENT] != 1
        if fresh:
            differentiate(machine, t, Y0, w, run, p, modes, lam)
        if memory[C_FACTORED] != h:
            memory[RATE] = 1.0
            memory[C_FACTORED] = h
            r.factorizations += 1
            singular = factor_real(memory, notes, n, h * C_REAL)
            singular += factor_complex(memory, notes, n, h * C_COMPLEX, h * C_IMAGINARY)
            if singular != 0:
                notes[CURRENT] = 0
                return FAILED
        taken = newton(machine, t, h, memory, notes, w, run, p, modes, lam)
        if taken != FAILED:
            y1 = view(w, Y1 * length, length)
            for i in range(length):
                y1[i] = last[i]
            memory[STEP_ERROR] = estimate(machine, t, h, memory, notes, w, run, p, modes, lam)
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
    """Ratio of the next step's length to this accepted one's.

    The predictive controller of K. Gustafsson; a step that could grow by little keeps its length,
    and with it the factored matrices.
    """
    r = run[0]
    n = w.size // (2 * ROWS)
    memory, notes = floats(machine, n), counts(machine, n)
    now = max(r.error, 1e-10)
    ratio = now**-0.25
    if notes[EQUAL] > 0:
        predicted = h / memory[H_BASE] * (memory[ERROR_BASE] / now) ** 0.25 * ratio
        ratio = min(ratio, predicted)
    ratio *= r.safety * (2 * _NEWTON + 1) / (2 * _NEWTON + notes[ITERATIONS])
    if r.rejected_before != 0:
        ratio = min(ratio, 1.0)
    if 1.0 <= ratio <= _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, ratio)))


@compiled(HOOK)
def accepted(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Keep the step's polynomial, from which the next one's stages are foreseen."""
    length = w.size // ROWS
    n = length // 2
    memory, notes = floats(machine, n), counts(machine, n)
    change = line(memory, POLYNOMIAL, n)
    for i in range(length):
        change[i] = w[Y1 * length + i] - w[Y0 * length + i]
    curve(w, line(memory, POLYNOMIAL + 1, n), line(memory, POLYNOMIAL + 2, n))
    memory[H_BASE] = h
    memory[ERROR_BASE] = max(1e-2, run[0].error)
    notes[EQUAL] += 1
    return 0


@compiled(HOOK)
def restart(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Forget the past: the motion goes on under other equations."""
    notes = counts(machine, w.size // (2 * ROWS))
    notes[EQUAL] = 0
    notes[CURRENT] = 0
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
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1.

    The collocation polynomial is of degree three. Where the equations are not stiff over the step,
    the accelerations at its ends are as good as the states, and a polynomial through positions,
    velocities and accelerations is of the method's own order; where they are stiff, errors of the
    state would be magnified in them.
    """
    length = w.size // ROWS
    n = length // 2
    memory, notes = floats(machine, n), counts(machine, n)
    for row in range(DENSE_ROWS):
        f = view(w, (F + row) * length, length)
        for i in range(length):
            f[i] = 0.0
    if stiffness(memory, notes, w, h) > _SMOOTH:
        y0 = view(w, Y0 * length, length)
        y1 = view(w, Y1 * length, length)
        for i in range(length):
            w[F * length + i] = y0[i]
            w[(F + 1) * length + i] = y1[i] - y0[i]
        curve(w, view(w, (F + 2) * length, length), view(w, (F + 3) * length, length))
        return 0
    hermite_rows(h, w, K + LAST)
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    k0 = view(w, K * length, length)
    k1 = view(w, (K + LAST) * length, length)
    f1 = view(w, (F + 1) * length, length)
    f2 = view(w, (F + 2) * length, length)
    f3 = view(w, (F + 3) * length, length)
    f4 = view(w, (F + 4) * length, length)
    f5 = view(w, (F + 5) * length, length)
    for i in range(n):
        j = n + i
        f4[i] = 0.5 * h * h * k0[j] + f2[i] - f3[i]
        f5[i] = 0.5 * h * h * k1[j] + f2[i] + 2.0 * f3[i] - f4[i]
        # The velocity's integral over the step is the change of position, but for rounding.
        mean = (y1[i] - y0[i]) / h
        f4[j] = 30.0 * (mean - y0[j] - f1[j] / 2.0 - f2[j] / 6.0 - f3[j] / 12.0)
        if abs(f4[j]) < 30.0 * _ROUNDING * ((abs(y0[i]) + abs(y1[i])) / h + abs(y0[j])):
            f4[j] = 0.0
    return 0
