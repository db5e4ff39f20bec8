"""Rounding of a potential whose terms cancel: what their sum does not show, its values scatter.

In a row of equally spaced states a smooth function has small differences of a high order, a jump
has large ones in its own neighbourhood, and rounding has them everywhere; or, where it is coarse,
neighbours are equal although the gradient tells them apart.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, f8, integers
from runtime.core.jit import addressed, inner

# formula: of the tenth difference
_BINOMIAL = (1.0, -10.0, 45.0, -120.0, 210.0, -252.0, 210.0, -120.0, 45.0, -10.0, 1.0)
_GAIN = 430.0  # formula: root of the sum of their squares
_BLOCKS, _EACH = 4, 8  # measured: groups of differences, of which a jump disturbs two
_POINTS = 66  # formula: intervals of all groups
_CERTAIN = 16.0  # measured: times the scatter that a difference of two values may be in long runs
_WAYS = (0.0, 1e-6, 1.0)  # measured: of the coordinates' sizes; rows of states. 0: along the step
_APART = 1e-9  # safety: of V; neighbours with a smaller difference may be equal by right


@inner
def evaluate_along(context: Context, t: float, way: float, i: int) -> float:
    """V of the state number i in a row, J; its positions go to row SAMPLE, the way to DELTA."""
    q0, q1, q = context.q0, context.q1, ws.positions(context, ws.SAMPLE)
    size, step = ws.row_of(context, ws.SIZE), ws.positions(context, ws.DELTA)
    for j in range(context[ft.COORDINATES]):
        # coordinates that moved alike would hide what depends on their differences
        turn = (1.0 - 2.0 * (j % 2)) * (1.0 + 0.3 * (j % 3))
        step[j] = (way * turn * size[j] if way > 0.0 else q1[j] - q0[j]) / _POINTS
        q[j] = q0[j] + i * step[j]
    return float(abi.potential_of(context)(t, q, context.parameters, context.modes))


@inner
def measure_scatter(context: Context, t: float, way: float) -> float:
    """Scatter of V along a row of states, by differences of the tenth order, J."""
    least = np.inf
    for block in range(_BLOCKS):
        largest = 0.0
        for first in range(2 * _EACH * block, 2 * _EACH * block + _EACH):
            total = 0.0
            for i in range(len(_BINOMIAL)):
                total += _BINOMIAL[i] * evaluate_along(context, t, way, first + i)
            largest = max(largest, abs(total))
        least = min(least, largest)
    return least / _GAIN if np.isfinite(least) else 0.0


@inner
def measure_stairs(context: Context, t: float, way: float) -> float:
    """Stair of V along a row in which most neighbours are equal, against the gradient, J.

    It is the second in size, as the first may be a jump, and where there is one alone the row
    passes less than two by its gradient.
    """
    q, step = ws.positions(context, ws.SAMPLE), ws.positions(context, ws.DELTA)
    gradient, equal, slope = ws.second_half(context, ws.DELTA), 0, 0.0
    largest, second = 0.0, 0.0
    before = evaluate_along(context, t, way, 0)
    for i in range(_POINTS):
        now = evaluate_along(context, t, way, i + 1)
        abi.potential_gradient_of(context)(t, q, context.parameters, context.modes, gradient)
        change = 0.0
        for j in range(context[ft.COORDINATES]):
            change += gradient[j] * step[j]
        equal += 1 if now == before and abs(change) > _APART * abs(now) else 0
        stair = abs(now - before)
        largest, second = max(largest, stair), max(second, min(largest, stair))
        slope, before = slope + abs(change), now
    return 2.0 * max(second, slope) if 2 * equal > _POINTS else 0.0


@addressed(f8(integers, f8))
def measure_rounding(context: Context, t: float) -> float:
    """By how much two values of the potential about the step may differ by rounding, J."""
    rounding = 0.0
    for way in _WAYS:
        scatter = _CERTAIN * measure_scatter(context, t, way)
        rounding = max(rounding, scatter, measure_stairs(context, t, way))
    return rounding
