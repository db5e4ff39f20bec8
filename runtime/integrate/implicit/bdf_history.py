"""The past of backward differentiation formulas: differences of all coordinates and velocities.

They stand at equal distances in time. A step of another length interpolates them anew: L. F.
Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM Journal on Scientific Computing 18, 1997,
section 2.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, view
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import Y0, Y1, F, K, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.linalg.vectors import axpy, copy_vector

HIGHEST = 5
KAPPA = np.array([0.0, -0.1850, -1.0 / 9.0, -0.0823, -0.0415, 0.0])
GAMMA = np.concatenate([[0.0], np.cumsum(1.0 / np.arange(1, HIGHEST + 1))])
ALPHA = (1.0 - KAPPA) * GAMMA  # formula: of the numerical differentiation formulas
PSI_SHARE = np.vstack([0.0 * GAMMA, GAMMA / ALPHA[1:, None]])  # of ∇ʲ in psi at order k, [k, j]
ERROR_CONSTANT = np.append(KAPPA * GAMMA + 1.0 / np.arange(1, HIGHEST + 2), 1.0)
GROW = 10.0  # measured: largest ratio of the lengths of two steps

# Rows: backward differences of the past, the same at this step's length, and a step's:
# what is foreseen of the change, psi, and the difference k + 1 of the unknowns at its end.
PAST, NOW, AHEAD, PSI, DIFFERENCE = 0, 8, 16, 17, 18

_FAILURES = 3  # measured: rejections in a row after which higher differences are useless


def newton_form(powers: Sequence[Fraction]) -> list[Fraction]:
    """Coefficients of 1, x, x² ... as those of F0 + x (F1 + (1 - x) (F2 + x (F3 + ...)))."""
    rest = list(powers)
    coefficients: list[Fraction] = []
    while rest:
        if len(coefficients) % 2 == 0:  # the value at x = 0; then divide the rest by x
            coefficients.append(rest.pop(0))
        else:  # the value at x = 1; then divide by 1 - x: partial sums from the constant on
            *sums, value = accumulate(rest)
            coefficients.append(value)
            rest = [partial - value for partial in sums]
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
def change_spacing(context: Context, k: int, ratio: float) -> None:
    """Work out, at CHANGE, the matrix that takes differences 1 … k to another distance.

    It is R(ratio) R(1) of Shampine and Reichelt's section 2; column j belongs to the new ∇ʲ.
    """
    scaled = view(context.method_floats, mem.CHANGE, (6, 6))
    result = view(context.method_floats, mem.CHANGE + 36, (6, 6))
    for j in range(1, k + 1):
        one, other = 1.0, 1.0
        for i in range(1, k + 1):
            one *= (i - 1 - ratio * j) / i
            other *= (i - 1 - j) / i
            scaled[i, j], result[i, j] = one, other
    for i in range(1, k + 1):
        # Row by row in place: row i of R(ratio) is used up by row i of the product.
        for j in range(1, k + 1):
            scaled[0, j] = 0.0
            for m in range(1, k + 1):
                scaled[0, j] += scaled[i, m] * result[m, j]
        copy_vector(scaled[0], scaled[i])


@inner
def start_history(context: Context, h: float, order: int) -> None:
    """Make up a past for the state Y0 with derivative K: a straight line, at order 1.

    At order 2 positions have a parabola, as their second derivative is known, which leaves their
    tiny flights after an impact exact however coarse the tolerance is.
    """
    notes, n, rows = context.method_integers, context[ft.COORDINATES], mem.rows(context)
    k0, slope, bend = row_of(context, K), rows[PAST + 1], rows[PAST + 2]
    for j in range(2, 8):
        rows[PAST + j].fill(0.0)
    rows[mem.LOW].fill(0.0)
    copy_vector(row_of(context, Y0), rows[PAST])
    for i in range(2 * n):
        slope[i] = h * k0[i]
    if order > 1:
        for i in range(n):
            bend[i] = h * h * k0[n + i]
            slope[i] -= 0.5 * bend[i]
    context.method_floats[mem.H_BASE] = h
    notes[mem.STEP_ORDER] = notes[mem.NEXT_ORDER] = order
    # What is made up is smooth: the next step may be another one at once.
    notes[mem.EQUAL] = order if order > 1 else 0
    run_record(context).exponent = 1.0 / (order + 1)


@inner
def rescale_history(context: Context, h: float) -> None:
    """Fill the rows at NOW with the differences of the past at distance `h`.

    Where the past is of no use, that is the derivative alone, and the order one.
    """
    notes, rows = context.method_integers, mem.rows(context)
    ratio = h / context.method_floats[mem.H_BASE]
    failures = run_record(context).rejected - notes[mem.REJECTED]
    if notes[mem.STEP_ORDER] > 1 and (ratio > 1.01 * GROW or failures >= _FAILURES):
        start_history(context, h, 1)
        ratio = 1.0
    k = notes[mem.STEP_ORDER]
    if ratio != 1.0:
        change_spacing(context, k, ratio)
        notes[mem.EQUAL] = 0
    change = view(context.method_floats, mem.CHANGE, (6, 6))
    for j in range(k + 3):
        now = rows[NOW + j]
        if ratio == 1.0 or j == 0 or j > k:
            copy_vector(rows[PAST + j], now)
        else:
            now.fill(0.0)
            for m in range(1, k + 1):
                axpy(change[m, j], rows[PAST + m], now)


@inner
def extrapolate(context: Context) -> None:
    """Extrapolate the past to the end of the step: what it adds, AHEAD; the state, Y1; and PSI."""
    y1, rows = row_of(context, Y1), mem.rows(context)
    k = context.method_integers[mem.STEP_ORDER]
    start, ahead, psi, low = rows[NOW], rows[AHEAD], rows[PSI], rows[mem.LOW]
    ahead.fill(0.0)
    psi.fill(0.0)
    for j in range(k, 0, -1):
        axpy(1.0, rows[NOW + j], ahead)
        axpy(PSI_SHARE[k, j], rows[NOW + j], psi)
    for i in range(y1.size):
        ahead[i] += low[i]
        y1[i] = start[i] + ahead[i]


@inner
def extend_history(context: Context, h: float) -> None:
    """Take the step of length `h` to Y1 into the differences, and keep what rounding cut off it."""
    n, notes, unknown = context[ft.COORDINATES], context.method_integers, mem.unknowns(context)
    k, y1, rows = notes[mem.STEP_ORDER], row_of(context, Y1), mem.rows(context)
    start, ahead, low, difference = rows[NOW], rows[AHEAD], rows[mem.LOW], rows[DIFFERENCE]
    newest, higher, last = rows[PAST + k + 1], rows[PAST + k + 2], rows[NOW + k + 1]
    low.fill(0.0)
    for i in range(2 * n):
        newest[i] = (y1[i] - start[i]) - ahead[i]
    for i in range(2 * notes[mem.FREEDOMS]):
        j = unknown[i // 2] + i % 2 * n
        change = ahead[j] + difference[j]
        left = start[j] + change
        if context[ft.SLIDING_COUNT] != 0 or y1[j] == left:
            low[j] = change - (left - start[j])
            newest[j] = difference[j]
    for i in range(2 * n):
        higher[i] = newest[i] - last[i]
        for j in range(k, 0, -1):
            rows[PAST + j, i] = rows[NOW + j, i] + rows[PAST + j + 1, i]
    copy_vector(y1, rows[PAST])
    context.method_floats[mem.H_BASE] = h


@addressed(ft.DENSE)
def dense(context: Context, t: float, h: float) -> int:
    """Fill the coefficient rows with the polynomial of degree k through the last k + 1 states."""
    y1, rows = row_of(context, Y1), mem.rows(context)
    for row in range(mem.DENSE_ROWS):
        row_of(context, F + row).fill(0.0)
    for i in range(y1.size):
        summed = (y1[i] - rows[NOW, i]) - rows[AHEAD, i]
        for j in range(context.method_integers[mem.STEP_ORDER], -1, -1):
            summed += rows[NOW + j, i]
            value = summed if j > 0 else y1[i]
            for row in range(mem.DENSE_ROWS):
                row_of(context, F + row)[i] += _WEIGHTS[row, j] * value
    return 0
