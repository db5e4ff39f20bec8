"""How stiff the equations are: bounds and the spectral radius of their derivatives."""

import numpy as np

from runtime.core.arrays import Context
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import SIZE, row_of
from runtime.integrate.implicit import method_memory as mem

_POWERS = 8  # safety: iterations of the power method before the mean is taken, and in it
_QUIET = 0.5  # measured: h ρ with which an explicit method is at ease
_LONG = 30  # measured: steps at ease until the run returns to it


@inner
def stiffness(context: Context, h: float) -> float:
    """Largest row of h² |G_u| + h |G_u̇|, each entry relative to the sizes of its coordinates."""
    n, f = context[COORDINATES], context.method_integers[mem.FREEDOMS]
    unknown, size = mem.unknowns(context), row_of(context, SIZE)
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    largest = 0.0
    for i in range(f):
        total = 0.0
        for k in range(f):
            row, column = unknown[i], unknown[k]
            total += h * h * abs(by_u[i, k]) * size[column] / size[row]
            total += h * abs(by_rate[i, k]) * size[n + column] / size[n + row]
        largest = max(largest, total)
    return float(largest)


@inner
def estimate_spectrum(context: Context) -> None:
    """Find the largest |λ| of u̇ = y, ẏ = G_u u + G_u̇ y, and the damping of what belongs to it.

    The power method: the mean growth of an even number of iterations, as u and y have other units
    and their sizes change in turn. Three iterates in a row give a and b in λ² = a λ + b.
    """
    memory, f = context.method_floats, context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    rows = mem.rows(context)
    x, y, z = rows[mem.IN], rows[mem.OUT], rows[mem.SLOPE]
    memory[mem.STIFFNESS], memory[mem.DAMPING] = 0.0, 1.0
    for i in range(f):
        x[i] = 1.0 + 0.1 * i
        y[i] = 1.0 - 0.3 * i
    grown = 0.0
    xx, xy, yy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0
    for iteration in range(2 * _POWERS):
        largest = 0.0
        xx, xy, yy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(f):
            z[i] = 0.0
            for k in range(f):
                z[i] += by_u[i, k] * x[k] + by_rate[i, k] * y[k]
        for i in range(f):
            xx += x[i] * x[i]
            xy += x[i] * y[i]
            yy += y[i] * y[i]
            xz += x[i] * z[i]
            yz += y[i] * z[i]
            x[i], y[i] = y[i], z[i]
            largest = max(largest, abs(x[i]), abs(y[i]))
        if not (largest > 0.0 and np.isfinite(largest)):
            return
        for i in range(f):
            x[i] /= largest
            y[i] /= largest
        if iteration >= _POWERS:
            grown += np.log(largest)
    memory[mem.STIFFNESS] = np.exp(grown / _POWERS)
    independent = xx * yy - xy * xy
    if independent > 1e-10 * xx * yy:
        a = (xx * yz - xy * xz) / independent
        b = (yy * xz - xy * yz) / independent
    elif f == 1:
        a, b = by_rate[0, 0], by_u[0, 0]
    else:
        return
    if a * a + 4.0 * b < 0.0:
        memory[mem.STIFFNESS] = np.sqrt(-b)
        memory[mem.DAMPING] = -0.5 * a / np.sqrt(-b)


@inner
def suits_explicit(context: Context, h: float) -> int:
    """1 where an explicit method could long have taken the same steps, and may be chosen."""
    r, notes = run_record(context), context.method_integers
    quiet = r.automatic != 0 and h * context.method_floats[mem.STIFFNESS] < _QUIET
    notes[mem.CALM] = notes[mem.CALM] + 1 if quiet else 0
    if notes[mem.CALM] < _LONG * r.patience:
        return 0
    notes[mem.CALM] = 0
    return 1
