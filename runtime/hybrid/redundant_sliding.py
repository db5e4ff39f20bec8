"""Degenerate sliding: shares where several functions in sliding mode act on one freedom."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Vector, view
from runtime.core.jit import inlined, inner
from runtime.core.kinds import BALANCED, MIXED, ONE_WAY, SLIDING
from runtime.linalg.dense_elimination import equilibrate
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector, dot, largest_ratio

_DRIVEN = 1e-12  # accuracy: of a size and all accelerations; a smaller response is rounding
_FORCED = 1e-14  # accuracy: of a size and all F/m; a response of what stands, below it, is rounding


@inlined
def is_unilateral(context: Context, k: int) -> bool:
    """Whether function `k` is held by a reaction without a bound: of a contact, of a freewheel."""
    return bool(context.rigid[k] >= 0 or context.sticks[k] == ONE_WAY)


@inner
def orthogonalize_row(context: Context, i: int) -> float:
    """Make row `i` orthogonal to the rows before it, reactions first; size of its terms."""
    matrix, right, count = context.response_copy, context.right_side, context[ft.SLIDING_COUNT]
    closed = is_unilateral(context, context.sliding_functions[i])
    row = view(matrix, i * count, count)
    scale = max(1.0, abs(right[i]))
    for _ in range(2):
        for j in range(count):
            first = is_unilateral(context, context.sliding_functions[j])
            if not (j < i if first == closed else first):
                continue
            other = view(matrix, j * count, count)
            along = dot(row, other)
            axpy(-along, other, row)
            right[i] -= along * right[j]
            scale = max(scale, abs(along * right[j]))
    return float(scale)


@inner
def solve_least(context: Context, slack: float) -> int:
    """As `solve_equilibrated`, for the smallest of many solutions; 1 where there is none.

    The matrix is `response_copy`, the right side `right_side`, in which x takes its place; all
    arrays are overwritten. Frictions of one freedom share its force in many ways. This one makes
    Σ |column| x²/reach least: each bears the same part of its reach, the largest permitted |x| in
    `response_column`, so that they stick as long as possible, and break loose together. Rows are
    made orthogonal one after the other (Gram and Schmidt, twice); a row without a rest depends on
    the others, and its residual may be `slack` of its terms. Rows of contacts and freewheels come
    first and must be independent: one that repeats others may open.
    """
    matrix, right, reach = context.response_copy, context.right_side, context.response_column
    count = context[ft.SLIDING_COUNT]
    if equilibrate(matrix, right, count) != 0:
        return 1
    for c in range(count):
        norm = 0.0
        for i in range(count):
            norm += matrix[i * count + c] ** 2
        if not norm > 0.0:
            return 1
        reach[c] = np.sqrt(reach[c] / np.sqrt(norm))
        for i in range(count):
            matrix[i * count + c] *= reach[c]
    for turn in range(2):
        for i in range(count):
            closed = is_unilateral(context, context.sliding_functions[i])
            if closed != (turn == 0):
                continue
            row = view(matrix, i * count, count)
            size = np.sqrt(dot(row, row))
            scale = orthogonalize_row(context, i)
            rest = np.sqrt(dot(row, row))
            if rest > SAME_HOLD * size:
                for c in range(count):
                    row[c] /= rest
                right[i] /= rest
                continue
            if closed or not abs(right[i]) <= slack * scale:
                return 1
            row[:] = 0.0
            right[i] = 0.0
    for c in range(count):
        total = 0.0
        for i in range(count):
            total += right[i] * matrix[i * count + c]
        reach[c] *= total
    copy_vector(view(reach, 0, count), right)
    return 0


@inner
def is_resting(context: Context, c: int) -> bool:
    """Whether the `c`-th function in sliding mode stays on its surface by itself.

    No mode moves it off. A balanced one takes the mean of both sides there, of mixed ones each
    holds as it is written, which `rest_mixed` says to the kernels.
    """
    k = context.sliding_functions[c]
    if context.boundary[k] == MIXED:
        return bool(context.kernel_modes[k] == SLIDING)
    return bool(context.boundary[k] == BALANCED and not is_driven(context, c, 0.0))


@inner
def rest_mixed(context: Context) -> bool:
    """Let mixed functions rest that the modes do not drive onto their surface; whether any does."""
    found = False
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        if context.boundary[k] == MIXED and not is_driven(context, c, -1.0):
            context.kernel_modes[k] = SLIDING
            found = True
    return found


@inner
def is_driven(context: Context, c: int, way: float) -> bool:
    """Whether its modes move the `c`-th function in sliding mode, `way` -1 onto, 1 off, 0 either.

    A response that is the rounding of accelerations moves nothing, nor does that of forces which a
    machine that stands bears, nor does a condition move what a contact or a freewheel keeps.
    """
    k = context.sliding_functions[c]
    for j in range(context[ft.SLIDING_COUNT]):
        other = context.sliding_functions[j]
        kept = is_unilateral(context, other) and context.sticks[k] == 0
        if kept and share_freedom(context, k, other):
            return False
    response = context.response[c * context[ft.SLIDING_COUNT] + c]
    response = abs(response) if way == 0.0 else way * response
    if response <= 0.0:
        return False
    speeds = view(ws.row_of(context, ws.SIZE), context[ft.COORDINATES], context[ft.COORDINATES])
    per_second = largest_ratio(context.base_accelerations, speeds)
    per_second += largest_ratio(context.unit_accelerations[c], speeds)
    largest = context.reserve[k] if context.modes[k] == SLIDING else context.largest[k]
    per_second = max(_DRIVEN * per_second, _FORCED * context.force_rates[c])
    return not response <= largest * per_second


@inner
def measure_forces(context: Context, t: float, q: Vector, v: Vector, k: int) -> float:
    """Largest |F|/m beside the typical speed of its coordinate, in 1/s, under `kernel_modes`.

    0 where function `k` cannot rest.
    """
    if context.boundary[k] != BALANCED and context.boundary[k] != MIXED:
        return 0.0
    force, size = context.forces, ws.row_of(context, ws.SIZE)
    per_mass, n, largest = ws.row_of(context, ws.PROJECTION), context[ft.COORDINATES], 0.0
    abi.applied_forces_of(context)(t, q, v, context.parameters, context.kernel_modes, force)
    for j in range(n):
        rate = abs(force[j]) * per_mass[j] / size[n + j]
        largest = max(largest, rate if np.isfinite(rate) else 0.0)
    return float(largest)


@inner
def rests(context: Context, k: int) -> bool:
    """Whether function `k` is in sliding mode and rests, see `is_resting`."""
    for c in range(context[ft.SLIDING_COUNT]):
        if context.sliding_functions[c] == k:
            return is_resting(context, c)
    return False


@inner
def keep_resting(context: Context, value: float) -> None:
    """Replace the equations of functions that rest by x = `value`, in `solve_least`'s arrays."""
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        if is_resting(context, c):
            context.right_side[c] = value
            for j in range(count):
                context.response_copy[c * count + j] = 1.0 if j == c else 0.0


@inner
def share_freedom(context: Context, k: int, other: int) -> bool:
    """Whether two functions in sliding mode act on one freedom; after the accelerations."""
    matrix, count = context.response, context[ft.SLIDING_COUNT]
    c, d = 0, 0
    for i in range(count):
        c = i if context.sliding_functions[i] == k else c
        d = i if context.sliding_functions[i] == other else d
    product = matrix[c * count + c] * matrix[d * count + d]
    crossed = matrix[c * count + d] * matrix[d * count + c]
    return bool(abs(product - crossed) <= SAME_HOLD * abs(product))
