"""The error of a Radau IIA step, from an embedded formula of order 3."""

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import COORDINATES, method_integers_of
from runtime.core.jit import inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import STAGE, Y0, K, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.newton_matrices import dependent_error, filtered_error
from runtime.integrate.implicit.radau5_coefficients import C_REAL, E_A, E
from runtime.integrate.implicit.radau5_stages import STATES, VELOCITIES
from runtime.integrate.implicit.state_space_form import evaluate

LAST = 1  # row, after K, of the derivative at the end of the step


@inner
def embedded_error(context: Integers, t: float, h: float, k0: Vector) -> float:
    """Size of the filtered error c (k0 + Σ e z / h), which is left in row IN of METHOD_FLOATS."""
    n, unknown = context[COORDINATES], mem.unknowns(context)
    y0 = row_of(context, Y0)
    s1, s2 = row_of(context, K + STATES), row_of(context, K + STATES + 1)
    s3 = row_of(context, K + STATES + 2)
    one, two = mem.row(context, VELOCITIES), mem.row(context, VELOCITIES + 1)
    three = mem.row(context, VELOCITIES + 2)
    rates, raw = mem.row(context, mem.SLOPE), mem.row(context, mem.OUT)
    c = h * C_REAL
    for i in range(method_integers_of(context)[mem.FREEDOMS]):
        # The changes of positions are h (c u̇ + A Δu̇), and Σ e c = -1: nothing large cancels.
        j = unknown[i]
        z = E_A[0] * one[i] + E_A[1] * two[i] + E_A[2] * three[i]
        rates[n + i] = c * ((k0[j] - y0[n + j]) + z)
        z = E[0] * one[i] + E[1] * two[i] + E[2] * three[i]
        rates[i] = c * k0[n + j] + C_REAL * z
    found = filtered_error(context, t, Y0, c)
    for j in range(n):
        z = E[0] * (s1[j] - y0[j]) + E[1] * (s2[j] - y0[j]) + E[2] * (s3[j] - y0[j])
        raw[j] = c * k0[j] + C_REAL * z
    return float(max(found, dependent_error(context, raw)))


@inner
def estimate_error(context: Integers, t: float, h: float) -> float:
    """Error over the tolerance; where it is too large at a first step or again, filtered twice."""
    r, n = run_record(context), context[COORDINATES]
    found = embedded_error(context, t, h, row_of(context, K))
    if found >= 1.0 and (r.rejected_before != 0 or method_integers_of(context)[mem.EQUAL] == 0):
        y0, z = row_of(context, Y0), row_of(context, STAGE)
        slope, change = row_of(context, K + LAST), mem.row(context, mem.IN)
        for i in range(2 * n):
            z[i] = y0[i] + change[i]
        if evaluate(context, t, STAGE, K + LAST) == FAILED:
            return found
        r.rhs += 1
        for i in range(n):
            slope[i] = z[n + i]
        found = embedded_error(context, t, h, slope)
    return found
