"""Rounding of a potential whose terms cancel: what their sum does not show, its values scatter.

In a row of equally spaced states a smooth function has small differences of a high order, a jump
has large ones in its own neighbourhood, and rounding has them everywhere. The shape of a potential
that is too fine for a row has them too, but so have its slopes then: for a wave of any length the
tenth difference of the values is no larger than the ninth one of slope times distance. In a short
row coarse rounding does not show, as neighbours are equal; rows of many lengths are looked at.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, f8, integers
from runtime.core.jit import addressed, inner
from runtime.integrate.energy_tolerances import CERTAIN

Differences = tuple[float, float, float, float, float, float, float, float, float, float, float]

_GAIN = 430.0  # formula: root of the sum of squares of the coefficients of a tenth difference
_ORDER = 10  # measured: of the differences; lower ones see the shape of a potential more
_BLOCKS, _EACH = 4, 8  # measured: groups of differences, of which a jump disturbs two
_POINTS = 66  # formula: intervals of all groups
_SHAPE = 4.0  # safety: differences of slopes, to which those of a shape come up
_LEAST_WAY, _LONGER = 1e-9, 10.0  # measured: of coordinates' sizes; the first row, growth of others
_LONG, _LONGEST = 3.0, 3e6  # measured: of coordinates' sizes; ends where V varies, and does not


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
def take_differences(value: float, before: Differences) -> Differences:
    """Differences of the orders 0 to 10 that end at this value, from those one place before."""
    d1 = value - before[0]
    d2 = d1 - before[1]
    d3 = d2 - before[2]
    d4 = d3 - before[3]
    d5 = d4 - before[4]
    d6 = d5 - before[5]
    d7 = d6 - before[6]
    d8 = d7 - before[7]
    d9 = d8 - before[8]
    return value, d1, d2, d3, d4, d5, d6, d7, d8, d9, d9 - before[9]


@inner
def measure_scatter(context: Context, t: float, way: float) -> tuple[float, int]:
    """Scatter of V along a row of states, J, or 0 for its shape; most equal pairs of a group."""
    q, step = ws.positions(context, ws.SAMPLE), ws.positions(context, ws.DELTA)
    gradient, least, most = ws.second_half(context, ws.DELTA), np.inf, 0
    for block in range(_BLOCKS):
        values = slopes = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        scatter, shape, equal = 0.0, 0.0, 0
        for i in range(_ORDER + _EACH):
            value = evaluate_along(context, t, way, 2 * _EACH * block + i)
            abi.potential_gradient_of(context)(t, q, context.parameters, context.modes, gradient)
            slope = 0.0
            for j in range(context[ft.COORDINATES]):
                slope += gradient[j] * step[j]
            values, slopes = take_differences(value, values), take_differences(slope, slopes)
            equal += 1 if values[1] == 0.0 else 0
            if i >= _ORDER - 1:
                shape = max(shape, abs(slopes[_ORDER - 1]))
            if i >= _ORDER:
                scatter = max(scatter, abs(values[_ORDER]))
        if not np.isfinite(scatter + shape):
            return np.nan, most
        most = max(most, equal)
        least = min(least, scatter if scatter > _SHAPE * shape else 0.0)
    return least / _GAIN, most


@addressed(f8(integers, f8))
def measure_rounding(context: Context, t: float) -> float:
    """By how much two values of the potential about the step may differ by rounding, J."""
    rounding, before, equal, way = 0.0, 0, 0, _LEAST_WAY
    # where many neighbours are equal, few show their rounding; one row more: in the first that is
    # longer, all groups need not scatter
    while way < _LONG or (way < _LONGEST and 2 * before > _ORDER + _EACH):
        before = equal
        scatter, equal = measure_scatter(context, t, way)
        if not np.isfinite(scatter):
            break
        rounding = max(rounding, CERTAIN * scatter)
        way *= _LONGER
    return rounding
