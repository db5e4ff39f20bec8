"""One trial step: stages, return onto the constraints, derivative at the end, error."""

from enum import IntEnum

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.constraints.repartitioning import is_poorly_chosen
from runtime.core.array_types import Integers
from runtime.core.array_views import (
    view,
)
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    CORRECTING,
    SLIDING_COUNT,
    TRIAL_STEP,
    correct_of,
    error_of,
    modes_of,
    parameters_of,
    repartition_of,
    return_to_surfaces_of,
    settings_of,
    stages_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import constraints_of
from runtime.core.rhs import evaluate_accelerations
from runtime.core.run_record import ConstraintReturn, is_near_singularity, run_record
from runtime.core.workspace import (
    ATOL,
    DELTA,
    PARTITION,
    PREDICTED,
    PROJECTION,
    SAMPLE,
    SIZE,
    Y1,
    K,
    position_rates,
    positions,
    row_of,
    velocities,
    velocity_rates,
)
from runtime.hybrid.sliding_rhs import STEP


class TrialStep(IntEnum):
    """How a trial step ended."""

    DONE = 0
    NEWTON_FAILED = 1
    NOT_FINITE = 2
    TOO_LARGE = 3
    """The error is over the tolerance."""


SAME = 0  # no result of `correct`: no coordinates are better

_MANY_ITERATIONS = 4  # measured: Newton iterations of a return from which on a repartition is tried


@inner
def drifted(context: Integers, t: float, rtol: float) -> bool:
    """Whether a constraint is off by more than a step's tolerance at Y1."""
    p = parameters_of(context)
    atol = row_of(context, ATOL)
    size = row_of(context, SIZE)
    n = context[COORDINATES]
    phi = view(row_of(context, DELTA), 0, context[CONSTRAINT_COUNT])
    constraints_of(context)(t, positions(context, Y1), p, phi)
    tolerance = np.inf
    for j in range(n):
        tolerance = min(tolerance, atol[j] + rtol * size[j])
    largest = 0.0
    for i in range(phi.size):
        largest = max(largest, abs(phi[i]))
    return bool(largest > tolerance)


