"""The past of backward differentiation formulas: differences of all coordinates and velocities.

They stand at equal distances in time. A step of another length interpolates them anew: L. F.
Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM Journal on Scientific Computing 18, 1997,
section 2.
"""

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from runtime.core.array_types import Integers
from runtime.core.borrowed_arrays import view
from runtime.core.function_table import (
    COORDINATES,
    DENSE,
    SLIDING_COUNT,
    method_floats_of,
    method_integers_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import Y0, Y1, F, K, row_of
from runtime.integrate.implicit import method_memory as mem

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


def newton_form(powers: Sequence[Fraction]) -> list[Fraction]:
    """Coefficients of 1, x, x² ... as those of F0 + x (F1 + (1 - x) (F2 + x (F3 + ...)))."""
    rest = list(powers)
    coefficients: list[Fraction] = []
    while rest:
        if len(coefficients) % 2 == 0:  # the value at x = 0; then divide the rest by x
            coefficients.append(rest[0])
            rest = rest[1:]
        else:  # the value at x = 1; then divide by 1 - x: partial sums from the constant on
            coefficients.append(sum(rest, Fraction(0)))
            rest = [sum(rest[: i + 1], -coefficients[-1]) for i in range(len(rest) - 1)]
    return coefficients


def _dense_weights() -> npt.NDArray[np.float64]:
    """F0 … F5 of the polynomials in x = (t - t₀)/h that go with ∇⁰ … ∇⁵ at t₁ = t₀ + h, (6, 6)."""
    columns, powers = [], [Fraction(1)]
    for m in range(HIGHEST + 1):
        padded = powers + [Fraction(0)] * (HIGHEST - m)
        columns.append([float(value) for value in newton_form(padded)])
        # The next is this times (x - 1 + m) / (m + 1).
        pairs = zip([Fraction(0), *powers], [*powers, Fraction(0)], strict=True)
        powers = [(lower + (m - 1) * same) / (m + 1) for lower, same in pairs]
    return np.ascontiguousarray(np.array(columns).T)


_WEIGHTS = _dense_weights()


@inner
def change_spacing(context: Integers, k: int, ratio: float) -> None:
    """Work out, at CHANGE, the matrix that takes differences 1 … k to another distance.

    It is R(ratio) R(1) of Shampine and Reichelt's section 2; column j belongs to the new ∇ʲ.
    """
    scaled = view(method_floats_of(context), mem.CHANGE, 36)
    result = view(method_floats_of(context), mem.CHANGE + 36, 36)
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
def start_history(context: Integers, h: float, order: int) -> None:
    """Make up a past for the state Y0 with derivative K: a straight line, at order 1.

    At order 2 positions have a parabola, as their second derivative is known, which leaves their
    tiny flights after an impact exact however coarse the tolerance is.
    """
    notes, n = method_integers_of(context), context[COORDINATES]
    y0, k0 = row_of(context, Y0), row_of(context, K)
    value, slope = mem.row(context, PAST), mem.row(context, PAST + 1)
    bend, low = mem.row(context, PAST + 2), mem.row(context, mem.LOW)
    for i in range(2 * n):
        for j in range(2, 8):
            mem.row(context, PAST + j)[i] = 0.0
        low[i] = 0.0
        value[i] = y0[i]
        slope[i] = h * k0[i]
    if order > 1:
        for i in range(n):
            bend[i] = h * h * k0[n + i]
            slope[i] -= 0.5 * bend[i]
    method_floats_of(context)[mem.H_BASE] = h
    notes[mem.STEP_ORDER] = order
    notes[mem.NEXT_ORDER] = order
    # What is made up is smooth: the next step may be another one at once.
    notes[mem.EQUAL] = order if order > 1 else 0
    run_record(context).exponent = 1.0 / (order + 1)


@inner
def rescale_history(context: Integers, h: float) -> None:
    """Fill the rows at NOW with the differences of the past at distance `h`.

    Where the past is of no use, that is the derivative alone, and the order one.
    """
    notes, length = method_integers_of(context), 2 * context[COORDINATES]
    ratio = h / method_floats_of(context)[mem.H_BASE]
    failures = run_record(context).rejected - notes[mem.REJECTED]
    if notes[mem.STEP_ORDER] > 1 and (ratio > 1.01 * GROW or failures >= _FAILURES):
        start_history(context, h, 1)
        ratio = 1.0
    k = notes[mem.STEP_ORDER]
    if ratio != 1.0:
        change_spacing(context, k, ratio)
        notes[mem.EQUAL] = 0
    change = view(method_floats_of(context), mem.CHANGE, 36)
    for j in range(k + 3):
        past, now = mem.row(context, PAST + j), mem.row(context, NOW + j)
        same = ratio == 1.0 or j == 0 or j > k
        for i in range(length):
            now[i] = past[i] if same else 0.0
        for m in range(1, 1 if same else k + 1):
            share, other = change[m * 6 + j], mem.row(context, PAST + m)
            for i in range(length):
                now[i] += share * other[i]


@inner
def extrapolate(context: Integers) -> None:
    """Extrapolate the past to the end of the step: what it adds, AHEAD; the state, Y1; and PSI."""
    length, k = 2 * context[COORDINATES], method_integers_of(context)[mem.STEP_ORDER]
    y1, low = row_of(context, Y1), mem.row(context, mem.LOW)
    ahead, psi, start = mem.row(context, AHEAD), mem.row(context, PSI), mem.row(context, NOW)
    for i in range(length):
        ahead[i] = 0.0
        psi[i] = 0.0
    for j in range(k, 0, -1):
        now = mem.row(context, NOW + j)
        share = GAMMA[j] / ALPHA[k]
        for i in range(length):
            ahead[i] += now[i]
            psi[i] += share * now[i]
    for i in range(length):
        ahead[i] += low[i]
        y1[i] = start[i] + ahead[i]


@inner
def extend_history(context: Integers, h: float) -> None:
    """Take the step of length `h` to Y1 into the differences, and keep what rounding cut off it."""
    notes, n, unknown = method_integers_of(context), context[COORDINATES], mem.unknowns(context)
    k, y1, low = notes[mem.STEP_ORDER], row_of(context, Y1), mem.row(context, mem.LOW)
    start, ahead = mem.row(context, NOW), mem.row(context, AHEAD)
    newest, higher = mem.row(context, PAST + k + 1), mem.row(context, PAST + k + 2)
    last, difference = mem.row(context, NOW + k + 1), mem.row(context, DIFFERENCE)
    for i in range(2 * n):
        newest[i] = (y1[i] - start[i]) - ahead[i]
        low[i] = 0.0
    for i in range(2 * notes[mem.FREEDOMS]):
        j = unknown[i // 2] + i % 2 * n
        change = ahead[j] + difference[j]
        left = start[j] + change
        if context[SLIDING_COUNT] != 0 or y1[j] == left:
            low[j] = change - (left - start[j])
            newest[j] = difference[j]
    for i in range(2 * n):
        higher[i] = newest[i] - last[i]
    for j in range(k, -1, -1):
        past, now = mem.row(context, PAST + j), mem.row(context, NOW + j)
        above = mem.row(context, PAST + j + 1)
        for i in range(2 * n):
            past[i] = now[i] + above[i] if j > 0 else y1[i]
    method_floats_of(context)[mem.H_BASE] = h


@addressed(DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows with the polynomial of degree k through the last k + 1 states."""
    y1, start, ahead = row_of(context, Y1), mem.row(context, NOW), mem.row(context, AHEAD)
    for i in range(2 * context[COORDINATES]):
        for row in range(DENSE_ROWS):
            row_of(context, F + row)[i] = 0.0
        summed = (y1[i] - start[i]) - ahead[i]
        for j in range(method_integers_of(context)[mem.STEP_ORDER], -1, -1):
            summed += mem.row(context, NOW + j)[i]
            value = summed if j > 0 else y1[i]
            for row in range(DENSE_ROWS):
                row_of(context, F + row)[i] += _WEIGHTS[row, j] * value
    return 0
