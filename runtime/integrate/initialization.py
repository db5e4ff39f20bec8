"""The first instant of a run: partition, correction, modes, first step."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, i8
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    RANK,
    SAMPLE_TIMES,
    SWITCHES,
    correct_of,
    first_step_of,
    initialize_modes_of,
    modes_of,
    out_modes_of,
    parameters_of,
    repartition_of,
    restart_of,
    rigid_of,
    row_order_of,
    sample_times_of,
    settings_of,
    spreads_of,
)
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import switching_rates_of
from runtime.core.modes import SLIDING
from runtime.core.outcomes import Outcome
from runtime.core.rhs import evaluate_accelerations
from runtime.core.run_record import Plan, run_record
from runtime.core.workspace import (
    BAND,
    G0,
    IMPACT_AT,
    LARGEST,
    PARTITION,
    RESERVE,
    SAMPLE,
    SCAN,
    SIZE,
    TRIAL,
    Y0,
    K,
    position_rates,
    positions,
    row_of,
    switch_row,
    velocities,
    velocity_rates,
)
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.hybrid.mode_transition import LOOK_AHEAD
from runtime.hybrid.sliding_rhs import STEP
from runtime.hybrid.stiction_force import find_jamming_friction, is_finite, suspend_friction
from runtime.hybrid.switching_functions import evaluate_switching_and_rates
from runtime.integrate.sampling import record

# accuracy: of a function's spread; |g| at which its rounding is some units in the last place
_ROUGH = 0.1


@inner
def spread(context: Integers, t: float) -> None:
    """Write into row TRIAL how far functions go when all is changed by its size: Σ |∂g| size.

    dg/dt is linear in velocities and accelerations; taken one at a time, each of its size, they
    give the derivatives.
    """
    p = parameters_of(context)
    sample = row_of(context, SAMPLE)
    size = row_of(context, SIZE)
    n = context[COORDINATES]
    length = 2 * n
    s = context[SWITCHES]
    rates = switching_rates_of(context)
    q = positions(context, Y0)
    v, a = positions(context, SAMPLE), velocities(context, SAMPLE)
    now, rest = switch_row(context, SCAN), switch_row(context, SCAN + 1)
    found = switch_row(context, TRIAL)
    for j in range(length):
        sample[j] = 0.0
    rates(t, q, v, a, p, rest)
    known = spreads_of(context)
    for k in range(s):
        found[k] = 0.0
    for j in range(length):
        sample[j] = size[j]
        rates(t, q, v, a, p, now)
        sample[j] = 0.0
        for k in range(s):
            change = abs(now[k] - rest[k])
            found[k] += change if np.isfinite(change) else 0.0
    for k in range(s):
        found[k] = max(found[k], known[k])


@compiled(i8(ADDRESSES))
def start(context: Integers) -> int:
    """Prepare a run whose state is in row Y0: everything that the first step needs.

    Returns the code of an outcome: OK, or why there is no first step (`run.index` says which
    constraint or switching function).
    """
    modes = modes_of(context)
    t_eval = sample_times_of(context)
    out_modes = out_modes_of(context)
    largest = switch_row(context, LARGEST)
    trial = switch_row(context, TRIAL)
    impact_at = switch_row(context, IMPACT_AT)
    size = row_of(context, SIZE)
    reserve = switch_row(context, RESERVE)
    band = switch_row(context, BAND)
    first_step = first_step_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    m = context[CONSTRAINT_COUNT]
    s = context[SWITCHES]
    t = r.t
    if m > 0 and r.plan == Plan.FREE:
        repartition_of(context)(context, t, Y0)
        r.repartitions = 0
        if r.rank < context[RANK]:
            r.index = row_order_of(context)[r.rank]
            return Outcome.SINGULAR
        result = correct_of(context)(context, t, Y0, PARTITION)
        r.newton += 1
        if result == FAILED:
            return Outcome.NEWTON_FAILED
        r.corrections += result
    q = positions(context, Y0)
    v = velocities(context, Y0)
    slope = position_rates(context, K)
    a = velocity_rates(context, K)
    for j in range(n):
        slope[j] = v[j]
    # Whether the constraints are independent is not for a joint to say that friction jams.
    suspend_friction(context)
    if r.plan == Plan.FREE:
        weak = evaluate_accelerations(context, t, q, v, modes, a)
        if weak > 0:
            r.index = weak - 1
            return Outcome.SINGULAR
    outcome = Outcome.OK
    if s > 0:
        # A run of no length has modes too; they are judged as if it went on for a second.
        longest = r.h_max if r.h_max > 0.0 else 1.0
        h = first_step(context, t, longest, r.rtol, r.order)
        settings_of(context)[STEP] = h
        rigid = rigid_of(context)
        spread(context, t)
        for k in range(s):
            # The rounding of a function is that of what it is made of, however small itself.
            if rigid[k] < 0:
                largest[k] = _ROUGH * trial[k]
            else:
                impact_at[k] = t
                largest[k] = size[0]
                for j in range(n):
                    largest[k] = min(largest[k], size[j])
        settled = initialize_modes_of(context)(context, 0, t, LOOK_AHEAD * h, Y0, G0)
        if settled != CONSISTENT:
            r.index = settled
            outcome = Outcome.INCONSISTENT
        evaluate_accelerations(context, t, q, v, modes, a)
        evaluate_switching_and_rates(context, t, Y0, K, G0)
        for k in range(s):
            if modes[k] == SLIDING:
                reserve[k] = largest[k]
                largest[k], band[k] = 1.0, 0.0
        r.rhs += 2
    if not is_finite(a):
        jammed = find_jamming_friction(context, t, q, v, a)
        if jammed == CONSISTENT:
            return Outcome.NOT_FINITE
        r.index = jammed
        return Outcome.INCONSISTENT
    if r.fixed == 0 and not r.h > 0.0:
        r.h = first_step(context, t, r.h_max, r.rtol, r.order)
        r.rhs += 1
    r.rhs += 1
    restart_of(context)(context, t, r.h)
    if r.every_step != 0:
        record(context, t, Y0)
    while r.next_sample < context[SAMPLE_TIMES] and t_eval[r.next_sample] <= t:
        if r.every_step == 0:
            record(context, t_eval[r.next_sample], Y0)
        r.next_sample += 1
    for i in range(r.samples):
        for k in range(s):
            # At the very instant of the start a condition on its boundary does not hold yet.
            if band[k] > 0.0:
                out_modes[i, k] = 0
    return outcome
