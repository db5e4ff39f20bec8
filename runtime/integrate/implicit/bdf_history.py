"""The past of backward differentiation formulas: differences of all coordinates and velocities.

They stand at equal distances in time. A step of another length interpolates them anew: L. F.
Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM Journal on Scientific Computing 18, 1997,
section 2.
"""

from fractions import Fraction

import numpy as np

from runtime.core.array_types import Integers
from runtime.core.array_views import view
from runtime.core.function_table import COORDINATES, DENSE, method_floats_of, method_integers_of
from runtime.core.jit import addressed, inner
from runtime.core.run_record import run_record
from runtime.core.workspace import Y0, Y1, F, K, row_of
from runtime.integrate.explicit.newton_form import newton_form_matrix
from runtime.integrate.implicit.method_memory import (
    CHANGE,
    EQUAL,
    H_BASE,
    LOW,
    NEXT_ORDER,
    REJECTED,
    STEP_ORDER,
    line,
)

HIGHEST = 5
KAPPA = np.array([0.0, -0.1850, -1.0 / 9.0, -0.0823, -0.0415, 0.0])
GAMMA = np.concatenate([[0.0], np.cumsum(1.0 / np.arange(1, HIGHEST + 1))])
ALPHA = (1.0 - KAPPA) * GAMMA  # formula: of the numerical differentiation formulas
ERROR_CONSTANT = np.append(KAPPA * GAMMA + 1.0 / np.arange(1, HIGHEST + 2), 1.0)
DENSE_ROWS = 6
GROW = 10.0  # measured: largest ratio of the lengths of two steps

# Rows: backward differences of the past, the same at this step's length, and a step's:
# what is foreseen of the change, psi, and the difference k + 1 of the unknowns at its end.
PAST, NOW, AHEAD, PSI, DIFFERENCE = 0, 8, 16, 17, 18

_FAILURES = 3  # measured: rejections in a row after which higher differences say nothing


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


_NESTING = newton_form_matrix(_basis())


@inner
def lengthen(context: Integers, k: int, ratio: float) -> None:
    """Work out, at CHANGE, the matrix that takes differences 1 … k to another distance.

    It is R(ratio) R(1) of Shampine and Reichelt's section 2; column j belongs to the new ∇ʲ.
    """
    memory = method_floats_of(context)
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
def begin(context: Integers, h: float, order: int) -> None:
    """Make up a past for the state Y0 with derivative K: a straight line, at order 1.

    At order 2 positions have a parabola, as their second derivative is known, which leaves their
    tiny flights after an impact exact however coarse the tolerance is.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    y0 = row_of(context, Y0)
    k0 = row_of(context, K)
    for j in range(8):
        past = line(memory, PAST + j, n)
        for i in range(length):
            past[i] = 0.0
    value, slope = line(memory, PAST, n), line(memory, PAST + 1, n)
    low = line(memory, LOW, n)
    for i in range(length):
        low[i] = 0.0
        value[i] = y0[i]
        slope[i] = h * k0[i]
    if order > 1:
        bend = line(memory, PAST + 2, n)
        for i in range(n):
            bend[i] = h * h * k0[n + i]
            slope[i] -= 0.5 * bend[i]
    memory[H_BASE] = h
    notes[STEP_ORDER] = order
    notes[NEXT_ORDER] = order
    # What is made up is smooth: the next step may be another one at once.
    notes[EQUAL] = order if order > 1 else 0
    run_record(context).exponent = 1.0 / (order + 1)


@inner
def look_back(context: Integers, h: float) -> None:
    """Fill the rows at NOW with the differences of the past at distance `h`.

    Where the past is of no use, that is the derivative alone, and the order one.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    r = run_record(context)
    ratio = h / memory[H_BASE]
    failures = r.rejected - notes[REJECTED]
    if notes[STEP_ORDER] > 1 and (ratio > 1.01 * GROW or failures >= _FAILURES):
        begin(context, h, 1)
        ratio = 1.0
    k = notes[STEP_ORDER]
    if ratio != 1.0:
        lengthen(context, k, ratio)
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
def foresee(context: Integers) -> None:
    """Extrapolate the past to the end of the step: what it adds, AHEAD; the state, Y1; and PSI."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    k = notes[STEP_ORDER]
    y1 = row_of(context, Y1)
    ahead, psi = line(memory, AHEAD, n), line(memory, PSI, n)
    low, start = line(memory, LOW, n), line(memory, NOW, n)
    for i in range(length):
        ahead[i] = 0.0
        psi[i] = 0.0
    for j in range(k, 0, -1):
        now = line(memory, NOW + j, n)
        share = GAMMA[j] / ALPHA[k]
        for i in range(length):
            ahead[i] += now[i]
            psi[i] += share * now[i]
    for i in range(length):
        ahead[i] += low[i]
        y1[i] = start[i] + ahead[i]


@addressed(DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows with the polynomial of degree k through the last k + 1 states."""
    n = context[COORDINATES]
    length = 2 * n
    memory, notes = method_floats_of(context), method_integers_of(context)
    y1 = row_of(context, Y1)
    start, ahead = line(memory, NOW, n), line(memory, AHEAD, n)
    for row in range(DENSE_ROWS):
        f = row_of(context, F + row)
        for i in range(length):
            f[i] = 0.0
    for i in range(length):
        summed = (y1[i] - start[i]) - ahead[i]
        for j in range(notes[STEP_ORDER], -1, -1):
            summed += line(memory, NOW + j, n)[i]
            value = summed if j > 0 else y1[i]
            for row in range(DENSE_ROWS):
                row_of(context, F + row)[i] += _NESTING[row, j] * value
    return 0
