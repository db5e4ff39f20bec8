"""One trial step: stages, return onto the constraints, derivative at the end, error."""

from enum import IntEnum, unique

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.constraints.repartitioning import is_poorly_chosen
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers, view
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import constraints_of
from runtime.core.loop_record import ConstraintReturn, is_near_singularity, run_record
from runtime.core.state_derivative import write_derivative
from runtime.hybrid.sliding_motion import STEP
from runtime.integrate.step_control import limit_by_states
from runtime.linalg.vectors import copy_vector, is_finite, largest_magnitude


@unique
class TrialStep(IntEnum):
    """How a trial step ended."""

    DONE = 0
    NEWTON_FAILED = 1
    NOT_FINITE = 2
    TOO_LARGE = 3  # the error is over the tolerance


@unique
class Signal(IntEnum):
    """How a run goes on, as the parts of a step answer; codes of outcomes, not negative, end it."""

    GOING = -1  # the run is not over
    LOOK = -2  # a singular configuration has to be looked at, see `singular_crossings`
    CHANGE = -3  # another method is due
    PROCEED = -4  # the step goes on with its next part
    KINK = -6  # an explicit function of time may bend or jump here
    RETRY = -5  # the step is not taken; the next one is shorter
    STOP = -9  # a condition that ends the run begins to hold
    SAMPLE = -8  # a function in Python computes a sampled value
    LEAVE = -7  # it is not taken, as other coordinates are due


SAME = 0  # code: no result of a return: no coordinates are better
_MANY_ITERATIONS = 4  # measured: Newton iterations of a return from which on a repartition is tried


@inner
def reject(context: Integers, reason: int, next_length: float) -> int:
    """Count a rejected step and set the length of the next one; `Signal.RETRY`."""
    r = run_record(context)
    r.rejected += 1
    r.reason = reason
    r.rejected_before = 1
    r.h = next_length
    return Signal.RETRY


@inner
def has_drifted(context: Context, t: float, rtol: float) -> bool:
    """Whether a constraint is off by more than a step's tolerance at Y1."""
    atol, size = ws.row_of(context, ws.ATOL), ws.row_of(context, ws.SIZE)
    phi = view(ws.row_of(context, ws.DELTA), 0, context[ft.CONSTRAINT_COUNT])
    constraints_of(context)(t, context.q1, context.parameters, phi)
    tolerance = np.inf
    for j in range(context[ft.COORDINATES]):
        tolerance = min(tolerance, atol[j] + rtol * size[j])
    return bool(largest_magnitude(phi) > tolerance)


@inner
def return_by_other_coordinates(context: Integers, t: float) -> int:
    """Return Y1 once more from where the step led, by other independent coordinates.

    Answers as `correct` does; `SAME`, with Y1 as it was, where there are none better.
    """
    y1, kept = ws.row_of(context, ws.Y1), ws.row_of(context, ws.SAMPLE)
    copy_vector(y1, kept)
    copy_vector(ws.row_of(context, ws.PREDICTED), y1)
    if ft.repartition_of(context)(context, t, ws.Y1) == 0:
        copy_vector(kept, y1)
        return SAME
    run_record(context).returns += 1
    return int(ft.correct_of(context)(context, t, ws.Y1, ws.PARTITION))


@inner
def return_by_partition(context: Integers, t: float) -> int:
    """Return Y1 by its independent coordinates, by others where these are poor."""
    if is_poorly_chosen(context, t) != 0:
        ft.repartition_of(context)(context, t, ws.Y1)
    result = ft.correct_of(context)(context, t, ws.Y1, ws.PARTITION)
    weak = run_record(context).weak_return != 0
    if result == FAILED or weak or result >= _MANY_ITERATIONS:
        again = return_by_other_coordinates(context, t)
        if again != SAME:
            return again
    return int(result)


