"""One trial step: stages, return onto the constraints, derivative at the end, error."""

import numpy as np

from runtime.constraints.newton_return import FAILED, WEAK
from runtime.constraints.repartitioning import poorly_chosen
from runtime.core.array_views import (
    floats_at,
    view,
)
from runtime.core.function_table import (
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
from runtime.core.jit import addressed, inner
from runtime.core.rhs import field
from runtime.core.signatures import ATTEMPT, Integers, Vector
from runtime.core.workspace import (
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
from runtime.hybrid.sliding_rhs import STEP

DONE = 0
NEWTON = 1
NOT_FINITE = 2
TOO_LARGE = 3  # the error is over the tolerance

NEVER, BY_PARTITION, BY_PROJECTION, IF_DRIFTED = 0, 1, 2, 3
"""When and how a step is brought back onto the constraints: the number CORRECTING of the table."""

SAME = 0  # no result of `correct`: no coordinates are better

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
def anew(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Return Y1 once more from where the step led, by other coordinates.

    Answers as `correct` does; `SAME`, with Y1 as it was, where there are none better.
    """
    length = w.size // ROWS
    y1 = view(w, Y1 * length, length)
    predicted = view(w, PREDICTED * length, length)
    kept = view(w, SAMPLE * length, length)
    for j in range(length):
        kept[j] = y1[j]
        y1[j] = predicted[j]
    if repartition_of(machine)(machine, t, Y1, w, run, p) == 0:
        for j in range(length):
            y1[j] = kept[j]
        return SAME
    run[0].newton += 1
    return int(correct_of(machine)(machine, t, Y1, PARTITION, w, p))


@inner
def returned(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Bring Y1 back onto the constraints, with another partition where this one is poor."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    correct = correct_of(machine)
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
        repartition_of(machine)(machine, t, Y1, w, run, p)
    result = correct(machine, t, Y1, PARTITION, w, p)
    r.newton += 1
    if result == FAILED or result >= _MANY_ITERATIONS:
        again = anew(machine, t, w, run, p)
        if again != SAME:
            result = again
    if result == FAILED:
        return NEWTON
    r.corrections += result % WEAK
    for j in range(n):
        r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    return DONE


@inner
def strained(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Return Y1 by other coordinates where it went further than the tolerance; 1 where it did.

    Explicit methods integrate all coordinates as well as the tolerance asks, so that the return
    moves the dependent ones by less, unless the independent ones determine them badly: within two
    steps a partition can go from good to singular, which the probes now and then do not see. With
    implicit methods the independent ones alone are right.
    """
    r = run[0]
    implicit = r.stage_calls == 0
    if implicit or machine[CORRECTING] != BY_PARTITION or FREE < r.plan < MISSING:
        return 0
    length = w.size // ROWS
    y1 = view(w, Y1 * length, length)
    predicted = view(w, PREDICTED * length, length)
    atol = view(w, ATOL * length, length)
    far = False
    for j in range(length):
        far = far or abs(y1[j] - predicted[j]) > atol[j] + r.rtol * abs(y1[j])
    if not far:
        return 0
    growth, ratio = r.growth_limit, r.ratio_limit
    result = anew(machine, t, w, run, p)
    if result == SAME:
        r.growth_limit, r.ratio_limit = growth, ratio
        return 0
    if result == FAILED:
        return FAILED
    r.corrections += result % WEAK
    return 1


@inner
def judged(
    machine: Integers,
    t: float,
    h: float,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """The derivative at Y1, and the error of the step."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    slope = view(w, (K + r.last) * length, n)
    a = view(w, (K + r.last) * length + n, n)
    v = view(w, Y1 * length + n, n)
    r.weak_row = field(machine, t, view(w, Y1 * length, n), v, p, modes, a, lam)
    r.rhs += 1
    for j in range(n):
        slope[j] = v[j]
    r.error = error_of(machine)(machine, h, r.rtol, w)


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
    judged(machine, t + h, h, w, run, p, modes, lam)
    if not np.isfinite(r.error):
        return NOT_FINITE
    if r.error > r.permitted and r.fixed == 0:
        return TOO_LARGE
    if lam.size > 0 and machine[HELD] == 0:
        again = strained(machine, t + h, w, run, p)
        if again == FAILED:
            return NEWTON
        if again == 1:
            judged(machine, t + h, h, w, run, p, modes, lam)
            if not np.isfinite(r.error):
                return NOT_FINITE
    return DONE
