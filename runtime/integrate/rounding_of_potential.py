"""Rounding of a potential whose terms cancel: what their sum does not show, its values scatter.

In a row of equally spaced states a smooth function has small differences of a high order, a jump
has large ones in its own neighbourhood, and rounding has them everywhere. Rows are made longer
until their values follow the gradient: in a shorter one coarse rounding does not show, in a longer
one the shape of the potential would count as rounding.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, f8, integers
from runtime.core.jit import addressed, inner
from runtime.core.unit_roundoff import EPS

# formula: of the tenth difference
_BINOMIAL = (1.0, -10.0, 45.0, -120.0, 210.0, -252.0, 210.0, -120.0, 45.0, -10.0, 1.0)
_GAIN = 430.0  # formula: root of the sum of their squares
_BLOCKS, _EACH = 4, 8  # measured: groups of differences, of which a jump disturbs two
_POINTS = 66  # formula: intervals of all groups
_CERTAIN = 16.0  # measured: times the scatter that a difference of two values may be in long runs
_LEAST_WAY, _LONGER = 1e-9, 10.0  # measured: of coordinates' sizes; the first row, growth of others
_DIGITS = 4.0  # safety: roundings of V by which a sum of slopes may miss its change
_APART = 1e-8  # safety: of a change of V; what a sum of slopes over a part of a row may miss


@inner
def evaluate_along(context: Context, t: float, way: float, i: int) -> float:
    """V of the state number i in a row, J; its positions go to row SAMPLE, the way to DELTA."""
    q0, q = context.q0, ws.positions(context, ws.SAMPLE)
    size, step = ws.row_of(context, ws.SIZE), ws.positions(context, ws.DELTA)
    for j in range(context[ft.COORDINATES]):
        # coordinates that moved alike would hide what depends on their differences
        turn = (1.0 - 2.0 * (j % 2)) * (1.0 + 0.3 * (j % 3))
        step[j] = way * turn * size[j] / _POINTS
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
    return least / _GAIN


@inner
def measure_drift(context: Context, t: float, way: float) -> float:
    """By how much V misses the sum of its slopes in a part of a row, beyond its last digits, J."""
    q, step = ws.positions(context, ws.SAMPLE), ws.positions(context, ws.DELTA)
    gradient, least = ws.second_half(context, ws.DELTA), np.inf
    for block in range(_BLOCKS):
        first = evaluate_along(context, t, way, 2 * _EACH * block)
        value, change, slopes = first, 0.0, 0.0
        for i in range(2 * _EACH + 1):
            value = evaluate_along(context, t, way, 2 * _EACH * block + i)
            abi.potential_gradient_of(context)(t, q, context.parameters, context.modes, gradient)
            slope = 0.0
            for j in range(context[ft.COORDINATES]):
                slope += gradient[j] * step[j]
            part = 0.5 if i % (2 * _EACH) == 0 else 1.0
            change += part * slope
            slopes += part * abs(slope)
        digits = _DIGITS * EPS * max(abs(first), abs(value))
        least = min(least, abs(value - first - change) - digits - _APART * slopes)
    return least


@addressed(f8(integers, f8))
def measure_rounding(context: Context, t: float) -> float:
    """By how much two values of the potential about the step may differ by rounding, J."""
    least, way = np.inf, _LEAST_WAY
    while way <= 1.0:
        scatter = _CERTAIN * measure_scatter(context, t, way)
        if not np.isfinite(scatter):
            break
        least = min(least, scatter)
        if measure_drift(context, t, way) <= scatter:
            return scatter
        way *= _LONGER
    return least if np.isfinite(least) else 0.0