@inner
def return_end_to_constraints(context: Integers, t: float) -> int:
    """Bring Y1 back onto the constraints; row PREDICTED keeps where the step led."""
    r = run_record(context)
    y1, predicted = ws.row_of(context, ws.Y1), ws.row_of(context, ws.PREDICTED)
    copy_vector(y1, predicted)
    if not is_finite(y1):
        return TrialStep.NOT_FINITE
    correcting = context[ft.CORRECTING]
    by_partition = correcting == ConstraintReturn.BY_PARTITION
    # No coordinates are independent at a singular position, and near it none are good.
    near = by_partition and is_near_singularity(context)
    if by_partition and not near:
        result = return_by_partition(context, t)
    elif correcting == ConstraintReturn.IF_DRIFTED and not has_drifted(context, t, r.rtol):
        return TrialStep.DONE
    else:
        result = ft.correct_of(context)(context, t, ws.Y1, ws.PROJECTION)
    r.returns += 1
    if result == FAILED:
        return TrialStep.NEWTON_FAILED
    r.corrections += result
    if not near:
        for j in range(context[ft.COORDINATES]):
            r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    return TrialStep.DONE


@inner
def improve_return(context: Integers, t: float) -> int:
    """Return Y1 by other coordinates where the return moved it by more than the tolerance.

    Explicit methods integrate all coordinates as well as the tolerance asks, so that the return
    moves the dependent ones by less, unless the independent ones determine them badly: within two
    steps a partition can go from good to singular, which the probes now and then do not see. With
    implicit methods the independent ones alone are right. Answers as `correct` does, or `SAME`.
    """
    r = run_record(context)
    implicit = r.stage_calls == 0
    by_partition = context[ft.CORRECTING] == ConstraintReturn.BY_PARTITION
    if implicit or not by_partition or is_near_singularity(context):
        return SAME
    y1, predicted = ws.row_of(context, ws.Y1), ws.row_of(context, ws.PREDICTED)
    atol = ws.row_of(context, ws.ATOL)
    far = False
    for j in range(y1.size):
        far = far or abs(y1[j] - predicted[j]) > atol[j] + r.rtol * abs(y1[j])
    if not far:
        return SAME
    growth, ratio = r.growth_limit, r.ratio_limit
    result = return_by_other_coordinates(context, t)
    if result == SAME:
        r.growth_limit, r.ratio_limit = growth, ratio
    elif result != FAILED:
        r.corrections += result
    return result


@inner
def estimate_error(context: Integers, t: float, h: float) -> bool:
    """Write the derivative at Y1 and `run.error`; whether that is finite."""
    r = run_record(context)
    r.weak_row = write_derivative(context, t, ws.Y1, ws.K + r.last)
    r.rhs += 1
    r.error = ft.error_of(context)(context, h, r.rtol)
    return bool(np.isfinite(r.error))


@addressed(ft.TRIAL_STEP)
def take_trial_step(context: Context, t: float, h: float) -> int:
    """Step from Y0 over `h` to Y1, corrected, with its derivative and the error `run.error`.

    Returns `TrialStep.DONE`, or why the step cannot be accepted.
    """
    r = run_record(context)
    context.settings[STEP] = h
    if context[ft.STATES] != 0 and r.dense_calls != 0:
        limit_by_states(context, t)
    taken = ft.stages_of(context)(context, t, h)
    r.rhs += r.stage_calls
    if taken < 0:
        return TrialStep.NEWTON_FAILED
    r.corrections += taken
    constrained = context[ft.CONSTRAINT_COUNT] > 0
    if constrained and context[ft.CORRECTING] != ConstraintReturn.NEVER:
        code = return_end_to_constraints(context, t + h)
        if code != TrialStep.DONE:
            return code
    if context[ft.SLIDING_COUNT] != 0:
        ft.return_to_surfaces_of(context)(context, t + h, ws.Y1)
    if not estimate_error(context, t + h, h):
        return TrialStep.NOT_FINITE
    if r.error > r.permitted and r.fixed == 0:
        return TrialStep.TOO_LARGE
    if constrained and context[ft.SLIDING_COUNT] == 0:
        again = improve_return(context, t + h)
        if again == FAILED:
            return TrialStep.NEWTON_FAILED
        if again != SAME and not estimate_error(context, t + h, h):
            return TrialStep.NOT_FINITE
    return TrialStep.DONE
