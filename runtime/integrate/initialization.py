"""The first instant of a run: partition, correction, modes, first step."""

import numpy as np

from runtime.constraints.newton_return import FAILED, WEAK
from runtime.core import outcome_codes as codes
from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    RANK,
    RIGID,
    ROW_ORDER,
    SETTINGS,
    SPREADS,
    begin_of,
    correct_of,
    first_step_of,
    repartition_of,
    restart_of,
    switching_rates_of,
)
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.rhs import field
from runtime.core.signatures import (
    IntegerMatrix,
    Integers,
    Matrix,
    Vector,
    i8,
    integer_matrix,
    integers,
    matrix,
    vector,
)
from runtime.core.workspace import (
    BAND,
    FREE,
    G0,
    IMPACT_AT,
    LARGEST,
    PARTITION,
    RESERVE,
    ROWS,
    SAMPLE,
    SCAN,
    SIZE,
    SWITCH_ROWS,
    TRIAL,
    Y0,
    K,
    Run,
    run_record,
)
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.hybrid.mode_transition import LOOK_AHEAD
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.sliding_rhs import STEP
from runtime.hybrid.stiction_force import at_rest, finite, jams
from runtime.hybrid.switching_functions import measure
from runtime.integrate.sampling import record

_ROUGH = 0.1  # of a function's spread: |g| at which its rounding is some units in the last place


@inner
def spread(machine: Integers, t: float, w: Vector, sw: Vector, p: Vector) -> None:
    """Write into row TRIAL how far functions go when all is changed by its size: Σ |∂g| size.

    dg/dt is linear in velocities and accelerations; taken one at a time, each of its size, they
    give the derivatives.
    """
    length = w.size // ROWS
    n = length // 2
    s = sw.size // SWITCH_ROWS
    rates = switching_rates_of(machine)
    q = view(w, Y0 * length, n)
    v, a = view(w, SAMPLE * length, n), view(w, SAMPLE * length + n, n)
    now, rest = view(sw, SCAN * s, s), view(sw, (SCAN + 1) * s, s)
    found = view(sw, TRIAL * s, s)
    for j in range(length):
        w[SAMPLE * length + j] = 0.0
    rates(t, q, v, a, p, rest)
    known = floats_at(machine, SPREADS, s)
    for k in range(s):
        found[k] = 0.0
    for j in range(length):
        w[SAMPLE * length + j] = w[SIZE * length + j]
        rates(t, q, v, a, p, now)
        w[SAMPLE * length + j] = 0.0
        for k in range(s):
            change = abs(now[k] - rest[k])
            found[k] += change if np.isfinite(change) else 0.0
    for k in range(s):
        found[k] = max(found[k], known[k])


@compiled(
    i8(
        ADDRESSES,
        vector,
        vector,
        run_record,
        vector,
        integers,
        integers,
        vector,
        vector,
        vector,
        matrix,
        integer_matrix,
    )
)
def start(
    machine: Integers,
    w: Vector,
    sw: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    scratch: Integers,
    lam: Vector,
    t_eval: Vector,
    out_t: Vector,
    out_y: Matrix,
    out_modes: IntegerMatrix,
) -> int:
    """Prepare a run whose state is in row Y0: everything that the first step needs.

    Returns the code of an outcome: OK, or why there is no first step (`run.index` says which
    constraint or switching function).
    """
    first_step = first_step_of(machine)
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    m = lam.size
    s = sw.size // SWITCH_ROWS
    t = r.t
    if m > 0 and r.plan == FREE:
        repartition_of(machine)(machine, t, Y0, w, run, p)
        r.repartitions = 0
        if r.rank < machine[RANK]:
            r.index = integers_at(machine, ROW_ORDER, m)[r.rank]
            return codes.SINGULAR
        result = correct_of(machine)(machine, t, Y0, PARTITION, w, p)
        r.newton += 1
        if result == FAILED:
            return codes.NEWTON_FAILED
        r.corrections += result % WEAK
    q = view(w, Y0 * length, n)
    v = view(w, Y0 * length + n, n)
    slope = view(w, K * length, n)
    a = view(w, K * length + n, n)
    for j in range(n):
        slope[j] = v[j]
    # Whether the constraints are independent is not for a joint to say that friction jams.
    at_rest(machine, p, modes)
    if r.plan == FREE:
        weak = field(machine, t, q, v, p, modes, a, lam)
        if weak > 0:
            r.index = weak - 1
            return codes.SINGULAR
    outcome = codes.OK
    if s > 0:
        # A run of no length has modes too; they are judged as if it went on for a second.
        longest = r.h_max if r.h_max > 0.0 else 1.0
        h = first_step(machine, t, longest, r.rtol, r.order, w, p, modes, lam)
        floats_at(machine, SETTINGS, 2)[STEP] = h
        rigid = integers_at(machine, RIGID, s)
        spread(machine, t, w, sw, p)
        for k in range(s):
            # The rounding of a function is that of what it is made of, however small itself.
            if rigid[k] < 0:
                sw[LARGEST * s + k] = _ROUGH * sw[TRIAL * s + k]
            else:
                sw[IMPACT_AT * s + k] = t
                sw[LARGEST * s + k] = w[SIZE * length]
                for j in range(n):
                    sw[LARGEST * s + k] = min(sw[LARGEST * s + k], w[SIZE * length + j])
        settled = begin_of(machine)(
            machine, 0, t, LOOK_AHEAD * h, Y0, G0, w, sw, p, modes, scratch, lam
        )
        if settled != CONSISTENT:
            r.index = settled
            outcome = codes.INCONSISTENT
        field(machine, t, q, v, p, modes, a, lam)
        measure(machine, t, Y0, K, G0, w, sw, p, modes, lam)
        for k in range(s):
            if modes[k] == HELD_MODE:
                sw[RESERVE * s + k] = sw[LARGEST * s + k]
                sw[LARGEST * s + k], sw[BAND * s + k] = 1.0, 0.0
        r.rhs += 2
    if not finite(a):
        jammed = jams(machine, t, q, v, p, modes, a, lam)
        if jammed == CONSISTENT:
            return codes.NOT_FINITE
        r.index = jammed
        return codes.INCONSISTENT
    if r.fixed == 0 and not r.h > 0.0:
        r.h = first_step(machine, t, r.h_max, r.rtol, r.order, w, p, modes, lam)
        r.rhs += 1
    r.rhs += 1
    restart_of(machine)(machine, t, r.h, w, run)
    if r.every_step != 0:
        record(t, Y0, w, run, modes, out_t, out_y, out_modes)
    while r.next_sample < t_eval.size and t_eval[r.next_sample] <= t:
        record(t_eval[r.next_sample], Y0, w, run, modes, out_t, out_y, out_modes)
        r.next_sample += 1
    for i in range(r.samples):
        for k in range(s):
            # At the very instant of the start a condition on its boundary does not hold yet.
            if sw[BAND * s + k] > 0.0:
                out_modes[i, k] = 0
    return outcome
