"""The error of a Radau IIA step, from an embedded formula of order 3."""

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import COORDINATES, method_floats_of, method_integers_of
from runtime.core.jit import inner
from runtime.core.run_record import run_record
from runtime.core.workspace import STAGE, Y0, K, row_of
from runtime.integrate.implicit.method_memory import (
    COUNTS,
    EQUAL,
    FREEDOMS,
    IN,
    OUT,
    SLOPE,
    TOLERANCE,
    line,
)
from runtime.integrate.implicit.newton_matrices import filtered, uneven
from runtime.integrate.implicit.radau5_coefficients import (
    A11,
    A12,
    A13,
    A21,
    A22,
    A23,
    A31,
    A32,
    A33,
    C_REAL,
    E1,
    E2,
    E3,
)
from runtime.integrate.implicit.radau5_stages import (
    STATES,
    VELOCITIES,
)
from runtime.integrate.implicit.state_space_form import arrive

LAST = 1  # row, after K, of the derivative at the end of the step
# The changes of positions go with these, of velocities with E1, E2, E3.
E_A1 = E1 * A11 + E2 * A21 + E3 * A31
E_A2 = E1 * A12 + E2 * A22 + E3 * A32
E_A3 = E1 * A13 + E2 * A23 + E3 * A33


@inner
def embedded(context: Integers, t: float, h: float, k0: Vector) -> float:
    """Size of the filtered error c (k0 + Σ e z / h), which is left in row IN of METHOD_FLOATS."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    y0 = row_of(context, Y0)
    s1 = row_of(context, K + STATES)
    s2 = row_of(context, K + STATES + 1)
    s3 = row_of(context, K + STATES + 2)
    rates = line(memory, SLOPE, n)
    c = h * C_REAL
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    for i in range(notes[FREEDOMS]):
        # The changes of positions are h (c u̇ + A Δu̇), and Σ e c = -1: nothing large cancels.
        j = notes[COUNTS + i]
        z = E_A1 * one[i] + E_A2 * two[i] + E_A3 * three[i]
        rates[n + i] = c * ((k0[j] - y0[n + j]) + z)
        rates[i] = c * k0[n + j] + C_REAL * (E1 * one[i] + E2 * two[i] + E3 * three[i])
    found = filtered(context, t, Y0, c)
    raw = line(memory, OUT, n)
    for j in range(n):
        z = E1 * (s1[j] - y0[j]) + E2 * (s2[j] - y0[j]) + E3 * (s3[j] - y0[j])
        raw[j] = c * k0[j] + C_REAL * z
    return float(max(found, uneven(context, raw, line(memory, TOLERANCE, n))))


@inner
def estimate(context: Integers, t: float, h: float) -> float:
    """Error over the tolerance; where it is too large at a first step or again, filtered twice."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    length = 2 * n
    found = embedded(context, t, h, row_of(context, K))
    if found >= 1.0 and (r.rejected_before != 0 or notes[EQUAL] == 0):
        y0 = row_of(context, Y0)
        z = row_of(context, STAGE)
        slope = row_of(context, K + LAST)
        change = line(memory, IN, n)
        for i in range(length):
            z[i] = y0[i] + change[i]
        if arrive(context, t, STAGE, K + LAST) == FAILED:
            return found
        r.rhs += 1
        for i in range(n):
            slope[i] = z[n + i]
        found = embedded(context, t, h, slope)
    return found
