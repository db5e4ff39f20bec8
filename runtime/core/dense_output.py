"""Evaluation of the dense output, the same for every explicit method.

The rows at `F` hold coefficients of the form that Hairer, Nørsett and Wanner use (Solving Ordinary
Differential Equations I, section II.6): with x the fraction of the step, the polynomial is
F0 + x (F1 + (1 - x) (F2 + x (F3 + ...))).
"""

from runtime.core.array_views import view
from runtime.core.jit import inner
from runtime.core.signatures import Vector
from runtime.core.workspace import ROWS, Y0, Y1, F, K


@inner
def interpolate(w: Vector, dense_rows: int, x: float, index: int) -> None:
    """Write the state at fraction `x` of the step into row `index` of the workspace."""
    length = w.size // ROWS
    out = view(w, index * length, length)
    last = view(w, (F + dense_rows - 1) * length, length)
    for j in range(length):
        out[j] = last[j]
    for i in range(dense_rows - 2, -1, -1):
        f = view(w, (F + i) * length, length)
        factor = x if i % 2 == 0 else 1.0 - x
        for j in range(length):
            out[j] = f[j] + factor * out[j]


@inner
def hermite_rows(h: float, w: Vector, last: int) -> None:
    """Fill the first four coefficient rows from the states and derivatives at both ends.

    `last` is the row of the derivative at the end of the step.
    """
    length = w.size // ROWS
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    k0 = view(w, K * length, length)
    k1 = view(w, last * length, length)
    f0 = view(w, F * length, length)
    f1 = view(w, (F + 1) * length, length)
    f2 = view(w, (F + 2) * length, length)
    f3 = view(w, (F + 3) * length, length)
    for j in range(length):
        change = y1[j] - y0[j]
        f0[j] = y0[j]
        f1[j] = change
        f2[j] = h * k0[j] - change
        f3[j] = 2.0 * change - h * (k0[j] + k1[j])