@inner
def projected(context: Integers, t: float) -> int:
    """Move Y1 onto the constraints by the least in the metric of the masses, if it must be."""
    y1 = row_of(context, Y1)
    predicted = row_of(context, PREDICTED)
    r = run_record(context)
    length = 2 * context[COORDINATES]
    if context[CORRECTING] == ConstraintReturn.IF_DRIFTED and not drifted(context, t, r.rtol):
        return TrialStep.DONE
    result = correct_of(context)(context, t, Y1, PROJECTION)
    r.newton += 1
    if result == FAILED:
        return TrialStep.NEWTON_FAILED
    r.corrections += result
    for j in range(length // 2):
        moved = abs(y1[j] - predicted[j])
        r.largest_dq = max(r.largest_dq, moved)
    return TrialStep.DONE


@inner
def anew(context: Integers, t: float) -> int:
    """Return Y1 once more from where the step led, by other coordinates.

    Answers as `correct` does; `SAME`, with Y1 as it was, where there are none better.
    """
    length = 2 * context[COORDINATES]
    y1 = row_of(context, Y1)
    predicted = row_of(context, PREDICTED)
    kept = row_of(context, SAMPLE)
    for j in range(length):
        kept[j] = y1[j]
        y1[j] = predicted[j]
    if repartition_of(context)(context, t, Y1) == 0:
        for j in range(length):
            y1[j] = kept[j]
        return SAME
    run_record(context).newton += 1
    return int(correct_of(context)(context, t, Y1, PARTITION))


@inner
def returned(context: Integers, t: float) -> int:
    """Bring Y1 back onto the constraints, with another partition where this one is poor."""
    r = run_record(context)
    n = context[COORDINATES]
    length = 2 * n
    correct = correct_of(context)
    y1 = row_of(context, Y1)
    predicted = row_of(context, PREDICTED)
    finite = True
    for j in range(length):
        predicted[j] = y1[j]
        finite = finite and np.isfinite(y1[j])
    if not finite:
        return TrialStep.NOT_FINITE
    if context[CORRECTING] != ConstraintReturn.BY_PARTITION:
        return projected(context, t)
    if is_near_singularity(context):
        # No coordinates are independent at a singular position, and near it none are good.
        result = correct(context, t, Y1, PROJECTION)
        r.newton += 1
        if result == FAILED:
            return TrialStep.NEWTON_FAILED
        r.corrections += result
        return TrialStep.DONE
    if is_poorly_chosen(context, t) != 0:
        repartition_of(context)(context, t, Y1)
    result = correct(context, t, Y1, PARTITION)
    r.newton += 1
    if result == FAILED or result >= _MANY_ITERATIONS or r.weak_return != 0:
        again = anew(context, t)
        if again != SAME:
            result = again
    if result == FAILED:
        return TrialStep.NEWTON_FAILED
    r.corrections += result
    for j in range(n):
        r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    return TrialStep.DONE


@inner
def strained(context: Integers, t: float) -> int:
    """Return Y1 by other coordinates where it went further than the tolerance; 1 where it did.

    Explicit methods integrate all coordinates as well as the tolerance asks, so that the return
    moves the dependent ones by less, unless the independent ones determine them badly: within two
    steps a partition can go from good to singular, which the probes now and then do not see. With
    implicit methods the independent ones alone are right.
    """
    r = run_record(context)
    implicit = r.stage_calls == 0
    if (
        implicit
        or context[CORRECTING] != ConstraintReturn.BY_PARTITION
        or is_near_singularity(context)
    ):
        return 0
    length = 2 * context[COORDINATES]
    y1 = row_of(context, Y1)
    predicted = row_of(context, PREDICTED)
    atol = row_of(context, ATOL)
    far = False
    for j in range(length):
        far = far or abs(y1[j] - predicted[j]) > atol[j] + r.rtol * abs(y1[j])
    if not far:
        return 0
    growth, ratio = r.growth_limit, r.ratio_limit
    result = anew(context, t)
    if result == SAME:
        r.growth_limit, r.ratio_limit = growth, ratio
        return 0
    if result == FAILED:
        return FAILED
    r.corrections += result
    return 1


@inner
def judged(context: Integers, t: float, h: float) -> None:
    """The derivative at Y1, and the error of the step."""
    modes = modes_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    slope = position_rates(context, K + r.last)
    a = velocity_rates(context, K + r.last)
    v = velocities(context, Y1)
    r.weak_row = evaluate_accelerations(context, t, positions(context, Y1), v, modes, a)
    r.rhs += 1
    for j in range(n):
        slope[j] = v[j]
    r.error = error_of(context)(context, h, r.rtol)


@addressed(TRIAL_STEP)
def take_trial_step(context: Integers, t: float, h: float) -> int:
    """Step from Y0 over `h` to Y1, corrected, with its derivative and the error `run.error`.

    Returns `TrialStep.DONE`, or why the step cannot be accepted.
    """
    r = run_record(context)
    settings_of(context)[STEP] = h
    taken = stages_of(context)(context, t, h)
    r.rhs += r.stage_calls
    if taken < 0:
        return TrialStep.NEWTON_FAILED
    r.corrections += taken
    if context[CONSTRAINT_COUNT] > 0 and context[CORRECTING] != ConstraintReturn.NEVER:
        code = returned(context, t + h)
        if code != TrialStep.DONE:
            return code
    if context[SLIDING_COUNT] != 0:
        return_to_surfaces_of(context)(context, t + h, Y1)
    judged(context, t + h, h)
    if not np.isfinite(r.error):
        return TrialStep.NOT_FINITE
    if r.error > r.permitted and r.fixed == 0:
        return TrialStep.TOO_LARGE
    if context[CONSTRAINT_COUNT] > 0 and context[SLIDING_COUNT] == 0:
        again = strained(context, t + h)
        if again == FAILED:
            return TrialStep.NEWTON_FAILED
        if again == 1:
            judged(context, t + h, h)
            if not np.isfinite(r.error):
                return TrialStep.NOT_FINITE
    return TrialStep.DONE
