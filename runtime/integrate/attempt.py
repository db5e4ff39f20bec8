"""One trial step: stages, return onto the constraints, derivative at the end, error."""

import numpy as np

from runtime.compiled import addressed, inner
from runtime.constraints.correction import FAILED, WEAK
from runtime.integrate.bent import STEP
from runtime.integrate.field import field
from runtime.integrate.repartition import poorly_chosen
from runtime.integrate.signatures import ATTEMPT, Integers, Vector
from runtime.integrate.slots import (
    CONSTRAINT_COUNT,
    CORRECTING,
    HELD,
    SETTINGS,
    constraints_of,
    correct_of,
    error_of,
    repartition_of,
    return_held_of,
    stages_of,
)
from runtime.integrate.views import (
    floats_at,
    view,
)
from runtime.integrate.workspace import (
    ATOL,
    DELTA,
    FREE,
    MISSING,
    PARTITION,
    PREDICTED,
    PROJECTION,
    ROWS,
    SAMPLE,
    SIZE,
    Y1,
    K,
    Run,
)

DONE = 0
NEWTON = 1
NOT_FINITE = 2
TOO_LARGE = 3  # the error is over the tolerance

NEVER, BY_PARTITION, BY_PROJECTION, IF_DRIFTED = 0, 1, 2, 3
"""When and how a step is brought back onto the constraints: the number CORRECTING of the table."""

_MANY_ITERATIONS = 4


@inner
def drifted(machine: Integers, t: float, w: Vector, rtol: float, p: Vector) -> bool:
    """Whether a constraint is off by more than a step's tolerance at Y1."""
    length = w.size // ROWS
    n = length // 2
    phi = view(w, DELTA * length, machine[CONSTRAINT_COUNT])
    constraints_of(machine)(t, view(w, Y1 * length, n), p, phi)
    tolerance = np.inf
    for j in range(n):
        tolerance = min(tolerance, w[ATOL * length + j] + rtol * w[SIZE * length + j])
    largest = 0.0
    for i in range(phi.size):
        largest = max(largest, abs(phi[i]))
    return bool(largest > tolerance)


@inner
def projected(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Move Y1 onto the constraints by the least in the metric of the masses, if it must be."""
    r = run[0]
    length = w.size // ROWS
    if machine[CORRECTING] == IF_DRIFTED and not drifted(machine, t, w, r.rtol, p):
        return DONE
    result = correct_of(machine)(machine, t, Y1, PROJECTION, w, p)
    r.newton += 1
    if result == FAILED:
        return NEWTON
    r.corrections += result % WEAK
    for j in range(length // 2):
        moved = abs(w[Y1 * length + j] - w[PREDICTED * length + j])
        r.largest_dq = max(r.largest_dq, moved)
    return DONE


@inner
def returned(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Bring Y1 back onto the constraints, with another partition where this one is poor."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    correct = correct_of(machine)
    repartition = repartition_of(machine)
    y1 = view(w, Y1 * length, length)
    predicted = view(w, PREDICTED * length, length)
    finite = True
    for j in range(length):
        predicted[j] = y1[j]
        finite = finite and np.isfinite(y1[j])
    if not finite:
        return NOT_FINITE
    if machine[CORRECTING] != BY_PARTITION:
        return projected(machine, t, w, run, p)
    if FREE < r.plan < MISSING:
        # No coordinates are independent at a singular position, and near it none are good.
        result = correct(machine, t, Y1, PROJECTION, w, p)
        r.newton += 1
        if result == FAILED:
            return NEWTON
        r.corrections += result % WEAK
        return DONE
    if poorly_chosen(machine, t, w, p, run) != 0:
        repartition(machine, t, Y1, w, run, p)
    result = correct(machine, t, Y1, PARTITION, w, p)
    r.newton += 1
    if result == FAILED or result >= _MANY_ITERATIONS:
        kept = view(w, SAMPLE * length, length)
        for j in range(length):
            kept[j] = y1[j]
            y1[j] = predicted[j]
        if repartition(machine, t, Y1, w, run, p) != 0:
            result = correct(machine, t, Y1, PARTITION, w, p)
            r.newton += 1
        else:
            for j in range(length):
                y1[j] = kept[j]
    if result == FAILED:
        return NEWTON
    r.corrections += result % WEAK
    for j in range(n):
        r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    return DONE


@addressed(ATTEMPT)
def attempt(
    machine: Integers,
    t: float,
    h: float,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Step from Y0 over `h` to Y1, corrected, with its derivative and the error `run.error`.

    Returns `DONE`, or why the step cannot be accepted.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    floats_at(machine, SETTINGS, 2)[STEP] = h
    taken = stages_of(machine)(machine, t, h, w, run, p, modes, lam)
    r.rhs += r.stage_calls
    if taken < 0:
        return NEWTON
    r.corrections += taken
    if lam.size > 0 and machine[CORRECTING] != NEVER:
        code = returned(machine, t + h, w, run, p)
        if code != DONE:
            return code
    if machine[HELD] != 0:
        return_held_of(machine)(machine, t + h, Y1, w, p, modes, lam)
    slope = view(w, (K + r.last) * length, n)
    a = view(w, (K + r.last) * length + n, n)
    v = view(w, Y1 * length + n, n)
    r.weak_row = field(machine, t + h, view(w, Y1 * length, n), v, p, modes, a, lam)
    r.rhs += 1
    for j in range(n):
        slope[j] = v[j]
    r.error = error_of(machine)(machine, h, r.rtol, w)
    if not np.isfinite(r.error):
        return NOT_FINITE
    if r.error > r.permitted and r.fixed == 0:
        return TOO_LARGE
    return DONE
