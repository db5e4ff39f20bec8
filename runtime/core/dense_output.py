"""Evaluation of the dense output, the same for every explicit method.

The rows at `F` hold coefficients of the form that Hairer, Nørsett and Wanner use (Solving Ordinary
Differential Equations I, section II.6): with x the fraction of the step, the polynomial is
F0 + x (F1 + (1 - x) (F2 + x (F3 + ...))).
"""

from runtime.core.arrays import Integers
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import inner
from runtime.core.workspace_rows import Y0, Y1, F, K, row_of


@inner
def interpolate(context: Integers, dense_rows: int, x: float, index: int) -> None:
    """Write the state at fraction `x` of the step into row `index` of the workspace."""
    length = 2 * context[COORDINATES]
    out = row_of(context, index)
    last = row_of(context, F + dense_rows - 1)
    for j in range(length):
        out[j] = last[j]
    for i in range(dense_rows - 2, -1, -1):
        f = row_of(context, F + i)
        factor = x if i % 2 == 0 else 1.0 - x
        for j in range(length):
            out[j] = f[j] + factor * out[j]


@inner
def hermite_rows(context: Integers, h: float, last: int) -> None:
    """Fill the first four coefficient rows; the derivative at the end of the step is row `last`."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    k0 = row_of(context, K)
    k1 = row_of(context, last)
    f0 = row_of(context, F)
    f1 = row_of(context, F + 1)
    f2 = row_of(context, F + 2)
    f3 = row_of(context, F + 3)
    for j in range(length):
        change = y1[j] - y0[j]
        f0[j] = y0[j]
        f1[j] = change
        f2[j] = h * k0[j] - change
        f3[j] = 2.0 * change - h * (k0[j] + k1[j])
